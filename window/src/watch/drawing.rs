//! The words of the cover as an image, in capitals that are read from where a surgeon stands.

use picture::{Anchor, Canvas, palette, text_width};

/// Height of capitals, mm: 20 minutes of arc at 2 m.
const CAPITALS_MM: f64 = 12.0;
/// A pixel of a screen that does not say how large it is, mm.
pub(super) const PIXEL_MM: f64 = 0.277;
/// The height of capitals by the size of the type.
const CAPITALS: f64 = 0.6;
/// Lines by the height of capitals.
const LEADING: f64 = 1.7;
/// The sentence below the large words, by their size: 16 minutes of arc.
const SMALLER: f64 = 0.8;
/// Type below this is none.
const LEAST: f32 = 8.0;

/// A line and the size of its type.
type Line = (String, f32);

/// Words on red, `width` x at most `height` pixels; the size of a pixel is in mm. Where the large type does not fit it is as large as
/// fits: some words are better than none.
pub(super) fn draw([width, height]: [u32; 2], pixel_mm: f64, headline: &str, reason: &str) -> Canvas {
    let wanted = (CAPITALS_MM / pixel_mm / CAPITALS) as f32;
    let (lines, total) = fitting([width, height], wanted, headline, reason);
    let mut canvas = Canvas::new(width.max(1), (total.ceil() as u32).clamp(1, height.max(1)));
    let (w, h) = (f64::from(canvas.width()), f64::from(canvas.height()));
    canvas.fill([0.0, 0.0], [w, h], palette::ALARM, 255);
    let mut y = 0.0;
    for (line, size) in lines {
        let high = line_height(size);
        canvas.text([w / 2.0, y + high / 2.0], &line, size, palette::RIM, Anchor::Centre);
        y += high;
    }
    canvas
}

/// The lines at the largest size that fits, and their height in all, pixels.
fn fitting([width, height]: [u32; 2], wanted: f32, headline: &str, reason: &str) -> (Vec<Line>, f64) {
    let mut size = wanted;
    loop {
        let lines = lines(f64::from(width), size, headline, reason);
        let total: f64 = lines.iter().map(|(_, size)| line_height(*size)).sum();
        let widest = lines
            .iter()
            .map(|(line, size)| text_width(line, *size))
            .fold(0.0, f32::max);
        let fits = total <= f64::from(height) && f64::from(widest) <= f64::from(width);
        if fits || size <= LEAST {
            return (lines, total);
        }
        size = (size * 0.9).max(LEAST);
    }
}

fn line_height(size: f32) -> f64 {
    f64::from(size) * CAPITALS * LEADING
}

fn lines(width: f64, size: f32, headline: &str, reason: &str) -> Vec<Line> {
    let small = size * SMALLER as f32;
    let parts = [(headline, size), (reason, small)];
    parts
        .into_iter()
        .flat_map(|(text, size)| broken(text, width, size).into_iter().map(move |line| (line, size)))
        .collect()
}

/// `text` in lines of at most `width` pixels, broken between words.
fn broken(text: &str, width: f64, size: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(last)) if f64::from(text_width(&longer, size)) <= width => *last = longer,
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use picture::text_box;

    use super::*;
    use crate::watch::judge::Fault;
    use crate::watch::words;

    const FULL: [u32; 2] = [1920, 1000];

    fn capitals_px(size: f32) -> f64 {
        let ink = text_box([500.0, 500.0], "H", size, Anchor::Centre).unwrap();
        f64::from(ink.bottom - ink.top)
    }

    /// The rim of two pixels on either side is no part of a letter.
    #[test]
    fn capitals_are_twelve_millimetres_high() {
        let headline = words::headline(Fault::Standing, 649_000_000);
        let wanted = (CAPITALS_MM / PIXEL_MM / CAPITALS) as f32;
        let (lines, _) = fitting(FULL, wanted, &headline, &words::reason(Fault::Standing));
        let (_, size) = lines[0];
        let mm = (capitals_px(size) - 4.0) * PIXEL_MM;
        assert!((11.5..13.5).contains(&mm), "{mm} mm");
        assert!((capitals_px(lines.last().unwrap().1) - 4.0) * PIXEL_MM >= 9.3);
    }

    #[test]
    fn words_fit_whatever_the_window_is() {
        let headline = words::headline(Fault::Unread(crate::code::Unread::Grey), 3_600_000_000_000);
        let reason = words::reason(Fault::Unread(crate::code::Unread::Grey));
        for size in [FULL, [1280, 800], [640, 480], [300, 900], [200, 100], [1, 1], [0, 0]] {
            let canvas = draw(size, PIXEL_MM, &headline, &reason);
            assert!(
                canvas.width() <= size[0].max(1) && canvas.height() <= size[1].max(1),
                "{size:?}"
            );
            let dark = canvas.rgba().chunks(4).filter(|pixel| pixel[0] < 60).count();
            assert!(dark > 300 || size[0] < 200, "{size:?}: {dark} dark pixels");
        }
    }

    #[test]
    fn nothing_is_lost_between_lines() {
        let text = "DISPLAY FROZEN 0.6 s - DO NOT NAVIGATE";
        for width in [50.0, 300.0, 5000.0] {
            assert_eq!(broken(text, width, 40.0).join(" "), text);
        }
    }
}
