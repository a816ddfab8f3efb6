//! Why an NRRD header was refused.

use geometry::GridError;

use crate::raster::NamesError;
use crate::source::KNOWN;

/// Why an NRRD header was refused. Lines count from 1; text from the file is cut to 80 characters, and text that could
/// name a patient (contents, labels, keys and values, lines that are nothing) is not repeated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NrrdError {
    /// The first line is not NRRD's.
    #[error("not an NRRD file: its first bytes are {found:02x?}, expected \"NRRD0001\" to \"NRRD0005\"; {KNOWN}")]
    Magic {
        /// The bytes.
        found: Vec<u8>,
    },
    /// A version that nobody has defined yet.
    #[error("line 1: NRRD version {found:?}, expected 0001 to 0005; write the file again as version 0004")]
    Version {
        /// The version.
        found: String,
    },
    /// The header does not end.
    #[error("the header has no end within {bytes} bytes: expected an empty line before the voxels")]
    Endless {
        /// Bytes looked at.
        bytes: usize,
    },
    /// The file ends with the header, and no other file is named.
    #[error(
        "the header ends at line {line} without an empty line and names no data file: the voxels are missing; copy the \
         file again from its origin"
    )]
    NoVoxels {
        /// The last line.
        line: usize,
    },
    /// A line that is neither field, comment nor key.
    #[error("line {line} ({bytes} bytes) is no field, comment or key: expected \"name: value\"")]
    Line {
        /// The line.
        line: usize,
        /// Its length.
        bytes: usize,
    },
    /// A field that the format does not have.
    #[error("line {line}: there is no field {found:?} in NRRD; correct or remove the line (keys are written with :=)")]
    Unknown {
        /// The line.
        line: usize,
        /// The field's name.
        found: String,
    },
    /// A field that is written as a key.
    #[error(
        "line {line}: {field} stands before :=, which makes it a key that nothing is read from; write `{field}: ...`, or take the line out"
    )]
    Key {
        /// The line.
        line: usize,
        /// The field.
        field: &'static str,
    },
    /// A field stands there twice.
    #[error("line {line}: {field} stands already in line {first}; remove one of them")]
    Duplicate {
        /// The second line.
        line: usize,
        /// The first line.
        first: usize,
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
    /// A list has too few entries, or too many.
    #[error("line {line}: {field} has {found} entries, expected {expected}")]
    Count {
        /// The line.
        line: usize,
        /// The field.
        field: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// An axis that holds no places: colours, vectors, time.
    #[error(
        "line {line}: axis {axis} is of kind {found:?}, expected \"domain\" or \"space\": this is not one scalar volume"
    )]
    Kind {
        /// The line.
        line: usize,
        /// The axis, from 0.
        axis: usize,
        /// Its kind.
        found: String,
    },
    /// The voxels are codes for other values.
    #[error(
        "line {line}: {field} says that the voxels were quantised: they are not HU; turn them back first (unu unquantize)"
    )]
    Quantised {
        /// The line.
        line: usize,
        /// The field.
        field: &'static str,
    },
    /// The header tells no directions in the patient.
    #[error(
        "the file has no orientation ({found}): refused rather than guess which side is left; if its axes are known to \
         be left, posterior, superior, say so (assume LPS)"
    )]
    NoOrientation {
        /// What there is.
        found: String,
    },
    /// The header tells directions but no place.
    #[error("the file has no space origin: its place in the patient is unknown; if 0 will do, say so (assume LPS)")]
    NoOrigin,
    /// Two fields about the distance of voxels disagree.
    #[error(
        "line {line}: the spacing of axis {axis} is {spacing}, but its space direction is {length} long; remove one"
    )]
    Disagreement {
        /// The line of the spacings.
        line: usize,
        /// The axis, from 0.
        axis: usize,
        /// Its spacing.
        spacing: f64,
        /// Its step's length, in the file's unit.
        length: f64,
    },
    /// The voxels' files cannot be named.
    #[error("line {line}: {source}")]
    Files {
        /// The line of the data file.
        line: usize,
        /// Why.
        source: NamesError,
    },
    /// Dimensions, spacing or axes that no scanner makes.
    #[error("{0}")]
    Grid(#[from] GridError),
}
