//! Any examination to a DICOM series: CT Image Storage, one file per slice.
//!
//! What is written is the CT Image IOD of PS3.3 A.3.3 with every attribute of Type 1, every attribute of Type 2 (empty
//! where the volume does not tell it, which is all that could name a patient), and HU as they are: 16 bits signed, slope 1,
//! intercept 0. The place of each slice is in ImagePositionPatient alone, so that a tilted gantry's shear stays exact; no
//! slice is resampled. The same volume gives the same files, byte for byte, identifiers included.

pub(crate) mod derived;
pub(crate) mod ds;
mod error;
mod folder;
mod header;
mod numbering;
pub(crate) mod placement;
mod rle;
pub(crate) mod uid;
mod writer;

#[cfg(test)]
mod tests;

pub use error::ExportError;
pub use writer::write;

/// How a series is written; the default is what every reader understands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// How the bytes lie in the files.
    pub syntax: Syntax,
    /// File names and instance numbers in a random order of this seed, as transfers leave them; slices lie where they lay.
    pub shuffle_names: Option<u64>,
}

/// The transfer syntax, PS3.5 section 10 and Annex A.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Syntax {
    /// Explicit VR Little Endian, 1.2.840.10008.1.2.1.
    #[default]
    ExplicitLittle,
    /// Implicit VR Little Endian, 1.2.840.10008.1.2.
    ImplicitLittle,
    /// Explicit VR Big Endian, 1.2.840.10008.1.2.2: retired, but archives hold it.
    ExplicitBig,
    /// RLE Lossless, 1.2.840.10008.1.2.5.
    Rle,
}
