//! The one door from untyped numbers to typed geometry: used where bytes come from a file, a socket, a command line or
//! another process's memory, and nowhere else. It refuses what is not finite and what is not a rotation.

use std::fmt;

use nalgebra::Vector3;

use crate::rotation::Rotation;
use crate::{Direction, Frame, PlaneError, Point, Rigid, SlicePlane, Vector};

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
    /// A direction's length is further from 1 than rounding makes it.
    NotUnitDirection {
        /// What was being read.
        what: String,
        /// The length found.
        length: f64,
    },
    /// The plane of an image is none.
    Plane(PlaneError),
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
            Self::NotUnitDirection { what, length } => {
                write!(
                    f,
                    "{what}: a length of 1 within {UNIT_TOLERANCE:e} is needed, found {length}"
                )
            }
            Self::Plane(error) => error.fmt(f),
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

/// How far a direction's length may be from 1: some roundings.
const UNIT_TOLERANCE: f64 = 1e-12;

/// A direction in `F` from three numbers of length 1, whose bits are kept.
///
/// # Errors
/// [`DoorError::NotFinite`], [`DoorError::NotUnitDirection`].
pub fn unit_direction<F: Frame>(components: [f64; 3]) -> Result<Direction<F>, DoorError> {
    let what = || format!("a direction in {}", F::NAME);
    finite(what, &components)?;
    let [x, y, z] = components;
    // By hypot: squares of numbers from outside may overflow.
    let length = x.hypot(y).hypot(z);
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        return Err(DoorError::NotUnitDirection { what: what(), length });
    }
    Ok(Direction::wrap(Vector3::from(components)))
}

/// The plane of an image of `size` pixels of `pixel_mm`, from the centre of its first pixel and the directions of growing columns and rows
/// in the CT's frame. All bits are kept, so that a pixel lies where its renderer had it.
///
/// # Errors
/// [`DoorError::NotFinite`], [`DoorError::NotUnitDirection`], [`DoorError::Plane`].
pub fn slice_plane(
    origin_mm: [f64; 3],
    [right, down]: [[f64; 3]; 2],
    pixel_mm: f64,
    size: [u32; 2],
) -> Result<SlicePlane, DoorError> {
    let axes = [unit_direction(right)?, unit_direction(down)?];
    SlicePlane::from_origin(point(origin_mm)?, axes, pixel_mm, size).map_err(DoorError::Plane)
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
    fn a_plane_goes_through_the_door_bit_for_bit() {
        let r = Rigid::<Ct, Tool>::from_rotation_vector(
            Vector::wrap([0.3, -1.1, 0.7].into()),
            Vector::wrap([9.0, 1e4, -3.0].into()),
        );
        let axes = [Direction::X, -Direction::Y].map(|d: Direction<Tool>| r.unwrap() * d);
        let plane = SlicePlane::centred(point([1.0, 2.0, 3.0]).unwrap(), axes, 0.3, [512, 300]).unwrap();
        let numbers = [plane.right().components(), plane.down().components()];
        let back = |origin, axes, pixel| slice_plane(origin, axes, pixel, plane.size());
        assert_eq!(back(plane.origin().mm(), numbers, 0.3), Ok(plane));
        let stretched = [numbers[0].map(|x| x * (1.0 + 1e-9)), numbers[1]];
        assert!(matches!(
            back([0.0; 3], stretched, 0.3),
            Err(DoorError::NotUnitDirection { .. })
        ));
        assert!(matches!(
            back([0.0; 3], [[1e200; 3], numbers[1]], 0.3),
            Err(DoorError::NotUnitDirection { .. })
        ));
        assert!(matches!(back([0.0; 3], [numbers[0]; 2], 0.3), Err(DoorError::Plane(_))));
        assert!(matches!(
            back([0.0, f64::NAN, 0.0], numbers, 0.3),
            Err(DoorError::NotFinite { .. })
        ));
        assert!(matches!(back([0.0; 3], numbers, f64::NAN), Err(DoorError::Plane(_))));
    }

    #[test]
    fn unit_quaternions_keep_their_bits() {
        let q = rigid::<Ct, Tool>([0.6001, 0.8, 0.0, 0.0], [0.0; 3], 1e-3)
            .unwrap()
            .quaternion();
        assert_eq!(rigid::<Ct, Tool>(q, [0.0; 3], 1e-9).unwrap().quaternion(), q);
    }
}
