//! Grids at growing tilt: how many are found, how well, how fast; and disc by disc, as the thesis counts.
//!
//! `cargo bench -p calib --bench grid`: a line per tilt and noise; found of two images, root mean square error of the
//! centres (px), median and least time (ms); then the detector of single discs: candidates, false ones, missed ones of
//! 200. `cargo bench -p calib --bench grid -- wrong 500` draws that many images at random tilt, roll and noise, and
//! counts grids of which a disc has the wrong column or row.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;

use calib::disc::{DetectOptions, detect};
use calib::grid::{Found, GridSpec, find};
use common::Random;
use common::grid_series::{Drawn, Scene, draw};
use nalgebra::Vector2;

const TILTS: [f64; 11] = [0.0, 15.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 75.0, 80.0, 84.0];

#[allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures time; nothing is stamped with it"
)]
fn now() -> std::time::Instant {
    std::time::Instant::now()
}

fn spec() -> GridSpec {
    GridSpec::new(10, 10, 20.0)
}

/// Distances to the truth, the smallest over the quarter turns that such a grid cannot tell; and the largest of them.
fn errors(found: &Found, drawn: &Drawn) -> [f64; 2] {
    let turned = |k: usize, [c, r]: [usize; 2]| match k {
        0 => [c, r],
        1 => [9 - r, c],
        2 => [9 - c, 9 - r],
        _ => [r, 9 - c],
    };
    let of = |k: usize| {
        let offs = found.discs.iter().map(|d| {
            let [c, r] = turned(k, [d.col, d.row]);
            (d.at - drawn.centres[r * 10 + c]).norm()
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

/// Candidates, false and missed ones of the detector of single discs.
fn counted(drawn: &Drawn) -> [usize; 3] {
    let discs = detect(&drawn.image, &DetectOptions::new(1.5, 8.0)).unwrap();
    let near = (0.45 * drawn.least_pitch).max(1.5);
    let at = |d: &calib::disc::Disc| Vector2::new(d.at[0] as f64, d.at[1] as f64);
    let missed = drawn
        .centres
        .iter()
        .filter(|c| discs.iter().all(|d| (at(d) - **c).norm() > near));
    let missed = missed.count();
    [discs.len(), (discs.len() + missed).saturating_sub(100), missed]
}

fn series() {
    println!("noise tilt  pitch px  found   rms px   ms median    least   candidates  false  missed (chi, of 200)");
    for noise in [2.0, 10.0, 25.0] {
        for tilt_deg in TILTS {
            let (mut times, mut rms, mut counts, mut pitch) = (Vec::new(), Vec::new(), [0; 3], 0.0);
            for seed in 0..2 {
                let drawn = draw(&Scene {
                    tilt_deg,
                    roll_deg: 17.0,
                    noise,
                    seed,
                });
                pitch = drawn.least_pitch;
                for _ in 0..3 {
                    let start = now();
                    let found = find(&drawn.image, &spec());
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                    rms.extend(found.ok().map(|f| errors(&f, &drawn)[0]));
                }
                counts.iter_mut().zip(counted(&drawn)).for_each(|(a, b)| *a += b);
            }
            times.sort_by(f64::total_cmp);
            let mean = (rms.iter().map(|e| e * e).sum::<f64>() / rms.len().max(1) as f64).sqrt();
            let [candidates, wrong, missed] = counts;
            println!(
                "{noise:5} {tilt_deg:4} {pitch:9.1} {:>4}/2 {mean:8.4} {:11.1} {:8.1} {candidates:12} {wrong:6} {missed:7}",
                rms.len() / 3,
                times[3],
                times[0]
            );
        }
    }
}

fn wrong(images: u64) {
    let (mut found, mut wrong) = (0, 0);
    for seed in 0..images {
        let mut random = Random::new(seed + 77);
        let scene = Scene {
            tilt_deg: 84.0 * random.unit(),
            roll_deg: 180.0 * random.signed(),
            noise: 2.0 + 23.0 * random.unit(),
            seed,
        };
        let drawn = draw(&scene);
        if let Ok(grid) = find(&drawn.image, &spec()) {
            found += 1;
            if errors(&grid, &drawn)[1] > 0.5 * drawn.least_pitch {
                wrong += 1;
                println!("wrong: {scene:?}");
            }
        }
    }
    println!("{images} images: {found} grids found, {wrong} with a wrong column or row");
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let count = words
        .iter()
        .position(|w| w == "wrong")
        .and_then(|i| words.get(i + 1)?.parse().ok());
    match count {
        Some(images) => wrong(images),
        None => series(),
    }
}
