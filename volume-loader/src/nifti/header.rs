//! A header whose every number has been judged, before anything is allocated for it.

use geometry::VolumeGrid;

use super::error::HeaderError;
use super::fields::{Fields, Layout};
use super::meaning;
use super::orientation;
use crate::scale::{self, Unusable};
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
    /// Which orientation was taken.
    pub form: String,
    /// What is doubtful about it, a sentence each.
    pub doubts: Vec<String>,
    /// The kind of scanner by DICOM's word, where a text says it.
    pub modality: Option<&'static str>,
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
        let orientation::Placed {
            ct_from_voxel,
            form,
            mut doubts,
        } = orientation::ct_from_voxel(&fields)?;
        let grid = VolumeGrid::checked(dims, ct_from_voxel)?;
        doubts.extend(unscaled(&fields));
        let (meaning, modality) = meaning::of(&fields);
        doubts.extend(meaning);
        Ok(Self {
            layout,
            sample,
            grid,
            offset,
            scale,
            form,
            doubts,
            modality,
        })
    }

    /// Bytes of one slice.
    pub(crate) fn slice_bytes(&self) -> u64 {
        let [columns, rows, _] = self.grid.dims().map(u64::from);
        columns * rows * self.sample.bytes() as u64
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

/// The doubt about an intercept beside a slope of 0. The standard (nifti1.h, "DATA SCALING") has no scale then, and so has nibabel; ITK adds
/// the intercept.
fn unscaled(fields: &Fields) -> Option<String> {
    let inter = fields.inter;
    (fields.slope == 0.0 && inter != 0.0).then(|| {
        format!(
            "scl_slope is 0 and scl_inter {inter}: the numbers are taken as they are, after the standard; programs built on ITK add {inter} HU"
        )
    })
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
