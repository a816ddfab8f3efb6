//! Dials of the tissue of a run: processor time of a frame's own thread while the tube presses, and how far places in the kidney
//! are from where states that are settled to 1e-8, or on finer cubes, have them.

use nalgebra::{Isometry3, Vector3};
use organs::Way;
use simulation::space::frames::{Frames, Settings, State};

use super::motion::{Noise, stroke};
use super::organ::{Shipped, Targets, pose};
use super::trade::{Dial, Row, Trade, median, processor_s};
use super::{ACROSS, DEPTH, TOUCH};

/// Cubes of what the cubes of others are held against, mm.
const FINE_MM: f64 = 10.0;

const SETTLED: &str = "largest distance of a place in the kidney to where the same cubes have it when settled to 1e-8 from pose to pose; 20 mm/s";
const CUBES: &str =
    "largest distance of a place in the kidney to where cubes of 10 mm have it when settled to 1e-6; 20 mm/s";

type Poses = Vec<Isometry3<f64>>;
/// Places in the kidney at each pose.
type Truth = Vec<Option<Vec<Vector3<f64>>>>;

/// In, held, aside, along and out, with noise of the tracker.
fn poses(trade: &Trade, way: &Way) -> Poses {
    let across = way
        .direction
        .cross(&Vector3::ith(way.direction.imin(), 1.0))
        .normalize();
    let (other, mut noise) = (way.direction.cross(&across), Noise(1));
    let speed = if trade.is_quick { 100.0 } else { 20.0 };
    let places = stroke(TOUCH, DEPTH, ACROSS, 0.7, speed).into_iter();
    let mut at = places.map(|p| {
        pose(
            way,
            p.gone,
            &(across * p.aside[0] + other * p.aside[1] + noise.vector(0.05)),
        )
    });
    if trade.is_quick {
        at.by_ref().take(20).collect()
    } else {
        at.collect()
    }
}

/// Where places are at each `every`th pose; `None` where no state is settled.
fn settled(mut frames: Frames, targets: &Targets, poses: &Poses, every: usize) -> Truth {
    let each = poses.iter().step_by(every).map(|pose| {
        let is_settled = (0..20).any(|_| frames.frame(pose).state == State::Settled);
        // Once more: factors are of this pose then, and the next one begins with them.
        frames.frame(pose);
        is_settled.then(|| targets.moved(frames.state()))
    });
    let truth: Truth = each.collect();
    let count = truth.iter().flatten().count();
    println!("the truth is settled at {count} of {} poses", truth.len());
    assert!(10 * count >= 9 * truth.len(), "nine of ten poses have a truth");
    truth
}

/// Median milliseconds of frames that press, and the largest distance to the truth, of contestants who take turns at each pose.
fn race(all: &mut [(Frames, Targets)], poses: &Poses, truth: &Truth, every: usize) -> Vec<(f64, f64)> {
    let (mut times, mut worst) = (vec![Vec::new(); all.len()], vec![0.0_f64; all.len()]);
    for (k, pose) in poses.iter().enumerate() {
        for (i, (frames, targets)) in all.iter_mut().enumerate() {
            let began = processor_s();
            let frame = frames.frame(pose);
            let ms = 1e3 * (processor_s() - began);
            if frame.force.points > 0 {
                times[i].push(ms);
            }
            if let Some(truth) = truth[k / every].as_ref().filter(|_| k.is_multiple_of(every)) {
                let moved = targets.moved(frames.state());
                let off = moved.iter().zip(truth).map(|(a, b)| (a - b).norm());
                worst[i] = off.fold(worst[i], f64::max);
            }
        }
    }
    times.into_iter().map(median).zip(worst).collect()
}

fn write(
    trade: &Trade,
    name: &'static str,
    chosen: &str,
    against: &'static str,
    names: &[String],
    measured: Vec<(f64, f64)>,
) {
    let dial = Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "ms a pose that presses",
        error_unit: "mm",
        against,
    };
    let rows: Vec<Row> = names
        .iter()
        .cloned()
        .zip(measured)
        .map(|(name, (ms, mm))| (name, ms, mm))
        .collect();
    trade.write(&dial, &rows);
}

type Change = fn(&mut Settings, f64);

pub(crate) fn measure(trade: &Trade) {
    let (shipped, usual) = (Shipped::read(), Settings::default());
    let strict = |tolerance: f64| Settings {
        tolerance,
        depth: 0.1 * tolerance,
        delay: 0,
        most_steps: 40,
        ..usual
    };
    let model = shipped.model();
    let (frames, way, targets) = shipped.frames(&model, &strict(1e-8));
    println!("{} unknowns, {} places", frames.state().len(), targets.len());
    let poses = poses(trade, &way);
    let truth = settled(frames, &targets, &poses, 1);
    let dials: [(&str, &[f64], f64, &str, Change); 4] = [
        (
            "tissue-tolerance",
            &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5],
            usual.tolerance,
            "",
            |s, x| s.tolerance = x,
        ),
        (
            "tissue-refresh",
            &[0.25, 0.5, 1.0, 2.0, 4.0],
            usual.refresh,
            " mm",
            |s, x| s.refresh = x,
        ),
        (
            "tissue-delay",
            &[0.0, 1.0, 2.0, 4.0],
            usual.delay as f64,
            " states",
            |s, x| s.delay = x as usize,
        ),
        (
            "tissue-steps",
            &[3.0, 6.0, 12.0, 24.0],
            usual.most_steps as f64,
            "",
            |s, x| s.most_steps = x as usize,
        ),
    ];
    for (name, values, chosen, unit, change) in dials {
        let contestant = |value: &f64| {
            let mut settings = usual;
            change(&mut settings, *value);
            let (frames, _, targets) = shipped.frames(&model, &settings);
            (frames, targets)
        };
        let mut all: Vec<_> = values.iter().map(contestant).collect();
        let names: Vec<String> = values.iter().map(|v| format!("{v}{unit}")).collect();
        let measured = race(&mut all, &poses, &truth, 1);
        write(trade, name, &format!("{chosen}{unit}"), SETTLED, &names, measured);
    }
    cubes(trade, shipped, &poses, &strict(1e-6));
}

/// Each side with the usual settings. What is held against goes through every sixth pose, of which the tube goes 2 mm.
fn cubes(trade: &Trade, mut shipped: Shipped, poses: &Poses, strict: &Settings) {
    let (sides, every) = ([28.0, 20.0, 14.0], if trade.is_quick { 1 } else { 6 });
    let mut all = Vec::new();
    for side in sides {
        shipped = shipped.in_cubes_of(side);
        let (frames, _, targets) = shipped.frames(&shipped.model(), &Settings::default());
        println!("cubes of {side} mm: {} unknowns", frames.state().len());
        all.push((frames, targets));
    }
    let fine = if trade.is_quick { 14.0 } else { FINE_MM };
    let shipped = shipped.in_cubes_of(fine);
    let (frames, _, targets) = shipped.frames(&shipped.model(), strict);
    println!("cubes of {fine} mm: {} unknowns", frames.state().len());
    let truth = settled(frames, &targets, poses, every);
    let measured = race(&mut all, poses, &truth, every);
    let names = sides.map(|s| format!("{s} mm"));
    write(trade, "tissue-cube", "20 mm", CUBES, &names, measured);
}
