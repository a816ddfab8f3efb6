//! How well the detector of discs tells markers from other things in patches of CT slices, beside the Laplacian of a
//! Gaussian.
//!
//! `cargo bench -p optics --bench bead_roc`. Reads `../shared/data/bead-patches-ct` (300 patches of spherical navigation
//! markers and 300 of other structures, 36 x 36 pixels of 8 bits, windowed), beside the workspace; without it, it says so
//! and ends. A patch's score is the greatest response within four pixels of its middle: of chi and of its significance
//! over the ladder of radii that a whole patch has room for, of the scale-normalised Laplacian at the best of its scales,
//! and of the shell for hollow markers (`optics::shell`); the last also on each half of the patches,
//! in the order of their files. Writes `out/bench/bead_roc.{csv,png}`: share of markers found over share of others taken for one, the area
//! under it with its standard error (Hanley and McNeil 1982), and the point of the default threshold.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

#[path = "bead_roc/laplacian.rs"]
mod laplacian;

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use optics::disc::{DetectOptions, Disc, Polarity, detect};
use optics::image::Image;
use optics::shell;
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::write_png;

/// Radii for which inside, gap and ring find room about the middle of a patch, pixels.
const RADII: [f64; 2] = [2.0, 9.5];
/// Radii of markers' outlines, pixels.
const OUTLINES: [f64; 11] = [5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];
/// A marker's centre is within this of the patch's, pixels.
const NEAR: f64 = 4.0;

/// One detector's scores of markers and of others.
struct Scored {
    name: String,
    markers: Vec<f64>,
    others: Vec<f64>,
}

/// An 8-bit grey PNG.
fn read(path: &Path) -> Option<Image> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).ok()?))
        .read_info()
        .ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let (width, height) = (info.width as usize, info.height as usize);
    let grey = info.color_type == png::ColorType::Grayscale && info.bit_depth == png::BitDepth::Eight;
    grey.then(|| Image::from_bytes(width, height, &bytes[..width * height]).ok())?
}

fn patches(folder: &Path) -> Vec<Image> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    paths.iter().filter_map(|p| read(p)).collect()
}

/// Discs near the middle, with the thresholds of these options.
fn discs(patch: &Image, options: &DetectOptions) -> Vec<Disc> {
    let middle = [patch.width(), patch.height()].map(|n| (n as f64 - 1.0) / 2.0);
    let near = |d: &Disc| (d.at[0] as f64 - middle[0]).hypot(d.at[1] as f64 - middle[1]) <= NEAR;
    detect(patch, options)
        .unwrap_or_default()
        .into_iter()
        .filter(near)
        .collect()
}

fn options() -> DetectOptions {
    DetectOptions {
        polarity: Polarity::Bright,
        ..DetectOptions::new(RADII[0], RADII[1])
    }
}

