//! What stands around a picture: letters of the patient's sides, a scale in mm, a bar of colours, words.

use geometry::{SlicePlane, letters};
use picture::{Anchor, Canvas, Line, Rgb};

use crate::draw::colour::Ramp;
use crate::draw::view::{round_length, short};

pub(super) const WORDS: Rgb = picture::palette::WORDS;
pub(super) const QUIET: Rgb = picture::palette::QUIET;
pub(super) const ALARM: Rgb = picture::palette::ALARM;
/// The colour of the word MODEL, which no other word has.
pub(super) const MODEL: Rgb = Rgb(255, 120, 255);
const GROUND: Rgb = super::cut::NOTHING;

/// An empty picture.
pub(super) fn canvas(width: u32, height: u32) -> Canvas {
    let mut canvas = Canvas::new(width, height);
    canvas.fill([-0.5, -0.5], [f64::from(width), f64::from(height)], GROUND, 255);
    canvas
}

/// Letters at the four edges of a view that lies at `corner`, and a scale at its lower left.
pub(super) fn sides(canvas: &mut Canvas, plane: &SlicePlane, corner: [f64; 2], small: bool) {
    let [width, height] = plane.size().map(f64::from);
    let (size, inset) = if small { (13.0, 9.0) } else { (19.0, 14.0) };
    let (right, down) = (plane.right(), plane.down());
    let at = |x: f64, y: f64| [corner[0] + x, corner[1] + y];
    canvas.text(
        at(width - inset, 0.5 * height),
        &letters(right),
        size,
        WORDS,
        Anchor::Right,
    );
    canvas.text(at(inset, 0.5 * height), &letters(-right), size, WORDS, Anchor::Left);
    canvas.text(
        at(0.5 * width, height - inset),
        &letters(down),
        size,
        WORDS,
        Anchor::Centre,
    );
    canvas.text(at(0.5 * width, inset), &letters(-down), size, WORDS, Anchor::Centre);
    let length = round_length(width * plane.pixel_mm());
    let pixels = length / plane.pixel_mm();
    let foot = height - inset;
    canvas.line(
        at(inset, foot),
        at(inset + pixels, foot),
        Line::solid(WORDS, 2.0).with_rim(1.0),
    );
    let text = format!("{} mm", short(length));
    canvas.text(
        at(inset + pixels + 6.0, foot),
        &text,
        if small { 11.0 } else { 13.0 },
        WORDS,
        Anchor::Left,
    );
}

/// A bar of colours from `top` to `bottom` at `left`.
pub(super) fn bar(canvas: &mut Canvas, ramp: &Ramp, [left, top, bottom]: [f64; 3], unit: &str) {
    let rows = (bottom - top).max(1.0) as u32;
    for row in 0..=rows {
        let part = 1.0 - f64::from(row) / f64::from(rows);
        let colour = ramp.colour(ramp.low + (ramp.high - ramp.low) * part);
        canvas.fill([left, top + f64::from(row)], [18.0, 1.0], colour, 255);
    }
    for k in 0..=4 {
        let part = 0.25 * f64::from(k);
        let y = bottom - (bottom - top) * part;
        canvas.line([left + 18.0, y], [left + 23.0, y], Line::solid(WORDS, 1.0));
        let number = short(ramp.low + (ramp.high - ramp.low) * part);
        canvas.text([left + 27.0, y], &number, 13.0, WORDS, Anchor::Left);
    }
    canvas.text([left, top - 16.0], unit, 13.0, WORDS, Anchor::Left);
}

/// Small squares of colours with what they mean, from left to right; goes on below where a row is full.
pub(super) fn legend(canvas: &mut Canvas, [left, mut y]: [f64; 2], all: &[(Rgb, &str)]) {
    let mut x = left;
    for (colour, words) in all {
        let wide = 18.0 + f64::from(picture::text_width(words, 12.0)) + 16.0;
        if x + wide > f64::from(canvas.width()) && x > left {
            (x, y) = (left, y + 18.0);
        }
        canvas.fill([x, y - 5.0], [11.0, 11.0], *colour, 255);
        canvas.text([x + 17.0, y], words, 12.0, QUIET, Anchor::Left);
        x += wide;
    }
}
