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
            return Self::Other;
        }
        // Both maps are affine: what holds at the corners holds of all voxels between.
        let far = ct.dims().map(|n| f64::from(n - 1));
        let corner = |k: usize| {
            let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { far[axis] } else { 0.0 });
            Point::<Voxel>::new(at[0], at[1], at[2])
        };
        let moved = |k| labels.ct_from_voxel() * corner(k) - ct.ct_from_voxel() * corner(k);
        let all: [Vector<geometry::Ct>; 8] = std::array::from_fn(moved);
        if all.iter().all(|by| by.norm() <= SAME_MM) {
            return Self::Same;
        }
        match all.iter().all(|by| (*by - all[0]).norm() <= SAME_MM) {
            true => Self::Moved { by_mm: all[0].mm() },
            false => Self::Other,
        }
    }

    /// Whether nobody can tell that the map belongs to this CT.
    pub fn is_doubtful(&self) -> bool {
        *self != Self::Same
    }
}

impl fmt::Display for GridMatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => write!(f, "the label map lies on the CT's voxels"),
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
}
