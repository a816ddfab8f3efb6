//! A transform as it came, and the door to a pose that may be used.

use crate::fault::Fault;

/// A quaternion whose length is this far off is none. TX writes four decimals, so that rounding is below 1.1e-4; of
/// single precision it is below 1e-6.
pub const UNIT_TOLERANCE: f64 = 1e-3;
/// A place further out is none, mm: devices fill places that they do not know with -3.7e28.
pub const MOST_MM: f64 = 1e5;

/// `tracker_from_tool` as the device sent it; nothing is known of its numbers. In the device's own frame, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Quaternion, w x y z.
    pub q: [f64; 4],
    /// Translation, mm.
    pub t_mm: [f64; 3],
    /// Root mean square distance of the markers to the tool's definition, mm.
    pub error_mm: f64,
}

/// A transform whose numbers may be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Quaternion, w x y z, as the device sent it.
    pub q: [f64; 4],
    /// Translation, mm.
    pub t_mm: [f64; 3],
    /// Root mean square distance of the markers to the tool's definition, mm.
    pub error_mm: f64,
    /// The length of `q` less 1.
    pub off_unit: f64,
}

/// Why a transform cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A number that is none.
    #[error("{value} in the {field}; allowed are finite numbers")]
    NotFinite {
        /// Which number.
        field: &'static str,
        /// NaN, inf or -inf.
        value: &'static str,
    },
    /// A quaternion of zeros: what some senders make of a tool that they do not see.
    #[error("a quaternion of zeros")]
    ZeroQuaternion,
    /// A quaternion that is no rotation.
    #[error("a quaternion of length {norm}; allowed is 1 within {allowed}")]
    NotUnit {
        /// Its length.
        norm: f64,
        /// How far it may be off.
        allowed: f64,
    },
    /// A place that no localizer sees.
    #[error("a place {found_mm} mm off; allowed are 100000 mm")]
    TooFar {
        /// Its largest coordinate, mm.
        found_mm: f64,
    },
    /// An error that is none.
    #[error("an error of {found_mm} mm; it cannot be negative")]
    NegativeError {
        /// What stands there, mm.
        found_mm: f64,
    },
    /// The device calls it valid and sends no numbers.
    #[error("the device calls it valid and sends no transform")]
    Absent,
}

impl Transform {
    /// The pose, with the deviation of the quaternion's length from 1, which may be at most `tolerance`.
    ///
    /// # Errors
    /// The first thing that is wrong with its numbers.
    pub fn check(&self, tolerance: f64) -> Result<Pose, PoseError> {
        finite(&self.q, "quaternion")?;
        finite(&[self.error_mm], "error")?;
        check_place(&self.t_mm, "translation")?;
        let norm = self.q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm == 0.0 {
            return Err(PoseError::ZeroQuaternion);
        }
        if (norm - 1.0).abs() > tolerance {
            return Err(PoseError::NotUnit {
                norm,
                allowed: tolerance,
            });
        }
        if self.error_mm < 0.0 {
            let found_mm = self.error_mm;
            return Err(PoseError::NegativeError { found_mm });
        }
        Ok(Pose {
            q: self.q,
            t_mm: self.t_mm,
            error_mm: self.error_mm,
            off_unit: norm - 1.0,
        })
    }
}

/// Whether a place may be used.
///
/// # Errors
/// [`PoseError::NotFinite`], [`PoseError::TooFar`].
pub fn check_place(place_mm: &[f64; 3], field: &'static str) -> Result<(), PoseError> {
    finite(place_mm, field)?;
    let found_mm = place_mm.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if found_mm > MOST_MM {
        return Err(PoseError::TooFar { found_mm });
    }
    Ok(())
}

fn finite(numbers: &[f64], field: &'static str) -> Result<(), PoseError> {
    let value = numbers.iter().find(|number| !number.is_finite());
    match value {
        None => Ok(()),
        Some(number) if number.is_nan() => Err(PoseError::NotFinite { field, value: "NaN" }),
        Some(number) => {
            let value = if *number > 0.0 { "inf" } else { "-inf" };
            Err(PoseError::NotFinite { field, value })
        }
    }
}

/// A time of a device: seconds of its own clock and nanoseconds.
///
/// # Errors
/// [`Fault::Nanoseconds`] where they are a second or more.
pub(crate) fn device_ns(seconds: u32, nanoseconds: u32) -> Result<i64, Fault> {
    if nanoseconds >= 1_000_000_000 {
        return Err(Fault::Nanoseconds { found: nanoseconds });
    }
    Ok(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds))
}
