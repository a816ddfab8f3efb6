//! A small copy of an image with two lines under it: that this is a research display and when it was given out, and what the image may
//! claim. The renderer's own words on it are too small to be read once it is shrunk.

use bus::clock::date;
use bus::message::{FrameHeader, FrameState};
use bus::port::Shown;
use picture::palette::{ALARM, RIM, WARN, WORDS};
use picture::{Anchor, Canvas, Rgb, encode_png};

use super::NOTICE;
use crate::write::record::thumbnails::shrunk;

/// Height of a line, pixels.
const LINE: u32 = 16;
/// Least width, pixels: the longest words have room.
const WIDTH: u32 = 248;

/// What stands under an image whatever it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Label {
    /// What the run's poses come from; empty for a localizer's in the present.
    pub(super) origin: &'static str,
    /// Whether the run's workflow does not let images be shown that follow the tool.
    pub(super) is_withheld: bool,
}

/// An image that may not claim any more what stands on it is dimmed, one that is withheld is covered. `None` where nothing is left of it.
pub(super) fn small_png(header: &FrameHeader, shown: Shown<'_>, label: Label) -> Option<Vec<u8>> {
    encode_png(&drawn(header, shown, label)?, &header.stamp.texts()).ok()
}

fn drawn(header: &FrameHeader, shown: Shown<'_>, label: Label) -> Option<Canvas> {
    let (width, height, rgba) = shrunk(header.width, header.height, shown.rgba);
    if width == 0 || height == 0 {
        return None;
    }
    let mut canvas = Canvas::new(width.max(WIDTH), height + 2 * LINE);
    canvas.fill(
        [0.0; 2],
        [f64::from(canvas.width()), f64::from(canvas.height())],
        RIM,
        255,
    );
    let is_old = shown.state != header.stamp.frame_state();
    if !label.is_withheld {
        canvas.paste(&rgba, width, (canvas.width() - width) / 2, 0);
    }
    if is_old {
        canvas.dim(96);
    }
    let (words, colour) = claim(shown.state, is_old, label, header.stamp.replay);
    // To the second: whoever looks sees by a clock how late the image came.
    let notice = format!("{NOTICE} {}", date::now().get(11..).unwrap_or_default());
    for (line, words, colour) in [(0, &notice, WARN), (1, &words, colour)] {
        let middle = f64::from(height + line * LINE) + f64::from(LINE) / 2.0;
        let centre = f64::from(canvas.width()) / 2.0;
        canvas.text([centre, middle], words, 11.0, colour, Anchor::Centre);
    }
    Some(canvas)
}

/// What an image may claim, in words. `replay` is the stamp's: it is believed where the run says nothing of its origin.
fn claim(state: Option<FrameState>, is_old: bool, label: Label, replay: u32) -> (String, Rgb) {
    let origin = match (label.origin, replay) {
        ("", 1) => "REPLAY, NOT LIVE",
        ("", 2) => "SIMULATED TIME, NOT LIVE",
        (origin, _) => origin,
    };
    let (state, colour) = match state {
        _ if label.is_withheld => ("WITHHELD", ALARM),
        Some(FrameState::Live) => ("", WORDS),
        Some(FrameState::Stale) => ("POSE OLD", WARN),
        Some(FrameState::Lost(_)) => ("NO POSE", ALARM),
        Some(FrameState::Requested) => ("A POSE ASKED FOR", WORDS),
        Some(FrameState::Look) => ("A PLANE ASKED FOR", WORDS),
        None => ("UNKNOWN STATE", ALARM),
    };
    let old = if is_old { "OLD" } else { "" };
    let parts = [origin, old, state].into_iter().filter(|part| !part.is_empty());
    (parts.collect::<Vec<_>>().join(", "), colour)
}

#[cfg(test)]
mod tests;
