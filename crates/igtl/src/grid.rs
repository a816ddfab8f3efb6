//! What the steps of an IMAGE make of it: the lengths of its voxels, its hand, its angles.

use crate::body::image::Image;

/// Why the voxels of an image do not stand where a receiver puts them.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GridError {
    /// A step without length.
    #[error("the step along {axis} has length 0")]
    Flat {
        /// `i`, `j` or `k`.
        axis: char,
    },
    /// The steps are a left-handed system: receivers that rebuild the third axis of the first two mirror it.
    #[error("the steps along i, j, k are left-handed")]
    LeftHanded,
    /// The steps are not at right angles (the CT of a tilted gantry); receivers draw them as if they were.
    #[error("the steps along {axes} are off a right angle by {degrees:.3} degrees; allowed are {allowed:.3}")]
    Sheared {
        /// Which two.
        axes: &'static str,
        /// By how much.
        degrees: f64,
        /// The bound.
        allowed: f64,
    },
}

/// The lengths of a voxel along i, j, k in mm, of an image whose steps are at right angles and right-handed.
///
/// Steps of length 1 may be voxels of a millimetre, or those of a sender who sends directions alone: the message does
/// not tell.
///
/// # Errors
/// See [`GridError`]; `allowed_degrees` is how far two steps may be off a right angle.
pub fn check_grid(image: &Image<'_>, allowed_degrees: f64) -> Result<[f64; 3], GridError> {
    let steps = image.placed.columns.map(|step| step.map(f64::from));
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let lengths = steps.map(|step| dot(step, step).sqrt());
    for (axis, length) in ['i', 'j', 'k'].into_iter().zip(lengths) {
        if length <= 0.0 {
            return Err(GridError::Flat { axis });
        }
    }
    for (axes, a, b) in [("i and j", 0, 1), ("i and k", 0, 2), ("j and k", 1, 2)] {
        let degrees = (dot(steps[a], steps[b]) / (lengths[a] * lengths[b]))
            .asin()
            .abs()
            .to_degrees();
        // What is no number is off by more than anything.
        if degrees.is_nan() || degrees > allowed_degrees {
            return Err(GridError::Sheared {
                axes,
                degrees,
                allowed: allowed_degrees,
            });
        }
    }
    if crate::rotation::deviation(&image.placed.columns).determinant < 0.0 {
        return Err(GridError::LeftHanded);
    }
    Ok(lengths)
}
