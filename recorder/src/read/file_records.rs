//! The records of a file from start to end, chunks unopened, each with its place.

use std::io::Read;

use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use crate::read::chunk::{MAX_RECORD, RawRecord};
use crate::read::damage::Fault;

/// A length from the file is believed by this many bytes at a time.
const PIECE: usize = 1 << 16;

/// Reads the records of a file.
pub(crate) struct FileRecords<R> {
    input: R,
    reader: LinearReader,
    /// Bytes of the whole file.
    length: u64,
    at: u64,
}

impl<R: Read> FileRecords<R> {
    /// Reads `length` bytes of `input`, which is at its start.
    pub(crate) fn new(input: R, length: u64) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(MAX_RECORD);
        Self {
            input,
            reader: LinearReader::new_with_options(options),
            length,
            at: MAGIC.len() as u64,
        }
    }

    /// Reads what lies behind byte `at` of a file of `length` bytes; `input` is there already, and a record starts there.
    /// The sums over the file's whole sections cannot be checked from its middle.
    pub(crate) fn from_middle(input: R, length: u64, at: u64) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_emit_chunks(true)
            .with_record_length_limit(MAX_RECORD);
        Self {
            input,
            reader: LinearReader::new_with_options(options),
            length,
            at,
        }
    }

    /// Bytes of the whole file.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// Where the next record starts, bytes from the start of the file.
    pub(crate) fn at(&self) -> u64 {
        self.at
    }

    /// The next record; `None` at the end of a whole file.
    pub(crate) fn next(&mut self) -> Result<Option<RawRecord>, Fault> {
        while let Some(event) = self.reader.next_event() {
            match event {
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    self.at += 1 + 8 + data.len() as u64;
                    return Ok(Some((opcode, data.to_vec())));
                }
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let read = self.input.read(self.reader.insert(wanted.min(PIECE)))?;
                    self.reader.notify_read(read);
                }
                Err(McapError::UnexpectedEof) => return Err(self.ending()),
                Err(error) => return Err(Fault::Framing(error)),
            }
        }
        match self.length.saturating_sub(self.at + MAGIC.len() as u64) {
            0 => Ok(None),
            found => Err(Fault::Behind { found }),
        }
    }

    fn ending(&self) -> Fault {
        match self.length.saturating_sub(self.at) {
            0 => Fault::Unfinished,
            found => Fault::CutOff { found },
        }
    }
}
