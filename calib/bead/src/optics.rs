//! What the scanner is expected to do to a bead: directions, blur, and how bright the dimmest bead can be.

use geometry::{Ct, Point, VolumeGrid};
use nalgebra::{Matrix3, Vector3};

use super::profile::Blur;
use super::{Refused, Search};

/// The finest blur that is expected, mm: a scanner's kernel for soft tissue.
const LEAST_BLUR_MM: f64 = 0.45;
/// Blur as a share of the voxel's step: that of a slice's sensitivity profile.
const BLUR_PER_STEP: f64 = 0.4;
/// How unlike the two steps of the slice's plane may be.
const MAX_UNEVEN: f64 = 1.5;

/// Directions of a volume: the slice's normal and the steps, in mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    /// Steps of the three axes as columns, in the patient, mm.
    pub(super) steps: Matrix3<f64>,
    pub(super) origin: Vector3<f64>,
    /// Unit vector along which the blur differs: the normal of the slices.
    pub(super) normal: Vector3<f64>,
    /// Distance between voxels in the plane (geometric mean) and between slices along the normal, mm.
    pub(super) step_mm: [f64; 2],
    /// Expected deviation of the blur in the plane and along the normal, voxel's own extent included, mm.
    pub(super) sigma_mm: [f64; 2],
}

impl Optics {
    pub(super) fn of(grid: &VolumeGrid) -> Result<Self, Refused> {
        let rows = grid.ct_from_voxel().rows();
        let steps = Matrix3::from_fn(|i, j| rows[i][j]);
        let spacing = grid.spacing_mm();
        let uneven = |odd: usize| {
            let [a, b] = [(odd + 1) % 3, (odd + 2) % 3];
            (spacing[a] / spacing[b]).ln().abs()
        };
        // The axis without which the others are most alike; the slices' own where all are.
        let odd = [2, 1, 0].into_iter().fold(
            2,
            |best, axis| {
                if uneven(axis) < uneven(best) - 1e-6 { axis } else { best }
            },
        );
        if uneven(odd) > MAX_UNEVEN.ln() {
            return Err(Refused::Uneven { spacing_mm: spacing });
        }
        let [a, b] = [(odd + 1) % 3, (odd + 2) % 3];
        // A grid's steps do not lie in one plane.
        let normal = steps
            .column(a)
            .cross(&steps.column(b))
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::z);
        let step_mm = [(spacing[a] * spacing[b]).sqrt(), steps.column(odd).dot(&normal).abs()];
        Ok(Self {
            steps,
            origin: Vector3::from_fn(|i, _| rows[i][3]),
            normal,
            step_mm,
            sigma_mm: step_mm.map(expected_blur),
        })
    }

    /// From the patient's millimetres to a continuous voxel index.
    pub(super) fn index(&self, grid: &VolumeGrid, mm: Vector3<f64>) -> [f64; 3] {
        let point = grid.voxel_from_ct() * Point::<Ct>::new(mm.x, mm.y, mm.z);
        point.mm()
    }

    /// Where a voxel lies, mm.
    pub(super) fn place(&self, voxel: [f64; 3]) -> Vector3<f64> {
        self.origin + self.steps * Vector3::from(voxel)
    }

    /// Distance from the axis along the normal, and height along it, of a displacement in mm.
    pub(super) fn cylinder(&self, d: &Vector3<f64>) -> (f64, f64) {
        let z = d.dot(&self.normal);
        // On the axis rounding may leave a little less than 0.
        ((d.norm_squared() - z * z).max(0.0).sqrt(), z)
    }

    /// Orthonormal columns of which the third is the normal.
    pub(super) fn axes(&self) -> Matrix3<f64> {
        let least = self.normal.iamin();
        let other = Vector3::from_fn(|i, _| f64::from(u8::from(i == least)));
        // Never parallel: the other axis is the one that the normal leans to least.
        let u = self.normal.cross(&other).try_normalize(0.0).unwrap_or(other);
        Matrix3::from_columns(&[u, self.normal.cross(&u), self.normal])
    }

    pub(super) fn blur(&self, radius_mm: f64) -> Blur {
        Blur {
            radius_mm,
            plane_mm: self.sigma_mm[0],
            axial_mm: self.sigma_mm[1],
            slice_mm: 0.0,
        }
    }

    /// Whether slices are thicker than their blur: how they are blurred then counts, and a spot's middle says little of its height.
    pub(super) fn is_thick(&self) -> bool {
        BLUR_PER_STEP * self.step_mm[1] > LEAST_BLUR_MM
    }

    /// The profiles that a slice may have: a bell, and where it is thick, a mean over its thickness behind the scanner's
    /// own blur, as slices averaged from thin ones are.
    pub(super) fn profiles(&self, radius_mm: f64) -> Vec<Blur> {
        let bell = self.blur(radius_mm);
        let step = self.step_mm[1];
        let averaged = Blur {
            axial_mm: LEAST_BLUR_MM,
            slice_mm: step,
            ..bell
        };
        if self.is_thick() {
            vec![bell, averaged]
        } else {
            vec![bell]
        }
    }

    /// The brightest voxel's share of the metal's HU for the smallest bead in the worst place: midway between voxels.
    pub(super) fn least_share(&self, search: &Search) -> f64 {
        let [plane, axial] = self.step_mm;
        self.blur(search.radius_mm[0])
            // Half a step along both axes of the plane is the root of 1/2 of a step from the ball's axis.
            .value(plane * std::f64::consts::FRAC_1_SQRT_2, axial / 2.0)
    }
}

/// Deviation of the scanner's Gaussian and of the voxel's box together, mm.
fn expected_blur(step_mm: f64) -> f64 {
    let scanner = LEAST_BLUR_MM.max(BLUR_PER_STEP * step_mm);
    // Variances of a convolution add; a box of one step has a twelfth of its square.
    (scanner * scanner + step_mm * step_mm / 12.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Affine;

    fn optics(rows: [[f64; 4]; 3]) -> Result<Optics, Refused> {
        Optics::of(&VolumeGrid::checked([9, 9, 9], Affine::from_rows(rows)).unwrap())
    }

    #[test]
    fn the_normal_is_that_of_the_slices_also_where_they_are_sheared_or_stored_sideways() {
        let box_of = |[a, b, c]: [f64; 3]| [[a, 0.0, 0.0, 0.0], [0.0, b, 0.0, 0.0], [0.0, 0.0, c, 0.0]];
        let normal = |rows| optics(rows).unwrap().normal.abs();
        assert_eq!(normal(box_of([0.5, 0.5, 3.0])), Vector3::z());
        assert_eq!(normal(box_of([0.8, 0.8, 0.8])), Vector3::z());
        assert_eq!(normal(box_of([3.0, 0.5, 0.5])), Vector3::x());
        assert_eq!(normal(box_of([0.5, 2.0, 0.5])), Vector3::y());
        let mut tilted = box_of([0.5, 0.5, 2.0]);
        tilted[1][2] = 0.7;
        let found = optics(tilted).unwrap();
        assert_eq!((found.normal.abs(), found.step_mm), (Vector3::z(), [0.5, 2.0]));
        let uneven = optics(box_of([0.5, 1.0, 2.0])).unwrap_err();
        assert!(uneven.to_string().contains("0.5"), "{uneven}");
    }
}
