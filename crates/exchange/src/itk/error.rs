//! Why a transform is not read.

use geometry::rotation::RotationError;

use super::{MAX_BYTES, MAX_PARTS, MOST_OFF};

/// Why a transform is not read; the name of the file is the caller's to put before it. Transforms of a composite are counted from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ItkError {
    /// The file is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It is no transform of ITK.
    #[error("it begins with {found:?}; expected #Insight Transform File V1.0, or HDF5")]
    Head {
        /// Its beginning.
        found: String,
    },
    /// A line of the text is none that such a file has.
    #[error("line {line}: {found:?}; expected {expected}")]
    Line {
        /// Where.
        line: usize,
        /// What stands there.
        found: String,
        /// What could.
        expected: &'static str,
    },
    /// The HDF5 is damaged, or has not what ITK writes.
    #[error("HDF5: {what}: {why}")]
    Hdf5 {
        /// Which part.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// There is no transform in it, or a composite of none.
    #[error("there is no transform in it")]
    Empty,
    /// Transforms that no composite puts together.
    #[error("{found} transforms and no CompositeTransform: which of them holds is not said")]
    Several {
        /// How many.
        found: usize,
    },
    /// More transforms than anybody composes.
    #[error("more than {MAX_PARTS} transforms")]
    TooMany,
    /// A transform is of a kind that is not read.
    #[error(
        "transform {part} is a {found}; read are Euler3DTransform, VersorRigid3DTransform, VersorTransform, Similarity3DTransform, \
         AffineTransform, MatrixOffsetTransformBase, TranslationTransform, IdentityTransform in three dimensions and a CompositeTransform \
         of these, as far as they are rigid"
    )]
    Kind {
        /// Which.
        part: usize,
        /// Its kind.
        found: String,
    },
    /// It has another number of numbers than its kind.
    #[error("transform {part} ({kind}): {found} {what}; expected {expected}")]
    Count {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// `Parameters` or `FixedParameters`.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many its kind has.
        expected: &'static str,
    },
    /// A number is none, or beyond what can be a place in mm.
    #[error("transform {part} ({kind}): {found} among its numbers; finite numbers of at most 1e9 are allowed")]
    Number {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// The number.
        found: String,
    },
    /// An angle is beyond a whole turn: then it is in degrees, which ITK takes for radians.
    #[error(
        "transform {part} ({kind}): angles of {found:?}; radians of at most a whole turn, 6.283, are expected: these look like degrees"
    )]
    Angle {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// The three.
        found: [f64; 3],
    },
    /// A versor is longer than a rotation's.
    #[error("transform {part} ({kind}): a versor of length {length}; at most 1 is allowed")]
    Versor {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// The length.
        length: f64,
    },
    /// It turns a right hand into a left one, or flattens.
    #[error("transform {part} ({kind}): {why}")]
    Hand {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// Why it is none.
        why: RotationError,
    },
    /// All of a composite stretches or shears, though each part of it is nearly rigid.
    #[error(
        "the transforms of the composite together are not rigid: their product is {off:.2e} from the nearest rotation (at most {MOST_OFF:e}); \
         the lengths of its columns are {columns:.5?}"
    )]
    Composite {
        /// The Frobenius distance.
        off: f64,
        /// By how much it stretches along each axis.
        columns: [f64; 3],
    },
    /// It stretches or shears.
    #[error(
        "transform {part} ({kind}) is not rigid: its matrix is {off:.2e} from the nearest rotation (at most {MOST_OFF:e}); the lengths of \
         its columns are {columns:.5?}"
    )]
    NotRigid {
        /// Which.
        part: usize,
        /// Its kind.
        kind: String,
        /// The Frobenius distance.
        off: f64,
        /// By how much it stretches along each axis.
        columns: [f64; 3],
    },
}
