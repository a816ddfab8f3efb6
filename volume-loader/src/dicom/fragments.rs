//! The fragments of a compressed image, joined (DICOM PS3.5 section A.4).

pub(super) mod offsets;

use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;

use super::error::FileError;
use super::tag as el;
use super::tag::Tag;
use super::tag::tag;

/// Why reading pixels stopped; the file's name comes later.
#[derive(Debug)]
pub(crate) enum ReadFailure {
    File(FileError),
    Io(std::io::Error),
}

impl From<FileError> for ReadFailure {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

impl From<std::io::Error> for ReadFailure {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

const ITEM: Tag = tag(0xFFFE, 0xE000);
const END: Tag = tag(0xFFFE, 0xE0DD);

/// Where the fragments of one image lie.
#[derive(Debug, Clone)]
pub(crate) enum Stretch {
    /// From the table of offsets, of no use for one image, to a delimiter before the end of the file.
    File(Range<u64>),
    /// Of one frame among others: fragments and nothing else.
    Frame(Range<u64>),
}

/// Joins the fragments in this stretch of the file, `most` bytes at most, into `joined`.
///
/// # Errors
/// [`ReadFailure`]. No more than `most` is allocated: a file may claim any length with holes in it.
pub(crate) fn join(file: &File, stretch: Stretch, most: u64, joined: &mut Vec<u8>) -> Result<(), ReadFailure> {
    let frame = matches!(stretch, Stretch::Frame(_));
    // The first item of a whole stretch is the table.
    let mut table = !frame;
    let (Stretch::File(range) | Stretch::Frame(range)) = stretch;
    let (mut at, length) = (range.start, range.end);
    joined.clear();
    loop {
        if frame && at == length && !joined.is_empty() {
            return Ok(());
        }
        let (found, bytes) = item(file, at, length)?;
        let value_at = at + 8;
        match found {
            ITEM => {}
            END if joined.is_empty() => {
                let (found, expected) = ("empty", "at least one fragment");
                return Err(FileError::Encapsulation { found, expected }.into());
            }
            END => return Ok(()),
            found => return Err(FileError::Delimiter { byte: at, found }.into()),
        }
        let end = value_at + u64::from(bytes);
        if end > length {
            return Err(truncated(at, end, length).into());
        }
        if !table {
            let found = joined.len() as u64 + u64::from(bytes);
            if found > most {
                return Err(FileError::TooLong {
                    tag: el::PIXELS,
                    byte: at,
                    found,
                    limit: most,
                }
                .into());
            }
            let start = joined.len();
            joined.resize(start + bytes as usize, 0);
            let room = joined.get_mut(start..).unwrap_or_default();
            file.read_exact_at(room, value_at)?;
        }
        table = false;
        at = end;
    }
}

fn truncated(byte: u64, expected: u64, found: u64) -> FileError {
    FileError::Truncated {
        tag: el::PIXELS,
        byte,
        expected,
        found,
    }
}

/// The tag and the length of the item at `at`; compressed files are little-endian.
fn item(file: &File, at: u64, length: u64) -> Result<(Tag, u32), ReadFailure> {
    if at + 8 > length {
        return Err(truncated(at, at + 8, length).into());
    }
    let mut header = [0; 8];
    file.read_exact_at(&mut header, at)?;
    let [a, b, c, d, bytes @ ..] = header;
    let found = tag(u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    Ok((found, u32::from_le_bytes(bytes)))
}
