//! Which fragments make which frame: by a table of offsets, held against the fragments themselves, or one fragment each (DICOM
//! PS3.5 section A.4).

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;

use super::{END, ITEM, ReadFailure, item, truncated};
use crate::dicom::error::{DicomError, FileError};
use crate::dicom::header::Header;
use crate::dicom::header::frames::Frame;
use crate::dicom::slice::Slice;
use crate::dicom::syntax::PixelCoding;
use crate::dicom::walk::Element;

/// Fragments in one file; writers make one or a few of each frame.
const MAX_FRAGMENTS: u32 = 1 << 20;

/// Gives each slice that is a compressed frame the place of its fragments. Each file is gone through once.
///
/// # Errors
/// [`DicomError::File`], [`DicomError::Unreadable`].
pub(crate) fn locate(headers: &[Header], slices: &mut [Slice]) -> Result<(), DicomError> {
    let mut known: BTreeMap<&PathBuf, Vec<u64>> = BTreeMap::new();
    for (header, slice) in headers.iter().zip(slices) {
        let Some(frame) = header.frame.as_ref().filter(|_| slice.coding != PixelCoding::Native) else {
            continue;
        };
        if !known.contains_key(&header.path) {
            known.insert(&header.path, borders(header, frame)?);
        }
        let borders = known.get(&header.path).map(Vec::as_slice).unwrap_or_default();
        let before = frame.number as usize - 1;
        if let (Some(&start), Some(&end)) = (borders.get(before), borders.get(before + 1)) {
            (slice.pixels_at, slice.end) = (start, end);
        }
    }
    Ok(())
}

/// Where each frame's first fragment begins, and where the last frame's last one ends.
fn borders(header: &Header, frame: &Frame) -> Result<Vec<u64>, DicomError> {
    let unreadable = |source| DicomError::Unreadable {
        path: header.path.clone(),
        source,
    };
    let (file, _) = scene::file::open(&header.path).map_err(|error| unreadable(error.into()))?;
    read(&file, header, frame).map_err(|failure| match failure {
        ReadFailure::Io(source) => unreadable(source),
        ReadFailure::File(source) => DicomError::File {
            path: header.path.clone(),
            source,
        },
    })
}

fn refused(found: impl Into<String>, expected: impl Into<String>) -> ReadFailure {
    let (found, expected) = (found.into(), expected.into());
    FileError::Offsets { found, expected }.into()
}

/// Borders of the frames of this header's file.
fn read(file: &File, header: &Header, frame: &Frame) -> Result<Vec<u64>, ReadFailure> {
    let (at, length) = (header.pixels.value_at, header.length);
    let frames = header.frames.unsigned_abs() as usize;
    let (tag, bytes) = item(file, at, length)?;
    if tag != ITEM {
        return Err(FileError::Delimiter { byte: at, found: tag }.into());
    }
    let first = at + 8 + u64::from(bytes);
    if first > length {
        return Err(truncated(at, first, length).into());
    }
    let [extended, lengths] = frame.tables;
    let offsets = match (extended, bytes) {
        (Some(_), 1..) => return Err(refused("a basic and an extended one", "one of them")),
        (Some(table), 0) => Some(ascending(wide(file, table, frames)?)?),
        (None, 0) => None,
        (None, _) => Some(narrow(file, at + 8, bytes, frames)?),
    };
    let lengths = match (extended, lengths) {
        (Some(_), Some(table)) => Some(wide(file, table, frames)?),
        _ => None,
    };
    let tables = Tables {
        frames,
        offsets,
        lengths,
        // The extended table has a fragment for each frame (PS3.5, A.4).
        single: extended.is_some(),
    };
    walk(file, first, length, &tables)
}

/// What is said of the frames' fragments.
struct Tables {
    frames: usize,
    /// Bytes from the first fragment's header to that of each frame's first.
    offsets: Option<Vec<u64>>,
    lengths: Option<Vec<u64>>,
    /// Whether each frame is one fragment.
    single: bool,
}

