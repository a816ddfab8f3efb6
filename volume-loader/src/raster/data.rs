//! Where the voxels lie, checked against the files' lengths before anything is allocated for them.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use geometry::VolumeGrid;

use super::{Remarks, trail};
use crate::source::{Place, ReadError};
use crate::stream::{Packing, open_file, opening};
use crate::voxels::Sample;

/// The most that lines before the voxels may hold, bytes.
const MAX_LINES: u64 = 1 << 20;

/// How voxels are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// As bytes, perhaps compressed.
    Bytes(Packing),
    /// As numbers in text.
    Text,
    /// As bytes, two hexadecimal digits each.
    Hex,
}

impl Encoding {
    /// The word that describes it.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Bytes(Packing::Plain) => "raw",
            Self::Bytes(Packing::Gzip) => "gzip",
            Self::Bytes(Packing::Zlib) => "zlib",
            Self::Text => "text",
            Self::Hex => "hexadecimal text",
        }
    }
}

/// What comes before the voxels in each file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Skip {
    /// The header's bytes, where voxels follow it in its own file.
    pub head: u64,
    /// Then lines, uncompressed.
    pub lines: u64,
    /// Then bytes, in the unpacked data; `None` where the voxels are the file's last bytes.
    pub bytes: Option<u64>,
}

/// All that a header says of its voxels.
#[derive(Debug, Clone)]
pub(crate) struct Data {
    /// The header's file.
    pub header: PathBuf,
    /// The format's name.
    pub format: &'static str,
    pub grid: VolumeGrid,
    pub sample: Sample,
    pub big_endian: bool,
    pub encoding: Encoding,
    /// In the order of slices.
    pub files: Vec<PathBuf>,
    pub slices_per_file: u32,
    pub skip: Skip,
    /// The most bytes of a file that belong to a compressed stream.
    pub packed_limit: u64,
    /// What is told a person.
    pub remarks: Remarks,
}

/// One file of voxels, found and long enough.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Part {
    pub path: PathBuf,
    /// Byte of the first voxel, or of the compressed stream.
    pub offset: u64,
    /// What is doubtful about its length.
    pub doubt: Option<String>,
}

impl Data {
    /// Bytes of one slice as the header has them.
    pub(crate) fn slice_bytes(&self) -> u64 {
        let [nx, ny, _] = self.grid.dims().map(u64::from);
        nx * ny * self.sample.bytes() as u64
    }

    /// Unpacked bytes of each file's voxels.
    pub(crate) fn part_bytes(&self) -> u64 {
        // A checked grid: at most 2^35 bytes.
        self.slice_bytes() * u64::from(self.slices_per_file)
    }

    /// Finds every file and the first byte of its voxels.
    ///
    /// # Errors
    /// Each variant of [`ReadError`] that tells of a file, its length or its beginning.
    pub(crate) fn locate(&self) -> Result<Vec<Part>, ReadError> {
        let mut known = self.known()?;
        let part = |path: &PathBuf| {
            let (file, about) = open_file(path)?;
            // A name says little: links and ways through other folders lead to one file too.
            if let Some(other) = known.insert((about.dev(), about.ino()), path.clone()) {
                let path = path.clone();
                return Err(ReadError::Twice { path, other });
            }
            let offset = self.locate_in(path, file, about.len())?;
            Ok(Part {
                path: path.clone(),
                offset,
                doubt: self.doubt(path, about.len(), offset),
            })
        };
        self.files.iter().map(part).collect()
    }

    /// The files that hold no voxels, by what the system knows them by: a header whose voxels are elsewhere.
    fn known(&self) -> Result<HashMap<(u64, u64), PathBuf>, ReadError> {
        // Voxels that follow the header begin behind it.
        if self.skip.head > 0 {
            return Ok(HashMap::new());
        }
        let (_, about) = open_file(&self.header)?;
        Ok(HashMap::from([((about.dev(), about.ino()), self.header.clone())]))
    }

    fn locate_in(&self, path: &Path, file: File, length: u64) -> Result<u64, ReadError> {
        let needed = self.part_bytes();
        let Some(skip) = self.skip.bytes else {
            let found = length.saturating_sub(self.skip.head);
            return match length.checked_sub(needed) {
                Some(offset) if offset >= self.skip.head => Ok(offset),
                _ => Err(truncated(path, Place::Header, needed, found)),
            };
        };
        let start = self.skip.head + skip_lines(path, file, self.skip.head, self.skip.lines)?;
        let offset = start.saturating_add(skip);
        match self.encoding {
            Encoding::Bytes(Packing::Plain) => self.check_plain(path, length, offset).map(|()| offset),
            Encoding::Bytes(_) => check_least(path, length, start.saturating_add(1)).map(|()| start),
            // A digit and something between: no shorter text holds that many numbers.
            Encoding::Text => {
                let least = needed / self.sample.bytes() as u64 * 2 - 1;
                check_least(path, length, offset.saturating_add(least)).map(|()| offset)
            }
            Encoding::Hex => check_least(path, length, offset.saturating_add(2 * needed)).map(|()| offset),
        }
    }

    /// What is told of bytes before and behind the voxels of an uncompressed file.
    fn doubt(&self, path: &Path, length: u64, offset: u64) -> Option<String> {
        if self.encoding != Encoding::Bytes(Packing::Plain) {
            return None;
        }
        let before = offset.saturating_sub(self.skip.head);
        if self.skip.bytes.is_none() && before >= self.slice_bytes() {
            return Some(format!(
                "{}: the voxels are the file's last bytes, and {before} before them are passed over, more than a slice: the header's \
                 dimensions may be wrong",
                path.display()
            ));
        }
        let end = offset.saturating_add(self.part_bytes());
        trail::doubt(path, end, length.saturating_sub(end))
    }

    fn check_plain(&self, path: &Path, length: u64, offset: u64) -> Result<(), ReadError> {
        let end = offset.saturating_add(self.part_bytes());
        if length < end {
            let slice = length.saturating_sub(offset) / self.slice_bytes().max(1);
            let place = match u32::try_from(slice) {
                Ok(slice) if length >= offset => Place::Slice(slice),
                _ => Place::Header,
            };
            return Err(truncated(path, place, end, length));
        }
        if length - end > trail::most(self.slice_bytes()) {
            return Err(ReadError::TooLong {
                path: path.to_owned(),
                expected: end,
                found: length,
            });
        }
        Ok(())
    }
}

fn check_least(path: &Path, found: u64, expected: u64) -> Result<(), ReadError> {
    if found < expected {
        return Err(truncated(path, Place::End, expected, found));
    }
    Ok(())
}

fn truncated(path: &Path, place: Place, expected: u64, found: u64) -> ReadError {
    ReadError::Truncated {
        path: path.to_owned(),
        place,
        expected,
        found,
    }
}

/// How many bytes `lines` lines have, from byte `start` of `path` on.
fn skip_lines(path: &Path, mut file: File, start: u64, lines: u64) -> Result<u64, ReadError> {
    if lines == 0 {
        return Ok(0);
    }
    let unreadable = |source| opening(path, source);
    std::io::Seek::seek(&mut file, std::io::SeekFrom::Start(start)).map_err(unreadable)?;
    let mut reader = BufReader::new(file.take(MAX_LINES));
    let mut skipped = 0;
    for _ in 0..lines {
        // Counted, not kept: a line may be as long as the limit.
        let line = reader.skip_until(b'\n').map_err(unreadable)? as u64;
        skipped += line;
        if line == 0 {
            let end = start.saturating_add(skipped);
            return Err(truncated(path, Place::Header, end + 1, end));
        }
    }
    Ok(skipped)
}
