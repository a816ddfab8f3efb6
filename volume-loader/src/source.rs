//! Where voxels come from: one trait for every kind of examination, and why reading one fails.
//!
//! A source gives its slices once, in order, straight into the caller's memory; no source holds a whole volume. One whose
//! slices lie apart ([`SliceReader`]) gives them in any order, to several threads at once.

mod error;
mod known;
mod whose;

use std::fmt;

use bus::message::Marks;
use geometry::VolumeGrid;

use crate::part::Sums;
pub use error::ReadError;
pub(crate) use known::KNOWN;
pub use whose::Whose;

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

    /// Whose examination it is, for the bus alone: it goes into no error, no line and no file.
    ///
    /// # Errors
    /// [`ReadError`] where what says so cannot be read; the voxels are none the worse for it.
    fn whose(&self) -> Result<Whose, ReadError> {
        Ok(Whose::default())
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

impl Facts {
    /// The kind of scanner by DICOM's word as the one fact of a format, where it is told.
    pub(crate) fn modality(word: Option<&str>) -> serde_json::Map<String, serde_json::Value> {
        let facts = word.into_iter().map(|word| ("modality".to_owned(), word.into()));
        facts.collect()
    }
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
