//! Transfer syntaxes (DICOM PS3.5 section 10, PS3.6 table A-1): how elements and pixels are coded.

use super::error::FileError;

/// How data elements are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    ImplicitLittle,
    ExplicitLittle,
    ExplicitBig,
}

/// How pixels are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PixelCoding {
    Native,
    Rle,
    JpegLossless,
    JpegLs,
    Jpeg2000,
}

/// A transfer syntax that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Syntax {
    pub elements: Coding,
    pub pixels: PixelCoding,
    /// In words, for a person.
    pub name: &'static str,
}

use Coding::{ExplicitBig, ExplicitLittle, ImplicitLittle};
use PixelCoding::{Jpeg2000, JpegLossless, JpegLs, Native, Rle};

const ROOT: &str = "1.2.840.10008.1.2";
/// What follows [`ROOT`].
const READ: &[(&str, Coding, PixelCoding, &str)] = &[
    ("", ImplicitLittle, Native, "uncompressed, implicit VR little endian"),
    (".1", ExplicitLittle, Native, "uncompressed, explicit VR little endian"),
    (".2", ExplicitBig, Native, "uncompressed, explicit VR big endian"),
    (".5", ExplicitLittle, Rle, "RLE lossless"),
    (".4.57", ExplicitLittle, JpegLossless, "JPEG lossless"),
    (
        ".4.70",
        ExplicitLittle,
        JpegLossless,
        "JPEG lossless, first-order prediction",
    ),
    (".4.80", ExplicitLittle, JpegLs, "JPEG-LS lossless"),
    (".4.81", ExplicitLittle, JpegLs, "JPEG-LS near-lossless"),
    (".4.90", ExplicitLittle, Jpeg2000, "JPEG 2000 lossless"),
    (".4.91", ExplicitLittle, Jpeg2000, "JPEG 2000"),
];
const NOT_READ: &[(&str, &str)] = &[
    (".1.99", "deflated explicit VR little endian"),
    (".4.50", "JPEG baseline, 8 bits, lossy"),
    (".4.51", "JPEG extended, 12 bits, lossy"),
    (".4.92", "JPEG 2000 multi-component lossless"),
    (".4.93", "JPEG 2000 multi-component"),
    (".4.110", "JPEG XL lossless"),
    (".4.112", "JPEG XL"),
    (".4.201", "HTJ2K lossless"),
    (".4.202", "HTJ2K lossless, RPCL"),
    (".4.203", "HTJ2K"),
];

impl Default for Syntax {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Syntax {
    /// What a file without File Meta Information is (PS3.5, A.1).
    pub(crate) const DEFAULT: Self = Self {
        elements: ImplicitLittle,
        pixels: Native,
        name: READ[0].3,
    };

    /// The transfer syntax of this unique identifier.
    ///
    /// # Errors
    /// [`FileError::Syntax`].
    pub(crate) fn of(uid: &str) -> Result<Self, FileError> {
        let rest = uid.strip_prefix(ROOT);
        if let Some(&(_, elements, pixels, name)) = READ.iter().find(|row| rest == Some(row.0)) {
            return Ok(Self { elements, pixels, name });
        }
        let known = NOT_READ.iter().find(|row| rest == Some(row.0));
        // A unique identifier has digits and points only, and at most 64 of them (PS3.5 section 9.1).
        let plausible = uid.len() <= 64 && uid.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        Err(FileError::Syntax {
            uid: if plausible { uid } else { "malformed" }.to_owned(),
            name: known.map_or("unknown", |row| row.1),
        })
    }
}
