//! A whole CT of 512 x 512 x 400 voxels: processor time by the beads' radius, and memory.

use std::fs;

use bead::{Dense, Search, find};
use geometry::{Affine, VolumeGrid};

use super::{DIMS, Random, STEP_MM, bead_places, score, tissue};

const SLICES: usize = 400;
const RADII_MM: [f64; 4] = [0.75, 1.0, 2.0, 4.0];
const ROUNDS: usize = 3;

/// Processor time of this thread, s.
fn processor_s() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let first = text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
    first.unwrap_or(f64::NAN) * 1e-9
}

/// The most memory that this process has had, MB.
fn peak_mb() -> f64 {
    let text = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kb = line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kb.unwrap_or(f64::NAN) / 1024.0
}

/// Slice by slice, so that no more is in memory than the volume; the body goes on over its end.
fn volume(radius_mm: f64) -> (Dense, Vec<[f64; 3]>) {
    let [nx, ny, nz] = [DIMS[0], DIMS[1], SLICES];
    let mut random = Random(3);
    let mut values = Vec::with_capacity(nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let at = [i, j, k].map(|v| v as f64);
                let place = [0, 1, 2].map(|a| at[a] * STEP_MM[a]);
                let hu = tissue([place[0], place[1], place[2] % 90.0]) + 60.0 * (random.next() - 0.5);
                values.push(hu.min(3071.0).round() as i16);
            }
        }
    }
    let beads = bead_places(&mut random);
    beads
        .iter()
        .for_each(|c| super::add_clipped(&mut values, *c, radius_mm));
    let rows = [0, 1, 2].map(|a| {
        let mut row = [0.0; 4];
        row[a] = STEP_MM[a];
        row
    });
    let grid = VolumeGrid::checked([nx, ny, nz].map(|d| d as i64), Affine::from_rows(rows)).expect("a sound grid");
    (Dense::new(grid, values).expect("as many values as voxels"), beads)
}

/// The time of one plain pass over the values, s.
fn plain_pass(volume: &Dense) -> f64 {
    use bead::Voxels;
    let start = processor_s();
    let mut row = vec![0_i16; DIMS[0]];
    let mut sum = 0_i64;
    for z in 0..SLICES as u32 {
        for y in 0..DIMS[1] as u32 {
            volume.row(y, z, &mut row);
            sum += row.iter().map(|v| i64::from(*v)).sum::<i64>();
        }
    }
    std::hint::black_box(sum);
    processor_s() - start
}

pub(crate) fn run() {
    println!("512 x 512 x 400 voxels, processor time");
    for radius_mm in RADII_MM {
        let (volume, truth) = volume(radius_mm);
        let before = peak_mb();
        let (mut ours, mut plain, mut found) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            let start = processor_s();
            found = find(&volume, &Search::of_radius(radius_mm))
                .expect("a search that can be")
                .beads;
            ours.push(processor_s() - start);
            plain.push(plain_pass(&volume));
        }
        let least = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
        let centres: Vec<[f64; 3]> = found.iter().map(|b| b.centre.mm()).collect();
        let (found, missed, wrong, rms) = score(&centres, &truth);
        println!(
            "radius {radius_mm} mm: {:.2} s, a plain pass {:.3} s, ratio {:.1}; {:.0} MB over the volume's {before:.0}; \
             {found} found, {missed} missed, {wrong} false, rms {rms:.4} mm",
            least(&ours),
            least(&plain),
            least(&ours) / least(&plain),
            peak_mb() - before,
        );
    }
}
