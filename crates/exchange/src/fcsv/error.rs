//! Why a list of fiducials is not read, or not written.

use super::{COLUMNS, MAX_BYTES, MAX_POINTS};
use crate::Unsettled;

/// Why a list of fiducials is not read, or not written; the name of the file is the caller's to put before it. Lines
/// are counted from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FcsvError {
    /// The file is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It is not text.
    #[error("line {line}: not UTF-8 text")]
    NotText {
        /// Where.
        line: usize,
    },
    /// It does not say its version, or another than is read.
    #[error("# Markups fiducial file version: found {found}; Slicer's versions 4 and 5 are read")]
    Version {
        /// What it says.
        found: String,
    },
    /// A line of its head says what is not allowed, or says it a second time.
    #[error("line {line}: {key} is {found:?}; expected {expected}")]
    Head {
        /// Where.
        line: usize,
        /// What the line says.
        key: &'static str,
        /// How.
        found: String,
        /// What is allowed.
        expected: &'static str,
    },
    /// It does not say its columns.
    #[error("there is no line `# columns = {COLUMNS}`: which column is which is not said")]
    NoColumns,
    /// A carriage return stands where no line of such a file has one.
    #[error(
        "line {line}: a carriage return in the middle of it; lines end with a line feed, with or without a carriage return before it"
    )]
    LineEnd {
        /// Where.
        line: usize,
    },
    /// A point has another number of columns than the head says.
    #[error(
        "line {line}: {found} columns; expected the 14 of {COLUMNS}, or these and two whole numbers more. A comma in a name is written \"in quotes\""
    )]
    Columns {
        /// Where.
        line: usize,
        /// How many there are.
        found: usize,
    },
    /// A quote that nothing ends.
    #[error("line {line}: a quotation mark begins a name and none ends it")]
    Quote {
        /// Where.
        line: usize,
    },
    /// A column holds what it must not.
    #[error("line {line}: {column} is {found:?}; expected {expected}")]
    Value {
        /// Where.
        line: usize,
        /// Which column.
        column: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// More points than anybody places.
    #[error("line {line}: more than {MAX_POINTS} points")]
    TooMany {
        /// Where that is.
        line: usize,
    },
    /// Where the points lie is not settled.
    #[error(transparent)]
    Unsettled(#[from] Unsettled),
    /// A name cannot stand in a line.
    #[error("the name {name:?} has control characters, and a line of this format cannot hold them; write .mrk.json")]
    Unwritable {
        /// The name.
        name: String,
    },
}
