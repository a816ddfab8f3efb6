//! Checks of single values of a scene in space.

use nalgebra::Vector3;

use super::super::raw::Triple;
use super::LONGEST;
use crate::numbers::{Checked, invalid};

/// Units are named, so that nobody takes others for granted.
pub(super) fn unit(key: &str, found: &str, allowed: &str) -> Checked<()> {
    let good = found == allowed;
    good.then_some(()).ok_or_else(|| {
        invalid(
            key,
            format!("{found:?}"),
            format!("{allowed:?}: a label map's places are mm, and forces are N"),
        )
    })
}

/// A length above 0.
pub(super) fn length(key: &str, value: f64) -> Checked<f64> {
    let good = value > 0.0 && value <= LONGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a length above 0, at most {LONGEST} mm")))
}

/// A place or a direction.
pub(super) fn triple(key: &str, [x, y, z]: Triple) -> Checked<Vector3<f64>> {
    let good = [x, y, z].iter().all(|c| c.abs() <= 1e5);
    good.then(|| Vector3::new(x, y, z)).ok_or_else(|| {
        invalid(
            key,
            format!("[{x}, {y}, {z}]"),
            "three numbers within 1e5: left, posterior, superior, mm",
        )
    })
}
