//! How far the linear part of a matrix is from a rotation, and a quaternion from length 1. Nothing is repaired here.

/// What a matrix `R` does beside turning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The largest absolute entry of `R^T R - I`: 0 for a rotation, and for a reflection.
    pub orthonormal: f64,
    /// `det R`: 1 for a rotation, -1 for a reflection.
    pub determinant: f64,
    /// The lengths of the three columns: 1 for a rotation; 1000 or 0.001 where metres were taken for millimetres.
    pub lengths: [f64; 3],
}

/// Why a matrix or a quaternion is no rotation.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RotationError {
    /// A column without length: what an empty or a broken message gives.
    #[error("a column of the matrix has length 0")]
    Zero,
    /// The hand of the frames differs: RAS taken for LPS on one side with an odd number of axes turned, or a mirrored
    /// tracker.
    #[error("the matrix mirrors (determinant {determinant:.6})")]
    Mirrors {
        /// The determinant.
        determinant: f64,
    },
    /// Another unit on one side.
    #[error("the matrix scales by {scale:.6}")]
    Scales {
        /// The mean length of the columns.
        scale: f64,
    },
    /// Not at right angles or of different lengths: rows taken for columns together with the place, or numbers of
    /// something else.
    #[error("the matrix is off a rotation by {deviation:.3e}; allowed is {allowed:.3e}")]
    Off {
        /// [`Deviation::orthonormal`].
        deviation: f64,
        /// The bound.
        allowed: f64,
    },
    /// A quaternion without length has no axis.
    #[error("the quaternion has length 0")]
    ZeroQuaternion,
    /// A quaternion of another length than 1.
    #[error("the quaternion has length {length:.6}; allowed is 1 within {allowed:.3e}")]
    Length {
        /// Its length.
        length: f64,
        /// The bound.
        allowed: f64,
    },
}

/// Columns that are as good as none.
const ZERO: f64 = 1e-6;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Measures the linear part of a matrix, given by its columns as on the wire.
pub fn deviation(columns: &[[f32; 3]; 3]) -> Deviation {
    let [x, y, z] = columns.map(|column| column.map(f64::from));
    let gram = [[x, x], [y, y], [z, z], [x, y], [x, z], [y, z]].map(|[a, b]| dot(a, b));
    let off = gram
        .iter()
        .enumerate()
        .map(|(entry, value)| (value - if entry < 3 { 1.0 } else { 0.0 }).abs());
    let cross = [
        y[1] * z[2] - y[2] * z[1],
        y[2] * z[0] - y[0] * z[2],
        y[0] * z[1] - y[1] * z[0],
    ];
    Deviation {
        orthonormal: off.fold(0.0, f64::max),
        determinant: dot(x, cross),
        lengths: [gram[0], gram[1], gram[2]].map(f64::sqrt),
    }
}

/// Holds a matrix against a rotation. Single precision alone is off by some 1e-7, recorded trackers by up to 5e-4.
///
/// A rotation that was sent transposed is a rotation, and cannot be told from one that was not.
///
/// # Errors
/// What it is instead, by the first of [`RotationError::Zero`], [`RotationError::Mirrors`], [`RotationError::Scales`]
/// (columns of one length and at right angles, but for `allowed` of that length) and [`RotationError::Off`].
pub fn check(columns: &[[f32; 3]; 3], allowed: f64) -> Result<Deviation, RotationError> {
    let measured = deviation(columns);
    let [a, b, c] = measured.lengths;
    let scale = (a + b + c) / 3.0;
    if a.min(b).min(c) < ZERO {
        return Err(RotationError::Zero);
    }
    if measured.determinant < 0.0 {
        return Err(RotationError::Mirrors {
            determinant: measured.determinant,
        });
    }
    if measured.orthonormal <= allowed {
        return Ok(measured);
    }
    // f64 has room for any f32, and a length of 1 is close to what the columns were to begin with.
    let [x, y, z] = columns.map(|column| column.map(|number| f64::from(number) / scale));
    let even = [dot(x, x), dot(y, y), dot(z, z)]
        .iter()
        .all(|square| (square - 1.0).abs() <= allowed);
    let square = [dot(x, y), dot(x, z), dot(y, z)]
        .iter()
        .all(|cosine| cosine.abs() <= allowed);
    Err(if even && square {
        RotationError::Scales { scale }
    } else {
        RotationError::Off {
            deviation: measured.orthonormal,
            allowed,
        }
    })
}

/// Holds a quaternion `x y z w` against length 1, and gives its length.
///
/// # Errors
/// [`RotationError::ZeroQuaternion`], [`RotationError::Length`].
pub fn check_quaternion(quaternion: &[f32; 4], allowed: f64) -> Result<f64, RotationError> {
    let squares = quaternion.map(|number| f64::from(number) * f64::from(number));
    let length = squares.iter().sum::<f64>().sqrt();
    if length < ZERO {
        return Err(RotationError::ZeroQuaternion);
    }
    if (length - 1.0).abs() > allowed {
        return Err(RotationError::Length { length, allowed });
    }
    Ok(length)
}
