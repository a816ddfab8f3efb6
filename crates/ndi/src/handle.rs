//! The number by which a device knows a tool.

use std::fmt;

/// A port handle: 1 to 255 in texts and BX, 16 bits in BX2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle(pub u16);

impl Handle {
    /// In the place of a handle in the 3-D component of BX2: markers of no tool.
    pub const STRAY: Self = Self(0xFFFF);
}

/// As in commands: two hexadecimal digits, or four where they are needed.
impl fmt::Display for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X}", self.0)
    }
}
