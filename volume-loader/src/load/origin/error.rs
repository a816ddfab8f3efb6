//! Why an object is none of the examination that it was opened with.

use crate::dicom::tag::{self as el, Tag};

/// Why an object is not taken for one of the examination. Values are never told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum OriginError {
    /// It is of another person.
    #[error(
        "{tag}: found another than the examination's, expected the same: one of them is of another patient (values are not shown, as they \
         name a patient)"
    )]
    OtherPatient {
        /// In what they differ.
        tag: Tag,
    },
    /// Somebody looked at it and did not approve of it.
    #[error(
        "{}: found REJECTED, expected APPROVED or UNAPPROVED: it was looked at and is not to be used",
        el::APPROVAL
    )]
    Rejected,
}
