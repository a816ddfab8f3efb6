//! Decoders of compressed images. Each stream's own header is read first and must be what the DICOM header says; a
//! decoder that fails, or panics, ends in a named error.

mod jpeg;
mod jpeg2000;
mod jpeg_lossless;
mod jpeg_ls;
mod rle;

#[cfg(test)]
pub(super) mod tests;

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::error::FileError;
use super::syntax::PixelCoding;

/// What a compressed image must be, after the DICOM header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Image {
    pub columns: u16,
    pub rows: u16,
    /// Bits of a pixel cell: 8 or 16.
    pub allocated: u16,
    /// The highest bit in use.
    pub high_bit: u16,
    pub signed: bool,
}

/// What a stream says that it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Claim {
    pub columns: u32,
    pub rows: u32,
    pub components: u16,
    /// Bits of a sample.
    pub precision: u16,
}

impl Image {
    /// Pixels in the image.
    pub(crate) fn pixels(&self) -> usize {
        usize::from(self.columns) * usize::from(self.rows)
    }

    /// The stream's own header must agree: dimensions to the pixel, one component, and samples that hold every bit in use.
    ///
    /// # Errors
    /// [`FileError::Mismatch`].
    fn check(&self, codec: &'static str, claim: Claim) -> Result<(), FileError> {
        let size = claim.columns == u32::from(self.columns) && claim.rows == u32::from(self.rows);
        let bits = self.high_bit < claim.precision && claim.precision <= self.allocated;
        if size && bits && claim.components == 1 {
            return Ok(());
        }
        let Claim {
            columns,
            rows,
            components,
            precision,
        } = claim;
        Err(FileError::Mismatch {
            codec,
            found: format!("{columns} x {rows} pixels, {components} components of {precision} bits"),
            expected: format!(
                "{} x {} pixels, 1 component of {} to {} bits",
                self.columns,
                self.rows,
                self.high_bit + 1,
                self.allocated
            ),
        })
    }
}

/// The pixel cells of a compressed image, row by row, each in 16 bits.
///
/// # Errors
/// [`FileError::Mismatch`], [`FileError::Codec`].
pub(crate) fn decode(coding: PixelCoding, data: &[u8], image: &Image) -> Result<Vec<u16>, FileError> {
    let codec = name(coding);
    let decoding = AssertUnwindSafe(|| match coding {
        PixelCoding::Rle => rle::decode(data, image),
        PixelCoding::JpegLossless => jpeg_lossless::decode(data, image),
        PixelCoding::JpegLs => jpeg_ls::decode(data, image),
        PixelCoding::Jpeg2000 => jpeg2000::decode(data, image),
        PixelCoding::Native => Err(failed(codec, "these pixels are not compressed")),
    });
    catch_unwind(decoding).unwrap_or_else(|_| Err(failed(codec, "the decoder gave up on damaged data")))
}

/// Whether the stream was made with loss, as its own header says.
///
/// # Errors
/// [`FileError::Codec`].
pub(crate) fn is_lossy(coding: PixelCoding, data: &[u8]) -> Result<bool, FileError> {
    match coding {
        PixelCoding::JpegLs => jpeg_ls::is_lossy(data),
        PixelCoding::Jpeg2000 => jpeg2000::is_lossy(data),
        PixelCoding::Native | PixelCoding::Rle | PixelCoding::JpegLossless => Ok(false),
    }
}

fn name(coding: PixelCoding) -> &'static str {
    match coding {
        PixelCoding::Native => "uncompressed",
        PixelCoding::Rle => "RLE",
        PixelCoding::JpegLossless => "JPEG lossless",
        PixelCoding::JpegLs => "JPEG-LS",
        PixelCoding::Jpeg2000 => "JPEG 2000",
    }
}

fn failed(codec: &'static str, detail: impl Into<String>) -> FileError {
    FileError::Codec {
        codec,
        detail: detail.into(),
    }
}
