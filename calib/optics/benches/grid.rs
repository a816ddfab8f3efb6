//! Grids at growing tilt: how many are found, how well, how fast, beside the thesis's way and OpenCV's; and disc by disc,
//! as the thesis counts.
//!
//! `cargo bench -p optics --bench grid`: the tables, of ours and the thesis's ways. With `-- opencv PYTHON` also those of
//! OpenCV on the same images (`PYTHON` has opencv-python-headless and numpy). `-- seeds N`: find rates over N seeds.
//! `-- wrong FIRST COUNT`: that many images at random tilt, roll and noise, with missing and false discs, and how many
//! grids have a disc with the wrong column or row; `-- dump FIRST COUNT` prints what is found in them, to compare builds.
//! `-- crowd`: the time for images of thousands of discs. `-- pieces FOLDER`: that for pieces of the photographs there.
//! `-- lens FIRST COUNT [opencv PYTHON] [only K1[,BLUR[,TILT]]]`: errors beside those stated, and beside OpenCV's, by lens, blur
//! and tilt, COUNT images each; `-- attacks FIRST COUNT [only WORD]`: under what no model has. Times are of the CPU.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "grid/attacks.rs"]
mod attacks;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "grid/crowd.rs"]
mod crowd;
#[path = "grid/lens.rs"]
mod lens;
#[path = "grid/opencv.rs"]
mod opencv;
#[path = "grid/pieces.rs"]
mod pieces;
#[path = "grid/series.rs"]
mod series;
#[path = "grid/thesis.rs"]
mod thesis;
#[path = "grid/wrong.rs"]
mod wrong;

use common::grid_series::Drawn;
use optics::grid::{Found, GridSpec};

pub(crate) const TILTS: [f64; 11] = [0.0, 15.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 75.0, 80.0, 84.0];
pub(crate) const NOISES: [f64; 3] = [2.0, 10.0, 25.0];

pub(crate) fn spec() -> GridSpec {
    GridSpec::new(10, 10, 20.0)
}

/// The place of a disc of 10 x 10 after some quarter turns.
pub(crate) fn turned(quarters: usize, [c, r]: [usize; 2]) -> [usize; 2] {
    match quarters {
        0 => [c, r],
        1 => [9 - r, c],
        2 => [9 - c, 9 - r],
        _ => [r, 9 - c],
    }
}

/// Root mean square distance to the truth, the smallest over the quarter turns that such a grid cannot tell, and the
/// largest of those distances.
pub(crate) fn errors(found: &Found, drawn: &Drawn) -> [f64; 2] {
    let of = |k: usize| {
        let offs = found.discs.iter().map(|d| {
            let [c, r] = turned(k, [d.col, d.row]);
            (d.at - drawn.centre(c, r)).norm()
        });
        let all: Vec<f64> = offs.collect();
        let squares: f64 = all.iter().map(|e| e * e).sum();
        [
            (squares / all.len() as f64).sqrt(),
            all.iter().copied().fold(0.0, f64::max),
        ]
    };
    (0..4).map(of).min_by(|a, b| a[0].total_cmp(&b[0])).unwrap()
}

/// CPU time of this thread so far, ms, from the kernel; NaN where it does not tell.
pub(crate) fn cpu_ms() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let ns = text.split_whitespace().next().and_then(|w| w.parse::<f64>().ok());
    ns.unwrap_or(f64::NAN) * 1e-6
}

fn number(words: &[String], after: &str, k: usize) -> Option<u64> {
    let place = words.iter().position(|w| w == after)?;
    words.get(place + 1 + k)?.parse().ok()
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    if let Some(first) = number(&words, "wrong", 0) {
        return wrong::run(first, number(&words, "wrong", 1).unwrap_or(1000));
    }
    if let Some(first) = number(&words, "dump", 0) {
        return wrong::dump(first, number(&words, "dump", 1).unwrap_or(100));
    }
    if words.iter().any(|w| w == "crowd") {
        return crowd::run();
    }
    if let Some(i) = words.iter().position(|w| w == "pieces") {
        return pieces::run(words.get(i + 1).unwrap());
    }
    if let Some(seeds) = number(&words, "seeds", 0) {
        return series::seeds(seeds);
    }
    let python = words.iter().position(|w| w == "opencv").and_then(|i| words.get(i + 1));
    let python = python.map(String::as_str);
    let only = words.iter().position(|w| w == "only").and_then(|i| words.get(i + 1));
    let only = only.map(String::as_str);
    if let Some(first) = number(&words, "lens", 0) {
        return lens::run(python, first, number(&words, "lens", 1).unwrap_or(100), only);
    }
    if let Some(first) = number(&words, "attacks", 0) {
        let count = number(&words, "attacks", 1).unwrap_or(20);
        return attacks::attacked(python, first, count, only);
    }
    series::tables(python);
}
