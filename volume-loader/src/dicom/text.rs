//! Text of an element (DICOM PS3.5 section 6.2).

use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

pub(crate) mod charset;

/// In the place of what may not be shown.
const HIDDEN: &str = "unknown";

/// A value that tells slices apart. Two of them are equal where their bytes are, but for the padding of each value between
/// backslashes; what may be shown of it may be the same for several that differ.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Label {
    // First, so that lists are in the order of what is shown.
    shown: String,
    digest: [u8; 32],
}

impl Label {
    /// Of an element's bytes; `None` where there is nothing but padding.
    pub(crate) fn of(bytes: &[u8]) -> Option<Self> {
        solid(bytes)?;
        let values = bytes.split(|&b| b == b'\\');
        let shown: Vec<String> = values.clone().map(code).collect();
        // The same in every build, as the order of series that are told apart by it is: who wrote down a number finds the same one.
        let mut hasher = blake3::Hasher::new();
        for value in values {
            let value = solid(value).unwrap_or_default();
            hasher.update(&(value.len() as u64).to_le_bytes()).update(value);
        }
        Some(Self {
            shown: shown.join("/"),
            digest: *hasher.finalize().as_bytes(),
        })
    }

    /// Whether a value of it may not be shown.
    pub(crate) fn is_hidden(&self) -> bool {
        self.shown.split('/').any(|value| value == HIDDEN)
    }

    /// What may be shown, with slashes between several values.
    pub(crate) fn shown(&self) -> &str {
        &self.shown
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.shown)
    }
}

/// Of the bytes themselves, whatever their character set; `None` where there is nothing but padding.
pub(crate) fn digest(bytes: &[u8]) -> Option<u64> {
    let mut hasher = DefaultHasher::new();
    solid(bytes)?.hash(&mut hasher);
    Some(hasher.finish())
}

/// The same of a name (PN): components between `^` and groups between `=`, each without the blanks around, and without those at the end
/// that are empty, as writers leave them out or not (DICOM PS3.5, 6.2.1).
pub(crate) fn name_digest(bytes: &[u8]) -> Option<u64> {
    let mut name = Vec::new();
    for group in bytes.split(|b| *b == b'=') {
        for component in group.split(|b| *b == b'^') {
            name.extend(solid(component).unwrap_or_default());
            name.push(b'^');
        }
        ended(&mut name, b'^');
        name.push(b'=');
    }
    ended(&mut name, b'=');
    digest(&name)
}

/// Without what it ends in.
fn ended(name: &mut Vec<u8>, byte: u8) {
    let end = name.iter().rposition(|b| *b != byte).map_or(0, |last| last + 1);
    name.truncate(end);
}

/// Without the padding around; `None` where there is nothing else.
fn solid(bytes: &[u8]) -> Option<&[u8]> {
    let solid = |byte: &u8| *byte != 0 && !byte.is_ascii_whitespace();
    let (first, last) = (bytes.iter().position(solid)?, bytes.iter().rposition(solid)?);
    bytes.get(first..=last)
}

/// The text without the padding around it; what is not ASCII becomes question marks.
pub(crate) fn text(bytes: &[u8]) -> String {
    let ascii: String = bytes
        .iter()
        .map(|&b| if b.is_ascii() { char::from(b) } else { '?' })
        .collect();
    ascii.trim_matches(['\0', ' ', '\t', '\r', '\n']).to_owned()
}

/// A code (CS, or a short SH) that may be shown: anything but capitals, digits and the like is not told.
pub(crate) fn code(bytes: &[u8]) -> String {
    let text = text(bytes);
    let plain = |b: u8| b.is_ascii_alphanumeric() || b" _-.+/".contains(&b);
    if !text.is_empty() && text.len() <= 16 && text.bytes().all(plain) {
        return text;
    }
    HIDDEN.to_owned()
}
