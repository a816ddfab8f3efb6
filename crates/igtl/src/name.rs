//! Names of a fixed number of bytes, padded with zeros: types, devices, tools, points.

use std::fmt;

/// A name as it lies on the wire: `N` bytes, those behind the first zero being none of it. A name of all `N` bytes has
/// no zero.
///
/// There are two kinds by what may stand in them. *Names* of types, devices, tools and frames are printable ASCII
/// (space to `~`), as the protocol says. *Labels* of points, images and patients are made by people in whatever
/// character set, so any byte but a control character may stand in them. Neither can end a line of a log or begin an
/// escape of a terminal.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Name<const N: usize>([u8; N]);

/// The name of a type of message.
pub type TypeName = Name<12>;
/// The name of a device, of a tool of TDATA or QTDATA, or of an image that owns points.
pub type DeviceName = Name<20>;

/// Why some text is no name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// It is longer than its field.
    #[error("{shown:?} has {found} bytes; a name here has at most {most}")]
    TooLong {
        /// The text.
        shown: String,
        /// Its length in bytes.
        found: usize,
        /// The field's.
        most: usize,
    },
    /// A byte of it must not stand in a name.
    #[error("byte {byte:#04x} at place {place} of {shown:?}; a name is of printable ASCII")]
    Byte {
        /// The text.
        shown: String,
        /// What was found.
        byte: u8,
        /// Where, from 0.
        place: usize,
    },
}

/// Which bytes may stand in a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Charset {
    /// Space to `~`.
    Ascii,
    /// Everything but control characters.
    Any,
}

impl Charset {
    pub(crate) fn admits(self, byte: u8) -> bool {
        let printable = byte >= 0x20 && byte != 0x7f;
        printable && (self == Self::Any || byte.is_ascii())
    }
}

impl<const N: usize> Name<N> {
    /// A name of no character.
    pub const EMPTY: Self = Self([0; N]);

    /// A name of printable ASCII.
    ///
    /// # Errors
    /// Where `text` is longer than `N` bytes, or holds anything else.
    pub fn new(text: &str) -> Result<Self, NameError> {
        Self::of(text, Charset::Ascii)
    }

    /// A label: UTF-8 without control characters.
    ///
    /// # Errors
    /// Where `text` is longer than `N` bytes, or holds a control character.
    pub fn label(text: &str) -> Result<Self, NameError> {
        Self::of(text, Charset::Any)
    }

    fn of(text: &str, charset: Charset) -> Result<Self, NameError> {
        let bytes = text.as_bytes();
        let mut field = [0; N];
        let Some(start) = field.get_mut(..bytes.len()) else {
            return Err(NameError::TooLong {
                shown: text.to_owned(),
                found: bytes.len(),
                most: N,
            });
        };
        start.copy_from_slice(bytes);
        match bytes.iter().position(|byte| !charset.admits(*byte)) {
            None => Ok(Self(field)),
            Some(place) => Err(NameError::Byte {
                shown: text.to_owned(),
                byte: bytes.get(place).copied().unwrap_or_default(),
                place,
            }),
        }
    }

    /// The name in a field of the wire, or the place and the byte that must not stand in it.
    pub(crate) fn from_wire(field: [u8; N], charset: Charset) -> Result<Self, (usize, u8)> {
        let mut name = Self(field);
        let length = name.as_bytes().len();
        // What senders leave behind the zero is nobody's.
        name.0.iter_mut().skip(length).for_each(|byte| *byte = 0);
        let wrong = |(_, byte): &(usize, &u8)| !charset.admits(**byte);
        match name.as_bytes().iter().enumerate().find(wrong) {
            None => Ok(name),
            Some((place, byte)) => Err((place, *byte)),
        }
    }

    /// The label in a field of the wire; what may not stand in one becomes `?`.
    pub(crate) fn scrubbed(mut field: [u8; N]) -> Self {
        let end = field.iter().position(|byte| *byte == 0).unwrap_or(N);
        for (at, byte) in field.iter_mut().enumerate() {
            *byte = match at < end {
                true if Charset::Any.admits(*byte) => *byte,
                true => b'?',
                false => 0,
            };
        }
        Self(field)
    }

    /// Its bytes, without the zeros behind it.
    pub fn as_bytes(&self) -> &[u8] {
        self.0.split(|byte| *byte == 0).next().unwrap_or_default()
    }

    /// All bytes of the field.
    pub(crate) const fn field(&self) -> &[u8; N] {
        &self.0
    }

    /// As text, where it is UTF-8; names always are.
    pub fn as_str(&self) -> Option<&str> {
        std::str::from_utf8(self.as_bytes()).ok()
    }

    /// Whether there is no character.
    pub fn is_empty(&self) -> bool {
        self.as_bytes().is_empty()
    }
}

impl<const N: usize> Default for Name<N> {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl<const N: usize> fmt::Display for Name<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&shown(self.as_bytes()))
    }
}

impl<const N: usize> fmt::Debug for Name<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&shown(self.as_bytes()), f)
    }
}

impl<const N: usize> PartialEq<str> for Name<N> {
    fn eq(&self, other: &str) -> bool {
        self.as_bytes() == other.as_bytes()
    }
}

impl<const N: usize> PartialEq<&str> for Name<N> {
    fn eq(&self, other: &&str) -> bool {
        self == *other
    }
}

/// Any bytes as one line of text that a terminal and a log may be given: what is not UTF-8 becomes U+FFFD, control
/// characters (and those that turn the direction of writing) are escaped.
pub(crate) fn shown(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let mut line = String::with_capacity(text.len());
    for character in text.chars() {
        let turns = matches!(character, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if character.is_control() || turns {
            line.extend(character.escape_default());
        } else {
            line.push(character);
        }
    }
    line
}
