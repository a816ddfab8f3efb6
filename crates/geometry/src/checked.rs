//! The one door from untyped numbers to typed geometry: used where bytes come from a file, a socket, a command line or
//! another process's memory, and nowhere else. It refuses what is not finite and what is not a rotation.

use std::fmt;

use nalgebra::Vector3;

use crate::rotation::Rotation;
use crate::{Direction, Frame, Point, Rigid, Vector};

/// Why numbers from outside were refused.
#[derive(Debug, Clone, PartialEq)]
pub enum DoorError {
    /// A number is NaN or infinite.
    NotFinite {
        /// What was being read, for instance `translation of Ct from Tool`.
        what: String,
        /// The numbers found.
        found: Vec<f64>,
    },
    /// A quaternion's norm is further from 1 than the tolerance.
    NotUnit {
        /// What was being read.
        what: String,
        /// The norm found.
        norm: f64,
        /// The largest accepted distance of the norm from 1.
        tolerance: f64,
    },
    /// A direction has no length.
    NoDirection {
        /// What was being read.
        what: String,
    },
}

impl fmt::Display for DoorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { what, found } => {
                write!(f, "{what}: every number must be finite, found {found:?}")
            }
            Self::NotUnit { what, norm, tolerance } => write!(
                f,
                "{what}: a rotation needs a quaternion of norm 1 within {tolerance:e}, found norm {norm}"
            ),
            Self::NoDirection { what } => write!(f, "{what}: a direction needs a length above zero"),
        }
    }
}

impl std::error::Error for DoorError {}

fn finite(what: impl FnOnce() -> String, numbers: &[f64]) -> Result<(), DoorError> {
    if numbers.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(DoorError::NotFinite {
        what: what(),
        found: numbers.to_vec(),
    })
}

/// A point in `F` from three numbers in its unit.
///
/// # Errors
/// [`DoorError::NotFinite`].
pub fn point<F: Frame>(mm: [f64; 3]) -> Result<Point<F>, DoorError> {
    finite(|| format!("a point in {}", F::NAME), &mm)?;
    Ok(Point::wrap(Vector3::from(mm)))
}

/// A direction in `F` from three numbers of any length above zero.
///
/// # Errors
/// [`DoorError::NotFinite`], [`DoorError::NoDirection`].
pub fn direction<F: Frame>(components: [f64; 3]) -> Result<Direction<F>, DoorError> {
    let what = || format!("a direction in {}", F::NAME);
    finite(what, &components)?;
    Vector::wrap(Vector3::from(components))
        .direction()
        .ok_or_else(|| DoorError::NoDirection { what: what() })
}

/// `to_from_from` from a quaternion (w, x, y, z) and a translation in `To`, mm.
///
/// The quaternion is accepted when its norm is within `tolerance` of 1. Where it is already unit to 2.5 ulp its bits are
/// kept, so that a pose goes through files and replays unchanged; else it is divided by its norm.
///
/// # Errors
/// [`DoorError::NotFinite`], [`DoorError::NotUnit`].
pub fn rigid<To: Frame, From: Frame>(
    quaternion: [f64; 4],
    translation_mm: [f64; 3],
    tolerance: f64,
) -> Result<Rigid<To, From>, DoorError> {
    let what = |part: &str| format!("{part} of {} from {}", To::NAME, From::NAME);
    finite(|| what("quaternion"), &quaternion)?;
    finite(|| what("translation"), &translation_mm)?;
    let [w, x, y, z] = quaternion;
    // By hypot: squares of numbers from outside may overflow.
    let norm = w.hypot(x).hypot(y.hypot(z));
    let not_unit = || DoorError::NotUnit {
        what: what("quaternion"),
        norm,
        tolerance,
    };
    if (norm - 1.0).abs() > tolerance {
        return Err(not_unit());
    }
    let rotation = Rotation::from_quaternion(quaternion).map_err(|_| not_unit())?;
    Ok(Rigid::from_parts(rotation, Vector::wrap(translation_mm.into())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ct, Tool};

    const Q: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

    #[test]
    fn refuses_what_is_not_finite() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(point::<Ct>([0.0, bad, 0.0]).is_err());
            assert!(direction::<Ct>([0.0, bad, 0.0]).is_err());
            assert!(rigid::<Ct, Tool>(Q, [0.0, 0.0, bad], 1e-9).is_err());
            assert!(rigid::<Ct, Tool>([1.0, bad, 0.0, 0.0], [0.0; 3], 1e-9).is_err());
        }
    }

    #[test]
    fn refuses_non_unit_quaternions_with_their_norm() {
        let err = rigid::<Ct, Tool>([1.0, 0.5, 0.0, 0.0], [0.0; 3], 1e-9).unwrap_err();
        assert!(err.to_string().contains("1.118"), "{err}");
        assert!(err.to_string().contains("Ct from Tool"), "{err}");
        assert!(rigid::<Ct, Tool>([0.0; 4], [0.0; 3], 1e-3).is_err());
        assert!(rigid::<Ct, Tool>([1e200; 4], [0.0; 3], 1e-3).is_err());
    }

    #[test]
    fn unit_quaternions_keep_their_bits() {
        let q = rigid::<Ct, Tool>([0.6001, 0.8, 0.0, 0.0], [0.0; 3], 1e-3)
            .unwrap()
            .quaternion();
        assert_eq!(rigid::<Ct, Tool>(q, [0.0; 3], 1e-9).unwrap().quaternion(), q);
    }
}
