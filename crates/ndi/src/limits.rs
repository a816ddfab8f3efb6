//! How much a device may make a reader hold.

/// Bounds of what is read; they are checked before anything is allocated for it.
///
/// A decoder holds at most one text or one body, and makes room as its bytes come. Whatever is made of a body, with its
/// frames, is at most ten times its length and 4 MiB besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a text with its CRC. The longest of a device are those of TX with many strays (some 8 KiB) and of GET.
    pub text: usize,
    /// Bytes of a binary body. Short replies hold at most 65535; long ones are for sensor images.
    pub body: u32,
}

impl Limits {
    /// 64 KiB of text, bodies of 1 MiB.
    pub const DEFAULT: Self = Self {
        text: 64 << 10,
        body: 1 << 20,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Most tools of one frame or list, and lists of markers but one: handles of TX and BX have 8 bits.
pub const MOST_TOOLS: usize = 256;
/// Most tools that a session sets up.
pub const MOST_LOADED: usize = 24;
