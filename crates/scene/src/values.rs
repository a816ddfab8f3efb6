//! Single values within what is allowed, or what was found.

use std::ops::RangeInclusive;
use std::time::Duration;

use geometry::{Frame, Point, checked};

use super::error::Invalid;

pub(super) type Checked<T> = Result<T, Invalid>;

/// A quaternion written with six digits is this far from unit.
pub(super) const UNIT_TOLERANCE: f64 = 1e-5;

pub(super) fn invalid(key: impl Into<String>, found: impl ToString, allowed: impl Into<String>) -> Invalid {
    Invalid {
        key: key.into(),
        found: found.to_string(),
        allowed: allowed.into(),
    }
}

/// A number within `range`; NaN is in no range.
pub(super) fn number(key: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Checked<f64> {
    if range.contains(&value) {
        return Ok(value);
    }
    let allowed = format!("{} to {} {unit}", range.start(), range.end());
    Err(invalid(key, value, allowed.trim_end()))
}

pub(super) fn seconds(key: &str, value: f64, range: RangeInclusive<f64>) -> Checked<Duration> {
    number(key, value, range, "s").map(Duration::from_secs_f64)
}

pub(super) fn point<F: Frame>(key: &str, mm: [f64; 3]) -> Checked<Point<F>> {
    checked::point(mm).map_err(|_| invalid(key, format!("{mm:?}"), "three finite numbers"))
}

/// The first name that was there before, with its index.
pub(super) fn repeated<'a>(names: impl Iterator<Item = &'a str>) -> Option<(usize, &'a str)> {
    let mut seen = std::collections::BTreeSet::new();
    names.enumerate().find(|(_, name)| !seen.insert(*name))
}
