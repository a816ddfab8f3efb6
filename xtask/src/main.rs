//! Chores of the project: `cargo xtask help` lists them.

mod bench;
mod demo;
mod dist;
mod failure;
mod fuzz;
mod python;
mod remote;
mod shell;
mod software;
mod steps;
mod test;
mod trade;

use std::io::Write;
use std::process::ExitCode;

use failure::Failure;
use shell::say;

const HELP: &str = "\
Chores of Trocar.

cargo xtask demo [-- ARGUMENTS]   builds the programs and runs the embedded demonstration for 10 s into out/;
                                  ARGUMENTS go to `pilot run` (--for 3s, --volume ct.nii.gz, --out DIR ...)
cargo xtask test                  everything that must pass: formatting, lints, documentation, tests
cargo xtask remote                remote-proc, for a second machine (docs/remote.md): built in release, put beside the other programs
cargo xtask test-remote           tests it between real runs; with --if-changed only where it, the bus or geometry has changed since it
                                  last passed, as `test` does
cargo xtask check                 what to run between two edits: formatting, lints, and the tests beside the code and of the house
cargo xtask bench [-- ARGUMENTS]  the benchmarks; ARGUMENTS go to `cargo bench`
cargo xtask bench trade [--quick] [--out DIR] [--again]   every dial of the system: time beside error, into docs/trade.{md,csv,png}
                                  (--quick: few rounds, into out/bench; --again: page and picture of the rows that are there)
cargo xtask bench solids          solids: cost, detection, and mesh, tolerance and barrier against error, into out/bench/solids-*
cargo xtask bench peers           the reslice engine beside VTK and SimpleITK, in a Python environment in the build folder
cargo xtask bench load            reading a DICOM series beside a plain read and SimpleITK, likewise
cargo xtask faults [COUNT] [load N] [only WORD]   kills and stops parts of a run COUNT times each (20) beside N busy loops (0), and
                                  prints how long it takes until every view is live again, as a table (docs/faults.md)
cargo xtask overload [SECONDS] [load N]           navigates for SECONDS (20) beside N busy loops (8) with different priorities, and prints
                                  how late the images were (docs/faults.md)
cargo xtask scenes [SECONDS]      runs each shipped scene for SECONDS (10) and prints the threads, memory and processor time of its
                                  processes, as a table (docs/scenes.md)
cargo xtask soak [MINUTES] [kill SECONDS] [tissue]   navigates for MINUTES (120) and prints the slopes of memory, files and latencies;
                                  with `kill`, a process dies every so many seconds; with `tissue`, the tube strokes an organ
cargo xtask fuzz [SECONDS] [TARGET ...]   libFuzzer on every parser of files and messages, 60 s each (needs a C++ compiler);
                                  inputs that are not survived go to fuzz/artifacts
cargo xtask dist                  what a user installs, into the build folder's dist/: a tarball and, where dpkg-deb is to be had, a
                                  Debian package, with programs, scenes, book, manual pages, completions and a list of all
                                  software of others in it
cargo xtask help                  this text";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let chore = arguments.next();
    // `cargo xtask demo -- --for 3s` and `cargo xtask demo --for 3s` mean the same.
    let rest: Vec<String> = arguments
        .enumerate()
        .filter(|(i, a)| *i > 0 || a != "--")
        .map(|(_, a)| a)
        .collect();
    let done = match chore.as_deref() {
        Some("demo") => demo::demo(&rest),
        Some("test") => test::test(&rest),
        Some("check") => test::check(&rest),
        Some("bench") => bench::bench(&rest),
        // They build for minutes and run for hours: whoever asks what they do has no use for either.
        Some("faults" | "overload" | "scenes" | "soak") if rest.iter().any(|word| word == "--help" || word == "-h") => {
            say(HELP);
            Ok(())
        }
        // Built in release, as a person's run is; the table goes to stdout.
        Some(name @ ("faults" | "overload" | "scenes" | "soak")) => {
            shell::run(shell::cargo(&["bench", "--package", "trocar", "--bench", name, "--"]).args(&rest))
        }
        Some("remote") => remote::build(),
        Some("test-remote") => remote::test(&rest),
        Some("dist") => dist::dist(&rest),
        Some("fuzz") => fuzz::fuzz(&rest),
        None | Some("help" | "--help" | "-h") => {
            say(HELP);
            Ok(())
        }
        Some(other) => Err(Failure::Usage(format!(
            "there is no chore {other:?}; `cargo xtask help` lists them"
        ))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "xtask: error: {failure}");
            failure.exit_code()
        }
    }
}
