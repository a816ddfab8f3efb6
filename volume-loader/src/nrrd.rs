//! NRRD, "nearly raw raster data": attached (`.nrrd`) or with the voxels beside (`.nhdr`).
//!
//! Read are versions 1 to 5 with one scalar volume, whose place in the patient the header tells ("space", "space
//! directions", "space origin"). Spaces are LPS, RAS or LAS; the change to LPS is made in the private module `place`
//! and nowhere else. Format: "Definition of NRRD File Format", <https://teem.sourceforge.net/nrrd/format.html>.

mod error;
mod fields;
mod header;
mod lists;
mod place;
mod reader;
mod types;
mod units;
mod writer;

#[cfg(test)]
mod tests;

pub use error::NrrdError;
pub use reader::open;
pub use writer::{Segment, write, write_labels};
