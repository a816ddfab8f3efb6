//! What a mesh is cut into, and the numbers of its corners.

use egui::epaint::Vertex;

use super::area::Area;
use super::blend::argb;

/// Bits behind the point of a position in pixels: corners lie on a grid of 1/256, as on most cards.
pub(crate) const GRID: u32 = 8;
/// The middle of a pixel, on that grid.
pub(crate) const MIDDLE: i64 = 1 << (GRID - 1);
/// Positions beyond are refused, pixels: products of two differences then fit into 64 bits with room to spare.
const FARTHEST: f64 = 524_288.0;
/// Texture coordinates beyond are refused.
const FARTHEST_UV: f32 = 1_048_576.0;

/// A corner of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// 1/256 pixel.
    pub(crate) at: [i64; 2],
    /// Parts of the texture's size.
    pub(crate) uv: [f32; 2],
    /// 0xAARRGGBB.
    pub(crate) colour: u32,
}

impl Corner {
    /// `None` for numbers that are not finite or too large.
    pub(crate) fn new(vertex: &Vertex, pixels_per_point: f32) -> Option<Self> {
        let at = [vertex.pos.x, vertex.pos.y].map(|v| f64::from(v) * f64::from(pixels_per_point));
        let uv = [vertex.uv.x, vertex.uv.y];
        // Written so that what is not a number fails.
        let is_near = at.iter().all(|v| v.abs() <= FARTHEST) && uv.iter().all(|v| v.abs() <= FARTHEST_UV);
        is_near.then(|| Self {
            at: at.map(snap),
            uv,
            colour: argb(vertex.color),
        })
    }
}

/// Pixels to the grid.
fn snap(pixels: f64) -> i64 {
    (pixels * f64::from(1 << GRID)).round() as i64
}

/// The same, with what lies too far put where it is refused no more.
pub(crate) fn snap_clamped(points: f32, pixels_per_point: f32) -> i64 {
    snap((f64::from(points) * f64::from(pixels_per_point)).clamp(-FARTHEST, FARTHEST))
}

/// The first pixel whose centre is not before `at` on the grid.
pub(crate) fn first_pixel(at: i64) -> i32 {
    i32::try_from((at + MIDDLE - 1) >> GRID).unwrap_or(i32::MAX)
}

/// A rectangle with sides along the pixels' and one colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quad {
    /// Left, top, right, bottom; 1/256 pixel, in this order.
    pub(crate) sides: [i64; 4],
    /// Texture coordinates at these sides.
    pub(crate) uv: [f32; 4],
    /// By which texels are multiplied, 0xAARRGGBB.
    pub(crate) tint: u32,
}

impl Quad {
    /// Whether the texture is the same everywhere.
    pub(crate) fn is_solid(&self) -> bool {
        let [u0, v0, u1, v1] = self.uv;
        u0 == u1 && v0 == v1
    }

    /// The pixels whose centres are inside; one on the left or upper side is.
    pub(crate) fn area(&self) -> Area {
        let [x0, y0, x1, y1] = self.sides.map(first_pixel);
        Area { x0, y0, x1, y1 }
    }
}

/// What is painted in one go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// One colour everywhere, 0xAARRGGBB.
    Fill(u32),
    /// A lent image, opaque.
    Image(Quad),
    /// Texels times a colour, blended.
    Blend(Quad),
    /// Triangles of the mesh: the first's place among the indices, and how many.
    Triangles {
        /// A multiple of three.
        first: u32,
        /// At least one.
        count: u32,
    },
}

/// A part of a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Item {
    /// Its pixels are all in here; clipped.
    pub(crate) area: Area,
    /// What it is.
    pub(crate) kind: Kind,
    /// The place of its primitive among those of the frame.
    pub(crate) primitive: u32,
    /// Of all that its pixels depend on.
    pub(crate) hash: u64,
}

impl Item {
    /// Whether what lies below shows nowhere in its area.
    pub(crate) fn is_opaque(&self) -> bool {
        match self.kind {
            Kind::Fill(colour) => colour >> 24 == 0xFF,
            Kind::Image(_) => true,
            Kind::Blend(_) | Kind::Triangles { .. } => false,
        }
    }
}

/// One step of a hash. For each `hash` no two words give the same, and for each word no two hashes do, so that chains of
/// equal length which differ in one word never agree; other chains agree with a chance of 2^-64.
#[inline]
pub(crate) fn step(hash: u64, word: u64) -> u64 {
    let mixed = (hash ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    mixed ^ (mixed >> 29)
}

/// The hash of a vertex added to `hash`.
#[inline]
pub(crate) fn step_vertex(hash: u64, vertex: &Vertex) -> u64 {
    let pair = |a: f32, b: f32| (u64::from(a.to_bits()) << 32) | u64::from(b.to_bits());
    let hash = step(hash, pair(vertex.pos.x, vertex.pos.y));
    let hash = step(hash, pair(vertex.uv.x, vertex.uv.y));
    step(hash, u64::from(argb(vertex.color)))
}
