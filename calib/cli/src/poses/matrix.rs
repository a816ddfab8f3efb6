//! A pose from the 16 numbers of a matrix by rows, or from a quaternion.

use std::path::Path;

use geometry::checked;
use geometry::rotation::RotationMatrix;

use super::{MOST_OFF, PosesError, Seen, quoted};
use crate::input_files::fields::{self, Field};
use crate::register::input_error::Place;

/// What the last row may differ by.
const ROW: f64 = 1e-6;

/// Where a pose stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) path: &'a Path,
    pub(super) line: usize,
}

impl At<'_> {
    pub(super) fn place(&self, column: usize, name: &str) -> Place {
        Place {
            path: self.path.to_owned(),
            line: self.line,
            column,
            name: quoted(name),
        }
    }

    /// A finite number of at most 1e9.
    pub(super) fn number(&self, field: &Field<'_>, name: &str) -> Result<f64, PosesError> {
        fields::coordinate(&field.text).map_err(|_| PosesError::Field {
            place: self.place(field.column, name),
            found: quoted(&field.text),
            expected: "a finite number of at most 1e9, with a point for the decimals",
        })
    }

    /// A pose from a matrix by rows, mm.
    pub(super) fn matrix(&self, m: &[f64; 16]) -> Result<Seen, PosesError> {
        let (path, line) = (self.path.to_owned(), self.line);
        let found = [m[12], m[13], m[14], m[15]];
        let last = [0.0, 0.0, 0.0, 1.0];
        if found.iter().zip(last).any(|(a, b)| (a - b).abs() > ROW) {
            return Err(PosesError::BottomRow { path, line, found });
        }
        let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
        let nearest = RotationMatrix::nearest([row(0), row(1), row(2)]);
        let nearest = nearest.map_err(|source| PosesError::NoRotation { path, line, source })?;
        let q = nearest.matrix.rotation().quaternion();
        self.pose(q, [m[3], m[7], m[11]], nearest.distance)
    }

    /// A pose from a quaternion and a translation, mm.
    pub(super) fn quaternion(&self, q: [f64; 4], t: [f64; 3]) -> Result<Seen, PosesError> {
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = (norm - 1.0).abs();
        if off > MOST_OFF || off.is_nan() {
            return Err(self.far(off));
        }
        // A norm that is 1 to rounding keeps its bits.
        let q = if off > 4.0 * f64::EPSILON {
            q.map(|x| x / norm)
        } else {
            q
        };
        self.pose(q, t, off)
    }

    fn pose(&self, q: [f64; 4], t: [f64; 3], off: f64) -> Result<Seen, PosesError> {
        if off > MOST_OFF {
            return Err(self.far(off));
        }
        let pose = checked::rigid(q, t, MOST_OFF).map_err(|_| self.far(off))?;
        let covariance = None;
        Ok(Seen { pose, off, covariance })
    }

    fn far(&self, distance: f64) -> PosesError {
        let (path, line) = (self.path.to_owned(), self.line);
        PosesError::FarFromRotation { path, line, distance }
    }
}
