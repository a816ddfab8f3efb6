//! Why a MetaImage header was refused.

use geometry::GridError;

use crate::raster::NamesError;
use crate::source::KNOWN;

/// Why a MetaImage header was refused. Lines count from 1; text from the file is cut to 80 characters, and text that could
/// name a patient (comments, names, fields of other programs, lines that are nothing) is not repeated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MetaImageError {
    /// No field of a MetaImage comes first.
    #[error(
        "not a MetaImage file: line 1 is no \"name = value\", expected \"ObjectType = Image\" or another field; {KNOWN}"
    )]
    NotMetaImage,
    /// A line that is not a field.
    #[error("line {line} ({bytes} bytes) is no field: expected \"name = value\"")]
    Line {
        /// The line.
        line: usize,
        /// Its length.
        bytes: usize,
    },
    /// The header does not end.
    #[error("the header has no end within {bytes} bytes: expected ElementDataFile as its last field")]
    Endless {
        /// Bytes looked at.
        bytes: usize,
    },
    /// A field stands there twice and says different things.
    #[error("line {line}: {field} says something else than line {first}; remove one of them")]
    Duplicate {
        /// The second line.
        line: usize,
        /// The first line.
        first: usize,
        /// The field.
        field: &'static str,
    },
    /// A field in other letters than the format's, in which it would be passed over.
    #[error(
        "line {line}: {field} is written in other letters, in which no program reads it; write {field}, or take the line out"
    )]
    Letters {
        /// The line.
        line: usize,
        /// The field.
        field: &'static str,
    },
    /// A field that is needed is missing.
    #[error("the header has no {field}; expected {expected}")]
    Missing {
        /// The field.
        field: &'static str,
        /// What it should say.
        expected: &'static str,
    },
    /// A field says something unusable.
    #[error("line {line}: {field} is {found:?}, expected {expected}")]
    Value {
        /// The line.
        line: usize,
        /// The field.
        field: &'static str,
        /// Its text.
        found: String,
        /// What would do.
        expected: &'static str,
    },
    /// The matrix or the origin is missing.
    #[error(
        "the file has no {field}: refused rather than guess which side is left; if its axes are known to be left, \
         posterior, superior and its origin 0, say so (assume LPS)"
    )]
    NoOrientation {
        /// The field.
        field: &'static str,
    },
    /// A direction is not of length 1.
    #[error("line {line}: the direction of axis {axis} is {length} long, expected 1: lengths belong in ElementSpacing")]
    Length {
        /// The line.
        line: usize,
        /// The axis, from 0.
        axis: usize,
        /// The direction's length.
        length: f64,
    },
    /// The voxels' files cannot be named.
    #[error("line {line}: {source}")]
    Files {
        /// The line of `ElementDataFile`.
        line: usize,
        /// Why.
        source: NamesError,
    },
    /// Dimensions, spacing or axes that no scanner makes.
    #[error("{0}")]
    Grid(#[from] GridError),
}