/// Goes from fragment to fragment: each offset must be that of one.
fn walk(file: &File, first: u64, length: u64, tables: &Tables) -> Result<Vec<u64>, ReadFailure> {
    let frames = tables.frames;
    let (mut at, mut fragments) = (first, 0);
    let mut borders = Vec::with_capacity(frames + 1);
    loop {
        let (tag, bytes) = item(file, at, length)?;
        match tag {
            ITEM => {}
            END => break,
            found => return Err(FileError::Delimiter { byte: at, found }.into()),
        }
        let end = at + 8 + u64::from(bytes);
        if end > length {
            return Err(truncated(at, end, length).into());
        }
        fragments += 1;
        if fragments > MAX_FRAGMENTS {
            let (byte, limit) = (at, MAX_FRAGMENTS);
            return Err(FileError::TooManyElements { byte, limit }.into());
        }
        if tables.begins(borders.len(), at - first)? {
            tables.check_length(borders.len(), bytes)?;
            borders.push(at);
        }
        at = end;
    }
    if borders.len() != frames || tables.single && fragments as usize != frames {
        let expected = match &tables.offsets {
            Some(_) => format!("a fragment at each of {frames} offsets"),
            None => format!("{frames} fragments, one for each frame, as there is no table"),
        };
        return Err(refused(
            format!("{fragments} fragments, {} of them first ones", borders.len()),
            expected,
        ));
    }
    borders.push(at);
    Ok(borders)
}

impl Tables {
    /// Whether the fragment at `offset` is the first of the frame with this index.
    fn begins(&self, frame: usize, offset: u64) -> Result<bool, ReadFailure> {
        match &self.offsets {
            None if self.frames == 1 => Ok(frame == 0),
            None if frame == self.frames => Err(refused(
                format!("none, and more than {frame} fragments"),
                format!("{frame}, one for each frame"),
            )),
            None => Ok(true),
            Some(offsets) => match offsets.get(frame) {
                Some(&given) if given < offset => Err(refused(
                    format!("{given} for frame {}", frame + 1),
                    format!("the beginning of a fragment, such as {offset}"),
                )),
                given => Ok(given == Some(&offset)),
            },
        }
    }

    /// The fragment of the frame with this index is as long as the table says, up to one byte that makes it even.
    fn check_length(&self, frame: usize, bytes: u32) -> Result<(), ReadFailure> {
        let Some(&given) = self.lengths.as_ref().and_then(|lengths| lengths.get(frame)) else {
            return Ok(());
        };
        let found = u64::from(bytes);
        match found == given || given % 2 == 1 && found == given.saturating_add(1) {
            true => Ok(()),
            false => Err(refused(
                format!("a length of {given} bytes for frame {}", frame + 1),
                format!("{found}, as its fragment has"),
            )),
        }
    }
}

/// The basic table, of 32-bit numbers.
fn narrow(file: &File, at: u64, bytes: u32, frames: usize) -> Result<Vec<u64>, ReadFailure> {
    if bytes as usize != 4 * frames {
        return Err(refused(
            format!("{bytes} bytes"),
            format!("{} for {frames} frames", 4 * frames),
        ));
    }
    let mut table = vec![0; 4 * frames];
    file.read_exact_at(&mut table, at)?;
    let numbers = table.as_chunks().0.iter();
    ascending(numbers.map(|bytes| u64::from(u32::from_le_bytes(*bytes))).collect())
}

/// An extended table, of 64-bit numbers.
fn wide(file: &File, table: Element, frames: usize) -> Result<Vec<u64>, ReadFailure> {
    let found = table.length.map_or(u64::from(u32::MAX), u64::from);
    if found != 8 * frames as u64 {
        let expected = format!("{} for {frames} frames", 8 * frames);
        return Err(refused(format!("{found} bytes of {}", table.tag), expected));
    }
    let mut bytes = vec![0; 8 * frames];
    file.read_exact_at(&mut bytes, table.value_at)?;
    Ok(bytes
        .as_chunks()
        .0
        .iter()
        .map(|bytes| u64::from_le_bytes(*bytes))
        .collect())
}

/// Frames lie in the file in their order.
fn ascending(offsets: Vec<u64>) -> Result<Vec<u64>, ReadFailure> {
    let pairs = offsets.iter().zip(offsets.iter().skip(1));
    match offsets.first() == Some(&0) && pairs.clone().all(|(a, b)| a < b) {
        true => Ok(offsets),
        false => Err(refused(
            "offsets that do not ascend from 0",
            "each frame behind the one before it",
        )),
    }
}
