//! Objects of DICOM that are derived from a series: the structures of a label map as a segmentation (PS3.3, A.51), and points as a structure
//! set (PS3.3, A.19).
//!
//! Both say of themselves that they are of the series' patient and study, and that their places are in its frame of reference; so both are
//! refused where the series does not say these. What they name of the patient stands in the series and goes nowhere else.

mod bits;
mod context;
mod error;
mod items;
pub(crate) mod segmentation;
mod structure_set;
#[cfg(test)]
mod tests;

pub(crate) use context::Context;
pub use error::DerivedError;
pub use structure_set::structure_set_bytes;
