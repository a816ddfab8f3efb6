//! Text in one typeface. Glyphs are rasterised once per size and kept.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use crate::Rgb;

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

/// Draws `text` on an opaque RGBA image of `size` (width, height).
pub(crate) fn draw(rgba: &mut [u8], image: [u32; 2], at: [f64; 2], text: &str, size: f32, colour: Rgb, anchor: Anchor) {
    let glyphs: Vec<Rc<Glyph>> = text.chars().map(|c| glyph(c, size)).collect();
    let length: f32 = glyphs.iter().map(|g| g.advance).sum();
    let shift = match anchor {
        Anchor::Left => 0.0,
        Anchor::Centre => length / 2.0,
        Anchor::Right => length,
    };
    // Capitals of this typeface are 0.73 of the size high.
    let baseline = at[1].clamp(-1e5, 1e5) as f32 + 0.365 * size * 0.82;
    let start = at[0].clamp(-1e5, 1e5) as f32 - shift;
    const RIM: [(i32, i32); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
    let mut pass = |offsets: &[(i32, i32)], colour: Rgb| {
        let mut x = start;
        for glyph in &glyphs {
            for (dx, dy) in offsets {
                let origin = [
                    x.round() as i32 + glyph.left + dx,
                    baseline.round() as i32 + glyph.top + dy,
                ];
                blend(rgba, image, origin, glyph, colour);
            }
            x += glyph.advance;
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
