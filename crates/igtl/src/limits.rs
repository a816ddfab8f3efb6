//! How much a peer may make a reader hold.

/// The longest body that anybody reads: what the C++ library's sockets carry in one message (2 GiB less 1 byte).
pub const MOST_BODY: u64 = (1 << 31) - 1;

/// Bounds of what is read; they are checked before anything is allocated for it.
///
/// A decoder holds at most 58 bytes and one body. Whatever is made of a body while it is decoded is at most twice its
/// content, and its metadata besides (of [`Limits::metadata_entries`] and [`Limits::metadata_bytes`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a body, at most [`MOST_BODY`]. A longer one closes the stream.
    pub body: u64,
    /// Entries of metadata.
    pub metadata_entries: u16,
    /// Bytes of all keys and values of the metadata.
    pub metadata_bytes: u32,
    /// Tools of a TDATA or QTDATA, points of a POINT, images of an IMGMETA, names of a CAPABILITY,
    /// attributes of a POLYDATA.
    pub elements: u32,
}

impl Limits {
    /// For a link that carries poses and words, no images: a body of 64 KiB.
    pub const POSES: Self = Self {
        body: 64 << 10,
        ..Self::VOLUMES
    };
    /// For a link that carries volumes too: a body of 512 MiB.
    pub const VOLUMES: Self = Self {
        body: 512 << 20,
        metadata_entries: 256,
        metadata_bytes: 64 << 10,
        elements: 4096,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::VOLUMES
    }
}
