//! The sampling grid of a volume: how many voxels, and where they lie in the patient.

use std::fmt;

use crate::{Affine, Ct, Point, Voxel};

/// Largest number of voxels along one axis.
pub const MAX_DIM: u64 = 16_384;
/// Largest number of voxels in a volume (8 GiB of i16): what 32-bit offsets reach.
pub const MAX_VOXELS: u64 = u32::MAX as u64;
/// Voxel spacings outside this range (mm) are refused: no scanner makes them, and a metre read as a millimetre does.
const SPACING_MM: std::ops::RangeInclusive<f64> = 1e-3..=100.0;
/// All voxels' coordinates (mm) lie within this: ten metres from the origin of a scanner's coordinates there is no patient, and a place
/// beyond is refused wherever one comes in (poses, targets, frames of images).
const FAR_MM: f64 = 1e4;
/// Smallest volume of the unit cell relative to the product of its steps: 0.17 is a tilt of 80 degrees.
const MIN_CELL: f64 = 0.17;

/// A grid of voxels with its place in the patient. Checked: dimensions and steps are usable and the map is invertible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeGrid {
    dims: [u32; 3],
    ct_from_voxel: Affine<Ct, Voxel>,
    voxel_from_ct: Affine<Voxel, Ct>,
}

/// Why a grid was refused.
#[derive(Debug, Clone, PartialEq)]
pub enum GridError {
    /// A dimension is not in 1..=[`MAX_DIM`].
    Dim {
        /// Which axis, 0 to 2.
        axis: usize,
        /// The dimension found.
        found: i64,
    },
    /// There are more than [`MAX_VOXELS`] voxels.
    TooMany {
        /// The number of voxels asked for.
        voxels: u64,
    },
    /// A number of the affine is NaN or infinite.
    NotFinite,
    /// A voxel step is too short or too long.
    Spacing {
        /// Which axis, 0 to 2.
        axis: usize,
        /// The length of the step, mm.
        found_mm: f64,
    },
    /// A voxel lies where no patient is.
    Far {
        /// Which voxel, of those at the eight corners.
        voxel: [u32; 3],
        /// Its largest coordinate, mm.
        found_mm: f64,
    },
    /// The three steps lie in or near one plane.
    Flat {
        /// Volume of the unit cell divided by the product of its steps; 1 for a box.
        relative_cell: f64,
    },
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dim { axis, found } => {
                write!(f, "dimension {axis} is {found}; allowed are 1 to {MAX_DIM} voxels")
            }
            Self::TooMany { voxels } => {
                write!(f, "the volume has {voxels} voxels; at most {MAX_VOXELS} are allowed")
            }
            Self::NotFinite => write!(f, "the voxel-to-patient matrix holds a NaN or an infinity"),
            Self::Spacing { axis, found_mm } => write!(
                f,
                "the voxel spacing along axis {axis} is {found_mm} mm; allowed are {} to {} mm",
                SPACING_MM.start(),
                SPACING_MM.end()
            ),
            Self::Far { voxel, found_mm } => write!(
                f,
                "voxel {voxel:?} lies at {found_mm} mm; at most {FAR_MM} mm either way are allowed: no patient lies so far from the origin of \
                 a scanner's coordinates"
            ),
            Self::Flat { relative_cell } => write!(
                f,
                "the voxel axes lie nearly in one plane (cell volume {relative_cell:.4} of a box's; at least {MIN_CELL} is allowed)"
            ),
        }
    }
}

impl std::error::Error for GridError {}

