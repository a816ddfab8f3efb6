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

/// Pixels that are mixed at once: as many channels as a vector of bytes has.
const AT_ONCE: usize = 4;
/// 16 bits for each channel of these pixels.
type Lanes = [u16; 4 * AT_ONCE];

/// Memory that is kept from image to image.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// For which columns of the screen, as places in the image: the first, the step, and of how many texels.
    across: Option<(i64, i64, usize)>,
    /// The first byte of the left one of the two texels around a column.
    starts: Vec<u32>,
    /// What the channels of both count, of 256.
    weights: Vec<[u16; 8]>,
    /// Two rows of the image at the columns of the screen: blue, green, red and nothing, as on the screen, with 8 bits behind
    /// the point. Filled up to whole [`Lanes`].
    rows: [Vec<u16>; 2],
    /// Which rows of the image these are.
    held: [Option<usize>; 2],
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
    /// Makes ready for the columns of `area`, in an image of `count` columns.
    fn begin(&mut self, across: Axis, area: Area, count: usize) {
        let columns = area.width() as usize;
        let key = (across.place(area.x0), across.place(area.x0 + 1), count);
        // Most cells of a screen are alike, and so is one from frame to frame.
        if self.across != Some(key) || self.starts.len() != columns {
            self.across = Some(key);
            self.starts.clear();
            self.weights.clear();
            for (start, weights) in (area.x0..area.x1).map(|x| pair(across.place(x), count)) {
                self.starts.push(start);
                self.weights.push(weights);
            }
        }
        self.held = [None; 2];
        let lanes = columns.next_multiple_of(AT_ONCE) * 4;
        self.rows.iter_mut().for_each(|row| row.resize(lanes, 0));
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
            resample(to, row, &self.starts, &self.weights);
            *held = Some(wanted);
        }
    }
}

/// The first byte of the two texels around a place, and what their channels count, of 256.
fn pair(place: i64, count: usize) -> (u32, [u16; 8]) {
    let last = (count as i64 - 1) << 8;
    let place = (place.saturating_add(1 << 23) >> 24).clamp(0, last);
    // The last texel has none on its right: it is the right one of the two at the end, with all the weight.
    let start = (place >> 8).min(count as i64 - 2).max(0);
    let right = (place - (start << 8)) as u16;
    let left = 256 - right;
    (4 * start as u32, [left, left, left, left, right, right, right, right])
}

/// A row of the image at the columns of the screen.
#[inline(never)]
fn resample(to: &mut [u16], row: &[u8], starts: &[u32], weights: &[[u16; 8]]) {
    let (to, _) = to.as_chunks_mut::<4>();
    for ((to, start), weights) in to.iter_mut().zip(starts).zip(weights) {
        let start = *start as usize;
        let Some(pair) = row.get(start..start + 8).and_then(<[u8]>::first_chunk::<8>) else {
            continue;
        };
        let sum = |c: usize| u16::from(pair[c]) * weights[c] + u16::from(pair[c + 4]) * weights[c + 4];
        let [r, g, b, nothing] = [sum(0), sum(1), sum(2), sum(3)];
        *to = [b, g, r, nothing];
    }
}

/// The two rows around a place, and what each counts in each channel, of 65536.
fn mixture(place: i64, count: usize, tint: u32) -> ([usize; 2], [Lanes; 2]) {
    let last = (count as i64 - 1) << 16;
    let place = (place.saturating_add(1 << 15) >> 16).clamp(0, last);
    let upper = (place >> 16) as usize;
    let part = (place & 0xFFFF) as u32;
    let rows = [upper, (upper + 1).min(count - 1)];
    let [blue, green, red, _] = tint.to_le_bytes().map(u32::from);
    let weights = [65_536 - part, part].map(|part| {
        // 65536 itself does not fit: what is missing is the 256th of a level.
        let weight = |channel: u32| u16::try_from((part * channel + 127) / 255).unwrap_or(u16::MAX);
        let pixel = [weight(blue), weight(green), weight(red), 0];
        std::array::from_fn(|lane| pixel[lane % 4])
    });
    (rows, weights)
}

/// Pixels of two rows with their weights.
#[inline(never)]
fn mix(to: &mut [u32], rows: &[Vec<u16>; 2], weights: [Lanes; 2]) {
    let [upper, lower] = rows.each_ref().map(|row| row.as_chunks().0);
    let (whole, rest) = to.as_chunks_mut::<AT_ONCE>();
    let count = whole.len();
    for ((to, a), b) in whole.iter_mut().zip(upper).zip(lower) {
        write(to, mix_at_once(a, b, &weights));
    }
    if let (Some(a), Some(b)) = (upper.get(count), lower.get(count)) {
        write(rest, mix_at_once(a, b, &weights));
    }
}

/// Written so that compilers make vector instructions of it: one that builds the pixels at once takes six times as long.
#[inline(always)]
fn mix_at_once(a: &Lanes, b: &Lanes, [upper, lower]: &[Lanes; 2]) -> [u8; 4 * AT_ONCE] {
    let product = |a: u16, b: u16| ((u32::from(a) * u32::from(b)) >> 16) as u16;
    let mut bytes = [0; 4 * AT_ONCE];
    for (lane, byte) in bytes.iter_mut().enumerate() {
        *byte = ((product(a[lane], upper[lane]) + product(b[lane], lower[lane]) + 128) >> 8) as u8;
    }
    bytes
}

#[inline(always)]
fn write(to: &mut [u32], bytes: [u8; 4 * AT_ONCE]) {
    let (pixels, _) = bytes.as_chunks::<4>();
    for (to, pixel) in to.iter_mut().zip(pixels) {
        *to = u32::from_le_bytes(*pixel);
    }
}
