//! bench
#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::draw::*;
use common::oracle;
use geometry::{Ct, Tracker};
use surface_registration::*;

/// Seconds that this thread had a processor for: other programs do not count.
fn busy() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}

fn seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let began = busy();
    let made = work();
    (busy() - began, made)
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let get = |k: &str, d: f64| args.iter().position(|a| a == k).map_or(d, |i| args[i + 1].parse().unwrap());
    let bone = oracle::bone("pelvis-phantom").unwrap();
    let (t, surface) = seconds(|| Surface::<Ct>::new(&bone.0, &bone.1).unwrap());
    println!("surface {t:.3} s {:?}", surface.facts());
    let (t, field) = seconds(|| Field::new(&surface, Spacing::default()).unwrap());
    println!("field {t:.3} s {}", field.nodes());
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let source = Source::new(&bone);
    let n = get("--n", 20.0) as u64;
    let regions = get("--regions", 7.0) as u8;
    let sweep = Sweep { regions, points: get("--points", 200.0) as usize, outliers: get("--out", 0.2), ..Sweep::default() };
    let (deg, mm) = (get("--deg", 30.0), get("--mm", 30.0));
    let mode = get("--mode", 0.0) as i32;
    let mut options = Options::default();
    options.effort.seeds = get("--seeds", 20000.0) as usize;
    options.effort.tried = get("--tried", 400.0) as usize;
    options.effort.sample = get("--sample", 48.0) as usize;
    options.effort.pairs = get("--pairs", 100.0) as usize;
    options.effort.places = get("--places", 1000.0) as usize;
    options.kernel_end = get("--end", 4.5);
    let (mut good, mut ratios, mut times) = (0, vec![], vec![]);
    for seed in 0..n {
        let seed = 1000 + seed;
        let drawn = source.draw(&sweep, seed);
        let points = checked_points(&drawn);
        let guess = off(&drawn, deg, mm, seed);
        let start: Start<Ct, Tracker> = if mode == 2 { Start::Nothing } else { Start::Guess { pose: guess, turn_rad: (deg * 1.2).to_radians(), shift_mm: mm * 1.2 } };
        let (t, found) = seconds(|| if mode == 1 { refine(&surface, &field, &points, &guess, &options) } else { register(&surface, &field, &points, &start, &options) });
        let found = found.unwrap();
        let tre = rms(&tre_mm(&found.transform.transform(), &drawn.ct_from_tracker, &targets()));
        let truth = refine(&surface, &field, &points, &drawn.ct_from_tracker, &options).unwrap();
        let truth_tre = rms(&tre_mm(&truth.transform.transform(), &drawn.ct_from_tracker, &targets()));
        let bound = bound_mm(&surface, &drawn, &targets(), 0.0);
        good += i32::from(tre < 2.0);
        if tre < 2.0 { ratios.push(tre / bound); }
        times.push(t);
        println!("{seed} tre {tre:.3} bound {bound:.3} pred {:.3} cost {:.1} truth-cost {:.1} truth-tre {:.3} ratio {:.3} share {:.2} margin {:?} hits {} of {} seeds {} o {:.2} k {:.4} {:.1} ms",
            rms(&targets().map(|t| found.predicted_tre_mm(t))), found.cost, truth.cost, truth_tre, found.noise_ratio, found.share_kept, found.margin().map(|m| m.round()), found.hits, found.fits, found.seeds, found.offset_mm, found.depth_scale, t * 1e3);
    }
    ratios.sort_by(f64::total_cmp);
    times.sort_by(f64::total_cmp);
    println!("good {good} of {n}; median tre/bound {:.3}; median time {:.1} ms", ratios.get(ratios.len() / 2).unwrap_or(&f64::NAN), times[times.len() / 2] * 1e3);
}
