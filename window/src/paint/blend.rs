//! Arithmetic of pixels: colours are `u32` 0xAARRGGBB with premultiplied alpha, the screen's 0x00RRGGBB.
//!
//! Two channels share one multiplication: with a channel of 8 bits in each half of a `u32`, a product with a factor of 8 bits
//! stays in its half.

use egui::epaint::Color32;

/// The lower byte of each half.
const LOW: u32 = 0x00FF_00FF;
/// One half, rounded up, of the 255 by which products are divided.
const HALF: u32 = 0x0080_0080;

/// A colour of egui.
pub(crate) fn argb(colour: Color32) -> u32 {
    let [r, g, b, a] = colour.to_array();
    u32::from_be_bytes([a, r, g, b])
}

/// Four bytes RGBA of an image without transparency.
pub(crate) fn opaque([r, g, b, _]: [u8; 4]) -> u32 {
    u32::from_be_bytes([0xFF, r, g, b])
}

/// Both halves times `factor` / 255, rounded to the nearest: exact, as (t + t / 256) / 256 is t / 255 for 16 bits.
fn scale(halves: u32, factor: u32) -> u32 {
    let t = halves * factor + HALF;
    ((t + ((t >> 8) & LOW)) >> 8) & LOW
}

/// Halves of at most 510, cut at 255.
fn saturate(halves: u32) -> u32 {
    let over = halves & 0x0100_0100;
    (halves | (over - (over >> 8))) & LOW
}

/// `source` over the screen's `below`: source + below (1 - alpha), each channel within half a level, at most 255.
#[inline]
pub(crate) fn over(below: u32, source: u32) -> u32 {
    let rest = 255 - (source >> 24);
    // A source of additive light has channels beyond its alpha, so that the sum may pass 255.
    let red_blue = saturate(scale(below & LOW, rest) + (source & LOW));
    let green = saturate(scale((below >> 8) & 0xFF, rest) + ((source >> 8) & 0xFF));
    red_blue | (green << 8)
}

/// All four channels times `factor` / 255, each within half a level.
#[inline]
pub(crate) fn fade(colour: u32, factor: u32) -> u32 {
    scale(colour & LOW, factor) | (scale((colour >> 8) & LOW, factor) << 8)
}

/// The channels of two colours multiplied, with 255 as one, each within half a level.
#[inline]
pub(crate) fn multiply(a: u32, b: u32) -> u32 {
    let alpha = b >> 24;
    // Glyphs are white, so that one factor serves all channels.
    if b == alpha * 0x0101_0101 {
        return fade(a, alpha);
    }
    let channel = |shift: u32| scale((a >> shift) & 0xFF, (b >> shift) & 0xFF) << shift;
    channel(24) | channel(16) | channel(8) | channel(0)
}

/// `source` over each pixel of a row.
pub(crate) fn over_row(row: &mut [u32], source: u32) {
    match source >> 24 {
        0xFF => row.fill(source & 0x00FF_FFFF),
        _ => row.iter_mut().for_each(|pixel| *pixel = over(*pixel, source)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_rounded_to_the_nearest() {
        for a in 0..256 {
            for b in 0..256 {
                let exact = (f64::from(a * b) / 255.0).round() as u32;
                assert_eq!(scale(a | (a << 16), b), exact | (exact << 16), "{a} {b}");
                assert_eq!(multiply(a * 0x0101_0101, b), scale(a, b), "{a} {b}");
            }
        }
    }

    #[test]
    fn over_is_within_half_a_level_and_cut_at_white() {
        for below in (0..256).step_by(3) {
            for source in 0..256_u32 {
                for alpha in (0..256_u32).step_by(5) {
                    let exact = f64::from(source) + f64::from(below) * f64::from(255 - alpha) / 255.0;
                    let got = over(below * 0x0001_0101, (alpha << 24) | (source * 0x0001_0101));
                    let level = got & 0xFF;
                    assert_eq!(got, level * 0x0001_0101);
                    assert!(
                        (f64::from(level) - exact.min(255.0)).abs() <= 0.5,
                        "{below} {source} {alpha}"
                    );
                }
            }
        }
    }
}
