//! What finding beads costs and how exact it is, beside the Laplacian of a Gaussian.
//!
//! `cargo bench -p bead --bench bead`. A volume of 512 x 512 x 90 voxels of 0.8 x 0.8 x 1 mm: noise, a body in air, a
//! cortex of bone with hollow inside, a wire of metal, and 20 beads of 2 mm, clipped at 3071 HU. The rival is the usual
//! blob detector, written here: three separable passes of a Gaussian, second differences, local maxima above half of what
//! an ideal bead gives, and a parabola through each for the centre. Both take turns; times are the least of the rounds and
//! their median, in seconds of the wall, and nanoseconds per voxel; errors are those of the beads found.
//!
//! `cargo bench -p bead --bench bead -- whole`: a CT of 512 x 512 x 400 voxels by the beads' radius, beside one plain pass
//! over its values, in processor time, and the memory it takes.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

#[path = "bead/log.rs"]
mod log;
#[path = "../../../benches/shared/trade.rs"]
mod trade;
#[path = "bead/whole.rs"]
mod whole;

use std::time::Instant;

use bead::{Dense, Ground, Search, find};
use geometry::{Affine, VolumeGrid};
use trade::{Dial, Row, Trade, turns};

const DIMS: [usize; 3] = [512, 512, 90];
const STEP_MM: [f64; 3] = [0.8, 0.8, 1.0];
const BLUR_MM: f64 = 0.45;
const METAL_HU: f64 = 14_000.0;
const ROUNDS: usize = 5;

/// Numbers in 0..1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The tissue at a place, HU.
fn tissue([x, y, z]: [f64; 3]) -> f64 {
    let r = ((x - 205.0) / 180.0).hypot((y - 205.0) / 120.0);
    if r > 1.0 {
        return -1000.0;
    }
    let bone = ((x - 205.0).hypot(y - 260.0) - 15.0).abs();
    let wire = (x - 150.0).hypot(y - 200.0);
    match (bone, wire) {
        (bone, _) if bone < 2.0 => 1300.0,
        (_, wire) if wire < 1.0 && z > 10.0 => 8000.0,
        _ => 40.0,
    }
}

/// Adds a blurred ball, by small cubes.
fn add(centre: [f64; 3], radius_mm: f64, mut put: impl FnMut(usize, f64)) {
    let n = 12;
    let part = |i: i32| ((f64::from(i) + 0.5) * 2.0 / f64::from(n) - 1.0) * radius_mm;
    let cubes = (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n].map(part));
    let within = |c: &[f64; 3]| c.iter().map(|u| u * u).sum::<f64>() <= radius_mm * radius_mm;
    let cubes: Vec<[f64; 3]> = cubes.filter(within).collect();
    let norm = BLUR_MM.powi(3) * std::f64::consts::TAU.powf(1.5);
    let each = METAL_HU * 4.0 / 3.0 * std::f64::consts::PI * radius_mm.powi(3) / cubes.len() as f64 / norm;
    let reach = radius_mm + 3.0;
    let low = [0, 1, 2].map(|a| ((centre[a] - reach) / STEP_MM[a]) as usize);
    let high = [0, 1, 2].map(|a| ((centre[a] + reach) / STEP_MM[a]) as usize);
    for k in low[2]..high[2] {
        for j in low[1]..high[1] {
            for i in low[0]..high[0] {
                let d = [i, j, k].map(|v| v as f64);
                let d = [0, 1, 2].map(|a| d[a] * STEP_MM[a] - centre[a]);
                let seen = |c: &[f64; 3]| (-0.5 * (0..3).map(|a| ((d[a] - c[a]) / BLUR_MM).powi(2)).sum::<f64>()).exp();
                put(
                    (k * DIMS[1] + j) * DIMS[0] + i,
                    each * cubes.iter().map(seen).sum::<f64>(),
                );
            }
        }
    }
}

/// To values that are clipped already.
fn add_clipped(values: &mut [i16], centre: [f64; 3], radius_mm: f64) {
    add(centre, radius_mm, |at, hu| {
        values[at] = (f64::from(values[at]) + hu).min(3071.0).round() as i16
    });
}

/// Twenty places in the tissue.
fn bead_places(random: &mut Random) -> Vec<[f64; 3]> {
    let place = |i: i32| {
        let angle = f64::from(i) * 0.31;
        [
            205.0 + 95.0 * angle.cos() + random.next(),
            205.0 - 95.0 * angle.sin() + random.next(),
            12.0 + 3.3 * f64::from(i) + random.next(),
        ]
    };
    (0..20).map(place).collect()
}

/// Twenty places around the bone, 1.5 to 2.5 mm from its cortex.
fn beside_bone(random: &mut Random) -> Vec<[f64; 3]> {
    let place = |i: i32| {
        let (angle, r) = (f64::from(i) * 0.31, 18.5 + random.next());
        let (x, y) = (205.0 + r * angle.cos(), 260.0 - r * angle.sin());
        [x, y, 12.0 + 3.3 * f64::from(i) + random.next()]
    };
    (0..20).map(place).collect()
}

