//! Images from files: bounded before they are decoded.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageReader, Limits};
use optics::image::{Image, ImageError, MAX_PIXELS};

/// The largest file that is opened, bytes: every format here is smaller for the most pixels that are taken.
const MAX_FILE: u64 = 1 << 30;

/// Why a file is no image.
#[derive(Debug, thiserror::Error)]
pub enum ReadImageError {
    /// The file cannot be opened.
    #[error("reading {path}: {source}. Check the name and the permissions")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A folder, a pipe or a device.
    #[error("reading {path}: this is not a file; give the path of a PNG, JPEG or PGM image")]
    NotAFile {
        /// The file.
        path: PathBuf,
    },
    /// More bytes than any image that is taken has.
    #[error("reading {path}: the file has {bytes} bytes, at most {MAX_FILE} are read")]
    LargeFile {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
    },
    /// Not of a known format, or damaged.
    #[error("reading {path}: this is no PNG, JPEG or PGM image, or a damaged one ({source}); save it again as PNG")]
    Decode {
        /// The file.
        path: PathBuf,
        /// Why.
        source: image::ImageError,
    },
    /// More pixels than are taken.
    #[error(
        "reading {path}: the image has {width} x {height} pixels, at most {MAX_PIXELS} (8192 x 8192) are taken; crop it or make it smaller"
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Its pixels are none that are taken.
    #[error("reading {path}: {source}")]
    Pixels {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ImageError,
    },
}

/// Reads a PNG, JPEG or PGM of 8 or 16 bits as grey; colours by their luminance.
///
/// # Errors
/// Each variant of [`ReadImageError`].
pub fn read_image(path: &Path) -> Result<Image, ReadImageError> {
    let owned = || path.to_owned();
    let failed = |source| ReadImageError::Read { path: owned(), source };
    // Asked for before opening: opening a pipe would wait for its writer.
    let found = fs::metadata(path).map_err(failed)?;
    if !found.is_file() {
        return Err(ReadImageError::NotAFile { path: owned() });
    }
    if found.len() > MAX_FILE {
        return Err(ReadImageError::LargeFile {
            path: owned(),
            bytes: found.len(),
        });
    }
    let open = || {
        ImageReader::open(path)
            .and_then(ImageReader::with_guessed_format)
            .map_err(failed)
    };
    let wrong = |source| ReadImageError::Decode { path: owned(), source };
    let (width, height) = open()?.into_dimensions().map_err(wrong)?;
    if u64::from(width) * u64::from(height) > MAX_PIXELS as u64 {
        return Err(ReadImageError::TooLarge {
            path: owned(),
            width,
            height,
        });
    }
    let mut reader = open()?;
    let mut limits = Limits::default();
    // Eight bytes a pixel (16 bits, four channels) of the most pixels.
    limits.max_alloc = Some(8 * MAX_PIXELS as u64);
    reader.limits(limits);
    grey(reader.decode().map_err(wrong)?).map_err(|source| ReadImageError::Pixels { path: owned(), source })
}

fn grey(decoded: DynamicImage) -> Result<Image, ImageError> {
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    match decoded {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => Image::new(width, height, decoded.into_luma16().into_raw()),
        _ => Image::from_bytes(width, height, &decoded.into_luma8().into_raw()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image");
        fs::write(&path, bytes).unwrap();
        read_image(&path).unwrap_err().to_string()
    }

    #[test]
    fn greys_of_8_and_16_bits_are_read_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grey.pgm");
        fs::write(&path, b"P5 2 2 255\n\x01\x02\x03\xff").unwrap();
        assert_eq!(read_image(&path).unwrap().samples(), [1, 2, 3, 255]);
        fs::write(&path, b"P5 2 1 65535\n\x01\x02\xff\xfe").unwrap();
        assert_eq!(read_image(&path).unwrap().samples(), [0x0102, 0xfffe]);
    }

    #[test]
    fn what_is_no_image_is_refused_by_name() {
        for bytes in [
            &b""[..],
            b"hello",
            b"P5 4 4 255\nabc",
            b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR",
            b"P5 0 0 255\n",
        ] {
            let text = refused(bytes);
            assert!(
                text.contains("PNG, JPEG or PGM") || text.contains("nothing in it"),
                "{text}"
            );
        }
        let huge = refused(b"P5 20000 20000 255\n");
        assert!(
            huge.contains("20000 x 20000 pixels") && huge.contains("8192 x 8192"),
            "{huge}"
        );
        assert!(
            read_image(Path::new("/"))
                .unwrap_err()
                .to_string()
                .contains("not a file")
        );
        assert!(
            read_image(Path::new("/no/such.png"))
                .unwrap_err()
                .to_string()
                .contains("/no/such.png")
        );
    }
}
