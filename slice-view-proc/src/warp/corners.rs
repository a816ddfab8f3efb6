//! Corners of a cube's pieces.

use super::lattice::Lattice;
use super::placed::Placed;

/// Corners of pieces of one cube where they lie now.
pub(super) struct Corners<'a> {
    lattice: &'a mut Lattice,
    pub(super) cube: &'a Placed,
    pub(super) nodes: &'a [[f64; 3]; 27],
    /// Of a cube of one or two pieces an axis, all of them at x + 3 y + 9 z, and a bit for each that lies behind the plane.
    pub(super) few: [[f64; 3]; 27],
    pub(super) behind: u32,
}

impl<'a> Corners<'a> {
    #[inline(always)]
    pub(super) fn of(lattice: &'a mut Lattice, cube: &'a Placed, nodes: &'a [[f64; 3]; 27]) -> Self {
        let (mut few, mut behind) = ([[0.0; 3]; 27], 0);
        if cube.span <= 2 {
            for z in 0..=cube.span {
                for y in 0..=cube.span {
                    for x in 0..=cube.span {
                        let corner = lattice.corner(cube, nodes, [x, y, z]);
                        let k = place([x, y, z]);
                        few[k] = corner;
                        behind |= u32::from(corner[2] >= 0.0) << k;
                    }
                }
            }
        }
        Self {
            lattice,
            cube,
            nodes,
            few,
            behind,
        }
    }

    #[inline(always)]
    pub(super) fn at(&mut self, corner: [i32; 3]) -> [f64; 3] {
        if self.cube.span <= 2 {
            self.few[place(corner)]
        } else {
            self.lattice.corner(self.cube, self.nodes, corner)
        }
    }

    /// Whether the plane surely passes by a face between four corners, before they are looked up.
    #[inline(always)]
    pub(super) fn is_missed(&self, corners: [[i32; 3]; 4]) -> bool {
        let bits =
            1_u32 << place(corners[0]) | 1 << place(corners[1]) | 1 << place(corners[2]) | 1 << place(corners[3]);
        self.cube.span <= 2 && (self.behind & bits == 0 || self.behind & bits == bits)
    }
}

#[inline(always)]
fn place([x, y, z]: [i32; 3]) -> usize {
    (x + 3 * y + 9 * z) as usize % 27
}
