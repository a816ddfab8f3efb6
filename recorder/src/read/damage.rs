//! Where and why a file could not be read.

use std::io;
use std::path::PathBuf;

use mcap::McapError;
use mcap::records::op;

use crate::read::lost::Lost;

/// A place in a file that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("at byte {at}: {fault}{}", .lost.as_ref().map_or(String::new(), ToString::to_string))]
pub struct Damage {
    /// Where the unreadable record starts, bytes from the start of the file.
    pub at: u64,
    /// What is wrong there.
    pub fault: Fault,
    /// Whether nothing behind it could be read.
    pub stops: bool,
    /// The messages that it held, for a chunk.
    pub lost: Option<Box<Lost>>,
}

/// What is wrong at a place in a file.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The file ends where the next record would start.
    #[error("the file ends here, without an index: its recording was never finished")]
    Unfinished,
    /// The file ends within a record.
    #[error("the file ends within a record: only its first {found} bytes are there")]
    CutOff {
        /// Bytes between the start of the record and the end of the file.
        found: u64,
    },
    /// More lies behind the end of a whole file.
    #[error("the file goes on behind its end by {found} bytes, which are not read: another recording, or none")]
    Behind {
        /// Bytes behind the end.
        found: u64,
    },
    /// A record cannot be read.
    #[error("damaged {record}: {source}")]
    Record {
        /// What kind of record.
        record: &'static str,
        /// mcap's words.
        source: McapError,
    },
    /// Nothing behind this place can be told apart.
    #[error("damaged: {0}")]
    Framing(McapError),
    /// A length that the record has no room for.
    #[error("damaged {record}: its parts ask for more than its {found} bytes")]
    Length {
        /// What kind of record.
        record: &'static str,
        /// Bytes of the record.
        found: u64,
    },
    /// A message of a channel that was never declared.
    #[error("a message of channel {channel}, which is not declared before it")]
    UnknownChannel {
        /// Its number.
        channel: u16,
    },
    /// The disk failed.
    #[error("reading: {0}")]
    Io(#[from] io::Error),
}

impl Fault {
    /// Whether this is how a kill leaves a file, and no sign of anything worse.
    pub fn is_mere_ending(&self) -> bool {
        matches!(self, Self::Unfinished | Self::CutOff { .. })
    }
}

/// Why nothing at all can be read.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file cannot be opened.
    #[error("opening {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something else than a recording.
    #[error(
        "{path} is not an MCAP file: it starts with {found:02x?} instead of {:02x?}",
        mcap::MAGIC
    )]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// Its first bytes, at most 8.
        found: Vec<u8>,
    },
}

/// A record's kind in words.
pub(crate) fn record_name(opcode: u8) -> &'static str {
    match opcode {
        op::HEADER => "header",
        op::FOOTER => "footer",
        op::SCHEMA => "schema",
        op::CHANNEL => "channel",
        op::MESSAGE => "message",
        op::CHUNK => "chunk",
        op::MESSAGE_INDEX => "message index",
        op::CHUNK_INDEX => "chunk index",
        op::ATTACHMENT => "attachment",
        op::ATTACHMENT_INDEX => "attachment index",
        op::STATISTICS => "statistics",
        op::METADATA => "metadata",
        op::METADATA_INDEX => "metadata index",
        op::SUMMARY_OFFSET => "summary offset",
        op::DATA_END => "end of data",
        _ => "record of an unknown kind",
    }
}
