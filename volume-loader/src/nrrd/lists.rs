//! Lists of a header: one entry for each axis, or for each coordinate of space. A list that is shorter or longer is of another volume.

use super::error::NrrdError;
use super::fields::{Field, Fields};

/// Lists of words, one for each axis of the array.
const WORDS: [&str; 7] = [
    "sizes",
    "spacings",
    "thicknesses",
    "axis mins",
    "axis maxs",
    "centers",
    "kinds",
];
/// Lists of texts between quotation marks.
const QUOTED: [&str; 2] = ["labels", "units"];
/// Vectors of a header whose space has three coordinates: how many there are.
const VECTORS: [(&str, Option<usize>); 3] = [
    ("space directions", None),
    ("space origin", Some(1)),
    ("measurement frame", Some(3)),
];

/// Holds each list against the number of axes.
///
/// # Errors
/// [`NrrdError::Count`].
pub(crate) fn check(fields: &Fields, dimension: usize) -> Result<(), NrrdError> {
    for field in WORDS.iter().filter_map(|name| fields.get(name)) {
        count(field, field.text.split_whitespace().count(), dimension)?;
    }
    for field in QUOTED.iter().filter_map(|name| fields.get(name)) {
        // What has neither quotation marks nor brackets is refused, or read over, for what it is.
        if field.text.contains('"') {
            count(field, quoted(&field.text), dimension)?;
        }
    }
    for (name, expected) in VECTORS {
        if let Some(field) = fields.get(name).filter(|field| field.text.contains('(')) {
            count(field, vectors(&field.text), expected.unwrap_or(dimension))?;
        }
    }
    match fields.get("space units") {
        Some(field) if field.text.contains('"') => count(field, quoted(&field.text), 3),
        _ => Ok(()),
    }
}

fn count(field: &Field, found: usize, expected: usize) -> Result<(), NrrdError> {
    match found == expected {
        true => Ok(()),
        false => Err(NrrdError::Count {
            line: field.line,
            field: field.name,
            found,
            expected,
        }),
    }
}

/// Texts between quotation marks, in which `\\"` is a mark of the text.
fn quoted(text: &str) -> usize {
    let (mut marks, mut is_escaped) = (0_usize, false);
    for c in text.chars() {
        marks += usize::from(c == '"' && !is_escaped);
        is_escaped = c == '\\' && !is_escaped;
    }
    marks.div_ceil(2)
}

/// Vectors, each of which begins with a bracket, and words `none`.
fn vectors(text: &str) -> usize {
    let nones = text.split_whitespace().filter(|word| *word == "none").count();
    text.matches('(').count() + nones
}
