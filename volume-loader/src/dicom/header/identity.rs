//! Whom a file is of. Read only where a person asks, and for the bus; nothing of it is in an error.

use std::path::Path;

use bus::message::IdentitySource;

use super::walk;
use crate::dicom::element::Elements;
use crate::dicom::error::DicomError;
use crate::dicom::tag::{self as el, Tag};
use crate::dicom::text::charset::Charset;
use crate::source::Whose;

/// What the file at `path` says of the patient, the visit and the place, by name; elements that are absent or empty are left
/// out.
///
/// # Errors
/// [`DicomError::File`], [`DicomError::Unreadable`].
pub(crate) fn all(path: &Path) -> Result<Vec<(&'static str, String)>, DicomError> {
    let Some(said) = Said::read(path)? else {
        return Ok(Vec::new());
    };
    let shown = el::IDENTITY.iter().filter(|(tag, _)| *tag != el::CHARACTER_SET);
    let named = shown.map(|(tag, name)| (*name, said.text(*tag)));
    Ok(named.filter(|(_, text)| !text.is_empty()).collect())
}

/// The same for the bus. A date that is none is left out.
///
/// # Errors
/// [`DicomError::File`], [`DicomError::Unreadable`].
pub(crate) fn whose(path: &Path) -> Result<Whose, DicomError> {
    let Some(said) = Said::read(path)? else {
        return Ok(Whose::default());
    };
    let study = said.text(el::STUDY_DESCRIPTION);
    let description = match study.is_empty() {
        true => said.text(el::SERIES_DESCRIPTION),
        false => study,
    };
    let words = [
        said.text(el::PATIENT_NAME),
        said.text(el::PATIENT_ID),
        day(&said.text(el::BIRTH_DATE)),
        day(&said.text(el::STUDY_DATE)),
        description,
    ];
    Ok(Whose::said(IdentitySource::Examination, words))
}

/// A file's elements with their character set.
struct Said(Elements, Charset);

impl Said {
    /// `None` where the file is no DICOM file.
    fn read(path: &Path) -> Result<Option<Self>, DicomError> {
        let elements = walk(path, |walker| Elements::read_with(walker, &el::IDENTITY))?;
        Ok(elements.map(|elements| {
            let charset = Charset::of(elements.get(el::CHARACTER_SET));
            Self(elements, charset)
        }))
    }

    fn text(&self, tag: Tag) -> String {
        self.0.get(tag).map(|bytes| self.1.text(bytes)).unwrap_or_default()
    }
}

/// YYYY-MM-DD of YYYYMMDD, or of YYYY.MM.DD as ACR-NEMA had it; empty for whatever is no day of the calendar.
fn day(text: &str) -> String {
    let digits: String = match text.split('.').map(str::len).collect::<Vec<_>>()[..] {
        [4, 2, 2] => text.replace('.', ""),
        _ => text.to_owned(),
    };
    if digits.len() != 8 || !digits.is_ascii() {
        return String::new();
    }
    let day = format!("{}-{}-{}", &digits[..4], &digits[4..6], &digits[6..]);
    match scene::identity::is_day(&day) {
        true => day,
        false => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::day;

    #[test]
    fn dates_that_are_none_are_empty() {
        assert_eq!(day("19520229"), "1952-02-29");
        assert_eq!(day("1952.02.29"), "1952-02-29");
        for none in [
            "00000000",
            "19530229",
            "1952",
            "",
            "195202",
            "19520229-",
            "é9520229",
            "１９５２",
            "--------",
            "1952.2.290",
        ] {
            assert_eq!(day(none), "", "{none}");
        }
    }
}
