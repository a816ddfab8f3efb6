//! Centres by thickness of slices, size of beads, and clipping.

#![allow(clippy::print_stdout, reason = "the table is what this is for")]

use super::specimen::{Random, Scanner};
use crate::bead::{Search, find};

const METAL_HU: f64 = 14_000.0;
const BEADS: u32 = 6;

/// Root mean square errors, found and predicted, mm; or how many beads were missed, or why none can be looked for.
fn cell(scanner: &Scanner, radius: f64) -> Result<[f64; 2], String> {
    let (mut random, mut sums, mut missed) = (Random(7), [0.0; 2], 0);
    for _ in 0..BEADS {
        let extent = [12.0, 12.0, 16.0 + 3.0 * scanner.voxel_mm[2]];
        let dims = [0, 1, 2].map(|a| (extent[a] / scanner.voxel_mm[a]) as u32 | 1);
        let centre = [0, 1, 2].map(|a| (f64::from(dims[a] / 2) + random.next() - 0.5) * scanner.voxel_mm[a]);
        let mut image = scanner.empty(dims, 40.0);
        image.bead(centre, radius, METAL_HU);
        let search = Search {
            metal_hu: METAL_HU,
            ..Search::of_radius(radius)
        };
        let found = find(&image.volume(&mut random, None), &search).map_err(|refused| refused.to_string())?;
        let Some(bead) = found.beads.first() else {
            println!("missed: {:?}", found.rejected.first());
            missed += 1;
            continue;
        };
        sums[0] += (0..3).map(|a| (bead.centre.mm()[a] - centre[a]).powi(2)).sum::<f64>();
        sums[1] += bead.covariance.trace();
    }
    match missed {
        0 => Ok(sums.map(|s| (s / f64::from(BEADS)).sqrt())),
        _ => Err(format!("{missed} of {BEADS} missed")),
    }
}

fn scanner(dz: f64, clip_hu: f64, boxed: bool) -> Scanner {
    let gauss = Scanner::of([0.5, 0.5, dz]);
    Scanner {
        clip_hu,
        boxed,
        noise_hu: 20.0,
        // A slice that is the mean over its thickness has only the scanner's own blur besides.
        sigma_mm: if boxed { [0.45; 2] } else { gauss.sigma_mm },
        ..gauss
    }
}

/// The table of `docs/beads.md`: `cargo test -p calib --lib -- --ignored --nocapture slices`.
#[test]
#[ignore = "minutes; prints the table of the documentation"]
fn table_of_slices() {
    for dz in [0.5, 1.0, 2.0, 3.0, 5.0] {
        for radius in [0.5, 1.0, 1.5] {
            for clip_hu in [32_767.0, 3071.0] {
                let cells = [false, true].map(|boxed| match cell(&scanner(dz, clip_hu, boxed), radius) {
                    Ok([rms, predicted]) => format!("{rms:.4} ({predicted:.4})"),
                    Err(why) => why,
                });
                println!(
                    "{dz} mm, bead of {} mm, clip {clip_hu}: bell {}; box {}",
                    2.0 * radius,
                    cells[0],
                    cells[1]
                );
            }
        }
    }
}

/// A slice of 3 mm that is the mean over its thickness is not among them: there the error is 0.10 mm (`docs/beads.md`).
#[test]
fn thin_slices_of_either_profile_and_thick_bells_keep_the_goals() {
    for (dz, boxed, goal) in [(1.0, false, 0.02), (1.0, true, 0.02), (3.0, false, 0.06)] {
        let [rms, _] = cell(&scanner(dz, 3071.0, boxed), 1.0).unwrap();
        println!("{dz} mm, box {boxed}: {rms:.4} mm");
        assert!(rms <= goal, "{dz} mm, box {boxed}: {rms}");
    }
}
