//! Why a NIfTI header was refused.

use geometry::GridError;

use crate::source::KNOWN;

/// Why a NIfTI header was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeaderError {
    /// The first four bytes are not a NIfTI header's length.
    #[error("not a NIfTI file: its first four bytes are {found:02x?}, expected a header length of 348 or 540; {KNOWN}")]
    NotNifti {
        /// The bytes.
        found: [u8; 4],
    },
    /// The magic is another; an Analyze 7.5 file has none.
    #[error(
        "not a NIfTI file: its magic is {found:02x?}, expected {expected:02x?}; Analyze files tell no left from right"
    )]
    Magic {
        /// The bytes found.
        found: Vec<u8>,
        /// The bytes of a NIfTI file.
        expected: Vec<u8>,
    },
    /// A header of a pair of files.
    #[error("this is the header of a two-file pair (.hdr and .img, magic \"ni1\"); convert the pair to one .nii file")]
    TwoFiles,
    /// Not one three-dimensional volume.
    #[error("dim is {found:?}: expected one volume, 3 dimensions or further ones of length 1")]
    Dimensions {
        /// The header's `dim`.
        found: [i64; 8],
    },
    /// A datatype that holds no HU.
    #[error("datatype {found} (byte 70 in NIfTI-1): expected an integer of 8 to 64 bits or a real of 32 or 64 bits")]
    Datatype {
        /// The header's `datatype`.
        found: i64,
    },
    /// The bits per voxel are not the datatype's.
    #[error("bitpix is {found}, expected {expected} for datatype {datatype}")]
    Bitpix {
        /// The header's `bitpix`.
        found: i64,
        /// The datatype's.
        expected: i64,
        /// The header's `datatype`.
        datatype: i64,
    },
    /// The voxels' place in the file makes no sense.
    #[error("vox_offset is {found}, expected a whole number from {least} to {most}")]
    Offset {
        /// The header's `vox_offset`.
        found: f64,
        /// The end of the header.
        least: f64,
        /// The largest accepted.
        most: f64,
    },
    /// The scale to HU is not finite, or makes one number of all voxels, or none that is HU.
    #[error("scl_slope is {slope} and scl_inter {inter}, expected {which} {expected}")]
    Scale {
        /// Which of the two.
        which: &'static str,
        /// What it must be.
        expected: &'static str,
        /// The header's `scl_slope`.
        slope: f64,
        /// The header's `scl_inter`.
        inter: f64,
    },
    /// Lengths are in an unknown unit.
    #[error("xyzt_units is {found}: its unit of length is {length}, expected 0 (unknown), 1 (m), 2 (mm) or 3 (um)")]
    Units {
        /// The header's `xyzt_units`.
        found: i64,
        /// Its lowest three bits.
        length: i64,
    },
    /// A code of an orientation that the format does not have.
    #[error("sform_code is {sform} and qform_code {qform}, expected 0 to 5 each; the header is damaged")]
    Code {
        /// The header's `sform_code`.
        sform: i64,
        /// The header's `qform_code`.
        qform: i64,
    },
    /// Neither an sform nor a qform.
    #[error(
        "the file has no orientation (sform_code {sform}, qform_code {qform}, expected one above 0): refused rather than guess which side is left"
    )]
    NoOrientation {
        /// The header's `sform_code`.
        sform: i64,
        /// The header's `qform_code`.
        qform: i64,
    },
    /// The two orientations point an axis to opposite sides of the patient.
    #[error(
        "the sform and the qform point axis {} of the voxels to opposite sides of the patient, and programs differ in which of them they go by: find \
         out which is right, and set the code of the other to 0",
        ["i", "j", "k"][*axis]
    )]
    Sides {
        /// The axis, from 0.
        axis: usize,
    },
    /// One of two orientations is the other in a mirror.
    #[error(
        "the sform and the qform are mirror images of one another, and programs differ in which of them they go by: find out which is right, \
         and set the code of the other to 0"
    )]
    Mirrored,
    /// The sform's steps are not those of `pixdim`.
    #[error(
        "the sform steps by {step} along axis {} of the voxels and pixdim says {pixdim}, and programs differ in which of them they go by: \
         find out which is right, and write it in both",
        ["i", "j", "k"][*axis]
    )]
    Steps {
        /// The axis, from 0.
        axis: usize,
        /// The length of the sform's step, in the file's unit.
        step: f64,
        /// What `pixdim` says.
        pixdim: f64,
    },
    /// The qform's quaternion is longer than 1.
    #[error("the qform's quaternion (b, c, d) = {found:?} has norm {norm}, expected at most 1")]
    Quaternion {
        /// b, c, d.
        found: [f64; 3],
        /// Their norm.
        norm: f64,
    },
    /// Dimensions, spacing or axes that no scanner makes.
    #[error("{0}")]
    Grid(#[from] GridError),
}
