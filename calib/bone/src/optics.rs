//! How a scanner blurs: a Gaussian, round in the slice's plane and of another width along the slice's normal.

use geometry::VolumeGrid;
use nalgebra::{Matrix3, Vector3};

use crate::error::Refused;

/// The most distance between voxels, mm.
const MOST_STEP_MM: f64 = 5.0;
/// Steps that differ less are alike.
const ALIKE: f64 = 1.02;

/// The slices of a CT.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Optics {
    /// Their normal.
    pub(crate) normal: Vector3<f64>,
    /// Steps within the slice's plane and from slice to slice, mm.
    pub(crate) step_mm: [f64; 2],
}

impl Optics {
    /// The axis whose step is not that of the two others goes across the slices; where all are alike, the third. Of a CT that is sheared (a
    /// gantry's tilt) the slices' normal is not that axis.
    pub(crate) fn of(grid: &VolumeGrid) -> Result<Self, Refused> {
        let step = grid.spacing_mm();
        if let Some(axis) = (0..3).find(|k| step[*k] > MOST_STEP_MM) {
            return Err(Refused::Coarse {
                axis,
                found: step[axis],
                most: MOST_STEP_MM,
            });
        }
        let alike = |a: usize, b: usize| step[a].max(step[b]) <= ALIKE * step[a].min(step[b]);
        let across = [2, 0, 1].into_iter().find(|k| alike((k + 1) % 3, (k + 2) % 3));
        let Some(across) = across else {
            return Err(Refused::Axes { found: step });
        };
        let (u, v) = ((across + 1) % 3, (across + 2) % 3);
        let vector = |axis: usize| Vector3::from(grid.ct_from_voxel().step(axis).mm());
        let normal = vector(u).cross(&vector(v)).normalize();
        Ok(Self {
            normal,
            step_mm: [0.5 * (step[u] + step[v]), vector(across).dot(&normal).abs()],
        })
    }

    /// The blur's covariance, mm^2, of deviations in the plane and along the normal.
    pub(crate) fn covariance(&self, [plane, axial]: [f64; 2]) -> Matrix3<f64> {
        let across = self.normal * self.normal.transpose();
        (Matrix3::identity() - across) * (plane * plane) + across * (axial * axial)
    }

    /// What is expected of the blur before anything was measured: the voxel's own width and a scanner's 0.4 mm.
    pub(crate) fn expected_mm(&self) -> [f64; 2] {
        self.step_mm.map(|step| (0.4 * step).hypot(0.4))
    }
}
