//! Lengths of a grid of voxels that bound what lies between their centres.

use geometry::VolumeGrid;

/// The lengths of a grid, mm.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// From a voxel's centre to the farthest corner of its cell.
    pub(super) half_diagonal_mm: f64,
    /// From a voxel's centre to the farthest point that is not nearer to one of its six neighbours.
    ///
    /// Those points are a box with the six planes half-way to the neighbours as its sides. So if a point `q` of a tube lies
    /// farther than this from a voxel, one of the six is nearer to `q`, and thus to the tube. A voxel whose six neighbours have
    /// its own label and which is farther than this from the tube is therefore never the nearest of its label. For a grid of right
    /// angles this is half the diagonal of a voxel.
    pub(super) reach_mm: f64,
    steps: [[f64; 3]; 3],
}

impl Lattice {
    pub(super) fn of(grid: &VolumeGrid) -> Self {
        let steps = [0, 1, 2].map(|axis| grid.ct_from_voxel().step(axis).mm());
        // The box of `reach_mm` has the corners c with c . step_i = +-abs(step_i)^2 / 2: sums of the rows of the inverse map.
        let rows = grid.voxel_from_ct().rows();
        let corners = [0, 1, 2].map(|i| [0, 1, 2].map(|k| rows[i][k] * dot(steps[i], steps[i])));
        Self {
            half_diagonal_mm: farthest(steps) / 2.0,
            reach_mm: farthest(corners) / 2.0,
            steps,
        }
    }

    /// The radius of a ball about a box of centres with so many steps along each axis, mm, rounded up.
    pub(super) fn ball_mm(&self, counts: [u32; 3]) -> f32 {
        let sides = [0, 1, 2].map(|i| self.steps[i].map(|x| x * f64::from(counts[i])));
        (farthest(sides) / 2.0) as f32 * (1.0 + f32::EPSILON)
    }
}

/// The greatest length of a sum of the three vectors, each with either sign: the long diagonal of the box that they span.
fn farthest(sides: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = sides;
    let length = |[s, t]: [f64; 2]| {
        let sum = [0, 1, 2].map(|k| a[k] + s * b[k] + t * c[k]);
        dot(sum, sum).sqrt()
    };
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    signs.into_iter().map(length).fold(0.0, f64::max)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
