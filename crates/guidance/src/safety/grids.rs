//! Whether a label map lies on the CT's voxels.

use std::fmt;

use geometry::{Point, Vector, VolumeGrid, Voxel};

/// Centres of voxels that are no farther apart are the same, mm: formats round to single precision.
const SAME_MM: f64 = 0.01;

/// How a label map's grid lies beside the CT's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridMatch {
    /// Voxel on voxel.
    Same,
    /// Voxel on voxel, on a part of the CT.
    Part {
        /// The CT's voxel on which the map's first lies.
        first: [u32; 3],
        /// Whether the map's file says to be in the CT's frame of reference. Else it may have been cut out, and its origin not been moved.
        is_known: bool,
    },
    /// As many voxels, as large and turned alike, and all moved by this much.
    Moved {
        /// Along the CT's axes, mm.
        by_mm: [f64; 3],
    },
    /// Another grid.
    Other,
}

impl GridMatch {
    /// Of two grids.
    pub fn of(labels: &VolumeGrid, ct: &VolumeGrid) -> Self {
        if labels == ct {
            return Self::Same;
        }
        if labels.dims() != ct.dims() {
            return Self::part(labels, ct).unwrap_or(Self::Other);
        }
        let all = moved(labels, ct, [0; 3]);
        if all.iter().all(|by| by.norm() <= SAME_MM) {
            return Self::Same;
        }
        match all.iter().all(|by| (*by - all[0]).norm() <= SAME_MM) {
            true => Self::Moved { by_mm: all[0].mm() },
            false => Self::Other,
        }
    }

    /// Where on the CT a smaller map lies voxel on voxel; `None` where it does not, or goes beyond.
    fn part(labels: &VolumeGrid, ct: &VolumeGrid) -> Option<Self> {
        let origin = labels.ct_from_voxel() * Point::<Voxel>::new(0.0, 0.0, 0.0);
        let at = (ct.voxel_from_ct() * origin).mm();
        let mut first = [0; 3];
        for axis in 0..3 {
            let nearest = at[axis].round();
            let beyond = f64::from(ct.dims()[axis]) - f64::from(labels.dims()[axis]);
            // Not a number is refused too.
            if !(0.0..=beyond).contains(&nearest) {
                return None;
            }
            first[axis] = nearest as u32;
        }
        let is_on = moved(labels, ct, first).iter().all(|by| by.norm() <= SAME_MM);
        is_on.then_some(Self::Part { first, is_known: false })
    }

    /// The same for a map of which this is known: whether its file says to be in the CT's frame of reference.
    pub fn known(self, is_known: bool) -> Self {
        match self {
            Self::Part { first, .. } => Self::Part { first, is_known },
            other => other,
        }
    }

    /// Whether nobody can tell that the map belongs to this CT.
    pub fn is_doubtful(&self) -> bool {
        !matches!(self, Self::Same | Self::Part { is_known: true, .. })
    }
}

/// How far the corners of the map lie from voxels of the CT, counted from `first` on; those one voxel beyond the last, so that also the
/// step of a map of one plane counts. Both maps are affine: what holds at the corners holds of all voxels between.
fn moved(labels: &VolumeGrid, ct: &VolumeGrid, first: [u32; 3]) -> [Vector<geometry::Ct>; 8] {
    let far = labels.dims();
    std::array::from_fn(|k| {
        let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { far[axis] } else { 0 });
        let point = |at: [u32; 3]| Point::<Voxel>::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2]));
        let on_ct = [0, 1, 2].map(|axis| at[axis] + first[axis]);
        labels.ct_from_voxel() * point(at) - ct.ct_from_voxel() * point(on_ct)
    })
}

impl fmt::Display for GridMatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => write!(f, "the label map lies on the CT's voxels"),
            Self::Part { is_known: true, .. } => write!(
                f,
                "the label map lies on a part of the CT's voxels, in its frame of reference"
            ),
            Self::Part { .. } => write!(f, "LABELS LIE ON A PART OF THE CT'S VOXELS: compare them"),
            Self::Moved { by_mm: [x, y, z] } => write!(
                f,
                "LABELS ARE MOVED against the CT's voxels by {x:.1} {y:.1} {z:.1} mm: compare them"
            ),
            Self::Other => write!(f, "LABELS LIE ON ANOTHER GRID THAN THE CT: compare them"),
        }
    }
}

