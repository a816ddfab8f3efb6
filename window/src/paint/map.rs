//! Where in a texture the pixels of a rectangle lie.

use super::item::{GRID, MIDDLE, Quad, first_pixel};

/// One texel, with 32 bits behind the point.
const ONE: i64 = 1 << 32;
/// A place so near to the centre of a texel is that centre, texels: what coordinates of 24 bits lose in a texture of 4096, and
/// an eighth of a level where the texel beside it is the farthest colour.
const NEAR: i64 = ONE >> 11;

/// The way of texture coordinates along one side of a rectangle, in texels with 32 bits behind the point; whole numbers are
/// centres of texels. Sums of whole numbers: a pixel has its place whatever part of the rectangle is painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    /// The first pixel of the rectangle.
    origin: i32,
    /// Its place.
    start: i64,
    /// From one pixel to the next.
    step: i64,
}

impl Axis {
    /// Both axes of a rectangle on a texture of `size` texels.
    pub(crate) fn both(quad: &Quad, size: [usize; 2]) -> [Self; 2] {
        let [x0, y0, x1, y1] = quad.sides;
        let [u0, v0, u1, v1] = quad.uv;
        [
            Self::new([x0, x1], [u0, u1], size[0]),
            Self::new([y0, y1], [v0, v1], size[1]),
        ]
    }

    fn new(sides: [i64; 2], uv: [f32; 2], count: usize) -> Self {
        let texel = uv.map(|uv| f64::from(uv) * count as f64);
        let per_grid = (texel[1] - texel[0]) / (sides[1] - sides[0]) as f64;
        let origin = first_pixel(sides[0]);
        let before = ((i64::from(origin) << GRID) + MIDDLE - sides[0]) as f64;
        let fixed = |texels: f64| (texels * ONE as f64).round() as i64;
        Self {
            origin,
            start: fixed(texel[0] + before * per_grid - 0.5),
            step: fixed(per_grid * f64::from(1 << GRID)),
        }
    }

    /// The place of pixel `at`.
    #[inline]
    pub(crate) fn place(&self, at: i32) -> i64 {
        let steps = i64::from(at) - i64::from(self.origin);
        self.start.wrapping_add(steps.wrapping_mul(self.step))
    }

    /// The texel under pixel `from`, where each pixel of `from..to` lies on the centre of one of `count` texels.
    pub(crate) fn exact(&self, from: i32, to: i32, count: usize) -> Option<usize> {
        let off = |place: i64| place.wrapping_add(ONE / 2).rem_euclid(ONE) - ONE / 2;
        let ends = [from, to - 1].map(|at| self.place(at));
        let whole = ends.map(|place| place.wrapping_add(ONE / 2) >> 32);
        let is_one = whole[1] - whole[0] == i64::from(to) - 1 - i64::from(from);
        let is_centred = ends.iter().all(|place| off(*place).abs() <= NEAR);
        let is_inside = whole[0] >= 0 && whole[1] < count as i64;
        (is_one && is_centred && is_inside).then(|| usize::try_from(whole[0]).ok())?
    }
}