impl VolumeGrid {
    /// A grid from untrusted numbers: everything is checked before anybody allocates for it.
    ///
    /// # Errors
    /// Each variant of [`GridError`].
    pub fn checked(dims: [i64; 3], ct_from_voxel: Affine<Ct, Voxel>) -> Result<Self, GridError> {
        let dims = check_dims(dims)?;
        if !ct_from_voxel.rows().iter().flatten().all(|x| x.is_finite()) {
            return Err(GridError::NotFinite);
        }
        let mut product = 1.0;
        for axis in 0..3 {
            let found_mm = ct_from_voxel.step(axis).norm();
            if !SPACING_MM.contains(&found_mm) {
                return Err(GridError::Spacing { axis, found_mm });
            }
            product *= found_mm;
        }
        check_far(dims, ct_from_voxel)?;
        // The volume of a voxel beside the product of its edges: near 0 three axes lie in a plane.
        let relative_cell = ct_from_voxel.determinant().abs() / product;
        let voxel_from_ct = match ct_from_voxel.inverse() {
            Some(inverse) if relative_cell >= MIN_CELL => inverse,
            _ => return Err(GridError::Flat { relative_cell }),
        };
        Ok(Self {
            dims,
            ct_from_voxel,
            voxel_from_ct,
        })
    }

    /// Voxels along each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The number of voxels.
    pub fn voxels(&self) -> u64 {
        self.dims.iter().map(|&d| u64::from(d)).product()
    }

    /// From voxel index to patient millimetres.
    pub fn ct_from_voxel(&self) -> Affine<Ct, Voxel> {
        self.ct_from_voxel
    }

    /// From patient millimetres to voxel index.
    pub fn voxel_from_ct(&self) -> Affine<Voxel, Ct> {
        self.voxel_from_ct
    }

    /// Lengths of the three voxel steps, mm.
    pub fn spacing_mm(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.ct_from_voxel.step(axis).norm())
    }

    /// Whether `p` lies in a voxel: its continuous index is in [-1/2, n - 1/2] along each axis of n voxels. Not so where a
    /// coordinate is not a number.
    pub fn holds(&self, p: Point<Ct>) -> bool {
        let voxel = (self.voxel_from_ct * p).mm();
        let inside = |(v, n): (f64, u32)| (-0.5..=f64::from(n) - 0.5).contains(&v);
        voxel.into_iter().zip(self.dims).all(inside)
    }

    /// The middle of the volume.
    pub fn centre(&self) -> Point<Ct> {
        let [x, y, z] = self.dims.map(|d| (f64::from(d) - 1.0) / 2.0);
        self.ct_from_voxel * Point::new(x, y, z)
    }

    /// The box in patient axes that holds every voxel's cell: (smallest, largest) corner.
    pub fn bounds(&self) -> (Point<Ct>, Point<Ct>) {
        // An affine map takes a box to a parallelepiped, whose extent is that of its eight corners.
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in 0..8 {
            let [x, y, z] = std::array::from_fn(|axis| {
                let far = corner >> axis & 1 == 1;
                // Whole numbers are voxel centres: cells begin half a voxel before the first and end half a voxel after
                // the last.
                if far { f64::from(self.dims[axis]) - 0.5 } else { -0.5 }
            });
            let p = (self.ct_from_voxel * Point::<Voxel>::new(x, y, z)).mm();
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
        (
            Point::new(low[0], low[1], low[2]),
            Point::new(high[0], high[1], high[2]),
        )
    }
}

/// Every voxel lies where a patient may be: the farthest is one of those at the corners.
fn check_far(dims: [u32; 3], ct_from_voxel: Affine<Ct, Voxel>) -> Result<(), GridError> {
    for corner in 0..8 {
        let voxel: [u32; 3] = std::array::from_fn(|axis| if corner >> axis & 1 == 1 { dims[axis] - 1 } else { 0 });
        let [x, y, z] = voxel.map(f64::from);
        let place = (ct_from_voxel * Point::<Voxel>::new(x, y, z)).mm();
        let farthest = place
            .into_iter()
            .fold(0.0, |most: f64, mm| if mm.abs() > most.abs() { mm } else { most });
        if farthest.abs() > FAR_MM {
            let found_mm = farthest;
            return Err(GridError::Far { voxel, found_mm });
        }
    }
    Ok(())
}

