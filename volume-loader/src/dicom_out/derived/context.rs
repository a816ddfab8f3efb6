//! What a series says that every object derived from it must say too: patient, study, frame of reference, and its instances.

use std::collections::BTreeSet;
use std::path::Path;

use dicom_core::{Tag as DicomTag, VR};
use dicom_dictionary_std::tags;
use scene::{VolumeSource, VolumeSpec};

use super::error::DerivedError;
use super::items::{Object, item, put, put_items};
use crate::dicom::element::Elements;
use crate::dicom::header::walk;
use crate::dicom::tag::{self as el, Tag, tag};
use crate::dicom::text::charset::Charset;
use crate::dicom::{DicomError, Series, alike, holds_series};

/// What is copied: where it stands, its VR, and where it goes. Of Type 2 all of them, empty where the series says nothing.
const COPIED: [(Tag, VR, DicomTag); 10] = [
    (el::STUDY_DATE, VR::DA, tags::STUDY_DATE),
    (tag(0x0008, 0x0030), VR::TM, tags::STUDY_TIME),
    (tag(0x0008, 0x0050), VR::SH, tags::ACCESSION_NUMBER),
    (tag(0x0008, 0x0090), VR::PN, tags::REFERRING_PHYSICIAN_NAME),
    (el::PATIENT_NAME, VR::PN, tags::PATIENT_NAME),
    (el::PATIENT_ID, VR::LO, tags::PATIENT_ID),
    (el::BIRTH_DATE, VR::DA, tags::PATIENT_BIRTH_DATE),
    (el::SEX, VR::CS, tags::PATIENT_SEX),
    (tag(0x0020, 0x0010), VR::SH, tags::STUDY_ID),
    (tag(0x0020, 0x1040), VR::LO, tags::POSITION_REFERENCE_INDICATOR),
];

/// What is read beside what is always read: all that is copied, the characters that it is written in, and the file's own identifier.
const READ: [(Tag, &str); 12] = {
    let mut all = [(el::CHARACTER_SET, "SpecificCharacterSet"); 12];
    all[1] = (el::SOP_INSTANCE, "SOPInstanceUID");
    let mut at = 0;
    while at < COPIED.len() {
        all[at + 2] = (COPIED[at].0, "");
        at += 1;
    }
    all
};

/// Most characters of an identifier (PS3.5 section 9.1).
const MOST_OF_IDENTIFIER: usize = 64;

/// An object of the series: class and identifier.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Instance {
    class: String,
    uid: String,
}

/// What is derived belongs to this; nothing of it is ever shown.
#[derive(Debug)]
pub(crate) struct Context {
    copied: Vec<String>,
    study: String,
    pub(super) series: String,
    pub(super) frame_of_reference: String,
    instances: Vec<Instance>,
}

impl Context {
    /// That of an examination.
    ///
    /// # Errors
    /// [`DerivedError::NotDicom`], [`DerivedError::Generated`], [`DerivedError::Series`], [`DerivedError::Identifier`].
    pub(crate) fn of(examination: &VolumeSpec) -> Result<Self, DerivedError> {
        let VolumeSource::File(file) = &examination.source else {
            return Err(DerivedError::Generated);
        };
        if !holds_series(&file.path) {
            let path = file.path.clone();
            return Err(DerivedError::NotDicom { path });
        }
        let series = Series::scan(&file.path)?.choose(file.series.map(|number| number as usize))?;
        // Slices of several patients, or of several frames of reference, are no examination.
        alike::check(&series)?;
        // A frame of reference for each slice is a writer's mistake that the loader mends: there is none that could be named.
        Self::of_series(&series)
    }

