//! From the bytes of a file to its transforms.

use std::str;

use roxmltree::{Document, Node, ParsingOptions};

use super::{Definition, DeviceSet, MAX_BYTES, MAX_TRANSFORMS, PlusError};
use crate::units::{About, about, unit_of};
use crate::{LengthUnit, quoted, unmarked};

/// Most nodes of a document: what is held of one is bounded with the file's length, and this much sooner.
const MAX_NODES: u32 = 1_000_000;
/// No number of a calibration is larger: mm, and entries of a matrix.
const MOST: f64 = 1e9;

/// Reads a file. Every transform of it must be whole; that one is rigid is asked for in [`DeviceSet::find`] alone, as those of images are not.
///
/// # Errors
/// The first six variants of [`PlusError`].
pub fn read(bytes: &[u8]) -> Result<DeviceSet, PlusError> {
    let text = text(bytes)?;
    let document = document(text)?;
    let root = document.root_element();
    let places: Vec<Node<'_, '_>> = root
        .children()
        .filter(|node| node.has_tag_name("CoordinateDefinitions"))
        .collect();
    let [place] = &places[..] else {
        return Err(other(&root, places.len()));
    };
    if !root.has_tag_name("PlusConfiguration") {
        return Err(other(&root, 1));
    }
    unclaimed(&document, &root)?;
    unclaimed(&document, place)?;
    let transforms: Vec<Node<'_, '_>> = place.children().filter(|node| node.has_tag_name("Transform")).collect();
    let found = transforms.len();
    if found > MAX_TRANSFORMS {
        return Err(PlusError::TooMany { found });
    }
    let definitions = transforms.iter().map(|node| definition(&document, node));
    Ok(DeviceSet {
        definitions: definitions.collect::<Result<_, _>>()?,
    })
}

/// The text of a file that is not too long.
pub(super) fn text(bytes: &[u8]) -> Result<&str, PlusError> {
    if bytes.len() > MAX_BYTES {
        return Err(PlusError::TooLong { bytes: bytes.len() });
    }
    str::from_utf8(unmarked(bytes)).map_err(|error| PlusError::Xml {
        why: format!("byte {} is not UTF-8 text", error.valid_up_to()),
    })
}

/// Its elements.
pub(super) fn document(text: &str) -> Result<Document<'_>, PlusError> {
    // Without entities of its own, which could make much of little.
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| PlusError::Xml {
        why: error.to_string().chars().take(160).collect(),
    })
}

fn other(root: &Node<'_, '_>, found: usize) -> PlusError {
    let root = quoted(root.tag_name().name());
    PlusError::Other { root, found }
}

/// Refuses an attribute about units or axes, which PLUS does not have and nothing here reads: PLUS's numbers are mm, between the frames that
/// a transform names.
fn unclaimed(document: &Document<'_>, node: &Node<'_, '_>) -> Result<(), PlusError> {
    let other = node.attributes().find_map(|attribute| match about(attribute.name()) {
        Some(About::Unit) if unit_of(attribute.value().trim()) == Some(LengthUnit::Millimetre) => None,
        Some(About::Unit) => Some((attribute, "mm, which PLUS is in")),
        Some(About::Axes) => Some((
            attribute,
            "no such attribute: the frames of a transform are From and To",
        )),
        None => None,
    });
    match other {
        None => Ok(()),
        Some((attribute, expected)) => Err(PlusError::Claim {
            line: document.text_pos_at(node.range().start).row,
            key: quoted(attribute.name()),
            found: quoted(attribute.value()),
            expected,
        }),
    }
}

fn definition(document: &Document<'_>, node: &Node<'_, '_>) -> Result<Definition, PlusError> {
    unclaimed(document, node)?;
    let line = document.text_pos_at(node.range().start).row;
    let refused = |key, found: &str, expected| PlusError::Attribute {
        line,
        key,
        found: quoted(found),
        expected,
    };
    let name = |key| {
        let name = node.attribute(key).unwrap_or_default();
        match name.is_empty() || name.len() > 64 || name.contains(char::is_control) {
            true => Err(refused(key, &format!("{name:?}"), "the name of a frame")),
            false => Ok(name.to_owned()),
        }
    };
    let words = node.attribute("Matrix").unwrap_or_default();
    let numbers: Option<Vec<f64>> = words
        .split_ascii_whitespace()
        .take(17)
        .map(|word| word.parse().ok())
        .collect();
    let numbers = numbers.unwrap_or_default();
    let is_finite = numbers.iter().all(|x| x.abs() <= MOST);
    let rows: Option<[f64; 16]> = numbers.try_into().ok().filter(|_| is_finite);
    let expected = "16 finite numbers by rows, the last of them 0 0 0 1";
    let rows = rows.filter(|rows| rows[12..] == [0.0, 0.0, 0.0, 1.0]);
    let rows = rows.ok_or_else(|| refused("Matrix", &format!("{words:?}"), expected))?;
    let error = match node.attribute("Error") {
        None => None,
        Some(word) => {
            let number = word.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            Some(number.ok_or_else(|| refused("Error", &format!("{word:?}"), "a finite number"))?)
        }
    };
    Ok(Definition {
        from: name("From")?,
        to: name("To")?,
        rows: [0, 4, 8, 12].map(|i| [rows[i], rows[i + 1], rows[i + 2], rows[i + 3]]),
        error,
        date: node.attribute("Date").map(quoted),
    })
}
