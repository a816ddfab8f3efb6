//! `cargo xtask bench trade`: every dial of the system, its time beside its error, as CSV, page and picture.

mod dials;
mod page;
mod picture;
mod rows;

use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::shell::{cargo, here, root, run, say};
use dials::{BENCHES, DIALS};
use rows::Measured;

/// What the person asked for.
struct Options {
    is_quick: bool,
    out: PathBuf,
    /// Page and picture of the rows that are there.
    is_again: bool,
}

impl Options {
    fn parse(arguments: &[String]) -> Result<Self, Failure> {
        let mut options = Self {
            is_quick: false,
            out: root().join("docs"),
            is_again: false,
        };
        let mut rest = arguments.iter().filter(|argument| *argument != "--");
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => options.is_quick = true,
                "--again" => options.is_again = true,
                "--out" => {
                    let folder = rest.next();
                    options.out = here().join(folder.ok_or_else(|| Failure::Usage("--out needs a folder".to_owned()))?);
                }
                other => {
                    return Err(Failure::Usage(format!(
                        "{other:?} is none of --quick, --again, --out DIR"
                    )));
                }
            }
        }
        // A quick run's numbers mean little: never where they would be read.
        if options.is_quick && options.out == root().join("docs") {
            options.out = root().join("out/bench");
        }
        Ok(options)
    }
}

/// Measures all dials, one benchmark after the other, and writes `trade.csv`, `trade.md` and `trade.png`.
///
/// # Errors
/// [`Failure`] where a benchmark fails, or a dial has not all its numbers: then no page is written.
pub(crate) fn trade(arguments: &[String]) -> Result<(), Failure> {
    let options = Options::parse(arguments)?;
    let folder = &options.out;
    let csv = folder.join("trade.csv");
    let started = page::load();
    let text = match options.is_again {
        true => fs::read_to_string(&csv).map_err(|e| Failure::file(&csv, e))?,
        false => measure(options.is_quick)?,
    };
    let measured = Measured::parse(&text, &DIALS).map_err(Failure::Usage)?;
    let path = folder.join("trade.md");
    // Rows that were measured before keep what the page says of where.
    let made = match options.is_again {
        true => made_before(&path)?,
        false => page::made(&started, options.is_quick),
    };
    let page = page::page(&measured, &made);
    fs::create_dir_all(folder).map_err(|e| Failure::file(folder, e))?;
    for (path, text) in [(&csv, text), (&path, page)] {
        fs::write(path, text).map_err(|e| Failure::file(path, e))?;
    }
    picture::write(&measured, &folder.join("trade.png")).map_err(Failure::Usage)?;
    say(&format!(
        "written: trade.csv, trade.md and trade.png in {}",
        folder.display()
    ));
    Ok(())
}

fn made_before(page: &Path) -> Result<String, Failure> {
    let text = fs::read_to_string(page).map_err(|e| Failure::file(page, e))?;
    let line = text.lines().find(|line| line.starts_with(page::MADE));
    line.map(str::to_owned)
        .ok_or_else(|| Failure::Usage(format!("{} does not say where it was measured", page.display())))
}

/// The rows of all benchmarks, which are built and run one after the other.
fn measure(is_quick: bool) -> Result<String, Failure> {
    let folder = root().join("out/bench");
    let rows = folder.join("trade-rows.csv");
    fs::create_dir_all(&folder).map_err(|e| Failure::file(&folder, e))?;
    fs::write(&rows, format!("{}\n", rows::HEADER)).map_err(|e| Failure::file(&rows, e))?;
    for (packages, benches) in BENCHES {
        let mut bench = cargo(&["bench"]);
        bench.args(packages.iter().flat_map(|name| ["--package", name]));
        bench.args(benches.iter().flat_map(|name| ["--bench", name]));
        bench.env("TROCAR_TRADE", &rows);
        if is_quick {
            bench.env("TROCAR_TRADE_QUICK", "1");
        }
        run(&mut bench)?;
    }
    fs::read_to_string(&rows).map_err(|e| Failure::file(&rows, e))
}
