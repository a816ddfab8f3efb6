//! Where slices lie, in the words of the Image Plane module (PS3.3 C.7.6.2).

use std::path::Path;

use geometry::{Ct, Direction, Point, Vector, VolumeGrid};

use super::ExportError;
use super::error::MAX_SLANT;

/// Tilts below this are rounding, degrees; a gantry stands to a tenth of a degree.
const MIN_TILT_DEGREES: f64 = 0.005;
/// Largest part of the step along the rows, relative to the step, that is still a gantry's tilt.
const MAX_SIDEWAYS: f64 = 1e-4;

/// What is the same for all slices, and where each one lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    grid: VolumeGrid,
    /// Cosines of the rows' direction, and of the columns': ImageOrientationPatient.
    pub orientation: [f64; 6],
    /// From row to row, and from column to column, mm: PixelSpacing, in DICOM's order.
    pub pixel_spacing_mm: [f64; 2],
    /// From slice to slice along the normal, mm.
    pub step_mm: f64,
    /// The angle between the step and the normal, degrees, where it lies in the columns' direction as a tilted gantry's does.
    /// The standard gives it no sign; this is the one that head-first supine series of Philips carry.
    pub tilt_degrees: Option<f64>,
}

impl Placement {
    /// The placement of `grid`'s slices; `path` is for the error.
    ///
    /// # Errors
    /// [`ExportError::Slanted`].
    pub(crate) fn new(grid: &VolumeGrid, path: &Path) -> Result<Self, ExportError> {
        let slanted = |degrees| ExportError::Slanted {
            path: path.to_owned(),
            degrees,
        };
        let steps = [0, 1, 2].map(|axis| grid.ct_from_voxel().step(axis));
        let (row, column) = (direction(steps[0]), direction(steps[1]));
        let cosine = row.dot(column);
        if cosine.abs() > MAX_SLANT {
            return Err(slanted(cosine.acos().to_degrees()));
        }
        let along_normal = steps[2].dot(direction(row.cross(column)).vector());
        let [[a, b, c], [d, e, f]] = [row, column].map(Direction::components);
        Ok(Self {
            grid: *grid,
            orientation: [a, b, c, d, e, f],
            pixel_spacing_mm: [steps[1].norm(), steps[0].norm()],
            step_mm: along_normal.abs(),
            tilt_degrees: tilt_degrees(steps[2], row, column, along_normal),
        })
    }

    /// The middle of slice `k`'s first voxel: ImagePositionPatient, mm LPS. Within 10 m of the origin, where 16 characters hold it to 1e-9 mm.
    pub(crate) fn position_mm(&self, k: u32) -> [f64; 3] {
        (self.grid.ct_from_voxel() * Point::new(0.0, 0.0, f64::from(k))).mm()
    }
}

fn tilt_degrees(step: Vector<Ct>, row: Direction<Ct>, column: Direction<Ct>, along_normal: f64) -> Option<f64> {
    let sideways = step.dot(row.vector()).abs() / step.norm();
    let degrees = (step.dot(column.vector()) / along_normal).atan().to_degrees();
    (sideways <= MAX_SIDEWAYS && degrees.abs() >= MIN_TILT_DEGREES).then_some(degrees)
}

/// The direction of a checked grid's step, which is never zero.
fn direction(step: Vector<Ct>) -> Direction<Ct> {
    step.direction()
        .unwrap_or_else(|| unreachable!("a checked grid has no step of length zero"))
}
