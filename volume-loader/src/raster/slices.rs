//! Slices of plain bytes, read where they lie: in any order, by several threads.

use std::fs::File;
use std::io::ErrorKind;
use std::os::unix::fs::FileExt;

use geometry::VolumeGrid;

use super::data::Part;
use crate::source::{Conversion, Place, ReadError, Scratch, SliceReader};
use crate::stream::open_file;
use crate::voxels::Decoder;

/// Bytes read at once: a whole number of voxels of any type, and small enough to stay in the cache until decoded.
const CHUNK_BYTES: usize = 1 << 18;

/// Files of uncompressed voxels whose lengths have been checked.
pub(crate) struct PlainSlices {
    parts: Vec<Part>,
    slices_per_file: u32,
    slice_voxels: u64,
    slices: u32,
    decoder: Decoder,
    /// The only file, where there is one only; of many, each is opened for its slices.
    open: Option<File>,
}

impl PlainSlices {
    /// Slices of `grid` in `parts`, `slices_per_file` in each.
    ///
    /// # Errors
    /// [`ReadError::Missing`], [`ReadError::Unreadable`].
    pub(crate) fn new(
        grid: &VolumeGrid,
        parts: Vec<Part>,
        slices_per_file: u32,
        decoder: Decoder,
    ) -> Result<Self, ReadError> {
        let open = match &parts[..] {
            [only] => Some(open(only)?),
            _ => None,
        };
        let [nx, ny, slices] = grid.dims();
        Ok(Self {
            parts,
            slices_per_file: slices_per_file.max(1),
            slice_voxels: u64::from(nx) * u64::from(ny),
            slices,
            decoder,
            open,
        })
    }

    fn check(&self, k: u32, out: &[i16]) -> Result<&Part, ReadError> {
        if out.len() as u64 != self.slice_voxels {
            return Err(ReadError::Buffer {
                slice: k,
                expected: self.slice_voxels,
                found: out.len(),
            });
        }
        let part = self.parts.get((k / self.slices_per_file) as usize);
        part.filter(|_| k < self.slices).ok_or(ReadError::Order {
            expected: self.slices.saturating_sub(1),
            found: k,
            count: self.slices,
        })
    }
}

impl SliceReader for PlainSlices {
    fn read(&self, k: u32, out: &mut [i16], scratch: &mut Scratch) -> Result<Conversion, ReadError> {
        let part = self.check(k, out)?;
        let opened;
        let file = match &self.open {
            Some(file) => file,
            None => {
                opened = open(part)?;
                &opened
            }
        };
        let mut decoder = self.decoder.clone();
        let bytes = decoder.sample.bytes();
        let within = u64::from(k % self.slices_per_file) * self.slice_voxels * bytes as u64;
        let mut byte = part.offset + within;
        scratch.bytes.resize(CHUNK_BYTES, 0);
        for voxels in out.chunks_mut(CHUNK_BYTES / bytes) {
            let chunk = scratch.bytes.get_mut(..voxels.len() * bytes).unwrap_or_default();
            file.read_exact_at(chunk, byte)
                .map_err(|source| failure(part, k, byte, chunk.len(), source))?;
            byte += chunk.len() as u64;
            decoder.decode(chunk, voxels);
        }
        Ok(decoder.conversion)
    }
}

fn open(part: &Part) -> Result<File, ReadError> {
    open_file(&part.path).map(|(file, _)| file)
}

/// The length was enough at the start: a short read means that somebody cut the file meanwhile.
fn failure(part: &Part, k: u32, byte: u64, wanted: usize, source: std::io::Error) -> ReadError {
    let (path, place) = (part.path.clone(), Place::Slice(k));
    if source.kind() == ErrorKind::UnexpectedEof {
        let found = std::fs::metadata(&path).map_or(byte, |about| about.len());
        return ReadError::Truncated {
            path,
            place,
            expected: byte + wanted as u64,
            found,
        };
    }
    ReadError::Unreadable {
        path,
        place,
        byte,
        source,
    }
}
