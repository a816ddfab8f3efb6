//! What can be wrong with the pairs in a file.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::input_files::fields::{BadNumber, MAX_MM};
use crate::input_files::source::SourceError;

/// What a header must look like, for errors.
const HEADER_HINT: &str = "The first line names the columns, in any order: from_x,from_y,from_z,to_x,to_y,to_z and, optionally, weight and label";

/// The most pairs: leave-one-out residuals take the square of the number.
pub(crate) const MAX_PAIRS: usize = 10_000;

/// Points of a patient are further apart than this, mm: in metres a whole one is not.
pub(crate) const LEAST_EXTENT_MM: f64 = 5.0;

/// A field of a file.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub(crate) path: PathBuf,
    pub(crate) line: usize,
    /// Characters, counted from 1.
    pub(crate) column: usize,
    /// What the field means, for instance `to_y`.
    pub(crate) name: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            path,
            line,
            column,
            name,
        } = self;
        write!(f, "{}, line {line}, column {column} ({name})", path.display())
    }
}

/// Why a file gave no pairs. Lines and columns count from 1.
#[derive(Debug, thiserror::Error)]
pub(crate) enum InputError {
    /// The file could not be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// There are only comments and blank lines, or only the header.
    #[error("reading {path}: there are no {what} in it, only {only}")]
    NoRows {
        path: PathBuf,
        what: &'static str,
        only: &'static str,
    },
    /// A column that must be there is not.
    #[error("reading {path}: line {line}: the header has no column {missing}; found {found}. {HEADER_HINT}")]
    MissingColumn {
        path: PathBuf,
        line: usize,
        missing: String,
        found: String,
    },
    /// A column whose name means nothing, as a misspelt one would.
    #[error("reading {place}: this column is not known. {HEADER_HINT}")]
    UnknownColumn { place: Place },
    /// Two columns have one name.
    #[error("reading {place}: this column is there a second time; leave one")]
    RepeatedColumn { place: Place },
    /// `--weights` without weights.
    #[error("reading {path}: --weights needs a column weight, and the header (line {line}) has none")]
    NoWeightColumn { path: PathBuf, line: usize },
    /// A row with more or fewer fields.
    #[error("reading {path}: line {line}, column {column}: {found} fields, expected {expected} ({names})")]
    Ragged {
        path: PathBuf,
        line: usize,
        /// Of the first field too many, or the end of the line.
        column: usize,
        found: usize,
        expected: usize,
        names: String,
    },
    /// A quote that does not close.
    #[error(
        "reading {path}: line {line}, column {column}: the quoted field does not end in a quote and a comma; a quote \
         within quotes is doubled"
    )]
    BadQuote { path: PathBuf, line: usize, column: usize },
    /// A field that is no number.
    #[error("reading {place}: found {found:?}, expected a number{}", in_mm(.place))]
    NotANumber { place: Place, found: String },
    /// NaN, an infinity, or a number too large for one.
    #[error("reading {place}: found {found:?}, which is not finite; leave the pair out if the point was not measured")]
    NotFinite { place: Place, found: String },
    /// A coordinate that cannot be in mm.
    #[error("reading {place}: found {found:?}, at most {MAX_MM:e} mm is allowed; is the file in millimetres?")]
    TooLarge { place: Place, found: String },
    /// A weight below zero.
    #[error("reading {place}: found {found:?}, a weight must be at least 0 (0 leaves the pair out)")]
    NegativeWeight { place: Place, found: String },
    /// Nothing weighs anything.
    #[error("reading {path}: the weights of all {pairs} pairs are zero; give at least 3 pairs a weight above zero")]
    NoWeight { path: PathBuf, pairs: usize },
    /// More rows than are taken.
    #[error("reading {path}: line {line} begins pair {}, at most {MAX_PAIRS} are taken; thin the set out", MAX_PAIRS + 1)]
    TooMany { path: PathBuf, line: usize },
    /// Two files of different length.
    #[error(
        "pairing {to_path} with {from_path}: {to} points in the first and {from} in the second; line by line each \
         point needs its partner"
    )]
    Unpaired {
        to_path: PathBuf,
        from_path: PathBuf,
        to: usize,
        from: usize,
    },
    /// What a touch says of its error is of the point of FROM alone.
    #[error(
        "reading {path}: it has the columns of touches (cxx to czz) as --to-points, and does not say that they are in the frame of --to; \
         give touches as --from-points, and as --to-points plain points"
    )]
    TouchesAsTo { path: PathBuf },
    /// Points that cannot be a patient's in mm.
    #[error(
        "reading {files}: the box around the {side} points is {extent_mm:.3} mm across, expected at least {LEAST_EXTENT_MM} mm; are they in metres? \
         Give them in millimetres"
    )]
    TooSmall {
        files: String,
        side: &'static str,
        extent_mm: f64,
    },
    /// A point that the CT does not show.
    #[error(
        "reading {path}: line {line}: the point {found:?} of the CT lies outside it; expected one within {low:.1?} to {high:.1?} mm (left, posterior, \
         superior). Are its axes and its unit those of the CT?"
    )]
    OutsideCt {
        path: PathBuf,
        line: usize,
        found: [f64; 3],
        low: [f64; 3],
        high: [f64; 3],
    },
    /// A pair is there twice, to the last digit.
    #[error(
        "reading {path}: lines {first} and {second} hold the same pair to the last digit, which would count twice; \
         delete one, or say --allow-duplicates"
    )]
    DuplicatePair { path: PathBuf, first: usize, second: usize },
    /// A point is paired with two different ones.
    #[error(
        "reading {path}: lines {first} and {second} hold the same {side} point {point:?} with different partners; if \
         it was measured twice, say --allow-duplicates, else correct one"
    )]
    DuplicatePoint {
        path: PathBuf,
        side: &'static str,
        point: [f64; 3],
        first: usize,
        second: usize,
    },
}

fn in_mm(place: &Place) -> &'static str {
    if place.name == "weight" {
        return " of at least 0";
    }
    " in mm, with a point for the decimals"
}

impl InputError {
    /// For what a field was found to hold.
    pub(crate) fn number(bad: BadNumber, place: Place, found: &str) -> Self {
        // What is quoted stays short, whatever the file holds.
        let found: String = found.chars().take(40).collect();
        match bad {
            BadNumber::NotANumber => Self::NotANumber { place, found },
            BadNumber::NotFinite => Self::NotFinite { place, found },
            BadNumber::TooLarge => Self::TooLarge { place, found },
            BadNumber::Negative => Self::NegativeWeight { place, found },
        }
    }

    pub(crate) fn too_many(path: &Path, line: usize) -> Self {
        let path = path.to_owned();
        Self::TooMany { path, line }
    }
}
