//! The whole way of a registration by ultrasound, with its truth: a generated patient's CT, the pelvis taken from it, a probe that
//! glides over his skin, bone in its images, registration.
//!
//! ```text
//! cargo bench --bench probe_walk -- [seeds] [--first SEED] [--images COUNT] [--pictures FOLDER]
//! ```
//!
//! For each seed another patient, another hand, another speed of sound, another noise, and another error of the probe's calibration,
//! drawn from what is told of it. Printed are the error at the patient's five nodes beside the one predicted, how far the points lie from
//! the true bone, what it took, and what becomes of the sweep where the scanner mirrored its picture since; `--images` sweeps no further than that many images; at the end medians, the worst, and how many were refused or wrong.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "probe_walk/ct.rs"]
mod ct;
#[path = "../study/src/sounding.rs"]
mod sounding;
#[path = "probe_walk/sweep.rs"]
mod sweep;

use bus::clock::monotonic_ns;
use geometry::{Ct, Point, Tracker};
use phantom::Phantom;
use surface_registration::{Field, Limits, Options, Spacing, Start, Surface, SurfaceRegistration, register};
use sweep::{Sweep, Swept};

fn main() {
    // Cargo adds `--bench`.
    let args: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let after = |name: &str| {
        args.iter()
            .position(|a| a == name)
            .and_then(|place| args.get(place + 1))
    };
    let seeds: u64 = args.first().and_then(|a| a.parse().ok()).unwrap_or(50);
    let first: u64 = after("--first").and_then(|a| a.parse().ok()).unwrap_or(1);
    println!(
        "| seed | images, with bone | points: off the true bone mm (bias, scatter, told; far) | TRE mm | predicted | offset, speed % | verdict | mirrored picture: costs more, TRE mm, verdict | s: sound, find, register |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut walks = Vec::new();
    for seed in first..first + seeds {
        let images = after("--images").and_then(|a| a.parse().ok()).unwrap_or(usize::MAX);
        let walk = walk(seed, images, after("--pictures").map(String::as_str));
        println!("{}", walk.line(seed));
        walks.push(walk);
    }
    summary(&walks);
}

/// On the machine's clock, s.
fn seconds_since(began_ns: i64) -> f64 {
    (monotonic_ns() - began_ns) as f64 / 1e9
}

struct Walk {
    swept: Swept,
    tre_mm: f64,
    predicted_mm: f64,
    offset_mm: f64,
    speed: f64,
    refused: Option<String>,
    register_s: f64,
    mirrored: Mirrored,
}

/// The same sweep by a scanner that mirrored its picture since the probe was calibrated.
struct Mirrored {
    /// By how much it costs more, squares of deviations.
    margin: f64,
    tre_mm: f64,
    /// Why it is refused by everything but the comparison with the other picture.
    refused: Option<String>,
}

fn walk(seed: u64, images: usize, pictures: Option<&str>) -> Walk {
    let patient = Phantom::new(seed);
    let bone = ct::pelvis(&patient);
    let triangles: Vec<[f64; 3]> = bone.places.iter().map(|place| place.mm.into()).collect();
    let surface = Surface::<Ct>::new(&triangles, &bone.triangles).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let swept = Sweep::of(&patient, seed, images).go(pictures);
    let began = monotonic_ns();
    let mut options = Options::default();
    options.priors.bone_mm = bone.deviation_rms_mm().max(0.05);
    let found = register(&surface, &field, &swept.points, &Start::Nothing, &options).unwrap();
    let register_s = seconds_since(began);
    let targets: Vec<Point<Ct>> = patient.targets().iter().map(|target| target.centre).collect();
    let count = targets.len() as f64;
    let predicted = targets.iter().map(|target| found.predicted_tre_mm(*target).powi(2));
    let refusals = Limits::default().judge(&found, &targets);
    let turned = register(&surface, &field, &swept.mirrored, &Start::Nothing, &options);
    let off = |found: &SurfaceRegistration<Ct, Tracker>| {
        let each = targets.iter().map(|target| {
            let there = swept.tracker_from_ct * *target;
            (found.transform.transform() * there).distance(*target).powi(2)
        });
        (each.sum::<f64>() / targets.len() as f64).sqrt()
    };
    let mirrored = match turned {
        Ok(turned) => Mirrored {
            margin: found.margin_over(&turned),
            tre_mm: off(&turned),
            refused: Limits::default()
                .judge(&turned, &targets)
                .first()
                .map(ToString::to_string),
        },
        // Most of its points lie beyond the CT's end wherever it is put.
        Err(why) => Mirrored {
            margin: f64::INFINITY,
            tre_mm: f64::INFINITY,
            refused: Some(why.to_string()),
        },
    };
    Walk {
        tre_mm: off(&found),
        predicted_mm: (predicted.sum::<f64>() / count).sqrt(),
        offset_mm: found.offset_mm,
        speed: found.depth_scale,
        refused: refusals.first().map(ToString::to_string),
        register_s,
        mirrored,
        swept,
    }
}

impl Walk {
    fn line(&self, seed: u64) -> String {
        let swept = &self.swept;
        let [bias, scatter, told] = swept.off_mm;
        format!(
            "| {seed} | {}, {} | {}: {bias:.2}, {scatter:.2}, {told:.2}; {:.3} | {:.2} | {:.2} | {:.2}, {:.2} of {:.2} | {} | {:.0}, {:.1}, {} | {:.2}, {:.2}, {:.2} |",
            swept.images,
            swept.with_bone,
            swept.points.points().len(),
            swept.far,
            self.tre_mm,
            self.predicted_mm,
            self.offset_mm,
            100.0 * self.speed,
            100.0 * (swept.speed - 1.0),
            self.refused.as_deref().unwrap_or("taken"),
            self.mirrored.margin,
            self.mirrored.tre_mm,
            self.mirrored.refused.as_deref().unwrap_or("taken"),
            swept.seconds[0],
            swept.seconds[1],
            self.register_s
        )
    }
}

fn summary(walks: &[Walk]) {
    let margins = walks.iter().map(|walk| walk.mirrored.margin);
    let are_taken = |walk: &&Walk| walk.mirrored.refused.is_none();
    println!(
        "mirrored pictures: the least costs {:.0} more; {} of {} would be taken, {} of them with less than {} more",
        margins.fold(f64::INFINITY, f64::min),
        walks.iter().filter(are_taken).count(),
        walks.len(),
        walks
            .iter()
            .filter(are_taken)
            .filter(|walk| walk.mirrored.margin < Limits::default().least_margin)
            .count(),
        Limits::default().least_margin,
    );
    let in_doubt = walks
        .iter()
        .filter(|walk| walk.refused.is_none() && walk.mirrored.margin < Limits::default().least_margin);
    println!(
        "right pictures that were taken and whose mirror image costs less than that more: {}",
        in_doubt.count()
    );
    let taken: Vec<&Walk> = walks.iter().filter(|walk| walk.refused.is_none()).collect();
    let mut tre: Vec<f64> = taken.iter().map(|walk| walk.tre_mm).collect();
    tre.sort_by(f64::total_cmp);
    if tre.is_empty() {
        println!("{} walks, all refused", walks.len());
        return;
    }
    let square = |of: fn(&Walk) -> f64| taken.iter().map(|walk| of(walk).powi(2)).sum::<f64>() / taken.len() as f64;
    println!(
        "{} walks, {} refused; of the others TRE median {:.2}, worst {:.2} mm; rms {:.2} where {:.2} is predicted; {} of 2 mm and more",
        walks.len(),
        walks.len() - taken.len(),
        tre[tre.len() / 2],
        tre[tre.len() - 1],
        square(|walk| walk.tre_mm).sqrt(),
        square(|walk| walk.predicted_mm).sqrt(),
        tre.iter().filter(|tre| **tre >= 2.0).count()
    );
}
