//! Text in one typeface. Glyphs are rasterised once per size and kept.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use crate::palette::Rgb;

/// Which point of the text lies at the given position; vertically it is always the middle of the capitals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The left end.
    Left,
    /// The middle.
    Centre,
    /// The right end.
    Right,
}

/// A rasterised character: coverage 0 to 255 over a rim of two pixels, and where it goes.
#[derive(Debug)]
struct Glyph {
    coverage: Vec<u8>,
    width: i32,
    height: i32,
    left: i32,
    top: i32,
    advance: f32,
}

thread_local! {
    static GLYPHS: RefCell<HashMap<(char, u32), Rc<Glyph>>> = RefCell::new(HashMap::new());
}

fn font() -> &'static FontRef<'static> {
    static FONT: OnceLock<FontRef<'static>> = OnceLock::new();
    FONT.get_or_init(|| {
        FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR)
            .unwrap_or_else(|_| unreachable!("the embedded typeface is a valid font"))
    })
}

fn glyph(character: char, size: f32) -> Rc<Glyph> {
    let key = (character, size.to_bits());
    GLYPHS.with_borrow_mut(|glyphs| {
        glyphs
            .entry(key)
            .or_insert_with(|| Rc::new(rasterise(character, size)))
            .clone()
    })
}

fn rasterise(character: char, size: f32) -> Glyph {
    let scale = PxScale::from(size);
    let id = font().glyph_id(character);
    let advance = font().as_scaled(scale).h_advance(id);
    let outlined = font().outline_glyph(id.with_scale_and_position(scale, point(0.0, 0.0)));
    let Some(outlined) = outlined else {
        return Glyph {
            coverage: Vec::new(),
            width: 0,
            height: 0,
            left: 0,
            top: 0,
            advance,
        };
    };
    let bounds = outlined.px_bounds();
    let (width, height) = (bounds.width() as i32, bounds.height() as i32);
    let mut coverage = vec![0; (width * height).max(0) as usize];
    outlined.draw(|x, y, c| coverage[(y as i32 * width + x as i32) as usize] = (c * 255.0).round() as u8);
    Glyph {
        coverage,
        width,
        height,
        left: bounds.min.x as i32,
        top: bounds.min.y as i32,
        advance,
    }
}

/// The pixels that a text covers: columns `left` to `right` and rows `top` to `bottom`, the ends not included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelBox {
    /// First column.
    pub left: i32,
    /// First row.
    pub top: i32,
    /// The column behind the last.
    pub right: i32,
    /// The row behind the last.
    pub bottom: i32,
}

impl PixelBox {
    /// Whether the two have a pixel in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    /// Whether `other` lies wholly within.
    pub fn holds(&self, other: &Self) -> bool {
        self.left <= other.left && self.top <= other.top && other.right <= self.right && other.bottom <= self.bottom
    }

