//! Where the voxels lie, in numbers and in words.

use geometry::{Ct, Direction, Vector, VolumeGrid};
use serde::Serialize;

/// The patient's axes in LPS: a word and a letter for each end, positive first.
const ENDS: [[(&str, char); 2]; 3] = [
    [("left", 'L'), ("right", 'R')],
    [("posterior", 'P'), ("anterior", 'A')],
    [("superior", 'S'), ("inferior", 'I')],
];
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Where a volume's voxels lie in the patient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// Voxels along each axis: columns, rows, slices.
    pub dims: [u32; 3],
    /// Lengths of the steps from voxel to voxel along each axis, mm.
    pub spacing_mm: [f64; 3],
    /// From the first voxel's outer side to the last one's along each axis, mm.
    pub size_mm: [f64; 3],
    /// Voxel indices to mm LPS, row by row; the fourth column is the first voxel's middle.
    pub ct_from_voxel: [[f64; 4]; 3],
    /// Where the three indices grow to, in words.
    pub orientation: String,
    /// The same in letters: `LPS` are indices along the patient's own axes.
    pub letters: String,
    /// The angle of each axis to the patient axis that it is named after, degrees.
    pub off_axis_degrees: [f64; 3],
    /// Whether the three axes, in order, are as the thumb and two fingers of the right hand.
    pub handedness: Handedness,
    /// The angle between the third axis and the slices' normal, degrees: a tilted gantry's.
    pub tilt_degrees: f64,
    /// By how much the angle between rows and columns differs from a right one, degrees.
    pub slant_degrees: f64,
}

/// The sign of the unit cell's volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Handedness {
    /// Positive.
    RightHanded,
    /// Negative: one axis is mirrored.
    LeftHanded,
}

impl Place {
    /// The place of `grid`.
    pub fn of(grid: &VolumeGrid) -> Self {
        let affine = grid.ct_from_voxel();
        let steps = [0, 1, 2].map(|axis| affine.step(axis));
        let directions = steps.map(direction);
        let named = named_axes(&directions);
        let end = |axis: usize| {
            let along = directions[axis].components()[named[axis]];
            (ENDS[named[axis]][usize::from(along < 0.0)], along.abs())
        };
        let ends = [0, 1, 2].map(end);
        let [columns, rows, slices] = ends.map(|((word, _), _)| word);
        let handedness = match affine.determinant() < 0.0 {
            true => Handedness::LeftHanded,
            false => Handedness::RightHanded,
        };
        let (dims, spacing_mm) = (grid.dims(), grid.spacing_mm());
        Self {
            dims,
            spacing_mm,
            size_mm: [0, 1, 2].map(|axis| f64::from(dims[axis]) * spacing_mm[axis]),
            ct_from_voxel: affine.rows(),
            orientation: format!("columns to {columns}, rows to {rows}, slices to {slices}"),
            letters: ends.iter().map(|((_, letter), _)| letter).collect(),
            off_axis_degrees: ends.map(|(_, cosine)| cosine.min(1.0).acos().to_degrees()),
            handedness,
            tilt_degrees: tilt_degrees(&steps),
            slant_degrees: directions[0].dot(directions[1]).asin().to_degrees().abs(),
        }
    }
}

/// Which patient axis each of ours is named after: none twice, and the cosines as large as they can be together.
fn named_axes(directions: &[Direction<Ct>; 3]) -> [usize; 3] {
    let cosines = |order: &[usize; 3]| -> f64 {
        let axes = directions.iter().zip(order);
        axes.map(|(direction, &named)| direction.components()[named].abs())
            .sum()
    };
    let better = |best: [usize; 3], order: [usize; 3]| match cosines(&order) > cosines(&best) + 1e-12 {
        true => order,
        false => best,
    };
    ORDERS.into_iter().fold(ORDERS[0], better)
}

/// The angle as a tangent: exact near zero, where a cosine is not.
fn tilt_degrees(steps: &[Vector<Ct>; 3]) -> f64 {
    let normal = direction(steps[0].cross(steps[1])).vector();
    let (across, along) = (normal.cross(steps[2]).norm(), normal.dot(steps[2]).abs());
    across.atan2(along).to_degrees()
}

/// The direction of a checked grid's step, which is never zero.
fn direction(step: Vector<Ct>) -> Direction<Ct> {
    step.direction()
        .unwrap_or_else(|| unreachable!("a checked grid has no step of length zero"))
}
