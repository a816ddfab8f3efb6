//! The safety distance of a tube that is dragged through 104 structures of 512 x 512 x 512 voxels: time and error of the index, of
//! all boundary voxels by force, and of an exact distance transform of one label. `cargo bench -p guidance --bench safety`.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "a benchmark measures real time")]
#![allow(clippy::print_stdout, reason = "the table is what this is for")]

mod others;
mod patient;

use std::hint::black_box;
use std::time::Instant;

use chance::SplitMix64;
use geometry::{Ct, Point};
use guidance::safety::{Distance, Structures, Tube};
use patient::{Patient, STRUCTURES};

const WITHIN_MM: f64 = 30.0;
const SECTIONS: usize = 200;
/// Steps of a drag.
const STEPS: usize = 120;
/// Steps that are also computed by force.
const FORCED: usize = 12;

/// A drag: the entry stays on the skin, the tip goes 0.5 mm a step.
fn drag(random: &mut SplitMix64, length: f64, radius: f64) -> Vec<Tube> {
    let mut point = |spread: f64| -> Point<Ct> {
        let [x, y, z] = [0; 3].map(|_| random.around(192.0, spread));
        Point::new(x, y, z)
    };
    let (entry, to, way) = (point(110.0), point(60.0), point(1.0));
    let aim = (to - entry).direction().unwrap();
    let drift = (way - Point::new(192.0, 192.0, 192.0)).direction().unwrap();
    (0..STEPS)
        .map(|k| Tube::new(entry, entry + aim * length + drift * (0.5 * k as f64), radius).unwrap())
        .collect()
}

/// Median and greatest time, ms.
fn times(mut each: Vec<f64>) -> [f64; 2] {
    each.sort_by(f64::total_cmp);
    [each[each.len() / 2], each[each.len() - 1]]
}

fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let began = Instant::now();
    let result = black_box(work());
    (result, began.elapsed().as_secs_f64() * 1e3)
}

/// The greatest difference from the least distance over boundary voxels, of structures outside the tube, mm.
fn difference(structures: &Structures, tube: &Tube, least: &[f64]) -> f64 {
    let found = structures.clearance(tube, WITHIN_MM).unwrap().structures;
    let off = found.iter().filter_map(|c| match c.distance {
        // Within the tube and a voxel about it, voxels that are no boundary count as well.
        Distance::Nearest(n) if n.distance_mm > c.voxel_half_diagonal_mm => {
            Some((n.distance_mm - least[c.label as usize]).abs())
        }
        _ => None,
    });
    off.fold(0.0, f64::max)
}

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().to_owned()
}

fn main() {
    let (patient, ms) = timed(Patient::new);
    let labelled = patient.labels.iter().filter(|&&l| l != 0).count() as f64 / patient.labels.len() as f64;
    println!(
        "load {}; the map took {ms:.0} ms to make, {:.0} % of it has a label",
        load(),
        100.0 * labelled
    );
    let build = || Structures::build(&patient.grid, |z, out| out.copy_from_slice(patient.slice(z))).unwrap();
    for _ in 0..3 {
        let (structures, ms) = timed(build);
        let boundary: u64 = structures.list().iter().map(|s| s.boundary_voxels()).sum();
        println!(
            "index of {} structures, {boundary} boundary voxels: {ms:.0} ms on one core, {} MiB",
            structures.list().len(),
            structures.bytes() >> 20
        );
    }
    let structures = build();
    let (points, ms) = timed(|| others::boundary(&patient));
    println!("{} boundary voxels listed by themselves: {ms:.0} ms", points.len());

    println!("\n{STEPS} steps of a drag, {SECTIONS} sections, within {WITHIN_MM} mm; ms as median / greatest");
    println!(
        "{:<26} {:>15} {:>15} {:>15} {:>18} {:>7} {:>14}",
        "tube", "clearance", "profile", "both", "by force", "ratio", "difference mm"
    );
    let mut random = SplitMix64::new(5);
    let mut kept = Vec::new();
    for (length, radius) in [
        (60.0, 3.0),
        (100.0, 6.0),
        (100.0, 6.0),
        (150.0, 6.0),
        (150.0, 12.0),
        (200.0, 25.0),
    ] {
        let tubes = drag(&mut random, length, radius);
        let (mut clearance, mut profile, mut cut) = (Vec::new(), Vec::new(), 0);
        for tube in &tubes {
            let (found, ms) = timed(|| structures.clearance(tube, WITHIN_MM).unwrap());
            clearance.push(ms);
            profile.push(timed(|| structures.profile(tube, SECTIONS, WITHIN_MM).unwrap()).1);
            cut = cut.max(found.structures.iter().filter(|c| c.cuts).count());
        }
        let both = clearance.iter().zip(&profile).map(|(a, b)| a + b).collect();
        let mut least = vec![f64::INFINITY; STRUCTURES as usize + 1];
        let (mut forced, mut worst) = (Vec::new(), 0.0_f64);
        for tube in tubes.iter().step_by(STEPS / FORCED) {
            forced.push(timed(|| others::forced(&points, tube, &mut least)).1);
            worst = worst.max(difference(&structures, tube, &least));
        }
        let name = format!("{length:.0} mm, r {radius:.0}, cuts {cut}");
        let [[c, c_most], [p, p_most], [b, b_most], [f, f_most]] = [clearance, profile, both, forced].map(times);
        println!(
            "{name:<26} {c:>7.2}/{c_most:<7.2} {p:>7.2}/{p_most:<7.2} {b:>7.2}/{b_most:<7.2} {f:>9.1}/{f_most:<8.1} {:>7.0} {worst:>14.1e}",
            f / c
        );
        kept.extend(tubes.into_iter().step_by(STEPS / 3));
    }

    let label = 7;
    let (field, ms) = timed(|| others::transform(&patient, label));
    println!(
        "\nexact distance transform of one label of {STRUCTURES}: {ms:.0} ms, {} MiB",
        (field.len() * 4) >> 20
    );
    let (mut each, mut off) = (Vec::new(), Vec::new());
    for tube in &kept {
        let found = structures.clearance(tube, 1e4).unwrap().structures;
        let truth = found.iter().find(|c| c.label == label).unwrap().distance_mm();
        if truth > 0.0 {
            let (mm, ms) = timed(|| others::sampled(&field, tube));
            each.push(ms);
            off.push((mm - truth).abs());
        }
    }
    let [median, most] = times(each);
    let worst = off.into_iter().fold(0.0, f64::max);
    println!(
        "its field read at points of the tube a voxel apart, interpolated: {median:.2}/{most:.2} ms a label, off by {worst:.3} mm at most"
    );
    println!("load {}", load());
}
