//! Textured rectangles that are blended: glyphs, discs of the font's texture, icons.

use super::area::{Area, Canvas};
use super::blend::{multiply, over};
use super::item::Quad;
use super::map::Axis;
use super::texture::{Source, Texels, Texture, sample};

/// Paints the part of a rectangle that lies in `area`, a part of its own and the canvas's.
pub(crate) fn paint(canvas: &mut Canvas<'_>, source: Source<'_>, quad: &Quad, area: Area) {
    match source {
        Source::Kept(texture) => {
            let [across, down] = Axis::both(quad, texture.size());
            let [columns, rows] = texture.size();
            let exact = (
                across.exact(area.x0, area.x1, columns),
                down.exact(area.y0, area.y1, rows),
            );
            match exact {
                (Some(x), Some(y)) => glyph(canvas, texture, quad.tint, area, [x, y]),
                _ => sampled(canvas, texture, quad, area),
            }
        }
        Source::Lent(image) => sampled(canvas, image, quad, area),
    }
}

/// Texels from (`x`, `y`) on, one for each pixel.
fn glyph(canvas: &mut Canvas<'_>, texture: &Texture, tint: u32, area: Area, [x, y]: [usize; 2]) {
    for (row, line) in (area.y0..area.y1).zip(y..) {
        let to = canvas.row(row, area.x0, area.x1);
        for (pixel, texel) in to.iter_mut().zip(texture.row(x, line)) {
            // Most of a glyph's rectangle is empty.
            if *texel != 0 {
                *pixel = over(*pixel, multiply(tint, *texel));
            }
        }
    }
}

fn sampled(canvas: &mut Canvas<'_>, texels: &impl Texels, quad: &Quad, area: Area) {
    let [across, down] = Axis::both(quad, texels.size());
    for y in area.y0..area.y1 {
        let v = down.place(y);
        for (pixel, x) in canvas.row(y, area.x0, area.x1).iter_mut().zip(area.x0..) {
            let texel = sample(texels, across.place(x), v);
            *pixel = over(*pixel, multiply(quad.tint, texel));
        }
    }
}
