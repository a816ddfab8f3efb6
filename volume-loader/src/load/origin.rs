//! Of which examination an object is that was made of one: a segmentation, a structure set. What contradicts is refused, what is
//! doubtful is told.

pub(crate) mod error;

use scene::{VolumeSource, VolumeSpec};

use crate::dicom::element::Elements;
use crate::dicom::header::person::Person;
use crate::dicom::tag as el;
use crate::dicom::{self, Reference};
use crate::source::ReadError;
use error::OriginError;

/// How an object belongs to the examination it was opened with.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Belongs {
    /// Whether both say one frame of reference.
    pub is_in_its_frame: bool,
    /// What is doubtful about whose it is, and whether anybody approved of it, a sentence each.
    pub doubts: Vec<String>,
}

/// Whether somebody said that an object is right (PS3.3, C.8.8.16).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Approval {
    NotSaid,
    Approved,
    Unapproved,
    Rejected,
    /// A word that the standard has not.
    Other,
}

/// What an object says of whom and of what it was made; never shown.
#[derive(Debug)]
pub(crate) struct Origin {
    person: Person,
    study: Option<String>,
    approval: Approval,
    /// The series that it was made of, where it says them.
    series: Vec<String>,
}

impl Origin {
    /// Of an object's elements and the series that its sequences name.
    pub(crate) fn of(e: &Elements, series: Vec<String>) -> Self {
        Self {
            person: Person::of(e),
            study: e.text(el::STUDY),
            approval: approval(e.text(el::APPROVAL)),
            series,
        }
    }

    /// What is doubtful about it as an object of this examination, a sentence each.
    ///
    /// # Errors
    /// [`OriginError`].
    pub(crate) fn check(&self, reference: &Reference) -> Result<Vec<String>, OriginError> {
        if self.approval == Approval::Rejected {
            return Err(OriginError::Rejected);
        }
        if let Some(tag) = self.person.contradiction(&reference.person) {
            return Err(OriginError::OtherPatient { tag });
        }
        let is_of_other =
            |own: &Option<String>, of: &Option<String>| matches!((own, of), (Some(own), Some(of)) if own != of);
        let mut told = Vec::new();
        match self.approval {
            Approval::Unapproved => told.push(format!(
                "{} is UNAPPROVED: nobody has said that it is right",
                el::APPROVAL
            )),
            Approval::Other => told.push(format!(
                "{} is not APPROVED, UNAPPROVED or REJECTED: whether anybody has said that it is right is not known",
                el::APPROVAL
            )),
            Approval::NotSaid | Approval::Approved | Approval::Rejected => {}
        }
        if is_of_other(&self.study, &reference.study) {
            told.push("it is of another study than the examination (StudyInstanceUID)".to_owned());
        }
        if let Some(series) = reference.series.as_ref().filter(|_| !self.series.is_empty())
            && !self.series.contains(series)
        {
            told.push(
                "it was made of another series than the examination: a patient who breathed or moved between the two lies elsewhere in it"
                    .to_owned(),
            );
        }
        Ok(told)
    }
}

fn approval(said: Option<String>) -> Approval {
    let said = said.map(|said| said.to_ascii_uppercase());
    match said.as_deref() {
        None => Approval::NotSaid,
        Some("APPROVED") => Approval::Approved,
        Some("UNAPPROVED") => Approval::Unapproved,
        Some(said) if said.split('\\').any(|word| word.trim() == "REJECTED") => Approval::Rejected,
        Some(_) => Approval::Other,
    }
}

/// What an examination says of itself, never shown; nothing where it is no DICOM.
///
/// # Errors
/// [`ReadError`] of the examination.
pub(crate) fn reference_of(examination: Option<&VolumeSpec>) -> Result<Reference, ReadError> {
    let Some(VolumeSource::File(file)) = examination.map(|examination| &examination.source) else {
        return Ok(Reference::default());
    };
    let series = file.series.map(|number| number as usize);
    Ok(dicom::reference(&file.path, series)?)
}
