//! Checks of single values of a scene, in space or in the plane.

use std::fmt::Display;
use std::ops::RangeInclusive;

use nalgebra::Vector2;
use scene::Invalid;

/// What a check of a value gives.
pub type Checked<T> = Result<T, Invalid>;

/// Numbers beyond this are refused: their squares must stay finite.
const LARGEST: f64 = 1e100;
/// The longest name.
const LONGEST_NAME: usize = 64;

/// What is wrong with the value of a key: what was found, and what is allowed.
pub fn invalid(key: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Invalid {
    Invalid {
        key: key.into(),
        found: found.to_string(),
        allowed: allowed.into(),
    }
}

/// A number that is one.
///
/// # Errors
/// [`Invalid`] with this key.
pub fn finite(key: &str, value: f64) -> Checked<f64> {
    let good = value.abs() <= LARGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a finite number, at most {LARGEST:e} away from 0")))
}

/// A number above zero.
///
/// # Errors
/// [`Invalid`] with this key.
pub fn positive(key: &str, value: f64) -> Checked<f64> {
    let good = value > 0.0 && value <= LARGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a number above 0, at most {LARGEST:e}")))
}

/// A point or a vector.
///
/// # Errors
/// [`Invalid`] with this key.
pub fn pair(key: &str, [x, y]: [f64; 2]) -> Checked<Vector2<f64>> {
    let good = x.abs() <= LARGEST && y.abs() <= LARGEST;
    good.then(|| Vector2::new(x, y))
        .ok_or_else(|| invalid(key, format!("[{x}, {y}]"), "two finite numbers"))
}

/// A count within a range.
///
/// # Errors
/// [`Invalid`] with this key.
pub fn within(key: &str, value: usize, range: RangeInclusive<usize>) -> Checked<usize> {
    let good = range.contains(&value);
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("{} to {}", range.start(), range.end())))
}

/// A name that can stand in reports and file names.
///
/// # Errors
/// [`Invalid`] with this key.
pub fn short_name(key: &str, name: &str) -> Checked<()> {
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
///
/// # Errors
/// [`Invalid`] with this key.
pub fn named<'a>(key: &str, name: &str, list: impl Iterator<Item = &'a str>) -> Checked<usize> {
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

/// A title fits above a picture.
///
/// # Errors
/// [`Invalid`] with the key `title`.
pub fn title(text: &str) -> Checked<()> {
    let good = (1..=100).contains(&text.chars().count()) && !text.chars().any(char::is_control);
    good.then_some(())
        .ok_or_else(|| invalid("title", format!("{text:?}"), "1 to 100 characters on one line"))
}

/// Names of the entries of a table are short, and each stands once.
///
/// # Errors
/// [`Invalid`] with the key of the first that is not.
pub fn names<'a>(table: &str, all: impl Iterator<Item = &'a str>) -> Checked<()> {
    let mut seen = std::collections::BTreeSet::new();
    for (k, name) in all.enumerate() {
        let key = format!("{table}.{k}.name");
        short_name(&key, name)?;
        if !seen.insert(name) {
            return Err(invalid(key, format!("{name:?} a second time"), "a name of its own"));
        }
    }
    Ok(())
}
