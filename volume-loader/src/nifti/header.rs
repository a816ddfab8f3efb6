//! A header whose every number has been judged, before anything is allocated for it.

use geometry::{GridError, VolumeGrid};

use super::fields::{Fields, Layout};
use super::orientation;
use crate::scale::{self, Unusable};
use crate::source::KNOWN;
use crate::voxels::Sample;

/// Voxels later than this are refused: extensions hold text, not volumes.
const MAX_OFFSET: f64 = (64 << 20) as f64;

/// A usable header.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    pub layout: Layout,
    pub sample: Sample,
    pub grid: VolumeGrid,
    /// Byte of the first voxel, in the unpacked data.
    pub offset: u64,
    /// HU = `scale[0]` * stored + `scale[1]`; absent where the file stores HU.
    pub scale: Option<[f64; 2]>,
    /// Which orientation was taken, and what was doubtful.
    pub notes: Vec<String>,
}

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

impl Header {
    /// Judges a header's bytes, [`Layout::bytes`] of them.
    ///
    /// # Errors
    /// Each variant of [`HeaderError`] but `NotNifti`.
    pub(crate) fn parse(layout: Layout, bytes: &[u8]) -> Result<Self, HeaderError> {
        let fields = Fields::parse(layout, bytes)?;
        let dims = one_volume(fields.dim)?;
        let sample = sample(&fields)?;
        let offset = offset(&fields)?;
        let scale = scale(&fields, sample)?;
        let (ct_from_voxel, notes) = orientation::ct_from_voxel(&fields)?;
        let grid = VolumeGrid::checked(dims, ct_from_voxel)?;
        Ok(Self {
            layout,
            sample,
            grid,
            offset,
            scale,
            notes,
        })
    }

    /// Byte after the last voxel, in the unpacked data.
    pub(crate) fn end(&self) -> u64 {
        // At most 2^26 + 2^35 * 8.
        self.offset + self.grid.voxels() * self.sample.bytes() as u64
    }
}

fn one_volume(dim: [i64; 8]) -> Result<[i64; 3], HeaderError> {
    let [count, x, y, z, further @ ..] = dim;
    let used = match count {
        3..=7 => count as usize - 3,
        _ => return Err(HeaderError::Dimensions { found: dim }),
    };
    if further.iter().take(used).any(|&d| d != 1) {
        return Err(HeaderError::Dimensions { found: dim });
    }
    Ok([x, y, z])
}

fn sample(fields: &Fields) -> Result<Sample, HeaderError> {
    let datatype = fields.datatype;
    let sample = Sample::of(datatype).ok_or(HeaderError::Datatype { found: datatype })?;
    let expected = 8 * sample.bytes() as i64;
    if fields.bitpix != expected {
        return Err(HeaderError::Bitpix {
            found: fields.bitpix,
            expected,
            datatype,
        });
    }
    Ok(sample)
}

fn offset(fields: &Fields) -> Result<u64, HeaderError> {
    let found = fields.vox_offset;
    // Four bytes that announce extensions follow the header.
    let least = (fields.layout.bytes() + 4) as f64;
    if found.fract() != 0.0 || !(least..=MAX_OFFSET).contains(&found) {
        return Err(HeaderError::Offset {
            found,
            least,
            most: MAX_OFFSET,
        });
    }
    Ok(found as u64)
}

/// A slope of 0 says that there is no scale, whatever the intercept.
fn scale(fields: &Fields, sample: Sample) -> Result<Option<[f64; 2]>, HeaderError> {
    let (slope, inter) = (fields.slope, fields.inter);
    if slope == 0.0 || (slope == 1.0 && inter == 0.0) {
        return Ok(None);
    }
    let (which, expected) = match scale::check([slope, inter], sample.range()) {
        Ok(()) => return Ok(Some([slope, inter])),
        Err(Unusable::Slope(expected)) => ("scl_slope", expected),
        Err(Unusable::Intercept(expected)) => ("scl_inter", expected),
    };
    Err(HeaderError::Scale {
        which,
        expected,
        slope,
        inter,
    })
}
