//! The scene file: one TOML file that says what is modelled, and nothing else is. Reading and checks of single values are those of
//! scenes in space (crate `organs`).
//!
//! Read in two steps: the raw shape ([`raw`]: every key known, every type right), then the [`crate::model`] made of it.
//! Errors say file, line, column, key, what was found and what is allowed.

pub(crate) mod raw;

use organs::Parsed;
pub(crate) use organs::numbers::{Checked, finite, invalid, named, names, pair, positive, short_name, title, within};
use raw::RawScene;

/// A scene in the plane.
pub(crate) type Source = Parsed<RawScene>;

/// Whether a text is of a scene of solids in space: it has the table `[space]`.
pub(crate) fn is_of_space(text: &str) -> bool {
    text.parse::<toml::Table>()
        .is_ok_and(|table| table.contains_key("space"))
}
