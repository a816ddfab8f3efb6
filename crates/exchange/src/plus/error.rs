//! Why a device set is not read, or has not what was asked for.

use geometry::rotation::RotationError;

use super::{MAX_BYTES, MAX_TRANSFORMS, MOST_OFF};

/// Why a device set is not read, or has not what was asked for; the name of the file is the caller's to put before it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlusError {
    /// The file is longer than any such file.
    #[error("the file has {bytes} bytes; at most {MAX_BYTES} are read")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It is not XML. Says line and column.
    #[error("not XML: {why}")]
    Xml {
        /// What is wrong.
        why: String,
    },
    /// It is other XML.
    #[error("found {found} CoordinateDefinitions in a <{root}>; expected one in a <PlusConfiguration>")]
    Other {
        /// The outermost element.
        root: String,
        /// How many it has.
        found: usize,
    },
    /// A transform lacks something, or has what it must not.
    #[error("line {line}: {key} of a Transform is {found}; expected {expected}")]
    Attribute {
        /// Where.
        line: u32,
        /// The attribute.
        key: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// An attribute says a unit or axes.
    #[error("line {line}: the attribute {key} is {found:?}, and nothing is read from it; expected {expected}")]
    Claim {
        /// Where.
        line: u32,
        /// The attribute.
        key: String,
        /// What it says.
        found: String,
        /// What is read.
        expected: &'static str,
    },
    /// A wire of the phantom lacks something, or has what it must not.
    #[error("line {line}: {key} of a Wire is {found}; expected {expected}")]
    Wire {
        /// Where.
        line: u32,
        /// The attribute.
        key: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// A scan conversion lacks something, or has what it must not.
    #[error("line {line}: {key} of a ScanConversion is {found}; expected {expected}")]
    Scan {
        /// Where.
        line: u32,
        /// The attribute.
        key: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// No phantom, or more wires than any has.
    #[error("{found} wires in its PhantomDefinition; 1 to {most} are read")]
    WireCount {
        /// How many there are.
        found: usize,
        /// How many are read.
        most: usize,
    },
    /// More transforms than any device set has.
    #[error("{found} transforms; at most {MAX_TRANSFORMS} are read")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// Nobody has this transform.
    #[error("there is no transform from {from:?} to {to:?}, nor back; there are {}", listed(.names))]
    Missing {
        /// The frame asked for.
        from: String,
        /// The other.
        to: String,
        /// Those that there are.
        names: Vec<String>,
    },
    /// It is there more than once.
    #[error("{name} is in the file more than once: which of them holds is not said")]
    Twice {
        /// Its name.
        name: String,
    },
    /// Both frames are one.
    #[error("from {name:?} to {name:?} there is nothing to be found: the tool's frame and the marker's are two")]
    Same {
        /// Its name.
        name: String,
    },
    /// The file has both ways, and they are not those there and back.
    #[error(
        "{name} and {back} contradict one another: there and back is {mm:.3} mm and {degrees:.3} degrees from where it began, and which of \
         them holds is not said"
    )]
    Contradicts {
        /// The one that was asked for.
        name: String,
        /// The other.
        back: String,
        /// How far apart the origins are.
        mm: f64,
        /// And the axes.
        degrees: f64,
    },
    /// It turns a right hand into a left one, or flattens.
    #[error("{name}: {why}")]
    Hand {
        /// Its name.
        name: String,
        /// Why it is none.
        why: RotationError,
    },
    /// It stretches or shears, as a calibration of an image's pixels does.
    #[error(
        "{name} is not rigid: its matrix is {off:.2e} from the nearest rotation (at most {MOST_OFF:e}); the lengths of its columns are \
         {columns:.5?}"
    )]
    NotRigid {
        /// Its name.
        name: String,
        /// The Frobenius distance.
        off: f64,
        /// By how much it stretches along each axis.
        columns: [f64; 3],
    },
}

fn listed(names: &[String]) -> String {
    match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    }
}
