//! Texts whose sender says in which character set they are.

use std::fmt;

use crate::name::shown;

/// The number of US-ASCII in IANA's list of character sets (MIBenum).
pub const US_ASCII: u16 = 3;
/// The number of UTF-8.
pub const UTF_8: u16 = 106;

/// A text as it came: its bytes, and the number of their character set (MIBenum of IANA).
///
/// It is shown as one line: what is not UTF-8 becomes U+FFFD, control characters are escaped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Text {
    /// MIBenum: [`US_ASCII`], [`UTF_8`] or another.
    pub encoding: u16,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Text {
    /// Of a Rust string: US-ASCII where it is, else UTF-8.
    pub fn new(text: &str) -> Self {
        Self {
            encoding: if text.is_ascii() { US_ASCII } else { UTF_8 },
            bytes: text.into(),
        }
    }

    /// As text, where its character set is US-ASCII or UTF-8 and its bytes are what that says.
    pub fn as_str(&self) -> Option<&str> {
        match self.encoding {
            US_ASCII | UTF_8 => std::str::from_utf8(&self.bytes)
                .ok()
                .filter(|text| self.encoding == UTF_8 || text.is_ascii()),
            _ => None,
        }
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(&self.bytes))
    }
}
