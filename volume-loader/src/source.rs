//! Where voxels come from: one trait for every kind of examination, and why reading one fails.
//!
//! A source gives its slices once, in order, straight into the caller's memory; no source holds a whole volume. One whose
//! slices lie apart ([`SliceReader`]) gives them in any order, to several threads at once.

use std::fmt;
use std::path::PathBuf;

use bus::message::Marks;
use geometry::VolumeGrid;

use crate::dicom::DicomError;
use crate::metaimage::MetaImageError;
use crate::nifti::HeaderError;
use crate::nrrd::NrrdError;
use crate::part::Sums;

/// An examination that gives its voxels slice by slice, as HU.
///
/// Voxels that do not fit an `i16` are changed by one policy, and counted in [`Conversion`]: HU below -32768 and above
/// 32767 are held to those, what is not a number becomes [`VoxelSource::padding_hu`], and fractions round to the
/// nearest whole number, halves away from zero.
pub trait VoxelSource: Send + Sync {
    /// How many voxels there are and where they lie in the patient.
    fn grid(&self) -> &VolumeGrid;

    /// HU of what the scanner did not measure.
    fn padding_hu(&self) -> i16;

    /// One line for a person: what this is, and whatever was doubtful about it. Nothing that names a patient.
    fn describe(&self) -> String;

    /// What every image of this volume must say: that its voxels are not the scanner's own, or not all of them.
    fn marks(&self) -> Marks {
        Marks::NONE
    }

    /// Reads slice `k` into `out`: `dims[0] * dims[1]` voxels, row-major, x fastest. Slices are asked for strictly in
    /// order, from 0 on, each once.
    ///
    /// # Errors
    /// [`ReadError`]; the source is of no further use then, and so is `out`.
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError>;

    /// Checks what can be checked only after the last slice, such as a compressed stream's checksum, and says what was
    /// changed. A volume is whole only after this.
    ///
    /// # Errors
    /// [`ReadError`]; the slices read before must not be used then.
    fn finish(&mut self) -> Result<Conversion, ReadError>;

    /// What only the reader of a format knows: for `inspect`, known before the first slice.
    fn facts(&self) -> Facts {
        Facts::default()
    }

    /// What is known only after the last slice, for a person.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// The slices in any order, where the source has them apart; `None` where they come as one stream. Who reads this way
    /// calls neither [`VoxelSource::read_slice`] nor [`VoxelSource::finish`].
    fn slices(&self) -> Option<&dyn SliceReader> {
        None
    }
}

/// Slices that lie apart, each whole by itself: read in any order and by several threads at once.
pub trait SliceReader: Sync {
    /// Reads slice `k` into `out` (`dims[0] * dims[1]` voxels, row-major, x fastest) and says what was changed.
    /// `scratch` is the calling thread's own; what is in it on entry means nothing.
    ///
    /// # Errors
    /// [`ReadError`]; what is in `out` then is not a slice.
    fn read(&self, k: u32, out: &mut [i16], scratch: &mut Scratch) -> Result<Conversion, ReadError>;
}

/// One thread's memory for reading slices, kept from slice to slice.
#[derive(Debug, Default)]
pub struct Scratch {
    /// A slice's file, or a part of it.
    pub bytes: Vec<u8>,
    /// A slice on its way to becoming a part of one.
    pub slice: Vec<i16>,
    /// Voxels on their way to becoming one.
    pub sums: Vec<Sums>,
}

/// What only the reader of a format knows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facts {
    /// What is doubtful about the files, a sentence each.
    pub warnings: Vec<String>,
    /// Facts of the format, by name: for DICOM the steps between slices, the tilt tag, the codec.
    pub extra: serde_json::Map<String, serde_json::Value>,
}

/// How many voxels were changed on their way to `i16`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Conversion {
    /// Held to -32768.
    pub clamped_low: u64,
    /// Held to 32767.
    pub clamped_high: u64,
    /// NaN or infinite, replaced by the padding.
    pub not_finite: u64,
    /// Rounded to a whole number.
    pub rounded: u64,
}

impl std::ops::AddAssign for Conversion {
    fn add_assign(&mut self, other: Self) {
        self.clamped_low += other.clamped_low;
        self.clamped_high += other.clamped_high;
        self.not_finite += other.not_finite;
        self.rounded += other.rounded;
    }
}

impl Conversion {
    /// The voxel for `value` HU, after the policy that [`VoxelSource`] tells; what was changed is counted.
    pub fn voxel(&mut self, value: f64, padding_hu: i16) -> i16 {
        if !value.is_finite() {
            self.not_finite += 1;
            return padding_hu;
        }
        let whole = value.round();
        self.rounded += u64::from(whole != value);
        self.clamped_low += u64::from(whole < f64::from(i16::MIN));
        self.clamped_high += u64::from(whole > f64::from(i16::MAX));
        // `as` saturates: this is the clamp.
        whole as i16
    }
}

/// Which part of a file was being read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// What comes before the voxels.
    Header,
    /// This slice's voxels.
    Slice(u32),
    /// What comes after the voxels.
    End,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header => write!(f, "the header"),
            Self::Slice(k) => write!(f, "slice {k}"),
            Self::End => write!(f, "the end after the last slice"),
        }
    }
}

