//! The voxels about a tile of an image, copied together.
//!
//! The taps of neighbouring pixels are mostly the same voxels, which lie in bricks scattered over the volume. Copied into
//! a small array of plain rows they are in the nearest cache, neighbours along x always lie side by side, and no tap asks
//! which brick it is in or whether it is beyond the border. Only what the tile's taps can reach is copied (see [`Region`]), and
//! as it is known before the tile's turn, its memory is asked for while the tile before is drawn ([`Plan::fetch`]). The copy
//! is what a tile needs and no more: a few tens of KiB, replaced tile by tile.

use super::region::{CUBES, Region, SIDE};
use super::source::{Source, Value};
use super::vector::Vector;

/// Voxels of a cube.
const CUBE: usize = SIDE * SIDE * SIDE;

/// A copy of a part of the volume: `f32` for products, `i16` where pairs are read at once.
#[derive(Debug, Clone, Default)]
pub(super) struct Patch<P> {
    values: Vec<P>,
    tables: [Vec<u32>; 3],
    first: [i32; 3],
}

/// The copies of both kinds, taken once.
#[derive(Debug, Clone, Default)]
pub(super) struct Patches {
    pub(super) shorts: Patch<i16>,
    pub(super) floats: Patch<f32>,
}

impl<P: Value + Default> Patch<P> {
    /// Copies the voxels of a plan; what was held before is lost. Voxels of the box that no tap reaches stay as they were.
    #[inline(always)]
    pub(super) fn copy<V: Value + Into<P>>(&mut self, source: &Source<'_, V>, plan: &Plan) {
        let [nx, ny, nz] = plan.extent;
        let [row, layer, end] = [nx * SIDE, nx * ny * SIDE * SIDE, nx * ny * nz * CUBE];
        self.first = plan.first;
        let sides = [(nx * SIDE, 1), (ny * SIDE, row), (nz * SIDE, layer)];
        for (table, (n, step)) in self.tables.iter_mut().zip(sides) {
            table.clear();
            table.extend((0..n).map(|i| (i * step) as u32));
        }
        // Never cleared: zeros for every tile would cost, and no tap reads what was not copied.
        if self.values.len() < end {
            self.values.resize(end, P::default());
        }
        for cube in &plan.cubes {
            let [i, j, k] = cube.place.map(usize::from);
            let to = &mut self.values[SIDE * (i + j * row + k * layer)..];
            match source
                .values
                .get(cube.from as usize..)
                .and_then(|values| values.first_chunk())
            {
                Some(brick) => copy_brick(brick, to, row, layer),
                None => plan.copy_rows(source, cube.place, to, row, layer),
            }
        }
    }

    /// The values: row by row, layer by layer.
    pub(super) fn values(&self) -> &[P] {
        &self.values
    }

    /// From one row to the next, and from one layer to the next.
    pub(super) fn steps(&self) -> [usize; 2] {
        let [x, y, _] = self.tables.each_ref().map(Vec::len);
        [x, x * y]
    }

    /// The voxel of the first value.
    pub(super) fn first(&self) -> [i32; 3] {
        self.first
    }

    /// The copy as a source of its own.
    #[inline(always)]
    pub(super) fn source(&self) -> Source<'_, P> {
        Source::from_parts(&self.values, self.tables.each_ref().map(Vec::as_slice), self.first)
    }
}

/// What is to be copied for a tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Plan {
    first: [i32; 3],
    /// Sides, cubes.
    extent: [usize; 3],
    cubes: Vec<Cube>,
    /// Of each number along x: whether four neighbours lie side by side.
    together: [bool; CUBES],
}

/// A cube of voxels.
#[derive(Debug, Clone, Copy)]
struct Cube {
    /// Its number along each axis.
    place: [u8; 3],
    /// Where its values begin if they lie as in a brick; else beyond all values.
    from: u32,
}

const SCATTERED: u32 = u32::MAX;