/// Every local maximum, whatever its height.
fn open() -> DetectOptions {
    DetectOptions {
        deviations: -1e9,
        least: 0.0,
        ..options()
    }
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

fn scored(name: &str, sets: &[Vec<Image>; 2], score: impl Fn(&Image) -> f64) -> Scored {
    let [markers, others] = sets.each_ref().map(|set| set.iter().map(&score).collect());
    Scored {
        name: name.to_owned(),
        markers,
        others,
    }
}

/// (share of others, share of markers) at or above every score, from none to all.
fn curve(scored: &Scored) -> Vec<[f64; 2]> {
    let mut levels: Vec<f64> = scored.markers.iter().chain(&scored.others).copied().collect();
    levels.sort_by(|a, b| b.total_cmp(a));
    levels.dedup();
    let share = |set: &[f64], level: f64| set.iter().filter(|s| **s >= level).count() as f64 / set.len() as f64;
    let mut points = vec![[0.0, 0.0]];
    points.extend(
        levels
            .iter()
            .map(|l| [share(&scored.others, *l), share(&scored.markers, *l)]),
    );
    points
}

/// The area under the curve and its standard error.
fn area(scored: &Scored) -> [f64; 2] {
    let points = curve(scored);
    let steps = points.windows(2);
    let a: f64 = steps.map(|w| (w[1][0] - w[0][0]) * (w[0][1] + w[1][1]) / 2.0).sum();
    let (m, n) = (scored.markers.len() as f64, scored.others.len() as f64);
    let (q1, q2) = (a / (2.0 - a), 2.0 * a * a / (1.0 + a));
    let variance = (a * (1.0 - a) + (m - 1.0) * (q1 - a * a) + (n - 1.0) * (q2 - a * a)) / (m * n);
    [a, variance.max(0.0).sqrt()]
}

/// The point where the share of markers exceeds that of others most.
fn best(points: &[[f64; 2]]) -> [f64; 2] {
    let order = |a: &&[f64; 2], b: &&[f64; 2]| (a[1] - a[0]).total_cmp(&(b[1] - b[0]));
    points.iter().max_by(order).copied().unwrap_or_default()
}

/// Shares of others and of markers in which the default threshold finds a disc.
fn at_default(sets: &[Vec<Image>; 2]) -> [f64; 2] {
    let share = |set: &Vec<Image>| {
        let found = set.iter().filter(|p| !discs(p, &options()).is_empty()).count();
        found as f64 / set.len() as f64
    };
    [share(&sets[1]), share(&sets[0])]
}

fn report(all: &[Scored], default: [f64; 2], folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    let mut csv = "detector,area,area_error,best_others,best_markers\n".to_owned();
    let (x, y) = (
        Axis::linear("share of other structures taken for a marker"),
        Axis::linear("share of markers found"),
    );
    let mut chart = Chart::new(
        "300 markers and 300 other structures",
        x.within(0.0, 1.0),
        y.within(0.0, 1.0),
    );
    for (scored, colour) in all.iter().zip(COLOURS) {
        let ([a, error], points) = (area(scored), curve(scored));
        let [others, markers] = best(&points);
        println!(
            "{:<34} area {a:.3} +- {error:.3}; best: {markers:.3} of markers at {others:.3} of others",
            scored.name
        );
        csv.push_str(&format!("{},{a:.4},{error:.4},{others:.4},{markers:.4}\n", scored.name));
        chart.push(Series::joined(
            format!("{} {a:.3}", scored.name),
            colour,
            Mark::None,
            points,
        ));
    }
    let [others, markers] = default;
    println!("chi at its default threshold: {markers:.3} of markers at {others:.3} of others");
    csv.push_str(&format!("chi at its default threshold,,,{others:.4},{markers:.4}\n"));
    chart.push(Series::scatter(
        "chi's default threshold",
        COLOURS[5],
        Mark::Square,
        [default],
    ));
    fs::write(folder.join("bead_roc.csv"), csv)?;
    let drawn = chart.draw(1000, 760);
    write_png(&folder.join("bead_roc.png"), &drawn.canvas, &[]).map_err(std::io::Error::other)
}

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = root.join("../shared/data/bead-patches-ct");
    let sets = ["pos", "neg"].map(|name| patches(&data.join(name)));
    if sets.iter().any(Vec::is_empty) {
        println!("not run: {} holds no patches", data.display());
        return Ok(());
    }
    let mut all = vec![
        scored("chi", &sets, |p| {
            greatest(discs(p, &open()).iter().map(|d| -d.chi.value))
        }),
        scored("chi's significance", &sets, |p| {
            greatest(discs(p, &open()).iter().map(|d| -d.chi.significance))
        }),
    ];
    let scales = [1.4, 2.0, 2.8, 4.0, 5.6, 8.0];
    let each = scales.map(|s| {
        scored(&format!("Laplacian of {s} px"), &sets, |p| {
            laplacian::score(p, &[s], NEAR)
        })
    });
    all.push(scored("Laplacian, greatest of all scales", &sets, |p| {
        laplacian::score(p, &scales, NEAR)
    }));
    let shells = |p: &Image| {
        shell::best(p, &OUTLINES, NEAR)
            .ok()
            .flatten()
            .map_or(0.0, |fit| fit.chi)
    };
    let hollow = scored("chi of a shell", &sets, shells);
    for (which, range) in [("first", 0..150), ("second", 150..300)] {
        let half = |set: &Vec<f64>| set.get(range.clone()).unwrap_or_default().to_vec();
        let [a, error] = area(&Scored {
            name: String::new(),
            markers: half(&hollow.markers),
            others: half(&hollow.others),
        });
        println!("chi of a shell, {which} half of the patches: area {a:.3} +- {error:.3}");
    }
    all.push(hollow);
    all.extend(each.into_iter().max_by(|a, b| area(a)[0].total_cmp(&area(b)[0])));
    report(&all, at_default(&sets), &root.join("out/bench"))
}