    fn of_series(series: &Series) -> Result<Self, DerivedError> {
        let paths: BTreeSet<&Path> = series.headers.iter().map(|header| header.path.as_path()).collect();
        let mut found: Option<Self> = None;
        for path in paths {
            let mut one = Self::of_file(path)?;
            let Some(first) = &mut found else {
                found = Some(one);
                continue;
            };
            let alike = [
                ("StudyInstanceUID", first.study == one.study),
                ("SeriesInstanceUID", first.series == one.series),
                (
                    "FrameOfReferenceUID",
                    first.frame_of_reference == one.frame_of_reference,
                ),
            ];
            if let Some((element, _)) = alike.into_iter().find(|(_, is_alike)| !is_alike) {
                return Err(identifier(path, element, "another than in the slices before"));
            }
            first.instances.append(&mut one.instances);
        }
        found.ok_or(DerivedError::Nothing { what: "slice" })
    }

    fn of_file(path: &Path) -> Result<Self, DerivedError> {
        let elements = walk(path, |walker| Elements::read_with(walker, &READ))?;
        // It was one when the series was looked through.
        let elements = elements.ok_or_else(|| DerivedError::Series(DicomError::NoSlices { path: path.to_owned() }))?;
        let charset = Charset::of(elements.get(el::CHARACTER_SET));
        let text = |tag: Tag| elements.get(tag).map(|bytes| charset.text(bytes)).unwrap_or_default();
        let uid = |tag: Tag, name: &'static str| checked(path, name, text(tag));
        Ok(Self {
            copied: COPIED.iter().map(|(tag, ..)| text(*tag)).collect(),
            study: uid(el::STUDY, "StudyInstanceUID")?,
            series: uid(el::SERIES, "SeriesInstanceUID")?,
            frame_of_reference: uid(el::FRAME_OF_REFERENCE, "FrameOfReferenceUID")?,
            instances: vec![Instance {
                class: checked(path, "SOPClassUID", elements.class().unwrap_or_default())?,
                uid: uid(el::SOP_INSTANCE, "SOPInstanceUID")?,
            }],
        })
    }

    /// The modules that are the same in all objects of the study: patient, study, frame of reference.
    pub(super) fn put(&self, object: &mut Object) {
        put(object, tags::SPECIFIC_CHARACTER_SET, VR::CS, "ISO_IR 192");
        for ((_, vr, to), text) in COPIED.iter().zip(&self.copied) {
            put(object, *to, *vr, text);
        }
        put(object, tags::STUDY_INSTANCE_UID, VR::UI, &self.study);
        put(object, tags::FRAME_OF_REFERENCE_UID, VR::UI, &self.frame_of_reference);
    }

    /// The objects of the series, as items that name each.
    pub(super) fn references(&self) -> Vec<Object> {
        let reference = |instance: &Instance| {
            item(|object| {
                put(object, tags::REFERENCED_SOP_CLASS_UID, VR::UI, &instance.class);
                put(object, tags::REFERENCED_SOP_INSTANCE_UID, VR::UI, &instance.uid);
            })
        };
        self.instances.iter().map(reference).collect()
    }

    /// The study and in it the series with its objects, in the words of structure sets.
    pub(super) fn referenced_study(&self) -> Object {
        item(|study| {
            // The class of a study is retired, and the element is of Type 1 all the same.
            put(study, tags::REFERENCED_SOP_CLASS_UID, VR::UI, "1.2.840.10008.3.1.2.3.1");
            put(study, tags::REFERENCED_SOP_INSTANCE_UID, VR::UI, &self.study);
            let series = item(|series| {
                put(series, tags::SERIES_INSTANCE_UID, VR::UI, &self.series);
                put_items(series, tags::CONTOUR_IMAGE_SEQUENCE, self.references());
            });
            put_items(study, tags::RT_REFERENCED_SERIES_SEQUENCE, vec![series]);
        })
    }
}

fn identifier(path: &Path, element: &'static str, found: &'static str) -> DerivedError {
    DerivedError::Identifier {
        path: path.to_owned(),
        element,
        found,
    }
}

/// An identifier that is one.
fn checked(path: &Path, element: &'static str, text: String) -> Result<String, DerivedError> {
    let is_one = |text: &str| text.len() <= MOST_OF_IDENTIFIER && text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    match text.as_str() {
        "" => Err(identifier(path, element, "nothing")),
        other if !is_one(other) => Err(identifier(path, element, "a value that is no identifier")),
        _ => Ok(text),
    }
}