impl Plan {
    /// The cubes of `region`.
    #[inline(always)]
    pub(super) fn set<V: Value>(&mut self, source: &Source<'_, V>, region: &Region) {
        (self.first, self.extent) = (region.first(), region.extent());
        self.cubes.clear();
        let side = SIDE as u32;
        let bricks: [[u32; CUBES]; 3] =
            [(0, 1), (1, side), (2, side * side)].map(|(a, step)| self.bricks(source, a, step));
        self.together = bricks[0].map(|term| term != SCATTERED);
        let [_, ny, nz] = self.extent;
        for k in 0..nz {
            for j in 0..ny {
                for i in region.row(j, k) {
                    let terms = [bricks[0][i], bricks[1][j], bricks[2][k]];
                    // One axis that breaks the brick is enough: its four voxels do not follow one another.
                    let from = if terms.contains(&SCATTERED) {
                        SCATTERED
                    } else {
                        terms.iter().sum()
                    };
                    self.cubes.push(Cube {
                        place: [i as u8, j as u8, k as u8],
                        from,
                    });
                }
            }
        }
    }

    /// Asks for the memory of part `part` of `parts`.
    #[inline(always)]
    pub(super) fn fetch<V: Value>(&self, source: &Source<'_, V>, vector: Vector, part: usize, parts: usize) {
        // Ends are computed alike for neighbouring parts: none is left out, whatever the remainder.
        let end = |part: usize| self.cubes.len() * part / parts;
        for cube in &self.cubes[end(part)..end(part + 1)] {
            if cube.from != SCATTERED {
                vector.fetch::<CUBE, V>(source.values, cube.from as usize);
                continue;
            }
            let [x, y, z] = self.terms(source, cube.place);
            for at in z.iter().flat_map(|z| y.iter().map(move |y| x[0] + y + z)) {
                vector.fetch::<1, V>(source.values, at);
            }
        }
    }

    /// Along axis `a`, the first term of each cube whose terms follow one another by `step`.
    fn bricks<V: Value>(&self, source: &Source<'_, V>, a: usize, step: u32) -> [u32; CUBES] {
        let n = self.extent[a];
        let terms = source.table(a, self.first[a]..self.first[a] + (n * SIDE) as i32);
        let mut bricks = [SCATTERED; CUBES];
        for (brick, terms) in bricks.iter_mut().zip(terms.as_chunks::<SIDE>().0) {
            if (1..SIDE).all(|i| terms[i] == terms[0] + i as u32 * step) {
                *brick = terms[0];
            }
        }
        bricks
    }

    /// Across the border, and in other layouts.
    #[inline(never)]
    fn copy_rows<V: Value + Into<P>, P: Copy>(
        &self,
        source: &Source<'_, V>,
        place: [u8; 3],
        to: &mut [P],
        row: usize,
        layer: usize,
    ) {
        let [x, y, z]: [[usize; SIDE]; 3] = self.terms(source, place);
        let together = self.together[usize::from(place[0])];
        for (k, z) in z.iter().enumerate() {
            for (j, y) in y.iter().enumerate() {
                let place = &mut to[k * layer + j * row..][..SIDE];
                let four = source.values[x[0] + y + z..].first_chunk::<SIDE>();
                match four.filter(|_| together) {
                    Some(four) => place.copy_from_slice(&four.map(Into::into)),
                    None => {
                        for (place, x) in place.iter_mut().zip(x) {
                            *place = source.values[x + y + z].into();
                        }
                    }
                }
            }
        }
    }

    /// The offset terms of a cube.
    #[inline(always)]
    fn terms<V: Value>(&self, source: &Source<'_, V>, place: [u8; 3]) -> [[usize; SIDE]; 3] {
        std::array::from_fn(|a| source.terms(a, self.first[a] + i32::from(place[a]) * SIDE as i32))
    }
}

#[inline(always)]
fn copy_brick<V: Value + Into<P>, P: Copy>(brick: &[V; CUBE], to: &mut [P], row: usize, layer: usize) {
    for (z, slice) in brick.as_chunks::<{ SIDE * SIDE }>().0.iter().enumerate() {
        let rows = &mut to[z * layer..][..(SIDE - 1) * row + SIDE];
        for (y, four) in slice.as_chunks::<SIDE>().0.iter().enumerate() {
            rows[y * row..][..SIDE].copy_from_slice(&four.map(Into::into));
        }
    }
}
