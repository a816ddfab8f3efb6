//! The colours of navigation images. Each has a contrast of at least 6 on black, which is the rim of every line, and any two
//! are told apart with the three kinds of colour blindness too (`tests/palette.rs`). No colour alone carries a meaning:
//! words or shapes say the same.

/// An opaque colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

/// The tube.
pub const TUBE: Rgb = Rgb(0x78, 0xb7, 0xdc);
/// The tube's inner tip and its error.
pub const TIP: Rgb = Rgb(0xf0, 0xef, 0x9a);
/// Targets.
pub const TARGET: Rgb = Rgb(0x00, 0xf8, 0xdc);
/// Where planes cut one another.
pub const CUT: Rgb = Rgb(156, 138, 156);
/// Alarm of medium priority: what is shown is old, or something about it has changed. Of nothing else.
pub const WARN: Rgb = Rgb(0xf9, 0xa4, 0x0a);
/// Alarm of high priority: there is no pose, or images and poses do not belong together. Of nothing else.
pub const ALARM: Rgb = Rgb(0xff, 0x54, 0x6c);
/// Replays, and nothing else.
pub const REPLAY: Rgb = Rgb(0xbd, 0x59, 0xff);
/// Words that are to be read.
pub const WORDS: Rgb = Rgb(235, 235, 235);
/// Words for reference.
pub const QUIET: Rgb = Rgb(165, 175, 190);
/// The rim of lines and letters.
pub const RIM: Rgb = Rgb(0, 0, 0);

/// Contrast of two colours, 1 to 21 (WCAG 2.2: relative luminances of sRGB, each plus 0.05, the lighter by the darker).
/// Graphics need 3, words 4.5.
pub fn contrast(a: Rgb, b: Rgb) -> f64 {
    let [a, b] = [a, b].map(|colour| luminance(colour) + 0.05);
    a.max(b) / a.min(b)
}

fn luminance(Rgb(r, g, b): Rgb) -> f64 {
    let linear = |channel: u8| match f64::from(channel) / 255.0 {
        c if c <= 0.04045 => c / 12.92,
        c => ((c + 0.055) / 1.055).powf(2.4),
    };
    0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_stands_out_from_its_rim() {
        assert!((contrast(Rgb(255, 255, 255), RIM) - 21.0).abs() < 1e-12);
        for colour in [TUBE, TIP, TARGET, CUT, WARN, ALARM, REPLAY, WORDS, QUIET] {
            assert!(contrast(colour, RIM) >= 6.0, "{colour:?}: {}", contrast(colour, RIM));
        }
    }
}
