//! Pairs of triangles that are a rectangle: nearly all that egui paints, and what has quick ways of its own.

use egui::epaint::Vertex;

use super::blend::argb;
use super::item::{Corner, Quad, snap_clamped};

/// Least and greatest x and y, points.
type Bounds = [[f32; 2]; 2];

/// The rectangle that two triangles of three vertices each are: sides along the pixels', one colour, and texture coordinates
/// that go with x and y alone.
pub(crate) fn find(six: [Vertex; 6], pixels_per_point: f32) -> Option<Quad> {
    // Most triangles that are none have a feather's colours: they cost no more than this.
    if six.iter().any(|vertex| vertex.color != six[0].color) {
        return None;
    }
    let bounds = bounds(&six)?;
    let [left_top, right_top, left_bottom, right_bottom] = corners(&six, bounds)?;
    let is_even = left_top[0] == left_bottom[0]
        && right_top[0] == right_bottom[0]
        && left_top[1] == right_top[1]
        && left_bottom[1] == right_bottom[1];
    let uv = [left_top[0], left_top[1], right_bottom[0], right_bottom[1]];
    is_even.then(|| quad(bounds, uv, six[0], pixels_per_point))?
}

/// The least and greatest position; `None` where they are the same in one axis or not numbers.
fn bounds(vertices: &[Vertex; 6]) -> Option<Bounds> {
    let [a, b, c] = [vertices[0].pos, vertices[1].pos, vertices[2].pos];
    let low = [a.x.min(b.x).min(c.x), a.y.min(b.y).min(c.y)];
    let high = [a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y)];
    (low[0] < high[0] && low[1] < high[1]).then_some([low, high])
}

/// Texture coordinates left and right above, left and right below, where the triangles make up the rectangle of `bounds`.
fn corners(six: &[Vertex; 6], bounds: Bounds) -> Option<[[f32; 2]; 4]> {
    let mut corners: [Option<[f32; 2]>; 4] = [None; 4];
    let mut seen = [0_usize; 2];
    for (i, vertex) in six.iter().enumerate() {
        let at = corner(vertex, bounds)?;
        seen[i / 3] |= 1 << at;
        // As numbers: positions of egui panic where they are none.
        let uv = [vertex.uv.x, vertex.uv.y];
        // Where two vertices share a corner they agree in everything.
        if corners[at].replace(uv).is_some_and(|other| other != uv) {
            return None;
        }
    }
    let missing = seen.map(|seen| 15 ^ seen);
    // Each triangle has three corners, and what one lacks is diagonal to what the other lacks.
    let is_whole =
        missing.iter().all(|m| m.count_ones() == 1) && missing[0].trailing_zeros() ^ missing[1].trailing_zeros() == 3;
    let [a, b, c, d] = corners;
    is_whole.then_some([a?, b?, c?, d?])
}

/// Bit 0: on the right side, bit 1: on the lower one; `None` where on no side.
fn corner(vertex: &Vertex, [low, high]: Bounds) -> Option<usize> {
    let side = |v: f32, axis: usize| match v {
        v if v == low[axis] => Some(0),
        v if v == high[axis] => Some(1),
        _ => None,
    };
    Some(side(vertex.pos.x, 0)? | (side(vertex.pos.y, 1)? << 1))
}

fn quad([low, high]: Bounds, uv: [f32; 4], vertex: Vertex, pixels_per_point: f32) -> Option<Quad> {
    let side = |v: f32| snap_clamped(v, pixels_per_point);
    let quad = Quad {
        sides: [side(low[0]), side(low[1]), side(high[0]), side(high[1])],
        uv,
        tint: argb(vertex.color),
    };
    let is_finite = low.iter().chain(&high).chain(&uv).all(|number| number.is_finite());
    let ends = [(low, [uv[0], uv[1]]), (high, [uv[2], uv[3]])];
    let is_near = ends.iter().all(|(pos, uv)| {
        let (pos, uv) = ((*pos).into(), (*uv).into());
        Corner::new(&Vertex { pos, uv, ..vertex }, pixels_per_point).is_some()
    });
    // A fill may be as large as it likes; a texture on it would be placed wrongly.
    (is_near || (is_finite && quad.is_solid())).then_some(quad)
}
