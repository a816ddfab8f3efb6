//! PNG files that carry their stamp as text, and that are whole or absent.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::Canvas;

/// Why a PNG was not written.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The encoder refused.
    #[error("encoding {path}: {source}")]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        source: png::EncodingError,
    },
    /// The file could not be written.
    #[error("writing {path}: {source}. Nothing was left under that name; check that the folder exists and has space")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// The PNG's bytes; each pair of `texts` becomes a tEXt chunk in front of the pixels. The same input gives the same bytes.
///
/// # Errors
/// The encoder's, for instance for a keyword that is not Latin-1.
pub fn encode_png(canvas: &Canvas, texts: &[(&str, String)]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, canvas.width(), canvas.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    // The canvas is opaque: three channels say all there is.
    let rgb: Vec<u8> = canvas.rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

/// Writes a PNG under a temporary name and renames it, so that a file of this name is always whole.
///
/// # Errors
/// [`PngError`].
pub fn write_png(path: &Path, canvas: &Canvas, texts: &[(&str, String)]) -> Result<(), PngError> {
    let bytes = encode_png(canvas, texts).map_err(|source| PngError::Encode {
        path: path.to_owned(),
        source,
    })?;
    write_bytes(path, &bytes)
}

/// Writes under a temporary name and renames.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), PngError> {
    let part = path.with_extension("png.part");
    let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        let _ = fs::remove_file(&part);
        PngError::Write {
            path: path.to_owned(),
            source,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_and_pixels_come_back() {
        let mut canvas = Canvas::new(3, 2);
        canvas.rgba_mut()[..4].copy_from_slice(&[9, 8, 7, 255]);
        let bytes = encode_png(&canvas, &[("pose_seq", "41".to_owned())]).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes)).read_info().unwrap();
        let text = &reader.info().uncompressed_latin1_text[0];
        assert_eq!((text.keyword.as_str(), text.text.as_str()), ("pose_seq", "41"));
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels[..3], [9, 8, 7]);
        assert_eq!(bytes, encode_png(&canvas, &[("pose_seq", "41".to_owned())]).unwrap());
    }

    #[test]
    fn a_folder_that_is_not_there_leaves_nothing() {
        let tmp = tempfile::tempdir().unwrap();
        let path = tmp.path().join("no/x.png");
        let text = write_png(&path, &Canvas::new(1, 1), &[]).unwrap_err().to_string();
        assert!(text.contains("no/x.png"), "{text}");
        assert_eq!(fs::read_dir(tmp.path()).unwrap().count(), 0);
    }
}
