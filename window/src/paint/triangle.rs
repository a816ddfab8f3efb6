//! Triangles with a colour at each corner, and a texture where they have one.
//!
//! A pixel is inside where its centre is; one on a side belongs to the triangle whose left or upper side it is, so that
//! triangles which share a side paint each pixel once. Colours and texture coordinates go along by sums of whole numbers that
//! begin where the row begins, before clipping: a pixel is the same whatever part of the triangle is painted.

use super::area::{Area, Canvas};
use super::blend::{multiply, over, over_row};
use super::item::{Corner, GRID, MIDDLE, first_pixel};
use super::texture::{Source, Texels, sample};

/// Bits behind the point of what is interpolated over a triangle.
const BITS: i32 = 32;
/// Bits behind the point of colours along a row.
const ROW_BITS: i32 = 16;

/// Paints the part of a triangle that lies in `area`, a part of the canvas's.
pub(crate) fn paint(canvas: &mut Canvas<'_>, source: Source<'_>, mut corners: [Corner; 3], area: Area) {
    let twice = twice_area(&corners);
    if twice == 0 {
        return;
    }
    // egui turns its triangles either way.
    if twice < 0 {
        corners.swap(1, 2);
    }
    let shape = Shape::new(&corners);
    let [a, b, c] = corners;
    if !(a.uv == b.uv && a.uv == c.uv) {
        return match source {
            Source::Kept(texture) => textured(canvas, &shape, &corners, texture, area),
            Source::Lent(image) => textured(canvas, &shape, &corners, image, area),
        };
    }
    let texel = source.at(a.uv);
    let colours = corners.map(|corner| multiply(corner.colour, texel));
    if colours == [colours[0]; 3] {
        if colours[0] != 0 {
            shape.each_row(area, |y, _, x0, x1| over_row(canvas.row(y, x0, x1), colours[0]));
        }
    } else {
        shaded(canvas, &shape, &corners, colours, area);
    }
}

/// Positive where the corners go clockwise on the screen.
fn twice_area([a, b, c]: &[Corner; 3]) -> i64 {
    (b.at[0] - a.at[0]) * (c.at[1] - a.at[1]) - (b.at[1] - a.at[1]) * (c.at[0] - a.at[0])
}

/// A side, and what is on its inner half.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: [i64; 2],
    along: [i64; 2],
    /// 0 for a left or upper side, which is inside itself, else -1.
    bias: i64,
}

impl Side {
    fn new(from: Corner, to: Corner) -> Self {
        let along = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
        // Clockwise, an upper side goes to the right, and a left one up.
        let is_inside = along[1] < 0 || (along[1] == 0 && along[0] > 0);
        Self {
            from: from.at,
            along,
            bias: if is_inside { 0 } else { -1 },
        }
    }

    /// Cuts the pixels of row `y` to those on the inner half.
    fn cut(&self, y: i64, [x0, x1]: [i64; 2]) -> [i64; 2] {
        let [along_x, along_y] = self.along;
        let at_zero = along_x * (y - self.from[1]) - along_y * (MIDDLE - self.from[0]) + self.bias;
        let step = -(along_y << GRID);
        match step {
            0 if at_zero < 0 => [x0, x0],
            0 => [x0, x1],
            // The first pixel at which it is not negative.
            1.. => [x0.max(-at_zero.div_euclid(step)), x1],
            // The one after the last such.
            _ => [x0, x1.min(at_zero.div_euclid(-step) + 1)],
        }
    }
}

/// The pixels of a triangle.
struct Shape {
    sides: [Side; 3],
    bounds: Area,
}

impl Shape {
    fn new(corners: &[Corner; 3]) -> Self {
        let [a, b, c] = *corners;
        let low = |axis: usize| first_pixel(a.at[axis].min(b.at[axis]).min(c.at[axis]));
        let high = |axis: usize| first_pixel(a.at[axis].max(b.at[axis]).max(c.at[axis]) + 1);
        Self {
            sides: [Side::new(a, b), Side::new(b, c), Side::new(c, a)],
            bounds: Area {
                x0: low(0),
                y0: low(1),
                x1: high(0),
                y1: high(1),
            },
        }
    }

    /// Calls `paint` with y, the row's first pixel before clipping, and the first and the one after the last in `area`.
    fn each_row(&self, area: Area, mut paint: impl FnMut(i32, i32, i32, i32)) {
        let Area { x0, x1, .. } = self.bounds;
        for y in area.y0.max(self.bounds.y0)..area.y1.min(self.bounds.y1) {
            let middle = (i64::from(y) << GRID) + MIDDLE;
            let all = [i64::from(x0), i64::from(x1)];
            let [from, to] = self.sides.iter().fold(all, |range, side| side.cut(middle, range));
            // Within the bounds by now, or empty.
            let (from, to) = (from as i32, to.min(i64::from(x1)) as i32);
            let (start, end) = (from.max(area.x0), to.min(area.x1));
            if start < end {
                paint(y, from, start, end);
            }
        }
    }
}

