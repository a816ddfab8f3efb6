//! In which pieces an image is drawn, and the copies of the voxels about them.

use super::super::Samples;
use super::kernel::Kernel;
use super::patch::{Patches, Plan};
use super::region::{LONGEST, Region, SIDE, Tile};

/// Columns and rows of tiles that are drawn from copies, the best first: long rows cost least, small tiles fit larger pixels.
const COPIED: [[usize; 2]; 4] = [[64, 32], [32, 32], [32, 16], [16, 16]];
/// Columns and rows of tiles that are drawn from the volume.
const IN_PLACE: [usize; 2] = [64, 8];

/// An image cut into tiles, row by row. They begin at whole blocks.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    image: [usize; 2],
    side: [usize; 2],
    reach: Option<i32>,
}

impl Tiles {
    /// Tiles for an image of `image` columns and rows, drawn with taps at most `reach` voxels from their points.
    pub(super) fn of(samples: &Samples, reach: Option<i32>, image: [usize; 2]) -> Self {
        let fits = |side: &[usize; 2], reach: i32| {
            let [columns, rows] = side.map(|n| (n - 1) as f64);
            // Up to three voxels more at either end make whole cubes.
            let room = (LONGEST - 2 * SIDE) as f64 - 2.0 * f64::from(reach);
            (0..3).all(|a| samples.right[a].abs() * columns + samples.down[a].abs() * rows <= room)
        };
        let copied = reach.and_then(|reach| COPIED.into_iter().find(|side| fits(side, reach)));
        Self {
            image,
            side: copied.unwrap_or(IN_PLACE),
            reach: copied.and(reach),
        }
    }

    /// If they are drawn from copies: how far taps are from their points at most, voxels. Pixels are small then, so that a
    /// row has blocks; an image of a few large pixels would fit into a copy, but not into vector code.
    pub(super) fn reach(&self) -> Option<i32> {
        self.reach
    }

    /// How many they are.
    pub(super) fn count(&self) -> usize {
        self.across() * self.image[1].div_ceil(self.side[1])
    }

    fn across(&self) -> usize {
        self.image[0].div_ceil(self.side[0])
    }

    /// Tile `i`.
    pub(super) fn tile(&self, i: usize) -> Tile {
        let [columns, rows] = [(i % self.across(), 0), (i / self.across(), 1)].map(|(n, a)| {
            let first = n * self.side[a];
            first..(first + self.side[a]).min(self.image[a])
        });
        Tile { columns, rows }
    }
}

/// The copy for the tile that is being drawn, and the plan of the next one. Taken once.
#[derive(Debug, Clone, Default)]
pub(super) struct Copies {
    patches: Patches,
    plan: Plan,
    planned: bool,
    held: bool,
}

impl Copies {
    /// Plans the copy for a tile; without a region it is drawn from the volume.
    pub(super) fn plan(&mut self, kernel: &impl Kernel, region: Option<Region>) {
        self.planned = region.is_some();
        if let Some(region) = region {
            kernel.plan(&region, &mut self.plan);
        }
    }

    /// Copies what was planned.
    pub(super) fn take(&mut self, kernel: &impl Kernel) {
        self.held = self.planned;
        if self.planned {
            kernel.copy(&self.plan, &mut self.patches);
        }
    }

    /// Asks for a part of the memory of what is planned.
    pub(super) fn fetch(&self, kernel: &impl Kernel, part: usize, parts: usize) {
        if self.planned {
            kernel.fetch(&self.plan, part, parts);
        }
    }

    /// The copy, if there is one for this tile.
    pub(super) fn held(&self) -> Option<&Patches> {
        self.held.then_some(&self.patches)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reslice::cpu::walk::lanes;

    fn samples(step: f64) -> Samples {
        Samples {
            origin: [0.0; 3],
            right: [step, 0.5 * step, 0.0],
            down: [0.0, 0.3 * step, step],
            into: [0.0; 3],
            fold: [1, 1],
            depths: 1,
        }
    }

    #[test]
    fn tiles_cover_an_image_once() {
        for image in [[1, 1], [67, 41], [512, 512], [8, 300]] {
            let tiles = Tiles::of(&samples(0.7), Some(2), image);
            let mut times = vec![0; image[0] * image[1]];
            for tile in (0..tiles.count()).map(|i| tiles.tile(i)) {
                assert_eq!(tile.columns.start % 8, 0);
                for (y, x) in tile.rows.flat_map(|y| tile.columns.clone().map(move |x| (y, x))) {
                    times[y * image[0] + x] += 1;
                }
            }
            assert!(times.iter().all(|&n| n == 1), "{image:?}");
        }
    }

    /// Vector code draws blocks only, and draws nothing where there are none.
    #[test]
    fn images_that_are_drawn_from_copies_have_blocks() {
        for step in [0.001, 0.7, 1.5, 3.0, 4.0, 15.0, 17.0, 1e6] {
            let samples = samples(step);
            let copied = Tiles::of(&samples, Some(1), [1, 1]).reach().is_some();
            assert!(!copied || lanes(samples.right).is_some(), "{step}");
            assert_eq!(copied, step < 3.5, "{step}");
        }
    }
}
