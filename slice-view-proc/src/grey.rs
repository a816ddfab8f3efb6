//! From HU to grey.

use scene::WindowLevel;

/// Writes the grey of each HU as an opaque RGBA pixel.
///
/// Linear from 0 at `centre - width/2` to 255 at `centre + width/2`, rounded to nearest, clamped outside (DICOM PS3.3
/// C.11.2.1.3.2, LINEAR_EXACT).
pub fn to_grey(window: WindowLevel, hu: &[f32], rgba: &mut [u8]) {
    let low = (window.centre_hu - window.width_hu / 2.0) as f32;
    let scale = (255.0 / window.width_hu) as f32;
    for (value, pixel) in hu.iter().zip(rgba.chunks_exact_mut(4)) {
        // `as` saturates, so that no value wraps around; NaN cannot come out of a resampler.
        let grey = ((value - low) * scale + 0.5) as u8;
        pixel.copy_from_slice(&[grey, grey, grey, 255]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middle_of_the_window() {
        let window = WindowLevel {
            centre_hu: 40.0,
            width_hu: 400.0,
        };
        let hu = [-32_768.0, -160.0, 40.0, 240.0, 32_767.0];
        let mut rgba = [0; 20];
        to_grey(window, &hu, &mut rgba);
        let greys: Vec<u8> = rgba.chunks(4).map(|p| p[0]).collect();
        assert_eq!(greys, [0, 0, 128, 255, 255]);
        assert!(rgba.chunks(4).all(|p| p[3] == 255));
    }
}
