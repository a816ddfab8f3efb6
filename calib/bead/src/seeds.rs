//! Where a bead may be: voxels that are bright enough and brighter than all around them.

use std::collections::VecDeque;

use super::{Refused, Voxels};

/// The most bright spots that are looked at; a chest with its bones has some thousands.
const MAX_SEEDS: usize = 300_000;
/// The greatest HU of 12 bits with the usual offsets of 1024 and 1000, and of 16 bits: one voxel of these is clipped.
const USUAL_CLIPS_HU: [i16; 3] = [3071, 3095, i16::MAX];
/// So many voxels must share another greatest value of a volume, and it must be metal's, for the scanner to have clipped
/// there.
const CLIPPED_VOXELS: u64 = 4;
const LEAST_CLIP_HU: i16 = 2000;

/// What one pass over the volume finds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Seeds {
    /// Ascending by slice, row, column.
    pub(super) voxels: Vec<[u32; 3]>,
    /// The HU at which the scanner seems to have clipped.
    pub(super) clip_hu: Option<i16>,
}

/// Slices of the volume with a voxel of the lowest value around, so that every voxel has neighbours.
struct Window {
    slices: VecDeque<Vec<i16>>,
    columns: usize,
}

/// Finds the local maxima of at least `threshold` among the 26 neighbours; of equal ones the first in the volume's order
/// counts as brighter, so that a plateau has few. One pass, three slices of memory.
///
/// Of these, those that `stands_out` accepts: in soft tissue every third grain of noise is a maximum.
pub(super) fn seeds(
    voxels: &dyn Voxels,
    threshold: f64,
    stands_out: impl Fn([u32; 3]) -> bool,
) -> Result<Seeds, Refused> {
    let [nx, ny, nz] = voxels.grid().dims();
    // Within the range of a voxel, so that a threshold from a header cannot overflow it.
    let level = threshold.clamp(f64::from(i16::MIN) + 1.0, f64::from(i16::MAX)).ceil() as i16;
    let mut window = Window::new(nx, ny);
    let (mut found, mut top) = (Vec::new(), Top::default());
    window.push(voxels, 0, &mut top);
    for z in 0..nz {
        if z + 1 < nz {
            window.push(voxels, z + 1, &mut top);
        } else {
            window.push_empty();
        }
        window.maxima(level, |x, y| {
            if stands_out([x, y, z]) {
                found.push([x, y, z]);
            }
        });
        // Noise at a low threshold would make every third voxel a seed.
        if found.len() > MAX_SEEDS {
            return Err(Refused::TooMany {
                limit: MAX_SEEDS,
                threshold_hu: threshold,
            });
        }
    }
    Ok(Seeds {
        voxels: found,
        clip_hu: top.clip(),
    })
}

/// The greatest value and how often it comes.
#[derive(Debug, Clone, Copy)]
struct Top {
    value: i16,
    count: u64,
}

impl Default for Top {
    fn default() -> Self {
        Self {
            value: i16::MIN,
            count: 0,
        }
    }
}

impl Top {
    fn add(&mut self, row: &[i16]) {
        let most = row.iter().copied().fold(i16::MIN, i16::max);
        if most < self.value {
            return;
        }
        let count = row.iter().filter(|v| **v == most).count() as u64;
        self.count = if most == self.value { self.count + count } else { count };
        self.value = most;
    }

    fn clip(&self) -> Option<i16> {
        let many = self.value >= LEAST_CLIP_HU && self.count >= CLIPPED_VOXELS;
        let clipped = many || USUAL_CLIPS_HU.contains(&self.value);
        clipped.then_some(self.value)
    }
}

impl Window {
    fn new(nx: u32, ny: u32) -> Self {
        let columns = nx as usize + 2;
        let empty = vec![i16::MIN; columns * (ny as usize + 2)];
        Self {
            slices: VecDeque::from([empty.clone(), empty.clone(), empty]),
            columns,
        }
    }

    /// Moves on by one slice.
    fn push(&mut self, voxels: &dyn Voxels, z: u32, top: &mut Top) {
        self.slices.rotate_left(1);
        let columns = self.columns;
        for (y, row) in (0..).zip(self.slices[2].chunks_exact_mut(columns).skip(1)) {
            if y == voxels.grid().dims()[1] {
                break;
            }
            let row = &mut row[1..columns - 1];
            voxels.row(y, z, row);
            top.add(row);
        }
    }

    fn push_empty(&mut self) {
        self.slices.rotate_left(1);
        self.slices[2].fill(i16::MIN);
    }

    /// Calls with column and row of each maximum in the middle slice.
    fn maxima(&self, level: i16, mut found: impl FnMut(u32, u32)) {
        let rows = self.slices[1].chunks_exact(self.columns).enumerate();
        for (y, row) in rows {
            // Most rows hold nothing so bright; this comparison the compiler makes sixteen at a time.
            if !row.iter().fold(false, |any, v| any | (*v >= level)) {
                continue;
            }
            for (x, value) in row.iter().enumerate() {
                // The margin holds the lowest value, which no level admits.
                if *value >= level && self.is_maximum(x, y) {
                    found(x as u32 - 1, y as u32 - 1);
                }
            }
        }
    }

    fn is_maximum(&self, x: usize, y: usize) -> bool {
        let middle = y * self.columns + x;
        let value = self.slices[1][middle];
        (0..27).filter(|i| *i != 13).all(|i| {
            let (dz, dy, dx) = (i / 9, i / 3 % 3, i % 3);
            let other = self.slices[dz][middle + dy * self.columns + dx - self.columns - 1];
            // Those before it in the volume's order win ties.
            if i < 13 { value > other } else { value >= other }
        })
    }
}
