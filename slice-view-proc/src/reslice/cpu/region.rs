//! Which voxels the taps of a tile can reach.
//!
//! With g one of three linear functions of the voxel (distance from the plane, column, row of the image), a tap q of a point p
//! in the tile, at most `reach` voxels from it on each axis, has |g(q) - g(p)| <= reach (|g_x| + |g_y| + |g_z|). So each g
//! bounds q along x for given y and z, and the voxels of a row lie in the three intervals' intersection.

use std::ops::Range;

use super::super::Samples;

/// The side of the cubes of voxels that are copied together, as bricks have it.
pub(super) const SIDE: usize = 4;
/// The longest side of a region, voxels.
pub(super) const LONGEST: usize = 64;
/// The most cubes along a side.
pub(super) const CUBES: usize = LONGEST / SIDE;
/// Bits of a fraction of x: with whole numbers below 2^15, 32 bits.
const BITS: u32 = 16;
const CUBE_BITS: u32 = BITS + SIDE.trailing_zeros();
/// The least part of a function's slope that lies along x; flatter ones are tilted, and their bounds widened by as much.
const FLATTEST: f64 = 1.0 / 64.0;
/// Positions are rounded by less, voxels.
const ROUNDING: f64 = 1e-3;
/// The three bounds are rounded by less: 128 rows of half a unit in the last place each.
const SLACK: f64 = 0.01;

/// The columns and rows of a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

/// The voxels of a box about the tile, of which rows are bounded further.
#[derive(Debug, Clone)]
pub(super) struct Region {
    first: [i32; 3],
    extent: [usize; 3],
    bounds: [Bound; 3],
}

/// Voxels of row (y, z) of cubes have `at + y by_y + z by_z <= x <= that + width`, relative to the region's first voxel.
#[derive(Debug, Clone, Copy)]
struct Bound {
    at: i32,
    by_y: i32,
    by_z: i32,
    width: i32,
}

impl Region {
    /// What the taps of a tile's points inside the volume can reach; `None` where none is inside, or a side is too long.
    pub(super) fn new(samples: &Samples, tile: &Tile, reach: i32, dims: [u32; 3]) -> Option<Self> {
        let ends = |range: &Range<usize>| [range.start as f64, range.end as f64 - 1.0];
        let [columns, rows] = [ends(&tile.columns), ends(&tile.rows)];
        // A place is linear in column and row, so that its extremes over the tile lie at the corners.
        let corners = [0, 1, 2, 3].map(|i| samples.at(columns[i % 2], rows[i / 2], 0.0));
        let (mut first, mut extent) = ([0; 3], [0; 3]);
        for a in 0..3 {
            let least = corners.iter().map(|p| p[a]).fold(f64::INFINITY, f64::min);
            let most = corners.iter().map(|p| p[a]).fold(f64::NEG_INFINITY, f64::max);
            if most - least > LONGEST as f64 {
                return None;
            }
            // Points beyond the border are padding and have no taps.
            let (least, most) = (least.max(-0.5), most.min(f64::from(dims[a]) - 0.5));
            if least > most {
                return None;
            }
            // A position may round either way across a voxel: the region has room for both.
            let (low, high) = (
                (least - ROUNDING).floor() as i32 + 1 - reach,
                (most + ROUNDING).floor() as i32 + reach,
            );
            first[a] = low.div_euclid(SIDE as i32);
            extent[a] = (high.div_euclid(SIDE as i32) + 1 - first[a]) as usize;
            first[a] *= SIDE as i32;
        }
        if extent.iter().any(|&n| n > CUBES) {
            return None;
        }
        let around = Around {
            first: first.map(f64::from),
            reach: f64::from(reach),
            long: (extent[0] * SIDE) as f64,
        };
        let bounds = functions(samples).map(|g| around.bound(g, &corners));
        Some(Self { first, extent, bounds })
    }

    /// The first voxel of the box: multiples of four.
    pub(super) fn first(&self) -> [i32; 3] {
        self.first
    }

    /// The sides of the box, cubes.
    pub(super) fn extent(&self) -> [usize; 3] {
        self.extent
    }

    /// The cubes that can be reached in row `y` of layer `z` of cubes.
    #[inline(always)]
    pub(super) fn row(&self, y: usize, z: usize) -> Range<usize> {
        let from = self
            .bounds
            .map(|bound| bound.at + y as i32 * bound.by_y + z as i32 * bound.by_z);
        let to: [i32; 3] = std::array::from_fn(|i| from[i] + self.bounds[i].width);
        // An arithmetic shift rounds down, and -1 stands for all before the box: an end there makes an empty range.
        let cubes = |x: i32| (x >> CUBE_BITS).clamp(-1, self.extent[0] as i32);
        let [from, to] = [from[0].max(from[1]).max(from[2]), to[0].min(to[1]).min(to[2])];
        cubes(from).max(0) as usize..(cubes(to) + 1).min(self.extent[0] as i32) as usize
    }
}

