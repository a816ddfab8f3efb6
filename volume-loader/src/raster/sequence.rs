//! The voxels of one file after another, in order.

use super::data::{Data, Encoding, Part};
use super::text::Words;
use super::trail;
use crate::source::{Place, ReadError};
use crate::stream::{Packing, Stream};
use crate::voxels::Decoder;

/// Bytes read at once: a whole number of voxels of any type.
const CHUNK_BYTES: usize = 1 << 16;

/// Reads slices strictly in order.
pub(crate) struct Sequence {
    parts: Vec<Part>,
    encoding: Encoding,
    slices_per_file: u32,
    part_bytes: u64,
    /// More bytes than these behind the last voxel are refused.
    most_behind: u64,
    remarks: Vec<String>,
    /// Unpacked bytes before the voxels of a compressed stream.
    skip: u64,
    packed_limit: u64,
    current: Option<Open>,
    chunk: Vec<u8>,
}

/// A file being read.
enum Open {
    Bytes { stream: Stream, end: u64 },
    Words(Words),
}

impl Sequence {
    /// Over files that have been found; none is open yet.
    pub(crate) fn new(data: &Data, parts: Vec<Part>) -> Self {
        Self {
            parts,
            encoding: data.encoding,
            slices_per_file: data.slices_per_file.max(1),
            part_bytes: data.part_bytes(),
            most_behind: trail::most(data.slice_bytes()),
            remarks: Vec::new(),
            skip: data.skip.bytes.unwrap_or(0),
            packed_limit: data.packed_limit,
            current: None,
            chunk: Vec::new(),
        }
    }

    /// Reads slice `k`, whose turn it is.
    ///
    /// # Errors
    /// [`ReadError`].
    pub(crate) fn slice(&mut self, k: u32, out: &mut [i16], decoder: &mut Decoder) -> Result<(), ReadError> {
        if k.is_multiple_of(self.slices_per_file) {
            self.close()?;
            let part = self.parts.get((k / self.slices_per_file) as usize);
            self.current = part.map(|part| self.open(part)).transpose()?;
        }
        let place = Place::Slice(k);
        let bytes = decoder.sample.bytes();
        self.chunk.resize(CHUNK_BYTES, 0);
        for part in out.chunks_mut(CHUNK_BYTES / bytes) {
            let chunk = self.chunk.get_mut(..part.len() * bytes).unwrap_or_default();
            match &mut self.current {
                Some(Open::Bytes { stream, end }) => stream.fill(chunk, place, *end)?,
                Some(Open::Words(words)) if self.encoding == Encoding::Hex => words.hex(chunk, place)?,
                Some(Open::Words(words)) => {
                    words.numbers(part, place, decoder)?;
                    continue;
                }
                // Parts cover all slices, and slices come in order: `Turn` saw to that.
                None => continue,
            }
            decoder.decode(chunk, part);
        }
        Ok(())
    }

    fn open(&self, part: &Part) -> Result<Open, ReadError> {
        let packing = match self.encoding {
            Encoding::Bytes(packing) => packing,
            Encoding::Text | Encoding::Hex => {
                let stream = Stream::open_at(&part.path, part.offset, u64::MAX, Packing::Plain)?;
                return Ok(Open::Words(Words::new(stream)));
            }
        };
        let limit = if packing == Packing::Plain {
            u64::MAX
        } else {
            self.packed_limit
        };
        let mut stream = Stream::open_at(&part.path, part.offset, limit, packing)?;
        let mut start = stream.position();
        if packing != Packing::Plain {
            start += self.skip;
        }
        let end = start.saturating_add(self.part_bytes);
        stream.skip_to(start, end)?;
        Ok(Open::Bytes { stream, end })
    }

    /// Reads the open file to its end, which checks what comes after the voxels.
    fn close(&mut self) -> Result<(), ReadError> {
        match self.current.take() {
            Some(Open::Bytes { mut stream, end }) => {
                let behind = stream.drain(self.most_behind)?;
                // What is known when the file is found was told then; and of many files one is enough.
                if stream.length().is_none() && self.remarks.is_empty() {
                    self.remarks = trail::packed(stream.path(), end, behind, stream.packed_behind());
                }
                Ok(())
            }
            Some(Open::Words(mut words)) => words.end(),
            None => Ok(()),
        }
    }

    /// What was found behind the voxels that have been read, of compressed files.
    pub(crate) fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// What can be checked only after the last slice.
    ///
    /// # Errors
    /// [`ReadError`].
    pub(crate) fn finish(&mut self) -> Result<(), ReadError> {
        self.close()
    }
}