/// A number that is linear over a triangle, with [`BITS`] behind the point. Sums wrap; what is inside the triangle is between the
/// corners' values and comes out right.
#[derive(Debug, Clone, Copy)]
struct Plane {
    at: [i64; 2],
    start: i64,
    /// For each 1/256 pixel across and down.
    slope: [i64; 2],
}

impl Plane {
    fn new(corners: &[Corner; 3], values: [f64; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| corner.at);
        let [p, q] = [values[1] - values[0], values[2] - values[0]];
        let [to_b, to_c] = [b, c].map(|end| [(end[0] - a[0]) as f64, (end[1] - a[1]) as f64]);
        let scale = f64::from(BITS).exp2();
        let twice = to_b[0] * to_c[1] - to_b[1] * to_c[0];
        let across = (p * to_c[1] - q * to_b[1]) / twice;
        let down = (q * to_b[0] - p * to_c[0]) / twice;
        Self {
            at: a,
            start: (values[0] * scale) as i64,
            slope: [across, down].map(|slope| (slope * scale).round() as i64),
        }
    }

    /// At the middle of a pixel.
    fn value(&self, x: i32, y: i32) -> i64 {
        let off = |pixel: i32, at: i64| (i64::from(pixel) << GRID) + MIDDLE - at;
        self.start
            .wrapping_add(self.slope[0].wrapping_mul(off(x, self.at[0])))
            .wrapping_add(self.slope[1].wrapping_mul(off(y, self.at[1])))
    }

    /// From one pixel to the next.
    fn step(&self) -> i64 {
        self.slope[0].wrapping_mul(1 << GRID)
    }
}

/// The planes of the four channels of colours, alpha first.
fn planes(corners: &[Corner; 3], colours: [u32; 3]) -> [Plane; 4] {
    [24, 16, 8, 0].map(|shift| Plane::new(corners, colours.map(|colour| f64::from((colour >> shift) & 0xFF))))
}

/// Colours along a row, alpha first, with [`ROW_BITS`] behind the point.
#[derive(Clone, Copy)]
struct Run {
    value: [i32; 4],
    step: [i32; 4],
}

impl Run {
    /// At pixel `x`, where the row begins at `from`.
    fn new(planes: &[Plane; 4], y: i32, from: i32, x: i32) -> Self {
        let short = |value: i64| (value >> (BITS - ROW_BITS)) as i32;
        let step = planes.map(|plane| short(plane.step()));
        let mut value = planes.map(|plane| short(plane.value(from, y)));
        for (value, step) in value.iter_mut().zip(step) {
            *value = value.wrapping_add(step.wrapping_mul(x - from));
        }
        Self { value, step }
    }

    /// This pixel's colour; moves on to the next.
    #[inline]
    fn next(&mut self) -> u32 {
        let level = self
            .value
            .map(|v| (v.wrapping_add(1 << (ROW_BITS - 1)) >> ROW_BITS).clamp(0, 255) as u32);
        for (value, step) in self.value.iter_mut().zip(self.step) {
            *value = value.wrapping_add(step);
        }
        (level[0] << 24) | (level[1] << 16) | (level[2] << 8) | level[3]
    }
}

fn shaded(canvas: &mut Canvas<'_>, shape: &Shape, corners: &[Corner; 3], colours: [u32; 3], area: Area) {
    let planes = planes(corners, colours);
    shape.each_row(area, |y, from, x0, x1| {
        let mut run = Run::new(&planes, y, from, x0);
        for pixel in canvas.row(y, x0, x1) {
            *pixel = over(*pixel, run.next());
        }
    });
}

fn textured(canvas: &mut Canvas<'_>, shape: &Shape, corners: &[Corner; 3], texels: &impl Texels, area: Area) {
    let colours = planes(corners, corners.map(|corner| corner.colour));
    let size = texels.size();
    let place = |axis: usize| {
        let count = size[axis] as f64;
        Plane::new(corners, corners.map(|corner| f64::from(corner.uv[axis]) * count - 0.5))
    };
    let (u, v) = (place(0), place(1));
    shape.each_row(area, |y, from, x0, x1| {
        let mut run = Run::new(&colours, y, from, x0);
        for (pixel, x) in canvas.row(y, x0, x1).iter_mut().zip(x0..) {
            let texel = sample(texels, u.value(x, y), v.value(x, y));
            *pixel = over(*pixel, multiply(run.next(), texel));
        }
    });
}