    fn joined(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// A text's glyphs, each with the pixel of its upper left corner.
fn placed(at: [f64; 2], text: &str, size: f32, anchor: Anchor) -> Vec<(Rc<Glyph>, [i32; 2])> {
    let shift = match anchor {
        Anchor::Left => 0.0,
        Anchor::Centre => text_width(text, size) / 2.0,
        Anchor::Right => text_width(text, size),
    };
    // Capitals of this typeface are 0.73 of the size high.
    let baseline = at[1].clamp(-1e5, 1e5) as f32 + 0.365 * size * 0.82;
    let mut x = at[0].clamp(-1e5, 1e5) as f32 - shift;
    let place = |character| {
        let glyph = glyph(character, size);
        let origin = [x.round() as i32 + glyph.left, baseline.round() as i32 + glyph.top];
        x += glyph.advance;
        (glyph, origin)
    };
    text.chars().map(place).collect()
}

/// How wide `text` is, pixels, without its rim.
pub fn text_width(text: &str, size: f32) -> f32 {
    text.chars().map(|c| glyph(c, size).advance).sum()
}

/// The pixels that [`Canvas::text`](crate::Canvas::text) changes with the same arguments on an image without borders, rim
/// included; `None` for a text without ink.
pub fn text_box(at: [f64; 2], text: &str, size: f32, anchor: Anchor) -> Option<PixelBox> {
    let glyphs = placed(at, text, size, anchor);
    let inked = glyphs.iter().filter(|(glyph, _)| !glyph.coverage.is_empty());
    let boxes = inked.map(|(glyph, [x, y])| PixelBox {
        left: x - 1,
        top: y - 1,
        right: x + glyph.width + 1,
        bottom: y + glyph.height + 1,
    });
    boxes.reduce(PixelBox::joined)
}

/// Draws `text` on an opaque RGBA image of `size` (width, height).
pub(crate) fn draw(rgba: &mut [u8], image: [u32; 2], at: [f64; 2], text: &str, size: f32, colour: Rgb, anchor: Anchor) {
    let glyphs = placed(at, text, size, anchor);
    const RIM: [(i32, i32); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
    let mut pass = |offsets: &[(i32, i32)], colour: Rgb| {
        for (glyph, [x, y]) in &glyphs {
            for (dx, dy) in offsets {
                blend(rgba, image, [x + dx, y + dy], glyph, colour);
            }
        }
    };
    pass(&RIM, Rgb(0, 0, 0));
    pass(&[(0, 0)], colour);
}

fn blend(rgba: &mut [u8], [width, height]: [u32; 2], [x0, y0]: [i32; 2], glyph: &Glyph, Rgb(r, g, b): Rgb) {
    for y in 0..glyph.height {
        for x in 0..glyph.width {
            let (px, py) = (x0 + x, y0 + y);
            if px < 0 || py < 0 || px >= width as i32 || py >= height as i32 {
                continue;
            }
            let cover = u32::from(glyph.coverage[(y * glyph.width + x) as usize]);
            let at = (py as usize * width as usize + px as usize) * 4;
            for (channel, ink) in rgba[at..at + 3].iter_mut().zip([r, g, b]) {
                let mixed = u32::from(*channel) * (255 - cover) + u32::from(ink) * cover;
                *channel = ((mixed + 127) / 255) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Canvas;

    #[test]
    fn the_box_of_a_text_is_what_it_changes() {
        let texts = [
            ("para-aortic-left +10.4 mm", 12.3),
            ("jgÅ|_", 31.0),
            ("±", 9.0),
            ("W 400 C -40", 7.7),
        ];
        for (text, size) in texts {
            for anchor in [Anchor::Left, Anchor::Centre, Anchor::Right] {
                let mut canvas = Canvas::new(800, 100);
                canvas.fill([0.0, 0.0], [800.0, 100.0], Rgb(90, 90, 90), 255);
                let at = [400.3, 50.6];
                canvas.text(at, text, size, Rgb(250, 250, 0), anchor);
                let inked = |i: usize| canvas.rgba()[4 * i..4 * i + 3] != [90; 3];
                let found = (0..800 * 100)
                    .filter(|&i| inked(i))
                    .map(|i| (i as i32 % 800, i as i32 / 800));
                let found = found.map(|(x, y)| PixelBox {
                    left: x,
                    top: y,
                    right: x + 1,
                    bottom: y + 1,
                });
                let (found, said) = (
                    found.reduce(PixelBox::joined).unwrap(),
                    text_box(at, text, size, anchor).unwrap(),
                );
                // A glyph's outermost pixels may be covered by less than half a grey level.
                assert!(said.holds(&found), "{text}: {found:?} {said:?}");
                let slack = (found.left - said.left) + (said.right - found.right);
                assert!(slack <= 2, "{text}: {found:?} {said:?}");
            }
        }
        // The space that does not break is in the typeface, and as wide: what is not would be drawn as a box.
        for space in [" ", "\u{a0}"] {
            assert_eq!(text_box([5.0, 5.0], space, 12.0, Anchor::Left), None);
            assert!((text_width(space, 12.0) - text_width("m", 12.0)).abs() < 1e-3);
        }
    }
}
