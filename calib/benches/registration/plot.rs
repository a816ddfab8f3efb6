//! The ladder as a table for other programs and as a picture.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use picture::chart::{Axis, COLOURS, Chart, Mark, Series};
use picture::{PngError, Rgb, write_png};

use super::ladder::{Rung, Solver, median};

/// The bound that the tests hold the default method to.
const BOUND: f64 = 20.0;
/// Smaller errors, in units, are drawn here: an axis of logarithms has no zero.
const LEAST: f64 = 1e-3;

/// Why the results were not written.
#[derive(Debug)]
pub(crate) enum PlotError {
    Table(PathBuf, io::Error),
    Picture(PngError),
}

impl std::fmt::Display for PlotError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Table(path, source) => write!(f, "writing {}: {source}", path.display()),
            Self::Picture(source) => source.fmt(f),
        }
    }
}

/// Writes `registration.csv` and `registration.png` and returns their folder, `out/bench` of the workspace.
pub(crate) fn write(rungs: &[Rung]) -> Result<PathBuf, PlotError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../out/bench");
    let csv = folder.join("registration.csv");
    let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&csv, table(rungs)));
    written.map_err(|source| PlotError::Table(csv, source))?;
    let drawn = chart(rungs).draw(1200, 760);
    write_png(&folder.join("registration.png"), &drawn.canvas, &[]).map_err(PlotError::Picture)?;
    Ok(folder)
}

fn table(rungs: &[Rung]) -> String {
    let mut text = "solver,condition,time_ns,median_rad,worst_rad,median_units,worst_units,lost\n".to_owned();
    for rung in rungs {
        let [median_rad, worst_rad] = rung.angle_rad;
        let [median_units, worst_units] = rung.units;
        let _ = writeln!(
            text,
            "{},{:e},{:.1},{median_rad:e},{worst_rad:e},{median_units:e},{worst_units:e},{}",
            rung.solver.name(),
            rung.condition,
            rung.time_ns,
            rung.lost
        );
    }
    text
}

fn chart(rungs: &[Rung]) -> Chart {
    let (low, high) = ends(rungs);
    let mut chart = Chart::new(
        "Paired-point registration, 24 points: error against time",
        Axis::log("time of a whole fit, from points to rotation, ns").within(low, high),
        Axis::log(
            "angle to the true rotation, in 2^-53 x condition (0.001 and less at the bottom); conditions 1 to 1e12, exact data",
        ),
    );
    for (solver, colour) in Solver::ALL.into_iter().zip(COLOURS) {
        let mine: Vec<&Rung> = rungs.iter().filter(|rung| rung.solver == solver).collect();
        add(&mut chart, &solver.name(), colour, &mine);
    }
    let bound = Series::joined(
        "bound of the default, 20",
        Rgb(60, 60, 60),
        Mark::None,
        [[low, BOUND], [high, BOUND]],
    );
    chart.push(bound.dashed());
    let key = |mark, name| Series::scatter(name, Rgb(60, 60, 60), mark, []);
    chart.push(key(Mark::Small, "one condition, worst set"));
    chart.push(key(Mark::Dot, "median of all"));
    chart.push(key(Mark::Triangle, "worst of all"));
    chart
}

/// A little more than the range of the times.
fn ends(rungs: &[Rung]) -> (f64, f64) {
    let times = rungs.iter().map(|rung| rung.time_ns);
    let (low, high) = times.fold((f64::INFINITY, 0.0_f64), |(low, high), t| (low.min(t), high.max(t)));
    (low * 0.7, high * 1.3)
}

fn add(chart: &mut Chart, name: &str, colour: Rgb, rungs: &[&Rung]) {
    let worst = |r: &Rung| r.units[1].max(LEAST);
    let small = rungs.iter().map(|r| [r.time_ns, worst(r)]);
    chart.push(Series::scatter("", colour, Mark::Small, small));
    let time = median(rungs.iter().map(|r| r.time_ns).collect());
    let middle = median(rungs.iter().map(|r| r.units[0].max(LEAST)).collect());
    let top = rungs
        .iter()
        .map(|r| worst(r))
        .filter(|x| x.is_finite())
        .fold(LEAST, f64::max);
    chart.push(Series::joined("", colour, Mark::None, [[time, middle], [time, top]]));
    chart.push(Series::scatter(name, colour, Mark::Dot, [[time, middle]]));
    chart.push(Series::scatter("", colour, Mark::Triangle, [[time, top]]));
}