fn check_dims(dims: [i64; 3]) -> Result<[u32; 3], GridError> {
    let mut checked = [0_u32; 3];
    let mut voxels = 1_u64;
    for axis in 0..3 {
        let dim = u32::try_from(dims[axis])
            .ok()
            .filter(|&d| d >= 1 && u64::from(d) <= MAX_DIM)
            .ok_or(GridError::Dim {
                axis,
                found: dims[axis],
            })?;
        checked[axis] = dim;
        // Cannot overflow: three times 14 bits.
        voxels *= u64::from(dim);
    }
    if voxels > MAX_VOXELS {
        return Err(GridError::TooMany { voxels });
    }
    Ok(checked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    fn boxed(step: f64) -> Affine<Ct, Voxel> {
        Affine::from_steps(
            Point::new(-10.0, 5.0, 100.0),
            [
                Vector::new(step, 0.0, 0.0),
                Vector::new(0.0, step, 0.0),
                Vector::new(0.0, 0.0, step),
            ],
        )
    }

    #[test]
    fn refuses_each_bad_grid_by_name() {
        let bad = |dims, affine| VolumeGrid::checked(dims, affine).unwrap_err();
        assert_eq!(bad([0, 1, 1], boxed(1.0)), GridError::Dim { axis: 0, found: 0 });
        assert_eq!(bad([1, -3, 1], boxed(1.0)), GridError::Dim { axis: 1, found: -3 });
        assert_eq!(
            bad([1, 1, 1 << 40], boxed(1.0)),
            GridError::Dim {
                axis: 2,
                found: 1 << 40
            }
        );
        assert!(matches!(
            bad([16_384, 16_384, 16_384], boxed(1.0)),
            GridError::TooMany { .. }
        ));
        assert_eq!(bad([2, 2, 2], boxed(f64::NAN)), GridError::NotFinite);
        assert!(matches!(bad([2, 2, 2], boxed(0.0)), GridError::Spacing { axis: 0, .. }));
        assert!(matches!(bad([2, 2, 2], boxed(1e6)), GridError::Spacing { .. }));
        let far = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, -1e17], [0.0, 0.0, 1.0, 0.0]]);
        let first = [0; 3];
        let found_mm = -1e17;
        assert_eq!(bad([2, 2, 2], far), GridError::Far { voxel: first, found_mm });
        let flat = Affine::from_rows([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.01, 0.0]]);
        assert!(matches!(bad([2, 2, 2], flat), GridError::Flat { .. }));
    }

    /// Origins of kilometres were taken, up to 1e9 mm, and so was a volume that reaches there from a near origin.
    #[test]
    fn a_volume_that_lies_or_ends_where_no_patient_is_is_refused() {
        let at = |origin: f64, count: i64| {
            let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, origin]];
            VolumeGrid::checked([2, 2, count], Affine::from_rows(rows)).map(|_| ())
        };
        let far = |voxel, found_mm| Err(GridError::Far { voxel, found_mm });
        assert_eq!(at(2e6, 2), far([0; 3], 2e6));
        assert_eq!(at(-10_000.5, 2), far([0; 3], -10_000.5));
        assert_eq!(at(9_000.0, 1_002), far([0, 0, 1001], 10_001.0));
        assert_eq!(at(9_000.0, 1_001), Ok(()));
        assert_eq!(at(-10_000.0, 16_384), Ok(()));
        let told = at(2e6, 2).unwrap_err().to_string();
        assert!(
            told.contains("voxel [0, 0, 0] lies at 2000000 mm; at most 10000 mm"),
            "{told}"
        );
    }

    #[test]
    fn bounds_hold_whole_cells() {
        let grid = VolumeGrid::checked([10, 20, 30], boxed(2.0)).unwrap();
        let (low, high) = grid.bounds();
        assert_eq!(low.mm(), [-11.0, 4.0, 99.0]);
        assert_eq!(high.mm(), [9.0, 44.0, 159.0]);
        assert_eq!(grid.centre().mm(), [-1.0, 24.0, 129.0]);
    }

    #[test]
    fn a_grid_holds_whole_cells_and_nothing_that_is_not_a_place() {
        let grid = VolumeGrid::checked([10, 20, 30], boxed(2.0)).unwrap();
        let (low, high) = grid.bounds();
        assert!(grid.holds(low) && grid.holds(high) && grid.holds(grid.centre()));
        for bad in [-11.001, 9.001, 1e300, -1e300, f64::NAN, f64::INFINITY] {
            assert!(!grid.holds(Point::new(bad, 24.0, 129.0)), "{bad}");
        }
    }
}
