//! Why a surface is not read.

use super::{MAX_BYTES, MAX_COUNT};
use crate::Unsettled;

/// Why a surface is not read; the name of the file is the caller's to put before it. Lines, points and polygons are counted from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The file is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It does not begin as such a file does.
    #[error("it begins with {found:?}; expected {expected}")]
    Head {
        /// Its beginning.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A word of a text is none that may stand there.
    #[error("line {line}: {found:?}; expected {expected}")]
    Word {
        /// Where.
        line: usize,
        /// What stands there; empty at the end of the file.
        found: String,
        /// What may.
        expected: &'static str,
    },
    /// A part of the format that is not read.
    #[error("{what} is not read; {instead}")]
    Unread {
        /// The part.
        what: String,
        /// What to do.
        instead: &'static str,
    },
    /// The file ends before what its head promises.
    #[error("{what}: {needed} bytes are promised and {left} are left: the file is cut off, or its head lies")]
    CutOff {
        /// What was being read.
        what: &'static str,
        /// How many bytes that takes.
        needed: u64,
        /// How many there are.
        left: usize,
    },
    /// There is more than the head promises.
    #[error("{left} bytes are left after all that the head promises: the head lies, or the file is of two")]
    TooMuch {
        /// How many.
        left: usize,
    },
    /// More points or triangles than any surface of a patient has.
    #[error("{found} {what}; at most {MAX_COUNT} are read")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        found: u64,
    },
    /// Polygons that do not begin with the first corner and end with the last.
    #[error("the polygons go from corner {first} to {last} of {corners}; expected all of them, from 0 to {corners}")]
    Offsets {
        /// Where the first begins.
        first: f64,
        /// Where the last ends.
        last: f64,
        /// How many corners there are.
        corners: usize,
    },
    /// A polygon that has no face.
    #[error("polygon {place} has {corners} corners; at least 3 are needed")]
    Polygon {
        /// Which.
        place: usize,
        /// How many it has.
        corners: usize,
    },
    /// A coordinate is none.
    #[error("point {point} is {found}; finite numbers are needed")]
    NotFinite {
        /// Which.
        point: usize,
        /// Its coordinates.
        found: String,
    },
    /// A triangle has a corner that is no point.
    #[error("triangle {triangle} has the corners {corners:?}; there are {count} points, the first of which is 0")]
    Corner {
        /// Which.
        triangle: usize,
        /// Its corners.
        corners: [u32; 3],
        /// How many points there are.
        count: usize,
    },
    /// There is no triangle.
    #[error("there is no triangle in it")]
    Empty,
    /// The comment says axes that nobody knows, or two that differ.
    #[error("the comment says SPACE={found}; RAS or LPS is read, once")]
    Space {
        /// What it says.
        found: String,
    },
    /// A comment says a frame that is neither.
    #[error("a comment says {found:?}; RAS or LPS is read, and what it says is not overruled")]
    Frame {
        /// What it says.
        found: String,
    },
    /// The comment says a unit that is not read, or two that differ.
    #[error(
        "a comment says the unit {found:?}; 1 mm and 1 m are read, and what it says is not overruled: write the surface in one of them"
    )]
    Unit {
        /// What it says.
        found: String,
    },
    /// Where the surface lies is not settled.
    #[error(transparent)]
    Unsettled(#[from] Unsettled),
    /// More points than STL's 32 bits hold, of a surface that is to be written.
    #[error("triangle {triangle} has a corner that is none of the {count} points, and the surface is not written")]
    Unwritable {
        /// Which.
        triangle: usize,
        /// How many points there are.
        count: usize,
    },
}
