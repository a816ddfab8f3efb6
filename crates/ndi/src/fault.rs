//! What may be wrong with what came, by name, with what was found and what is allowed.

/// One thing that is wrong with a reply or a command.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The bytes end in the middle of a reply.
    #[error("the reply ends after {found} bytes; it needs {needed}")]
    Truncated {
        /// Bytes that are there.
        found: u64,
        /// Bytes of the whole, as far as is known.
        needed: u64,
    },
    /// A byte that no text of the device has: a stream that lost its place, or another program.
    #[error("byte {byte:#04x} in a text; allowed are printable ASCII and line feeds")]
    Byte {
        /// What was found.
        byte: u8,
    },
    /// A text that does not end.
    #[error("a text of more than {most} bytes")]
    TextLimit {
        /// The bound.
        most: u64,
    },
    /// A text too short to hold its CRC.
    #[error("a text of {found} characters; it must have at least the 4 of its CRC")]
    TextShort {
        /// Without its carriage return.
        found: u64,
    },
    /// A text that is not what was sent.
    #[error("the text has CRC {computed:04X}; it says {found:04X}")]
    TextCrc {
        /// At its end.
        found: u16,
        /// Of the text as it came.
        computed: u16,
    },
    /// The length of a binary reply cannot be believed.
    #[error("the header has CRC {computed:04X}; it says {found:04X}")]
    HeaderCrc {
        /// In the header.
        found: u16,
        /// Of start sequence and length as they came.
        computed: u16,
    },
    /// A longer body than this reader takes.
    #[error("a body of {found} bytes; allowed are {most}")]
    BodyLimit {
        /// What the header says.
        found: u64,
        /// The bound.
        most: u64,
    },
    /// A body that is not what was sent.
    #[error("the body has CRC {computed:04X}; it says {found:04X}")]
    BodyCrc {
        /// Behind the body.
        found: u16,
        /// Of the body as it came.
        computed: u16,
    },
    /// The device broke off a binary reply and said why.
    #[error("ERROR{code:02X} stands in the middle of a binary reply")]
    ErrorInside {
        /// The device's number of the error.
        code: u8,
    },
    /// A character that is no hexadecimal digit.
    #[error("byte {byte:#04x} in {field}; allowed are hexadecimal digits")]
    NotHex {
        /// Where.
        field: &'static str,
        /// What was found.
        byte: u8,
    },
    /// A character that is in no decimal number of a fixed length.
    #[error("byte {byte:#04x} in {field}; allowed are a sign and digits")]
    NotDecimal {
        /// Where.
        field: &'static str,
        /// What was found.
        byte: u8,
    },
    /// Something else than what must stand here.
    #[error("{found:?} where {field} must stand; allowed: {allowed}")]
    Word {
        /// What should be there.
        field: &'static str,
        /// What is there, shortened.
        found: String,
        /// What may be there.
        allowed: &'static str,
    },
    /// A field that reaches beyond what it stands in.
    #[error("{field} needs {needed} bytes; {found} are left")]
    Ends {
        /// Which.
        field: &'static str,
        /// What it needs.
        needed: u64,
        /// What is left.
        found: u64,
    },
    /// Bytes behind the last field.
    #[error("{found} bytes are left over behind {field}")]
    Trailing {
        /// Behind what.
        field: &'static str,
        /// How many.
        found: u64,
    },
    /// More than there is room for, or than a device has.
    #[error("{found} {what}; allowed are {most}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        found: u64,
        /// The bound.
        most: u64,
    },
    /// A component shorter than its own header.
    #[error("a component of {found} bytes; its header alone has 12")]
    ComponentSize {
        /// What it says of itself.
        found: u32,
    },
    /// Containers in containers: a device has frames, and in them data.
    #[error("a container {found} deep; allowed are {most}")]
    Nested {
        /// How deep.
        found: u64,
        /// The bound.
        most: u64,
    },
    /// A format that is not known.
    #[error("version {found} of the general binary format; allowed is 1")]
    GbfVersion {
        /// What stands there.
        found: u16,
    },
    /// A time that is none.
    #[error("{found} nanoseconds; allowed are less than 1000000000")]
    Nanoseconds {
        /// What stands there.
        found: u32,
    },
    /// One tool twice in a frame: nobody can say which holds.
    #[error("handle {handle:02X} twice in one frame; each may stand once")]
    Twice {
        /// Which.
        handle: u16,
    },
}

/// Some bytes as a short word for a message: printable ASCII, the rest as `?`.
pub(crate) fn shown(bytes: &[u8]) -> String {
    const MOST: usize = 24;
    let shown = |byte: &u8| {
        if (0x20..0x7f).contains(byte) {
            char::from(*byte)
        } else {
            '?'
        }
    };
    bytes.iter().take(MOST).map(shown).collect()
}
