//! One series is of one patient, who lies one way, of one study and of one frame of reference; what else slices say differently is told.

pub(super) mod order;
pub(super) mod sides;
pub(super) mod told;

use std::collections::BTreeMap;

use super::error::DicomError;
use super::header::Header;
use super::series::Series;
use super::tag as el;
use super::tag::Tag;

/// What must be the same in every slice, as text that is never shown; `None` where a file does not say.
type Of<'a> = &'a dyn Fn(&Header) -> Option<String>;

/// Refuses a series with a slice of another patient, study or frame of reference than most. Frames of reference that were
/// replaced slice by slice tell nothing ([`Series::frames_merged`]), and a slice that does not say a name, a date of birth, a sex, an
/// issuer or a position is of any.
///
/// # Errors
/// [`DicomError::Mixed`], by the odd slice's file.
pub(crate) fn check(series: &Series) -> Result<(), DicomError> {
    let headers: Vec<&Header> = series.headers.iter().collect();
    one(&headers, el::PATIENT_ID, &|header| header.patient.map(hexadecimal))?;
    for (at, tag) in el::PERSON.into_iter().enumerate() {
        let of = |header: &Header| header.person.get(at).copied().flatten().map(hexadecimal);
        let said: Vec<&Header> = headers.iter().copied().filter(|header| of(header).is_some()).collect();
        one(&said, tag, &of)?;
    }
    one(&headers, el::STUDY, &|header| given(&header.study))?;
    match series.frames_merged {
        true => Ok(()),
        false => one(&headers, el::FRAME_OF_REFERENCE, &|header| {
            given(&header.frame_of_reference)
        }),
    }
}

fn hexadecimal(digest: u64) -> String {
    format!("{digest:x}")
}

fn given(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

fn one(headers: &[&Header], tag: Tag, of: Of<'_>) -> Result<(), DicomError> {
    let mut slices: BTreeMap<Option<String>, Vec<&Header>> = BTreeMap::new();
    for header in headers.iter().copied() {
        slices.entry(of(header)).or_default().push(header);
    }
    if slices.len() < 2 {
        return Ok(());
    }
    // By its file's name where several are as many, so that the words are always the same.
    let first = |headers: &[&Header]| {
        headers
            .iter()
            .map(|header| header.path.clone())
            .min()
            .unwrap_or_default()
    };
    let usual = slices
        .iter()
        .max_by_key(|(_, headers)| (headers.len(), std::cmp::Reverse(first(headers))));
    let Some((usual, expected)) = usual else { return Ok(()) };
    let mut others = slices.iter().filter(|(value, _)| *value != usual);
    let Some((value, found)) = others.by_ref().min_by_key(|(_, headers)| first(headers)) else {
        return Ok(());
    };
    Err(DicomError::Mixed {
        path: first(found),
        tag,
        found: match value {
            Some(_) => "another",
            None => "none",
        },
        slices: found.len(),
        expected: match usual {
            Some(_) => "the one",
            None => "none, as",
        },
        usual: expected.len(),
        other: first(expected),
    })
}