/// The volume and its beads' centres, mm.
fn specimen(places: fn(&mut Random) -> Vec<[f64; 3]>) -> (Vec<i16>, Vec<[f64; 3]>) {
    let mut random = Random(3);
    let [nx, ny, _] = DIMS;
    let voxel = |i: usize| [i % nx, i / nx % ny, i / nx / ny].map(|v| v as f64);
    let place = |i: usize| [0, 1, 2].map(|a| voxel(i)[a] * STEP_MM[a]);
    let mut values: Vec<f64> = (0..DIMS.iter().product())
        .map(|i| tissue(place(i)) + 60.0 * (random.next() - 0.5))
        .collect();
    let beads = places(&mut random);
    beads.iter().for_each(|c| add(*c, 1.0, |at, hu| values[at] += hu));
    (values.iter().map(|v| v.min(3071.0).round() as i16).collect(), beads)
}

/// (found, missed, false, root mean square error of the found ones in mm).
fn score(found: &[[f64; 3]], truth: &[[f64; 3]]) -> (usize, usize, usize, f64) {
    let distance = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt();
    let nearest = |q: &[f64; 3]| found.iter().map(|p| distance(p, q)).fold(f64::INFINITY, f64::min);
    let errors: Vec<f64> = truth.iter().map(nearest).filter(|e| *e < 1.5).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
    let wrong = found
        .iter()
        .filter(|p| truth.iter().all(|q| distance(p, q) > 1.5))
        .count();
    (errors.len(), truth.len() - errors.len(), wrong, rms)
}

fn line(name: &str, times: &mut [f64], score: (usize, usize, usize, f64)) {
    times.sort_by(f64::total_cmp);
    let voxels = DIMS.iter().product::<usize>() as f64;
    let (found, missed, wrong, rms) = score;
    println!(
        "{name:<24} {:>7.3} s least, {:>7.3} s median, {:>7.2} ns/voxel; {found} found, {missed} missed, {wrong} false, rms {rms:.4} mm",
        times[0],
        times[times.len() / 2],
        times[0] * 1e9 / voxels
    );
}

fn volume(values: Vec<i16>) -> Dense {
    let rows = [0, 1, 2].map(|a| {
        let mut row = [0.0; 4];
        row[a] = STEP_MM[a];
        row
    });
    let grid = VolumeGrid::checked(DIMS.map(|d| d as i64), Affine::from_rows(rows)).expect("a sound grid");
    Dense::new(grid, values).expect("as many values as voxels")
}

/// What the ground under a bead is taken for, and how well the beads' radius is known.
fn trade(trade: &Trade) {
    let (values, truth) = specimen(beside_bone);
    let volume = volume(values);
    let usual = Search::of_radius(1.0);
    let measure = |name, chosen: &str, cases: &[(&str, Search)]| {
        let mut errors = vec![f64::NAN; cases.len()];
        let times = turns(trade.rounds(1, 3), cases.len(), |k| {
            let found = find(&volume, &cases[k].1).expect("a search that can be").beads;
            let centres: Vec<[f64; 3]> = found.iter().map(|b| b.centre.mm()).collect();
            let (found, _, wrong, rms) = score(&centres, &truth);
            assert!(
                found == truth.len() && wrong == 0,
                "{}: {found} found, {wrong} false",
                cases[k].0
            );
            errors[k] = rms;
        });
        let row = |k: usize| -> Row { (cases[k].0.to_owned(), times[k], errors[k]) };
        let dial = Dial {
            name,
            chosen: chosen.to_owned(),
            time_unit: "s a volume of 512 x 512 x 90",
            error_unit: "mm",
            against: "root mean square of the centres of 20 beads put into a drawn body 1.5 to 2.5 mm from bone; noise of 17 HU; all are found and nothing else",
        };
        trade.write(&dial, &(0..cases.len()).map(row).collect::<Vec<_>>());
    };
    let grounds = [
        ("constant", Ground::Constant),
        ("plane", Ground::Sloping),
        ("second degree", Ground::Quadratic),
        ("random field", Ground::Correlated),
    ];
    let grounds = grounds.map(|(name, ground)| (name, Search { ground, ..usual }));
    measure("bead-ground", "random field", &grounds);
    let radii = [
        ("0.9 to 1.1 mm", [0.9, 1.1]),
        ("0.8 to 1.25 mm", usual.radius_mm),
        ("0.7 to 1.5 mm", [0.7, 1.5]),
        ("0.65 to 2 mm", [0.65, 2.0]),
    ];
    let radii = radii.map(|(name, radius_mm)| (name, Search { radius_mm, ..usual }));
    measure("bead-radius", "0.8 to 1.25 mm", &radii);
}

fn main() {
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade);
    }
    if std::env::args().any(|a| a == "whole") {
        return whole::run();
    }
    let (values, truth) = specimen(bead_places);
    let volume = volume(values.clone());
    let search = Search::of_radius(1.0);
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let (mut found, mut blobs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let start = Instant::now();
        found = find(&volume, &search).expect("a search that can be").beads;
        ours.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        blobs = log::blobs(&values, DIMS, STEP_MM, 1.0);
        theirs.push(start.elapsed().as_secs_f64());
    }
    let centres: Vec<[f64; 3]> = found.iter().map(|b| b.centre.mm()).collect();
    line("chi and model", &mut ours, score(&centres, &truth));
    line("Laplacian of Gaussian", &mut theirs, score(&blobs, &truth));
    println!("ratio {:.2} of the least times", ours[0] / theirs[0]);
}
