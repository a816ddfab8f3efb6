//! What the benchmarks share: the clock, the machine's own rate, and files of results.

#![allow(dead_code, reason = "each benchmark is a crate of its own and uses its part")]

use std::path::PathBuf;

use nalgebra::DMatrix;
use picture::chart::{Chart, Mark, Series};
use picture::{Canvas, Rgb};

/// Seconds of this thread's processor.
pub(crate) fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The least time of `rounds`, in milliseconds, and the last result.
pub(crate) fn least<T>(rounds: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut best = f64::INFINITY;
    let mut last = None;
    for _ in 0..rounds.max(1) {
        let began = now();
        last = Some(work());
        best = best.min(1e3 * (now() - began));
    }
    (best, last.unwrap())
}

/// Says how busy the machine is: other work makes even processor time longer, as it takes the caches.
pub(crate) fn say_load() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    println!("load of the machine: {} on {cores} cores", load.trim());
}

/// Gflop/s of one thread in a product of dense matrices (nalgebra, matrixmultiply): the rate that the machine has now.
pub(crate) fn peak() -> f64 {
    let n = 384;
    let a = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
    let (b, mut c) = (a.transpose(), DMatrix::zeros(n, n));
    let (milliseconds, ()) = least(10, || c.gemm(1.0, &a, &b, 0.0));
    2e-6 * (n * n * n) as f64 / milliseconds
}

/// Writes a table as `out/bench/NAME.csv`.
pub(crate) fn write_csv(name: &str, header: &str, rows: &[String]) {
    let text = format!("{header}\n{}\n", rows.join("\n"));
    std::fs::write(folder().join(format!("{name}.csv")), text).unwrap();
}

/// Draws charts one below the other as `out/bench/NAME.png`.
pub(crate) fn write_charts(name: &str, charts: &[Chart]) {
    let (width, height) = (1100, 620);
    let mut sheet = Canvas::new(width, height * charts.len() as u32);
    let bytes = (4 * width * height) as usize;
    for (k, chart) in charts.iter().enumerate() {
        let drawn = chart.draw(width, height);
        assert_eq!(drawn.skipped, 0, "{name}: points that cannot be drawn");
        sheet.rgba_mut()[k * bytes..(k + 1) * bytes].copy_from_slice(drawn.canvas.rgba());
    }
    let path = folder().join(format!("{name}.png"));
    picture::write_png(&path, &sheet, &[]).unwrap();
    println!("written: {} and its .csv", path.display());
}

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../out/bench");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Joined points, by colour.
pub(crate) fn line(name: &str, colour: Rgb, points: impl IntoIterator<Item = [f64; 2]>) -> Series {
    Series::joined(name, colour, Mark::Dot, points)
}
