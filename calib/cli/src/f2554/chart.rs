//! The chart of the turns about the tip.

use std::collections::BTreeMap;
use std::path::Path;

use calib::f2554::{Sample, Test};
use geometry::{Point, Tracker};
use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{PngError, write_png};

/// Samples of this many degrees are taken together.
const BIN_DEG: f64 = 15.0;

/// Draws the root mean square distance of the tip from the mean of its test, over the angle of the pointer, all places
/// together, and that of the single point as a line: a tip that is calibrated well stays at that line.
pub(super) fn write(path: &Path, samples: &[Sample], title: &str) -> Result<(), PngError> {
    let (x, y) = (
        Axis::linear("turn of the pointer, degrees"),
        Axis::linear("root mean square distance from the test's mean, mm"),
    );
    let mut chart = Chart::new(title, x, y);
    let marks = [Mark::Dot, Mark::Square, Mark::Triangle];
    let mut widest = BIN_DEG;
    for ((test, mark), colour) in Test::TURNS.into_iter().zip(marks).zip(COLOURS) {
        let points = binned(&distances(samples, test));
        widest = points.iter().map(|p| p[0].abs()).fold(widest, f64::max);
        if !points.is_empty() {
            chart.push(Series::joined(test.name(), colour, mark, points));
        }
    }
    let single: Vec<f64> = distances(samples, Test::Single).iter().map(|p| p[1]).collect();
    if !single.is_empty() {
        let level = rms(&single);
        let line = [[-widest, level], [widest, level]];
        let series = Series::joined("single point", COLOURS[6], Mark::None, line);
        chart.push(series.dashed());
    }
    chart.y.range = Some([0.0, 1.1 * top(&chart)]);
    write_png(path, &chart.draw(1100, 700).canvas, &[("title", title.to_owned())])
}

fn rms(list: &[f64]) -> f64 {
    (list.iter().map(|x| x * x).sum::<f64>() / list.len() as f64).sqrt()
}

/// The highest point of a chart.
fn top(chart: &Chart) -> f64 {
    let points = chart.series.iter().flat_map(|series| &series.points);
    points.map(|p| p[1]).fold(1e-6, f64::max)
}

/// The middle and the root mean square of the distances of each bin of angles.
fn binned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut bins: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
    for [angle, distance] in points {
        // Angles are at most 1e9 degrees.
        bins.entry((angle / BIN_DEG).round() as i32)
            .or_default()
            .push(*distance);
    }
    bins.iter()
        .map(|(bin, list)| [f64::from(*bin) * BIN_DEG, rms(list)])
        .collect()
}

/// Angle and distance from the mean of the place's test, of every sample.
fn distances(samples: &[Sample], test: Test) -> Vec<[f64; 2]> {
    let mut list: Vec<&Sample> = samples.iter().filter(|s| s.test == test).collect();
    list.sort_by_key(|s| s.place);
    let groups = list.chunk_by(|a, b| a.place == b.place);
    let of = |group: &[&Sample]| {
        let n = group.len() as f64;
        let mean = |k: usize| group.iter().map(|s| s.at.mm()[k]).sum::<f64>() / n;
        let mean: Point<Tracker> = Point::new(mean(0), mean(1), mean(2));
        let one = |s: &&Sample| [s.angle_rad.to_degrees(), s.at.distance(mean)];
        group.iter().map(one).collect::<Vec<_>>()
    };
    groups.flat_map(of).collect()
}