/// The slopes of distance, column and row over the voxels, each up to a factor.
fn functions(samples: &Samples) -> [[f64; 3]; 3] {
    let normal = cross(samples.right, samples.down);
    // The column does not change along `down` or the normal, the row not along `right` or the normal.
    [normal, cross(samples.down, normal), cross(normal, samples.right)]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// What bounds are made from.
struct Around {
    first: [f64; 3],
    reach: f64,
    /// Voxels along x.
    long: f64,
}

impl Around {
    fn bound(&self, g: [f64; 3], corners: &[[f64; 3]; 4]) -> Bound {
        let sum: f64 = g.iter().map(|c| c.abs()).sum();
        // A function without slope bounds nothing: the whole row.
        if sum == 0.0 {
            return Bound {
                at: 0,
                by_y: 0,
                by_z: 0,
                width: (self.long as i32) << BITS,
            };
        }
        // |g_x| + |g_y| + |g_z| = 1 from here on, and g_x > 0.
        let g = g.map(|c| c / if g[0] < 0.0 { -sum } else { sum });
        // Bounds are divided by this: a flatter one would leave the range of the fixed numbers.
        let gx = g[0].max(FLATTEST);
        let values = corners.map(|p| (0..3).map(|a| g[a] * (p[a] - self.first[a])).sum::<f64>());
        let widen = self.reach + (gx - g[0]) * self.long + ROUNDING;
        let least = values.iter().copied().fold(f64::INFINITY, f64::min) - widen;
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max) + widen;
        let fixed = |x: f64| (x / gx * f64::from(1 << BITS)) as i32;
        // From a cube's first voxel to its others.
        let others = (SIDE - 1) as f64 * (g[1].abs() + g[2].abs());
        let later = (SIDE - 1) as f64 * (g[1].max(0.0) + g[2].max(0.0));
        Bound {
            at: fixed(least - later) - fixed(SLACK * gx),
            by_y: fixed(-g[1] * SIDE as f64),
            by_z: fixed(-g[2] * SIDE as f64),
            width: fixed(most - least + others) + 2 * fixed(SLACK * gx),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DIMS: [u32; 3] = [70, 64, 51];

    fn samples(origin: [f64; 3], right: [f64; 3], down: [f64; 3]) -> Samples {
        Samples {
            origin,
            right,
            down,
            into: [0.0; 3],
            fold: [1, 1],
            depths: 1,
        }
    }

    /// Whether the region has the cube of voxel `q`.
    fn has(region: &Region, q: [i32; 3]) -> bool {
        let [x, y, z] = std::array::from_fn(|a| (q[a] - region.first[a]).div_euclid(SIDE as i32));
        let within = [x, y, z]
            .iter()
            .zip(region.extent)
            .all(|(&i, n)| i >= 0 && (i as usize) < n);
        within && region.row(y as usize, z as usize).contains(&(x as usize))
    }

    proptest! {
        /// Steps of any direction, parallel to axes and planes of the grid included.
        #[test]
        fn every_tap_of_every_point_is_in_the_region(
            origin in prop::array::uniform3(-20.0..70.0_f64), right in prop::array::uniform3(-0.9..0.9_f64),
            down in prop::array::uniform3(-0.9..0.9_f64), flat in 0_usize..8, reach in 1_i32..6,
        ) {
            let mut right = right;
            let mut down = down;
            for a in 0..3 {
                if flat >> a & 1 == 1 {
                    right[a] = 0.0;
                    down[a] *= 1e-7;
                }
            }
            let samples = samples(origin, right, down);
            let tile = Tile { columns: 8..24, rows: 3..19 };
            let region = Region::new(&samples, &tile, reach, DIMS);
            for (x, y) in tile.rows.clone().flat_map(|y| tile.columns.clone().map(move |x| (x, y))) {
                let p = samples.at(x as f64, y as f64, 0.0);
                if !(0..3).all(|a| p[a] >= -0.5 && p[a] <= f64::from(DIMS[a]) - 0.5) {
                    continue;
                }
                let Some(region) = &region else {
                    return Err(TestCaseError::fail("a point is inside, and there is no region"));
                };
                let whole = p.map(|v| v.floor() as i32);
                for corner in 0..8 {
                    let q = std::array::from_fn(|a| whole[a] + if corner >> a & 1 == 1 { reach } else { 1 - reach });
                    prop_assert!(has(region, q), "{p:?} {q:?} {region:?}");
                }
            }
        }
    }

    /// A copy that were as large as its box would be right too, but slow.
    #[test]
    fn a_slanting_region_is_much_smaller_than_its_box() {
        let samples = samples([20.0; 3], [0.5, -0.5, 0.0], [0.3, 0.3, -0.6]);
        let tile = Tile {
            columns: 0..32,
            rows: 0..32,
        };
        let region = Region::new(&samples, &tile, 1, [512; 3]).expect("inside");
        let [nx, ny, nz] = region.extent();
        let cubes: usize = (0..nz)
            .flat_map(|z| (0..ny).map(move |y| (y, z)))
            .map(|(y, z)| region.row(y, z).len())
            .sum();
        assert!(cubes * 2 < nx * ny * nz, "{cubes} of {nx} x {ny} x {nz}");
    }
}
