//! Animated PNG: every frame in full colour, no library more than PNG takes, and a viewer that knows no animation shows the
//! first frame.

use std::path::Path;

use crate::png_file::write_bytes;
use crate::{Canvas, PngError};

/// The bytes of an animation that repeats for ever, each frame shown for `milliseconds`. The same frames give the same bytes.
///
/// # Errors
/// The encoder's, for instance without frames; and where a frame has another size than the first.
pub fn encode_animation(frames: &[Canvas], milliseconds: u16) -> Result<Vec<u8>, png::EncodingError> {
    let wrong = |why: &str| png::EncodingError::IoError(std::io::Error::other(why.to_owned()));
    let first = frames.first().ok_or_else(|| wrong("an animation without frames"))?;
    let size = (first.width(), first.height());
    if frames.iter().any(|f| (f.width(), f.height()) != size) {
        return Err(wrong("frames of an animation differ in size"));
    }
    let count = u32::try_from(frames.len()).map_err(|_| wrong("too many frames"))?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_animated(count, 0)?;
    encoder.set_frame_delay(milliseconds, 1000)?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        let rgb: Vec<u8> = frame.rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        writer.write_image_data(&rgb)?;
    }
    writer.finish()?;
    Ok(bytes)
}

/// Writes an animation under a temporary name and renames it.
///
/// # Errors
/// [`PngError`].
pub fn write_animation(path: &Path, frames: &[Canvas], milliseconds: u16) -> Result<(), PngError> {
    let bytes = encode_animation(frames, milliseconds).map_err(|source| PngError::Encode {
        path: path.to_owned(),
        source,
    })?;
    write_bytes(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_in_order() {
        let frame = |shade: u8| {
            let mut canvas = Canvas::new(4, 3);
            canvas.rgba_mut().chunks_exact_mut(4).for_each(|p| p[0] = shade);
            canvas
        };
        let frames = [frame(10), frame(20), frame(30)];
        let bytes = encode_animation(&frames, 40).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let control = reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        for shade in [10, 20, 30] {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels[0], shade);
            let delay = reader.info().frame_control().unwrap();
            assert_eq!((delay.delay_num, delay.delay_den), (40, 1000));
        }
        assert_eq!(bytes, encode_animation(&frames, 40).unwrap());
    }

    #[test]
    fn no_frames_and_frames_of_two_sizes_are_refused() {
        assert!(encode_animation(&[], 40).is_err());
        let error = encode_animation(&[Canvas::new(2, 2), Canvas::new(3, 2)], 40).unwrap_err();
        assert!(error.to_string().contains("differ in size"), "{error}");
    }
}
