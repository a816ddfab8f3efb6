//! DICOM series in a folder: one file per slice, in any order and among other files; or Enhanced CT, whose files hold many
//! slices as frames, each with a place of its own.
//!
//! Geometry is derived from each slice's own position and orientation (DICOM PS3.3, C.7.6.2), never from file names,
//! instance numbers, SliceThickness or SpacingBetweenSlices. A tilted gantry stays what it is: a sheared map from voxels
//! to the patient. Uneven slices are refused, or put on an even grid where that was asked for ([`Options::regrid`]).
//!
//! [`Series::scan`] looks through a folder, [`Found::choose`] takes one series of it, [`DicomSource::open`] judges that
//! series and gives its voxels. Element headers are read by dicom-rs; lengths are judged here, before anything is
//! allocated. DICOM's patient axes are LPS and mm already.

pub(crate) mod alike;
mod codec;
pub(crate) mod element;
pub(crate) mod error;
mod facts;
mod fragments;
pub(crate) mod geometry;
mod group;
pub(crate) mod header;
mod padding;
mod pixels;
mod plan;
mod report;
mod scan;
mod series;
mod slice;
mod source;
mod stored;
pub(crate) mod syntax;
pub(crate) mod tag;
pub(crate) mod text;
mod values;
pub(crate) mod walk;
mod words;

#[cfg(test)]
pub(crate) mod tests;

pub use error::{DicomError, FileError};
pub use facts::{SeriesFacts, Steps};
pub use geometry::{Gap, GeometryError};
pub use series::{Found, Series, SeriesSummary};
pub use source::{DicomSource, Options};
pub(crate) use source::{Reference, has_preamble, holds_series, open_path, reference};
pub use tag::Tag;
