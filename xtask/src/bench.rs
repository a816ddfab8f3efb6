//! The benchmarks.

use std::fs;
use std::path::PathBuf;

use crate::failure::Failure;
use crate::shell::{cargo, program, quietly, root, run, say, target};
use crate::trade;

const PEERS: &str = "slice-view-proc/benches/peers";

/// All benchmarks, or one of those that have a name of their own; the rest of the arguments goes to it.
///
/// # Errors
/// [`Failure`] where a program cannot be started or fails.
pub(crate) fn bench(arguments: &[String]) -> Result<(), Failure> {
    match arguments.split_first() {
        Some((name, rest)) if name == "trade" => trade::trade(rest),
        Some((name, rest)) if name == "solids" => {
            run(cargo(&["bench", "--package", "simulation", "--bench", "*"]).args(rest))
        }
        Some((name, rest)) if name == "peers" => peers(rest),
        Some((name, rest)) if name == "load" => load(rest),
        // Without the pattern, cargo would build every library's tests as well, to ignore them. Those of the whole program are chores
        // of their own: a soak takes hours.
        _ => run(cargo(&["bench", "--workspace", "--exclude", "trocar", "--bench", "*"]).args(arguments)),
    }
}

/// The reslice engine beside other software.
fn peers(arguments: &[String]) -> Result<(), Failure> {
    // Built first, so that the script waits for the engine only.
    run(&mut cargo(&[
        "bench",
        "--package",
        "slice-view-proc",
        "--bench",
        "reslice",
        "--no-run",
    ]))?;
    let interpreter = interpreter().map_err(Failure::Usage)?;
    let script = format!("{PEERS}/reslice.py");
    let arguments = arguments.iter().filter(|argument| *argument != "--");
    run(program(interpreter, &[&script]).args(arguments))
}

/// The volume loader beside other software.
fn load(arguments: &[String]) -> Result<(), Failure> {
    let interpreter = interpreter().map_err(Failure::Usage)?;
    let mut bench = cargo(&["bench", "--package", "volume-loader", "--bench", "load"]);
    run(bench.args(arguments).env("TROCAR_PEERS_PYTHON", interpreter))
}

/// The Python of an environment with the other software, made where there is none for the same list.
fn interpreter() -> Result<PathBuf, String> {
    let list = root().join(PEERS).join("requirements.txt");
    let wanted = fs::read_to_string(&list).map_err(|e| format!("reading {}: {e}", list.display()))?;
    let folder = target().join("venv-peers");
    let interpreter = folder.join("bin/python");
    // Written last: an environment with it is whole.
    let stamp = folder.join("requirements.txt");
    if !fs::read_to_string(&stamp).is_ok_and(|made_for| made_for == wanted) {
        say(&format!("making {}", folder.display()));
        quietly(&mut program(
            "python3",
            &["-m", "venv", "--clear", &folder.to_string_lossy()],
        ))?;
        let install = [
            "-m",
            "pip",
            "install",
            "--disable-pip-version-check",
            "-r",
            &list.to_string_lossy(),
        ];
        quietly(&mut program(&interpreter, &install))?;
        fs::write(&stamp, wanted).map_err(|e| format!("writing {}: {e}", stamp.display()))?;
    }
    Ok(interpreter)
}
