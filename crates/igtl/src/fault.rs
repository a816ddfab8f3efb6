//! What may be wrong with a message, by name, with the number that was found and what is allowed.

use std::fmt;

/// One thing that is wrong, in what came from a peer or in what is to be sent to one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The bytes end in the middle of a message.
    #[error("the message ends after {found} bytes; it needs {needed}")]
    Truncated {
        /// Bytes that are there.
        found: u64,
        /// Bytes of the whole message, as far as is known: those of the header, or of header and body.
        needed: u64,
    },
    /// The peer speaks another protocol.
    #[error("the first bytes are those of {0}; this is a port of OpenIGTLink")]
    Protocol(&'static str),
    /// A header of a version that is neither 1 nor 2; nothing tells where the next message begins.
    #[error("header version {found}; allowed are 1 and 2")]
    Version {
        /// What stands in the header.
        found: u16,
    },
    /// A longer body than this reader takes.
    #[error("a body of {found} bytes; allowed are {most}")]
    BodyLimit {
        /// What the header says.
        found: u64,
        /// The bound.
        most: u64,
    },
    /// A type that is empty or not printable ASCII: most likely no header at all.
    #[error("byte {byte:#04x} in the name of the type; allowed is printable ASCII")]
    TypeName {
        /// What was found; 0 where the name is empty.
        byte: u8,
    },
    /// A name that must not stand in a log.
    #[error("byte {byte:#04x} in {field}; allowed is {allowed}")]
    NameByte {
        /// Which name.
        field: &'static str,
        /// What was found.
        byte: u8,
        /// What may stand there.
        allowed: &'static str,
    },
    /// The body is not what was sent.
    #[error("the body has CRC {computed:016x}; its header says {found:016x}")]
    Crc {
        /// Of the header.
        found: u64,
        /// Of the body as it came.
        computed: u64,
    },
    /// A content that is too short or too long for its type.
    #[error("a content of {found} bytes; {rule}")]
    Size {
        /// Its bytes, without extended header and metadata.
        found: u64,
        /// What this type allows.
        rule: SizeRule,
    },
    /// An extended header that is too short, or does not fit into the body.
    #[error("an extended header of {found} bytes; allowed are {least} to {most}")]
    ExtendedHeader {
        /// What it says of itself.
        found: u64,
        /// 12.
        least: u64,
        /// The body.
        most: u64,
    },
    /// Extended header and metadata are longer than the body.
    #[error("metadata of {found} bytes; {most} are left of the body")]
    MetadataSize {
        /// Index and values, as the extended header says.
        found: u64,
        /// What is left of the body.
        most: u64,
    },
    /// The index of the metadata has another length than its entries need.
    #[error("a metadata index of {found} bytes; {count} entries have one of {needed}")]
    MetadataIndex {
        /// Bytes, as the extended header says.
        found: u64,
        /// Entries, as the index says.
        count: u16,
        /// Two bytes, and eight for each.
        needed: u64,
    },
    /// A key or a value that reaches beyond the metadata, or bytes behind the last.
    #[error("keys and values of {found} bytes in metadata of {allowed}")]
    MetadataSpan {
        /// By the index.
        found: u64,
        /// By the extended header.
        allowed: u64,
    },
    /// More than this reader takes.
    #[error("{found} {what}; allowed are {most}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        found: u64,
        /// The bound.
        most: u64,
    },
    /// A key twice, or a tool twice: nobody can say which of them holds. Long names that are cut to 20 bytes become
    /// equal.
    #[error("{what} {shown:?} twice; each may stand once")]
    Twice {
        /// What is named.
        what: &'static str,
        /// The name.
        shown: String,
    },
    /// A text that reaches beyond its content, or leaves bytes behind it.
    #[error("a text of {found} bytes in a place of {allowed}")]
    TextLength {
        /// What its length says.
        found: u64,
        /// The bytes that are there, or the most that its length can say.
        allowed: u64,
    },
    /// A number that is none.
    #[error("{value} in {field}; allowed are finite numbers")]
    NotFinite {
        /// Which number.
        field: &'static str,
        /// NaN, inf or -inf.
        value: &'static str,
    },
    /// A number that means nothing in its place.
    #[error("{field} is {found}; allowed: {allowed}")]
    Value {
        /// Which number.
        field: &'static str,
        /// What was found.
        found: u64,
        /// What may stand there.
        allowed: &'static str,
    },
    /// An image without a voxel.
    #[error("an image of {} x {} x {} voxels; each must be at least 1", .0[0], .0[1], .0[2])]
    Dimensions([u16; 3]),
    /// A part of an image that does not lie inside it.
    #[error("a part at {offset:?} of {size:?} voxels; the image has {dimensions:?}")]
    Subvolume {
        /// Its first voxel.
        offset: [u16; 3],
        /// Its voxels.
        size: [u16; 3],
        /// The image's.
        dimensions: [u16; 3],
    },
    /// An index of a point that is not there.
    #[error("point {found} of a surface with {points} points")]
    PointIndex {
        /// From 0.
        found: u32,
        /// How many there are.
        points: u32,
    },
    /// Cells that do not fill their list.
    #[error("{field} of {found} cells; the list is said to have {said}")]
    Cells {
        /// Which list.
        field: &'static str,
        /// Whole cells in it.
        found: u64,
        /// What the header says.
        said: u64,
    },
    /// Metadata or a message number for a peer that reads headers of version 1 only.
    #[error("metadata and message numbers need a header of version 2")]
    NeedsVersionTwo,
}

/// How long a content may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeRule {
    /// This long.
    Exactly(u64),
    /// One of these.
    OneOf(&'static [u64]),
    /// So many elements of this length, none included.
    MultipleOf(u64),
    /// This long or longer.
    AtLeast(u64),
}

impl SizeRule {
    /// Whether a content of `size` bytes keeps the rule.
    pub fn admits(self, size: u64) -> bool {
        match self {
            Self::Exactly(one) => size == one,
            Self::OneOf(some) => some.contains(&size),
            Self::MultipleOf(element) => size.is_multiple_of(element),
            Self::AtLeast(least) => size >= least,
        }
    }
}

impl fmt::Display for SizeRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(one) => write!(f, "it must have {one}"),
            Self::OneOf(some) => write!(f, "it must have one of {some:?}"),
            Self::MultipleOf(element) => write!(f, "it must be a multiple of {element}"),
            Self::AtLeast(least) => write!(f, "it must have at least {least}"),
        }
    }
}

/// The word for a number that is not finite; `None` for all others.
pub(crate) fn not_finite(value: f64) -> Option<&'static str> {
    if value.is_finite() {
        None
    } else if value.is_nan() {
        Some("NaN")
    } else if value > 0.0 {
        Some("inf")
    } else {
        Some("-inf")
    }
}
