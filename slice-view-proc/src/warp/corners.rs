//! Corners of a cube's pieces.

use super::border::FACE_BEYOND;
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

    /// Whether the plane may pass through one of the cube's faces, by its nine nodes; what lies between the faces it may.
    #[inline(always)]
    pub(super) fn may_cut(&self, axis: usize, along: i32) -> bool {
        if 0 < along && along < self.cube.span {
            return true;
        }
        let steps = [1, 3, 9];
        let first = if along > 0 { 2 * steps[axis] } else { 0 };
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..9 {
            let node = first + steps[(axis + 1) % 3] * (k % 3) + steps[(axis + 2) % 3] * (k / 3);
            let depth = self.nodes[node][2];
            (least, most) = (least.min(depth), most.max(depth));
        }
        // Places are in single precision: a smaller neighbour's nodes lie on this face to some 3e-5 mm.
        let beyond = 0.5 * (FACE_BEYOND - 1.0) * (most - least) + 1e-6 * most.max(-least) + 1e-4;
        least - beyond <= 0.0 && most + beyond >= 0.0
    }
}

#[inline(always)]
fn place([x, y, z]: [i32; 3]) -> usize {
    (x + 3 * y + 9 * z) as usize % 27
}
