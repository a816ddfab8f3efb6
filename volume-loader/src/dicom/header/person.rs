//! Of whom an object is, so that two objects can be compared that different programs wrote. Nothing of it is ever shown.

use std::path::Path;

use super::{Header, walk};
use crate::dicom::element::Elements;
use crate::dicom::error::DicomError;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::charset::Charset;
use crate::dicom::text::digest;

/// What a person is told by, but for the position on the table, which another object need not say.
pub(crate) const SAID: [Tag; 5] = [el::PATIENT_ID, el::PATIENT_NAME, el::BIRTH_DATE, el::SEX, el::ID_ISSUER];

/// The same with the characters that it is written in, for who reads a file.
const READ: [(Tag, &str); 6] = [
    (el::CHARACTER_SET, ""),
    (el::PATIENT_ID, ""),
    (el::PATIENT_NAME, ""),
    (el::BIRTH_DATE, ""),
    (el::SEX, ""),
    (el::ID_ISSUER, ""),
];

/// Stands in a text for what is no character of its set.
const UNREAD: char = char::REPLACEMENT_CHARACTER;

/// What one object says of its patient: of each of [`SAID`] digests, by groups (alphabetic, ideographic, phonetic) and components,
/// of which names have several and other values one; `None` where it says nothing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Person([Vec<Vec<Option<u64>>>; SAID.len()]);

impl Person {
    /// Of an object's elements, among which [`SAID`] and SpecificCharacterSet were asked for.
    pub(crate) fn of(e: &Elements) -> Self {
        let charset = Charset::of(e.get(el::CHARACTER_SET));
        Self(SAID.map(|tag| {
            let text = e.get(tag).map(|bytes| charset.text(bytes)).unwrap_or_default();
            match tag {
                el::PATIENT_NAME => name(&text),
                // As ACR-NEMA had it.
                el::BIRTH_DATE => vec![vec![one(&text.replace('.', ""))]],
                _ => vec![vec![one(&text)]],
            }
        }))
    }

    /// Of a series whose slices are of one person: slices that are silent have what others say.
    ///
    /// # Errors
    /// [`DicomError::File`], [`DicomError::Unreadable`].
    pub(crate) fn of_series(headers: &[Header]) -> Result<Self, DicomError> {
        let says = |at: usize| {
            headers
                .iter()
                .find(|header| header.person.get(at).is_some_and(Option::is_some))
        };
        let mut paths: Vec<&Path> = headers
            .first()
            .into_iter()
            .map(|header| header.path.as_path())
            .collect();
        for header in (0..el::PERSON.len()).filter_map(says) {
            if !paths.contains(&header.path.as_path()) {
                paths.push(&header.path);
            }
        }
        let mut person = Self::default();
        for path in paths {
            let elements = walk(path, |walker| Elements::read_with(walker, &READ))?;
            for (known, found) in person
                .0
                .iter_mut()
                .zip(elements.map(|e| Self::of(&e)).unwrap_or_default().0)
            {
                if known.iter().flatten().all(Option::is_none) {
                    *known = found;
                }
            }
        }
        Ok(person)
    }

    /// The first element of which both say something, and not the same: they are of two persons. What one of them leaves out, also of
    /// a name, contradicts nothing.
    pub(crate) fn contradiction(&self, other: &Self) -> Option<Tag> {
        let mut all = SAID.into_iter().zip(self.0.iter().zip(&other.0));
        all.find(|(_, (one, other))| differ(one, other)).map(|(tag, _)| tag)
    }
}

fn differ(one: &[Vec<Option<u64>>], other: &[Vec<Option<u64>>]) -> bool {
    let mut pairs = one.iter().zip(other).flat_map(|(one, other)| one.iter().zip(other));
    pairs.any(|pair| matches!(pair, (Some(one), Some(other)) if one != other))
}

/// The components of a name, in each of its groups (PS3.5, 6.2.1), without regard to capitals: names may be compared so (PS3.4,
/// C.2.2.2.1), and systems write them so.
fn name(text: &str) -> Vec<Vec<Option<u64>>> {
    let group = |group: &str| {
        group
            .split('^')
            .map(|component| one(&component.to_uppercase()))
            .collect()
    };
    text.split('=').map(group).collect()
}

/// `None` where there is nothing but padding, or a character that could not be read: what it was is not known.
fn one(text: &str) -> Option<u64> {
    match text.contains(UNREAD) {
        true => None,
        false => digest(text.as_bytes()),
    }
}
