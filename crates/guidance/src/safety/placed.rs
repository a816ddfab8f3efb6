//! A tube among the voxels of a grid: where a voxel lies about its axis, and how far from it.

use geometry::{Ct, VolumeGrid};

use super::block::{Bits, Block, SIDE, each};
use super::tube::Tube;

/// Where a place lies about a tube, mm: two coordinates across the axis, and the depth.
pub(super) type About = [f64; 3];

/// A tube as voxels see it.
pub(super) struct Placed {
    /// Where voxel (0, 0, 0) lies.
    first: About,
    /// How far a step along each of the grid's axes leads.
    steps: [About; 3],
    /// Where the voxels of a block lie from its first.
    local: Vec<About>,
    radius: f64,
    half_length: f64,
}

impl Placed {
    pub(super) fn new(tube: &Tube, grid: &VolumeGrid) -> Self {
        let axes = across(tube.axis().components());
        let turned = |v: [f64; 3]| axes.map(|axis| axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]);
        let map = grid.ct_from_voxel();
        let origin = map * geometry::Point::<geometry::Voxel>::new(0.0, 0.0, 0.0);
        // The difference first: coordinates far from the origin of Ct are then rounded once.
        let first = turned((origin - tube.entry()).mm());
        let steps = [0, 1, 2].map(|k| turned(map.step(k).mm()));
        let local = |k| {
            let index = [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE].map(|n| n as f64);
            led([0.0; 3], &steps, index)
        };
        Self {
            first,
            local: (0..SIDE * SIDE * SIDE).map(local).collect(),
            steps,
            radius: tube.radius_mm(),
            half_length: tube.length_mm() / 2.0,
        }
    }

    /// Where a voxel index, whole or not, lies.
    #[inline]
    pub(super) fn about(&self, index: [f64; 3]) -> About {
        led(self.first, &self.steps, index)
    }

    /// Tells where the voxels of a block that `bits` names lie, each with its bit.
    #[inline]
    pub(super) fn each(&self, block: &Block, bits: &Bits, mut see: impl FnMut(usize, About)) {
        let [x, y, z] = self.about(block.at.map(|k| f64::from(k) * SIDE as f64));
        each(bits, |bit| {
            let [a, b, c] = self.local[bit];
            see(bit, [x + a, y + b, z + c]);
        });
    }

    /// The signed distance of a place from the solid tube, mm: from its nearest point outside it; within it less than zero, by how
    /// far the nearest point of its surface is.
    #[inline]
    pub(super) fn signed(&self, about: About) -> f64 {
        let beside = self.beside(about);
        let beyond = (about[2] - self.half_length).abs() - self.half_length;
        if beside > 0.0 && beyond > 0.0 {
            (beside * beside + beyond * beyond).sqrt()
        } else {
            beside.max(beyond)
        }
    }

    /// How far outside the tube's side a place is, mm; less than zero within it.
    #[inline]
    pub(super) fn beside(&self, [x, y, _]: About) -> f64 {
        (x * x + y * y).sqrt() - self.radius
    }
}

fn led(from: About, steps: &[About; 3], [i, j, k]: [f64; 3]) -> About {
    let [a, b, c] = steps;
    [0, 1, 2].map(|n| from[n] + a[n] * i + b[n] * j + c[n] * k)
}

/// Two unit vectors across a third, and it.
///
/// By the formula of Duff and others (Building an Orthonormal Basis, Revisited, 2017), which divides by no less than 1.
fn across([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    [
        [1.0 + sign * x * x * a, sign * b, -sign * x],
        [b, sign + y * y * a, -y],
        [x, y, z],
    ]
}

/// The axis of a tube in voxel indices, to ask which cells it runs through.
pub(super) struct Line {
    entry: [f64; 3],
    way: [f64; 3],
}

impl Line {
    pub(super) fn new(tube: &Tube, grid: &VolumeGrid) -> Self {
        let index = |p: geometry::Point<Ct>| (grid.voxel_from_ct() * p).mm();
        let entry = index(tube.entry());
        let tip = index(tube.tip());
        Self {
            entry,
            way: [0, 1, 2].map(|k| tip[k] - entry[k]),
        }
    }

    /// Whether the axis, from entry to tip, meets the cell of a voxel, with its faces.
    pub(super) fn meets(&self, voxel: [u32; 3]) -> bool {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for ((index, entry), way) in voxel.into_iter().zip(self.entry).zip(self.way) {
            let middle = f64::from(index) - entry;
            if way == 0.0 {
                if middle.abs() > 0.5 {
                    return false;
                }
                continue;
            }
            // Where it passes the two faces, as a share of its length.
            let faces = [middle - 0.5, middle + 0.5].map(|x| x / way);
            from = from.max(faces[0].min(faces[1]));
            to = to.min(faces[0].max(faces[1]));
        }
        from <= to
    }
}
