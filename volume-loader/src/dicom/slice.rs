//! One slice as it will be read: everything about its pixels judged, before one of them is.

use std::path::PathBuf;

use super::error::FileError;
use super::header::Header;
use super::stored::{Cell, ToHu};
use super::syntax::PixelCoding;
use super::tag as el;
use crate::scale::{self, Unusable};

/// More pixels than any scanner's slice has (4096 x 4096); holds what decoders allocate to 64 MB a thread and buffer.
const MAX_PIXELS: u64 = 1 << 24;

/// How to read one slice.
#[derive(Debug, Clone)]
pub(crate) struct Slice {
    pub path: PathBuf,
    pub coding: PixelCoding,
    pub columns: u16,
    pub rows: u16,
    pub to_hu: ToHu,
    /// Where the pixels begin, or their first fragment's header.
    pub pixels_at: u64,
    /// Length of the file, bytes.
    pub length: u64,
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
        check_length(header, pixels * cell.bytes() as u64)?;
        Ok(Self {
            path: header.path.clone(),
            coding: header.syntax.pixels,
            columns,
            rows,
            to_hu: ToHu::new(cell, slope, intercept),
            pixels_at: header.pixels.value_at,
            length: header.length,
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
    if frames != 1 {
        return Err(FileError::MultiFrame { frames });
    }
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

/// CT images have a slope and an intercept (PS3.3, C.8.2.1); others may go without both.
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
        (None, None) if header.modality != "CT" => Ok([1.0, 0.0]),
        (None, _) => Err(FileError::Missing { tag: el::SLOPE }),
        (_, None) => Err(FileError::Missing { tag: el::INTERCEPT }),
    }
}

/// Uncompressed pixels have the length that the header asks for, up to one byte that makes it even.
fn check_length(header: &Header, expected: u64) -> Result<(), FileError> {
    let Some(length) = header.pixels.length else {
        return Ok(());
    };
    let found = u64::from(length);
    if found == expected || found == expected.next_multiple_of(2) {
        return Ok(());
    }
    Err(FileError::PixelLength {
        found,
        expected,
        columns: header.columns,
        rows: header.rows,
        bits: header.bits_allocated,
    })
}
