//! Why a file of markups is not read.

use super::{MAX_BYTES, MAX_POINTS, MAX_VALUES};
use crate::Unsettled;

/// Why a file of markups is not read; the name of the file is the caller's to put before it. Markups and points are
/// counted from 1.
#[derive(Debug, thiserror::Error)]
pub enum MarkupsError {
    /// The file is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It has more values than are held.
    #[error("{found} commas, brackets and braces; at most {MAX_VALUES} are read")]
    TooManyValues {
        /// How many there are.
        found: usize,
    },
    /// A key is one of the schema's in other letters.
    #[error("{place} has the key {found:?}, which the schema writes {known:?}; what it says would be passed over")]
    Key {
        /// Whose it is.
        place: String,
        /// The key.
        found: String,
        /// That of the schema.
        known: &'static str,
    },
    /// A key that is not read says other axes or another unit than are taken.
    #[error(
        "{place} has the key {key:?}, which says {found}; its places would be taken along {axes} and in {unit}, and one of them is wrong: \
         nothing was taken. Write it where the schema has it, or take the key out"
    )]
    Claim {
        /// Whose it is.
        place: String,
        /// The key.
        key: String,
        /// What it says.
        found: String,
        /// The axes that would be taken.
        axes: &'static str,
        /// The unit that would be.
        unit: &'static str,
    },
    /// It is not JSON, also where a number is NaN, or a key is missing, there twice or of a wrong type.
    #[error("line {line}, column {column}: {why}")]
    Json {
        /// Where, counted from 1.
        line: usize,
        /// Where in it.
        column: usize,
        /// The beginning of what is wrong: a whole text of the file may be quoted in it.
        why: String,
    },
    /// It is of another schema.
    #[error("\"@schema\" is {found:?}; Slicer's markups-schema-v1.0.0 to v1.0.4 are read")]
    Schema {
        /// What it says.
        found: String,
    },
    /// A markup is of a kind that is not read.
    #[error("markup {markup} is of type {found:?}; read are Fiducial, Line, Angle, Curve and ClosedCurve")]
    Kind {
        /// Which.
        markup: usize,
        /// Its type.
        found: String,
    },
    /// A markup says axes that nobody knows.
    #[error("coordinateSystem of markup {markup} is {found}; allowed are \"LPS\" and \"RAS\"")]
    Axes {
        /// Which.
        markup: usize,
        /// What it says.
        found: String,
    },
    /// A markup says a unit other than mm.
    #[error("coordinateUnits of markup {markup} is {found}; \"mm\" alone is read, write the file in mm")]
    Unit {
        /// Which.
        markup: usize,
        /// What it says.
        found: String,
    },
    /// Where a markup lies is not settled.
    #[error("markup {markup}: {why}")]
    Unsettled {
        /// Which.
        markup: usize,
        /// Why.
        why: Unsettled,
    },
    /// A point has no place, or an orientation that is none.
    #[error("point {point} ({label:?}) of markup {markup}: {key} is {found}; expected {expected}")]
    Point {
        /// Which markup.
        markup: usize,
        /// Which of its points.
        point: usize,
        /// Its name.
        label: String,
        /// The key.
        key: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: String,
    },
    /// More points than anybody places.
    #[error("{found} control points; at most {MAX_POINTS} are read")]
    TooMany {
        /// How many there are.
        found: usize,
    },
}

impl From<serde_json::Error> for MarkupsError {
    fn from(error: serde_json::Error) -> Self {
        Self::Json {
            line: error.line(),
            column: error.column(),
            why: error.to_string().chars().take(160).collect(),
        }
    }
}