/// Why an examination was not read. Byte positions count from 0, in the unpacked data where a file is compressed.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// There is no such file.
    #[error("{}: there is no such file; check the name and that its disk is mounted", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The path names a folder, a pipe or a device.
    #[error("{}: this is {found}, expected a file", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// What it is.
        found: &'static str,
    },
    /// The file has no bytes.
    #[error("{}: the file is empty (0 bytes); copy it again from its origin", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused to open or read it.
    #[error("{}: cannot read {place} at byte {byte}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Where.
        byte: u64,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The header is not one that can be used.
    #[error("{}: {source}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: HeaderError,
    },
    /// The header of an NRRD file is not one that can be used.
    #[error("{}: {source}", path.display())]
    Nrrd {
        /// The header's file.
        path: PathBuf,
        /// What is wrong with it.
        source: NrrdError,
    },
    /// The header of a MetaImage file is not one that can be used.
    #[error("{}: {source}", path.display())]
    MetaImage {
        /// The header's file.
        path: PathBuf,
        /// What is wrong with it.
        source: MetaImageError,
    },
    /// A voxel written as text is no number, or there are more of them than voxels.
    #[error("{}: {place} has {found:?} before byte {byte}, expected {expected}", path.display())]
    Word {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// The byte after it.
        byte: u64,
        /// What stands there, 80 characters at most.
        found: String,
        /// What would do.
        expected: &'static str,
    },
    /// A DICOM file, folder or series was refused.
    #[error(transparent)]
    Dicom(Box<DicomError>),
    /// The file is shorter than its header says.
    #[error("{}: the file ends in {place}: expected at least {expected} bytes, found {found}; copy it again from its origin", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// The file is much longer than its header says: probably the header is wrong.
    #[error("{}: the voxels end at byte {expected}, found {found} bytes or more; the header's dimensions or datatype are wrong", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Bytes that the header asks for.
        expected: u64,
        /// Bytes that there are, at least.
        found: u64,
    },
    /// The compressed stream stops before its end.
    #[error("{}: the compressed stream breaks off in {place}: expected at least {expected} unpacked bytes and a checksum, found {found}; copy it again from its origin", path.display())]
    BrokenOff {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Unpacked bytes that the header asks for.
        expected: u64,
        /// Unpacked bytes that there are.
        found: u64,
    },
    /// The compressed stream is damaged.
    #[error("{}: the compressed stream is damaged in {place}, at unpacked byte {byte}: {detail}; copy it again from its origin", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// What was being read.
        place: Place,
        /// Unpacked bytes read before.
        byte: u64,
        /// What the decoder says.
        detail: String,
    },
    /// A slice was asked for out of order.
    #[error("slice {found} was asked for, expected slice {expected} of {count}: slices are read in order, each once")]
    Order {
        /// The slice whose turn it is.
        expected: u32,
        /// The slice asked for.
        found: u32,
        /// How many slices there are.
        count: u32,
    },
    /// The buffer for a slice has the wrong length.
    #[error("the buffer for slice {slice} holds {found} voxels, expected {expected}")]
    Buffer {
        /// The slice.
        slice: u32,
        /// Voxels per slice.
        expected: u64,
        /// Length of the buffer.
        found: usize,
    },
}

impl From<DicomError> for ReadError {
    fn from(error: DicomError) -> Self {
        Self::Dicom(Box::new(error))
    }
}

/// Keeps the order of slices: what every source asks before it reads.
#[derive(Debug, Clone, Default)]
pub(crate) struct Turn {
    next: u32,
}

impl Turn {
    /// Lets slice `k` into `out` pass if it is its turn and fits.
    ///
    /// # Errors
    /// [`ReadError::Order`], [`ReadError::Buffer`].
    pub(crate) fn take(&mut self, grid: &VolumeGrid, k: u32, out: &[i16]) -> Result<(), ReadError> {
        let [nx, ny, count] = grid.dims();
        if k != self.next || k >= count {
            return Err(ReadError::Order {
                expected: self.next,
                found: k,
                count,
            });
        }
        let expected = u64::from(nx) * u64::from(ny);
        if out.len() as u64 != expected {
            return Err(ReadError::Buffer {
                slice: k,
                expected,
                found: out.len(),
            });
        }
        self.next += 1;
        Ok(())
    }

    /// Passes once every slice has been read.
    ///
    /// # Errors
    /// [`ReadError::Order`].
    pub(crate) fn done(&self, grid: &VolumeGrid) -> Result<(), ReadError> {
        let count = grid.dims()[2];
        if self.next == count {
            return Ok(());
        }
        Err(ReadError::Order {
            expected: self.next,
            found: count,
            count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_change_is_made_and_counted() {
        let mut conversion = Conversion::default();
        let cases = [
            (12.0, 12),
            (-32768.0, -32768),
            (-32769.0, -32768),
            (32767.4, 32767),
            (32767.5, 32767),
            (1e300, 32767),
            (-0.5, -1),
            (f64::NAN, -1024),
            (f64::NEG_INFINITY, -1024),
        ];
        for (value, want) in cases {
            assert_eq!(conversion.voxel(value, -1024), want, "{value}");
        }
        let want = Conversion {
            clamped_low: 1,
            clamped_high: 2,
            not_finite: 2,
            rounded: 3,
        };
        assert_eq!(conversion, want);
    }
}
