//! Checks of single values.

use std::fmt::Display;
use std::ops::RangeInclusive;

use ::scene::Invalid;
use nalgebra::Vector2;

use super::Checked;
use super::raw::Pair;

/// Numbers beyond this are refused: their squares must stay finite.
const LARGEST: f64 = 1e100;
/// The longest name.
const LONGEST_NAME: usize = 64;

pub(crate) fn invalid(key: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Invalid {
    Invalid {
        key: key.into(),
        found: found.to_string(),
        allowed: allowed.into(),
    }
}

/// A number that is one.
pub(crate) fn finite(key: &str, value: f64) -> Checked<f64> {
    let good = value.abs() <= LARGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a finite number, at most {LARGEST:e} away from 0")))
}

/// A number above zero.
pub(crate) fn positive(key: &str, value: f64) -> Checked<f64> {
    let good = value > 0.0 && value <= LARGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a number above 0, at most {LARGEST:e}")))
}

/// A point or a vector.
pub(crate) fn pair(key: &str, [x, y]: Pair) -> Checked<Vector2<f64>> {
    let good = x.abs() <= LARGEST && y.abs() <= LARGEST;
    good.then(|| Vector2::new(x, y))
        .ok_or_else(|| invalid(key, format!("[{x}, {y}]"), "two finite numbers"))
}

/// A count within a range.
pub(crate) fn within(key: &str, value: usize, range: RangeInclusive<usize>) -> Checked<usize> {
    let good = range.contains(&value);
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("{} to {}", range.start(), range.end())))
}

/// A name that can stand in reports and file names.
pub(crate) fn short_name(key: &str, name: &str) -> Checked<()> {
    let good = (1..=LONGEST_NAME).contains(&name.chars().count()) && !name.chars().any(char::is_control);
    good.then_some(()).ok_or_else(|| {
        invalid(
            key,
            format!("{name:?}"),
            format!("1 to {LONGEST_NAME} characters on one line"),
        )
    })
}

/// The index of a name in a list.
pub(crate) fn named<'a>(key: &str, name: &str, list: impl Iterator<Item = &'a str>) -> Checked<usize> {
    let all: Vec<&str> = list.collect();
    let unknown = || {
        let names = all.iter().map(|n| format!("{n:?}")).collect::<Vec<_>>().join(", ");
        let allowed = if names.is_empty() {
            "none is defined".to_owned()
        } else {
            names
        };
        invalid(key, format!("{name:?}"), allowed)
    };
    all.iter().position(|n| *n == name).ok_or_else(unknown)
}
