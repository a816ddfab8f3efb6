//! Why an object was not derived.

use std::path::PathBuf;

use crate::dicom::DicomError;
use crate::dicom_out::ExportError;
use crate::write::error::WriteError;

/// Most characters of a name in DICOM (LO, PS3.5 section 6.2).
pub(super) const MOST_CHARACTERS: usize = 64;

/// Why a segmentation or a structure set was not written. Nothing is left of it then.
#[derive(Debug, thiserror::Error)]
pub enum DerivedError {
    /// The examination has no frame of reference that could be named.
    #[error(
        "{}: this examination is no DICOM series: it has no frame of reference in which the places would be; give the series that it was \
         made of, or write another format",
        path.display()
    )]
    NotDicom {
        /// The examination.
        path: PathBuf,
    },
    /// The examination is the generated patient.
    #[error("the generated patient is no DICOM series: it has no frame of reference in which the places would be")]
    Generated,
    /// The series could not be read.
    #[error(transparent)]
    Series(#[from] DicomError),
    /// The series does not say to what the object would belong.
    #[error("{}: {element}: found {found}, expected one identifier, the same in all slices: what is derived must say to what it belongs", path.display())]
    Identifier {
        /// A file of the series.
        path: PathBuf,
        /// By its name in PS3.6.
        element: &'static str,
        /// What it says; identifiers are not shown.
        found: &'static str,
    },
    /// A name that DICOM does not hold.
    #[error(
        "{name:?}: found {found}, expected 1 to {MOST_CHARACTERS} characters without a backslash or a control character (DICOM's LO); rename it"
    )]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        found: String,
    },
    /// A place that is no number, or too far off for the digits that DICOM has.
    #[error("{name:?}: found {found_mm:?} mm, expected a place that 16 characters of a decimal string hold to 1e-6 mm")]
    Place {
        /// The name of the point.
        name: String,
        /// LPS, mm.
        found_mm: [f64; 3],
    },
    /// Nothing to be written.
    #[error("there is no {what}: an object without one is none")]
    Nothing {
        /// What is missing.
        what: &'static str,
    },
    /// More than one object holds.
    #[error("{found} {what}: one object holds at most {most}")]
    TooMany {
        /// How many there are.
        found: u64,
        /// Of what.
        what: &'static str,
        /// How many there may be.
        most: u64,
    },
    /// A label that is no segment's number.
    #[error(
        "label {label}: the labels of structures are 1 to 32767; what is below 0 is no structure of a DICOM segmentation"
    )]
    Label {
        /// The label.
        label: i16,
    },
    /// The planes of the label map are none that DICOM describes.
    #[error(transparent)]
    Planes(#[from] ExportError),
    /// The object could not be put into DICOM's form.
    #[error("it cannot be encoded: {0}")]
    Encode(Box<dyn std::error::Error + Send + Sync>),
    /// The file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
}