#[cfg(test)]
mod tests {
    use geometry::Affine;

    use super::*;

    fn grid(dims: [i64; 3], step: f64, origin: [f64; 3]) -> VolumeGrid {
        let [x, y, z] = origin;
        let rows = [[step, 0.0, 0.0, x], [0.0, step, 0.0, y], [0.0, 0.0, step, z]];
        VolumeGrid::checked(dims, Affine::from_rows(rows)).unwrap()
    }

    #[test]
    fn a_map_that_is_moved_or_larger_or_turned_is_told_from_one_that_lies_on_the_ct() {
        let ct = grid([100, 90, 80], 0.7, [-10.0, 5.0, 3.0]);
        let of = |dims, step, origin| GridMatch::of(&grid(dims, step, origin), &ct);
        assert_eq!(of([100, 90, 80], 0.7, [-10.0, 5.0, 3.0]), GridMatch::Same);
        // Single precision: 0.7 as f32.
        assert_eq!(
            of([100, 90, 80], f64::from(0.7_f32), [-10.0, 5.0, 3.0]),
            GridMatch::Same
        );
        let moved = of([100, 90, 80], 0.7, [-10.0, 5.7, 3.0]);
        let GridMatch::Moved { by_mm } = moved else {
            panic!("{moved:?}")
        };
        assert!((by_mm[1] - 0.7).abs() < 1e-12, "{moved}");
        assert!(moved.to_string().contains("by 0.0 0.7 0.0 mm"), "{moved}");
        assert_eq!(of([100, 90, 81], 0.7, [-10.0, 5.0, 3.0]), GridMatch::Other);
        assert_eq!(of([100, 90, 80], 0.701, [-10.0, 5.0, 3.0]), GridMatch::Other);
        assert!(moved.is_doubtful() && !GridMatch::Same.is_doubtful());
    }

    #[test]
    fn a_map_on_a_part_of_the_voxels_is_told_from_one_between_them_or_beyond() {
        let ct = grid([100, 90, 80], 0.7, [-10.0, 5.0, 3.0]);
        let of = |dims, step, origin| GridMatch::of(&grid(dims, step, origin), &ct);
        let part = |is_known| GridMatch::Part {
            first: [0, 0, 10],
            is_known,
        };
        let found = of([100, 90, 70], 0.7, [-10.0, 5.0, 10.0]);
        assert_eq!((found, found.known(true)), (part(false), part(true)));
        // Who cuts voxels out and keeps the origin has such a map too.
        assert!(found.is_doubtful() && !found.known(true).is_doubtful());
        // One plane, whose step is the CT's, and one that is thicker.
        assert_eq!(of([100, 90, 1], 0.7, [-10.0, 5.0, 10.0]), part(false));
        let rows = [[0.7, 0.0, 0.0, -10.0], [0.0, 0.7, 0.0, 5.0], [0.0, 0.0, 7.0, 10.0]];
        let thick = VolumeGrid::checked([100, 90, 1], Affine::from_rows(rows)).unwrap();
        assert_eq!(GridMatch::of(&thick, &ct), GridMatch::Other);
        // One plane more than the CT has there, half a voxel aside, another size, and turned about an axis.
        assert_eq!(of([100, 90, 71], 0.7, [-10.0, 5.0, 10.0]), GridMatch::Other);
        assert_eq!(of([100, 90, 70], 0.7, [-10.0, 5.0, 10.35]), GridMatch::Other);
        assert_eq!(of([50, 45, 40], 0.71, [-10.0, 5.0, 3.0]), GridMatch::Other);
        let rows = [[-0.7, 0.0, 0.0, 59.3], [0.0, -0.7, 0.0, 67.3], [0.0, 0.0, 0.7, 10.0]];
        let turned = VolumeGrid::checked([100, 90, 70], Affine::from_rows(rows)).unwrap();
        assert_eq!(GridMatch::of(&turned, &ct), GridMatch::Other);
    }
}
