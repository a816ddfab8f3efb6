//! The bytes of a header, and the numbers in them; nothing is judged here but what tells a header from other bytes.

use super::error::HeaderError;

/// Bytes of a NIfTI-1 header, without the four that announce extensions.
pub(crate) const BYTES_1: usize = 348;
/// Bytes of a NIfTI-2 header.
pub(crate) const BYTES_2: usize = 540;
/// NIfTI-2's magic: the last four bytes tell a file mangled as text.
const MAGIC_2: &[u8; 8] = b"n+2\0\r\n\x1a\n";

/// NIfTI's version and byte order: how to find numbers in the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// 1 or 2.
    pub version: u8,
    /// Most significant byte first.
    pub big_endian: bool,
}

impl Layout {
    /// The layout whose header's length the file's first four bytes hold.
    ///
    /// # Errors
    /// [`HeaderError::NotNifti`].
    pub(crate) fn of(first: [u8; 4]) -> Result<Self, HeaderError> {
        for (length, version) in [(BYTES_1 as i32, 1), (BYTES_2 as i32, 2)] {
            for (found, big_endian) in [(i32::from_le_bytes(first), false), (i32::from_be_bytes(first), true)] {
                if found == length {
                    return Ok(Self { version, big_endian });
                }
            }
        }
        Err(HeaderError::NotNifti { found: first })
    }

    /// Length of the header, bytes.
    pub(crate) fn bytes(self) -> usize {
        if self.version == 1 { BYTES_1 } else { BYTES_2 }
    }
}

/// The numbers of a header, as they stand in the file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fields {
    pub layout: Layout,
    pub dim: [i64; 8],
    pub datatype: i64,
    pub bitpix: i64,
    pub pixdim: [f64; 8],
    pub vox_offset: f64,
    pub slope: f64,
    pub inter: f64,
    pub units: i64,
    pub qform_code: i64,
    pub sform_code: i64,
    pub quaternion_bcd: [f64; 3],
    pub qoffset: [f64; 3],
    pub srow: [[f64; 4]; 3],
    pub intent_code: i64,
    /// Texts by their names.
    pub texts: [(&'static str, String); 3],
}

/// Numbers at known places of a header of known length.
struct Cursor<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Cursor<'_> {
    /// `N` bytes from `at` on, least significant first; zeros past the end, which no caller reaches.
    fn take<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut raw = [0; N];
        if let Some(found) = self.bytes.get(at..at + N) {
            raw.copy_from_slice(found);
        }
        if self.big_endian {
            raw.reverse();
        }
        raw
    }
    /// The text at `at`, up to its first zero; bytes that are not UTF-8 are replaced.
    fn text(&self, at: usize, bytes: usize) -> String {
        let found = self.bytes.get(at..at + bytes).unwrap_or_default();
        let text = found.split(|byte| *byte == 0).next().unwrap_or_default();
        String::from_utf8_lossy(text).into_owned()
    }
    /// The three texts, by where they begin.
    fn texts(&self, [descrip, aux_file, intent_name]: [usize; 3]) -> [(&'static str, String); 3] {
        [
            ("descrip", self.text(descrip, 80)),
            ("aux_file", self.text(aux_file, 24)),
            ("intent_name", self.text(intent_name, 16)),
        ]
    }
    fn i16(&self, at: usize) -> i64 {
        i64::from(i16::from_le_bytes(self.take(at)))
    }
    fn i32(&self, at: usize) -> i64 {
        i64::from(i32::from_le_bytes(self.take(at)))
    }
    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.take(at))
    }
    fn f32(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.take(at)))
    }
    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.take(at))
    }
}

impl Fields {
    /// The numbers in `bytes`, which start at the file's first and are [`Layout::bytes`] long.
    ///
    /// # Errors
    /// [`HeaderError::Magic`], [`HeaderError::TwoFiles`].
    pub(crate) fn parse(layout: Layout, bytes: &[u8]) -> Result<Self, HeaderError> {
        let cursor = Cursor {
            bytes,
            big_endian: layout.big_endian,
        };
        if layout.version == 1 {
            check_magic(bytes.get(344..348).unwrap_or_default(), b"n+1\0")?;
            Ok(Self::version_1(layout, &cursor))
        } else {
            check_magic(bytes.get(4..12).unwrap_or_default(), MAGIC_2)?;
            Ok(Self::version_2(layout, &cursor))
        }
    }

    fn version_1(layout: Layout, c: &Cursor<'_>) -> Self {
        Self {
            layout,
            dim: std::array::from_fn(|i| c.i16(40 + 2 * i)),
            datatype: c.i16(70),
            bitpix: c.i16(72),
            pixdim: std::array::from_fn(|i| c.f32(76 + 4 * i)),
            vox_offset: c.f32(108),
            slope: c.f32(112),
            inter: c.f32(116),
            units: i64::from(c.take::<1>(123)[0]),
            qform_code: c.i16(252),
            sform_code: c.i16(254),
            quaternion_bcd: std::array::from_fn(|i| c.f32(256 + 4 * i)),
            qoffset: std::array::from_fn(|i| c.f32(268 + 4 * i)),
            srow: std::array::from_fn(|r| std::array::from_fn(|i| c.f32(280 + 16 * r + 4 * i))),
            intent_code: c.i16(68),
            texts: c.texts([148, 228, 328]),
        }
    }

    fn version_2(layout: Layout, c: &Cursor<'_>) -> Self {
        Self {
            layout,
            dim: std::array::from_fn(|i| c.i64(16 + 8 * i)),
            datatype: c.i16(12),
            bitpix: c.i16(14),
            pixdim: std::array::from_fn(|i| c.f64(104 + 8 * i)),
            // Offsets beyond 2^53 lose bits here; they are refused far below.
            vox_offset: c.i64(168) as f64,
            slope: c.f64(176),
            inter: c.f64(184),
            units: c.i32(500),
            qform_code: c.i32(344),
            sform_code: c.i32(348),
            quaternion_bcd: std::array::from_fn(|i| c.f64(352 + 8 * i)),
            qoffset: std::array::from_fn(|i| c.f64(376 + 8 * i)),
            srow: std::array::from_fn(|r| std::array::from_fn(|i| c.f64(400 + 32 * r + 8 * i))),
            intent_code: c.i32(504),
            texts: c.texts([240, 320, 508]),
        }
    }
}

fn check_magic(found: &[u8], expected: &[u8]) -> Result<(), HeaderError> {
    if found == expected {
        return Ok(());
    }
    let found = found.to_vec();
    if found.starts_with(b"ni1\0") || found.starts_with(b"ni2\0") {
        return Err(HeaderError::TwoFiles);
    }
    Err(HeaderError::Magic {
        found,
        expected: expected.to_vec(),
    })
}
