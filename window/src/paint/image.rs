//! Lent images: opaque, copied where a pixel is a texel, else interpolated between the four texels around it.
//!
//! Interpolation goes by rows. A row of the image is resampled to the columns of the screen once, with 8 bits behind the
//! point, and each row of the screen is a mixture of two of those. Both loops run over plain slices of 16-bit numbers, which
//! compilers turn into vector instructions. The error: 255/512 level of the place between two columns, which has 8 bits, 3/256
//! of products that are cut off, and half a level of rounding: 1.01, so that a level differs from the exact one by 1 at most.

use super::Image;
use super::area::{Area, Canvas};
use super::blend::{multiply, opaque};
use super::item::Quad;
use super::map::Axis;

/// A white that changes nothing.
const WHITE: u32 = 0xFFFF_FFFF;

/// Memory that is kept from image to image.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    columns: Vec<Column>,
    /// Two rows of the image at the columns of the screen, four channels of 8 bits and 8 bits behind the point each.
    rows: [Vec<u16>; 2],
    /// Which rows of the image these are.
    held: [Option<usize>; 2],
}

/// The two texels around a column of the screen.
#[derive(Debug, Clone, Copy)]
struct Column {
    /// The left one's first byte.
    at: u32,
    /// The weight of the right one, of 256.
    right: u16,
}

/// Paints the part of an image that lies in `area`, a part of the rectangle's and the canvas's. The image has at least two
/// columns, and the tint no transparency.
pub(crate) fn paint(canvas: &mut Canvas<'_>, image: &Image<'_>, quad: &Quad, area: Area, scratch: &mut Scratch) {
    let size = image.size.map(|n| n as usize);
    let [across, down] = Axis::both(quad, size);
    let exact = (
        across.exact(area.x0, area.x1, size[0]),
        down.exact(area.y0, area.y1, size[1]),
    );
    if let (Some(x), Some(y)) = exact {
        return copy(canvas, image, quad.tint, area, [x, y]);
    }
    scratch.begin(across, area, size[0]);
    for y in area.y0..area.y1 {
        let (rows, weights) = mixture(down.place(y), size[1], quad.tint);
        scratch.hold(image, rows);
        mix(canvas.row(y, area.x0, area.x1), &scratch.rows, weights);
    }
}

/// Texels from (`x`, `y`) on, one for each pixel.
fn copy(canvas: &mut Canvas<'_>, image: &Image<'_>, tint: u32, area: Area, [x, y]: [usize; 2]) {
    let stride = 4 * image.size[0] as usize;
    let rows = image.rgba.chunks_exact(stride).skip(y);
    for (row, from) in (area.y0..area.y1).zip(rows) {
        let to = canvas.row(row, area.x0, area.x1);
        let (texels, _) = from.get(4 * x..).unwrap_or_default().as_chunks::<4>();
        if tint == WHITE {
            to.iter_mut()
                .zip(texels)
                .for_each(|(to, texel)| *to = opaque(*texel) & 0x00FF_FFFF);
        } else {
            to.iter_mut()
                .zip(texels)
                .for_each(|(to, texel)| *to = multiply(opaque(*texel), tint) & 0x00FF_FFFF);
        }
    }
}

impl Scratch {
    /// Makes ready for the columns of `area`.
    fn begin(&mut self, across: Axis, area: Area, count: usize) {
        let last = (count as i64 - 1) << 8;
        let column = |x: i32| {
            let place = (across.place(x).saturating_add(1 << 23) >> 24).clamp(0, last);
            // The last texel has none on its right: it is the right one of the two at the end, with all the weight.
            let left = (place >> 8).min(count as i64 - 2).max(0);
            Column {
                at: 4 * left as u32,
                right: (place - (left << 8)) as u16,
            }
        };
        self.columns.clear();
        self.columns.extend((area.x0..area.x1).map(column));
        self.held = [None; 2];
        for row in &mut self.rows {
            row.clear();
            row.resize(4 * self.columns.len(), 0);
        }
    }

    /// Holds these two rows of the image.
    fn hold(&mut self, image: &Image<'_>, wanted: [usize; 2]) {
        // Going down, the lower row becomes the upper one; going up, where the image is upside down, the other way round.
        if self.held[1] == Some(wanted[0]) || self.held[0] == Some(wanted[1]) {
            self.rows.swap(0, 1);
            self.held.swap(0, 1);
        }
        let slots = self.rows.iter_mut().zip(&mut self.held).zip(wanted);
        for ((to, held), wanted) in slots.filter(|((_, held), wanted)| **held != Some(*wanted)) {
            let stride = 4 * image.size[0] as usize;
            let row = image.rgba.get(wanted * stride..).unwrap_or_default();
            resample(to, row, &self.columns);
            *held = Some(wanted);
        }
    }
}

/// A row of the image at the columns of the screen.
fn resample(to: &mut [u16], row: &[u8], columns: &[Column]) {
    let (to, _) = to.as_chunks_mut::<4>();
    for (to, column) in to.iter_mut().zip(columns) {
        let Some(Ok(pair)) = row
            .get(column.at as usize..)
            .and_then(|row| row.get(..8))
            .map(<&[u8; 8]>::try_from)
        else {
            continue;
        };
        let left = 256 - column.right;
        for channel in 0..4 {
            to[channel] = u16::from(pair[channel]) * left + u16::from(pair[channel + 4]) * column.right;
        }
    }
}

/// The two rows around a place, and what each counts in each channel, of 65536.
fn mixture(place: i64, count: usize, tint: u32) -> ([usize; 2], [[u16; 8]; 2]) {
    let last = (count as i64 - 1) << 16;
    let place = (place.saturating_add(1 << 15) >> 16).clamp(0, last);
    let upper = (place >> 16) as usize;
    let part = (place & 0xFFFF) as u32;
    let rows = [upper, (upper + 1).min(count - 1)];
    let channels = [tint >> 16, tint >> 8, tint, tint >> 24].map(|channel| channel & 0xFF);
    let weights = [65_536 - part, part].map(|part| {
        // 65536 itself does not fit: what is missing is the 256th of a level.
        let weight = |channel: u32| u16::try_from((part * channel + 127) / 255).unwrap_or(u16::MAX);
        let [r, g, b, a] = channels.map(weight);
        [r, g, b, a, r, g, b, a]
    });
    (rows, weights)
}

/// Pixels of two rows with their weights.
fn mix(to: &mut [u32], rows: &[Vec<u16>; 2], [upper, lower]: [[u16; 8]; 2]) {
    let product = |a: u16, b: u16| ((u32::from(a) * u32::from(b)) >> 16) as u16;
    let level = |a: u16, b: u16, channel: usize| {
        let sum = product(a, upper[channel]) + product(b, lower[channel]);
        u32::from((sum + 128) >> 8)
    };
    let pixel =
        |a: &[u16], b: &[u16]| (level(a[0], b[0], 0) << 16) | (level(a[1], b[1], 1) << 8) | level(a[2], b[2], 2);
    let (a, _) = rows[0].as_chunks::<4>();
    let (b, _) = rows[1].as_chunks::<4>();
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = pixel(a, b);
    }
}
