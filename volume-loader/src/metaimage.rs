//! MetaImage: header and voxels in one file (`.mha`), or the voxels beside (`.mhd`).
//!
//! The format's world is LPS in mm, as ITK reads and writes it. `TransformMatrix` holds, for each axis of the voxels, three
//! numbers: the direction of that axis. Format: MetaIO, <https://itk.org/Wiki/ITK/MetaIO/Documentation>, and its sources
//! where that page is silent.

mod error;
mod fields;
mod header;
mod place;
mod reader;
mod writer;

#[cfg(test)]
mod tests;

pub use error::MetaImageError;
pub use reader::open;
pub use writer::write;
