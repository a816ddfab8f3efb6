//! One slice as it will be read: everything about its pixels judged, before one of them is.

use std::path::PathBuf;

use super::error::FileError;
use super::header::Header;
use super::stored::{Cell, ToHu};
use super::syntax::PixelCoding;
use super::tag::{self as el, Tag};
use super::text::Label;
use crate::scale::{self, Unusable};

/// More pixels than any scanner's slice has (4096 x 4096); holds what decoders allocate to 64 MB a thread and buffer.
const MAX_PIXELS: u64 = 1 << 24;

/// Fourth values of ImageType and FrameType of a CT whose numbers are surely no HU (PS3.3, C.8.2.1.1.1, C.8.16.1.4).
const NO_HU: [&str; 4] = ["EFF_ATOMIC_NUM", "ELECTRON_DENSITY", "MAT_FRACTIONAL", "STD_DEVIATION"];
/// RescaleTypes of a CT whose numbers are surely no HU (PS3.3, C.11.1.1.2): optical, mg/ml, atomic number, electron densities,
/// parts.
const NO_HU_UNITS: [&str; 6] = ["OD", "MGML", "Z_EFF", "ED", "EDW", "PCT"];
/// Fourth values of images that may be HU and are not those of the tissue at each place; told, and not refused.
pub(crate) const DERIVED: [&str; 14] = [
    "ADDITION",
    "DIVISION",
    "MASKED",
    "MAXIMUM",
    "MEAN",
    "MINIMUM",
    "MULTIPLICATION",
    "QUANTITY",
    "SUBTRACTION",
    "VMI",
    "MAT_SPECIFIC",
    "MAT_REMOVED",
    "MAT_MODIFIED",
    "MAT_VALUE_BASED",
];

/// How to read one slice: of a file, or of a frame of a file.
#[derive(Debug, Clone)]
pub(crate) struct Slice {
    pub path: PathBuf,
    pub coding: PixelCoding,
    pub columns: u16,
    pub rows: u16,
    pub to_hu: ToHu,
    /// Number of the frame, where the file has several.
    pub frame: Option<u32>,
    /// Where the pixels begin, or the table of offsets before their fragments; of a frame, its first fragment's header.
    pub pixels_at: u64,
    /// Length of the file, bytes; of a compressed frame, where its last fragment ends.
    pub end: u64,
}

impl Slice {
    /// Judges the pixels that `header` describes.
    ///
    /// # Errors
    /// [`FileError`].
    pub(crate) fn of(header: &Header) -> Result<Self, FileError> {
        check_kind(header)?;
        let cell = Cell::of(header)?;
        let [slope, intercept] = rescale(header, cell)?;
        let (columns, rows) = (header.columns, header.rows);
        let pixels = u64::from(columns) * u64::from(rows);
        if pixels == 0 || pixels > MAX_PIXELS {
            let (tag, found) = (el::ROWS, format!("{rows} and Columns {columns}"));
            let expected = "at least 1 each, and at most 16777216 pixels";
            return Err(FileError::Value { tag, found, expected });
        }
        let bytes = pixels * cell.bytes() as u64;
        let (before, frames) = match &header.frame {
            Some(frame) => (u64::from(frame.number - 1), header.frames.unsigned_abs()),
            None => (0, 1),
        };
        check_length(header, bytes, frames)?;
        let native = header.syntax.pixels == PixelCoding::Native;
        Ok(Self {
            path: header.path.clone(),
            coding: header.syntax.pixels,
            columns,
            rows,
            to_hu: ToHu::new(cell, slope, intercept),
            frame: header.frame_number(),
            pixels_at: header.pixels.value_at + if native { before * bytes } else { 0 },
            end: header.length,
        })
    }

    /// Pixels in the slice.
    pub(crate) fn pixels(&self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }
}

/// One grey image.
fn check_kind(header: &Header) -> Result<(), FileError> {
    let frames = header.frames;
    if frames != 1 && header.frame.is_none() {
        return Err(FileError::MultiFrame { frames });
    }
    if let Some((tag, found)) = header.frame.as_ref().and_then(|frame| frame.distorted.clone()) {
        let expected = "a slice: pixels that lie where their frame's place and axes put them";
        return Err(FileError::Value { tag, found, expected });
    }
    if header.modality_lut {
        return Err(FileError::Value {
            tag: el::MODALITY_LUT,
            found: "there".to_owned(),
            expected: "none: HU are read by a slope and an intercept only",
        });
    }
    check_hu(header)?;
    if header.samples != 1 {
        return Err(FileError::Value {
            tag: el::SAMPLES,
            found: header.samples.to_string(),
            expected: "1: one grey value per pixel",
        });
    }
    if header.photometric != "MONOCHROME2" {
        return Err(FileError::Value {
            tag: el::PHOTOMETRIC,
            found: header.photometric.clone(),
            expected: "MONOCHROME2: larger numbers are brighter",
        });
    }
    Ok(())
}

/// A CT is HU, or there are windows and surfaces of something else. Other modalities are told to be none.
fn check_hu(header: &Header) -> Result<(), FileError> {
    if header.modality != "CT" {
        return Ok(());
    }
    let refused = |tag: Tag, found: &str| {
        let (found, expected) = (found.to_owned(), "an image whose numbers are HU");
        Err(FileError::Value { tag, found, expected })
    };
    let contrast = header.contrast.as_deref().unwrap_or_default();
    if NO_HU.contains(&contrast) {
        let tag = if header.frame.is_some() {
            el::FRAME_TYPE
        } else {
            el::IMAGE_TYPE
        };
        return refused(tag, contrast);
    }
    let unit = header.rescale_type.as_ref().map_or("", Label::shown);
    match NO_HU_UNITS.contains(&unit) {
        true => refused(el::RESCALE_TYPE, unit),
        false => Ok(()),
    }
}

/// CT images have a slope and an intercept (PS3.3, C.8.2.1), and frames a group that says both; classic slices of other modalities
/// may go without.
fn rescale(header: &Header, cell: Cell) -> Result<[f64; 2], FileError> {
    match (header.slope, header.intercept) {
        (Some(slope), Some(intercept)) => {
            let range = cell.range().map(|number| number as f64);
            let (tag, found, expected) = match scale::check([slope, intercept], range) {
                Ok(()) => return Ok([slope, intercept]),
                Err(Unusable::Slope(expected)) => (el::SLOPE, slope, expected),
                Err(Unusable::Intercept(expected)) => (el::INTERCEPT, intercept, expected),
            };
            let found = found.to_string();
            Err(FileError::Value { tag, found, expected })
        }
        (None, None) if header.modality != "CT" && header.frame.is_none() => Ok([1.0, 0.0]),
        (None, _) => Err(FileError::Missing { tag: el::SLOPE }),
        (_, None) => Err(FileError::Missing { tag: el::INTERCEPT }),
    }
}

/// Uncompressed pixels have the length that the header asks for, up to one byte that makes it even. `frame` is the length of one
/// frame; there is no padding between frames.
fn check_length(header: &Header, frame: u64, frames: u64) -> Result<(), FileError> {
    let Some(length) = header.pixels.length else {
        return Ok(());
    };
    let (found, expected) = (u64::from(length), frame * frames);
    if found == expected || found == expected.next_multiple_of(2) {
        return Ok(());
    }
    Err(FileError::PixelLength {
        found,
        expected,
        frames,
        columns: header.columns,
        rows: header.rows,
        bits: header.bits_allocated,
    })
}
