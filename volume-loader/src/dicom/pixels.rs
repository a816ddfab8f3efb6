//! Reading one slice's pixels.

use std::fs::File;
use std::io::ErrorKind;
use std::os::unix::fs::FileExt;

use super::codec::{self, Image};
use super::error::{DicomError, FileError};
use super::fragments::{self, ReadFailure, Stretch};
use super::slice::Slice;
use super::stored::ToHu;
use super::syntax::PixelCoding;
use crate::source::Conversion;

/// Bytes read at once: a whole number of pixels of any kind, and small enough to stay in the processor's cache.
const CHUNK_BYTES: usize = 1 << 16;

/// A compressed image is at most twice as long as its pixels (codes of noise are longer than what they stand for, and none
/// twice as long) and this much, bytes: tables and remarks.
const SPARE_BYTES: u64 = 1 << 20;

impl Slice {
    /// Reads the pixels as HU into `out`, which is as long as there are pixels; says what was changed.
    ///
    /// # Errors
    /// [`DicomError::File`], [`DicomError::Unreadable`].
    pub(crate) fn read(&self, out: &mut [i16], bytes: &mut Vec<u8>) -> Result<Conversion, DicomError> {
        self.try_read(out, bytes).map_err(|failure| match failure {
            // The file was long enough when its header was read.
            ReadFailure::Io(error) if error.kind() == ErrorKind::UnexpectedEof => self.refused(FileError::BrokenOff {
                byte: self.pixels_at,
                found: std::fs::metadata(&self.path).map_or(0, |about| about.len()),
            }),
            ReadFailure::Io(source) => DicomError::Unreadable {
                path: self.path.clone(),
                source,
            },
            ReadFailure::File(source) => self.refused(source),
        })
    }

    /// Whether what `conversion` tells of the slice's pixels leaves a picture of them.
    ///
    /// # Errors
    /// [`DicomError::File`] where more than half of them are beyond 16 bits.
    pub(crate) fn check_hu(&self, conversion: Conversion) -> Result<(), DicomError> {
        let (held, pixels) = (conversion.clamped_low + conversion.clamped_high, self.pixels() as u64);
        if 2 * held <= pixels {
            return Ok(());
        }
        let ToHu { slope, intercept, .. } = self.to_hu;
        Err(self.refused(FileError::Beyond {
            held,
            pixels,
            slope,
            intercept,
        }))
    }

    fn refused(&self, source: FileError) -> DicomError {
        DicomError::File {
            path: self.path.clone(),
            source: source.in_frame(self.frame),
        }
    }

    fn try_read(&self, out: &mut [i16], bytes: &mut Vec<u8>) -> Result<Conversion, ReadFailure> {
        let (file, _) = scene::file::open(&self.path).map_err(std::io::Error::from)?;
        let mut conversion = Conversion::default();
        if self.coding == PixelCoding::Native {
            self.read_native(&file, out, bytes, &mut conversion)?;
            return Ok(conversion);
        }
        self.join(&file, bytes)?;
        let samples = codec::decode(self.coding, bytes, &self.image())?;
        if samples.len() != out.len() {
            return Err(FileError::PixelLength {
                found: 2 * samples.len() as u64,
                expected: 2 * out.len() as u64,
                frames: 1,
                columns: self.columns,
                rows: self.rows,
                bits: 16,
            }
            .into());
        }
        self.to_hu.convert16(samples.into_iter(), out, &mut conversion);
        Ok(conversion)
    }

    fn join(&self, file: &File, bytes: &mut Vec<u8>) -> Result<(), ReadFailure> {
        let most = 2 * self.to_hu.cell.bytes() as u64 * self.pixels() as u64 + SPARE_BYTES;
        let stretch = match self.frame {
            Some(_) => Stretch::Frame(self.pixels_at..self.end),
            None => Stretch::File(self.pixels_at..self.end),
        };
        fragments::join(file, stretch, most, bytes)
    }

    fn read_native(
        &self,
        file: &File,
        out: &mut [i16],
        bytes: &mut Vec<u8>,
        conversion: &mut Conversion,
    ) -> Result<(), ReadFailure> {
        let width = self.to_hu.cell.bytes();
        bytes.resize(CHUNK_BYTES, 0);
        let mut at = self.pixels_at;
        for part in out.chunks_mut(CHUNK_BYTES / width) {
            let Some(chunk) = bytes.get_mut(..part.len() * width) else {
                break;
            };
            file.read_exact_at(chunk, at)?;
            self.to_hu.convert(chunk, part, conversion);
            at += chunk.len() as u64;
        }
        Ok(())
    }

    /// What a compressed image must be.
    pub(crate) fn image(&self) -> Image {
        Image {
            columns: self.columns,
            rows: self.rows,
            allocated: self.to_hu.cell.allocated,
            high_bit: self.to_hu.cell.high_bit,
            signed: self.to_hu.cell.signed,
        }
    }

    /// Whether the compressed image was made with loss, from its own header alone.
    ///
    /// # Errors
    /// As [`Slice::read`].
    pub(crate) fn is_lossy(&self, bytes: &mut Vec<u8>) -> Result<bool, DicomError> {
        if self.coding == PixelCoding::Native {
            return Ok(false);
        }
        let unreadable = |source| DicomError::Unreadable {
            path: self.path.clone(),
            source,
        };
        let (file, _) = scene::file::open(&self.path).map_err(|error| unreadable(error.into()))?;
        match self.join(&file, bytes) {
            Ok(()) => codec::is_lossy(self.coding, bytes).map_err(|source| self.refused(source)),
            Err(ReadFailure::File(source)) => Err(self.refused(source)),
            Err(ReadFailure::Io(source)) => Err(unreadable(source)),
        }
    }
}
