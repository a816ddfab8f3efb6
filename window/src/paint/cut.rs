//! Meshes cut into items: rectangles that have a quick way of their own, and small groups of triangles.

use egui::TextureId;
use egui::epaint::{Mesh, Primitive, Vertex};

use super::area::Area;
use super::blend::{argb, multiply};
use super::item::{Corner, Item, Kind, Quad, first_pixel, snap_clamped, step, step_vertex};
use super::texture::{Source, Textures};
use super::{Frame, Skipped};

/// The most triangles in one item.
const MOST: u32 = 64;
/// Triangles stay in one item while it is at most so wide and high, pixels: what changes in it is repainted as a whole.
const WIDEST: i32 = 64;

/// Cuts the primitives of `frame` into `items`, the lowest first, and counts what cannot be painted.
pub(crate) fn cut(frame: &Frame<'_>, textures: &Textures, items: &mut Vec<Item>) -> Skipped {
    let mut skipped = Skipped::default();
    for (i, clipped) in frame.primitives.iter().enumerate() {
        let clip = Area::clip(clipped.clip_rect, frame.pixels_per_point, Area::screen(frame.size));
        let mesh = match &clipped.primitive {
            Primitive::Mesh(mesh) => mesh,
            Primitive::Callback(_) => {
                skipped.callbacks += 1;
                continue;
            }
        };
        if clip.is_empty() || mesh.indices.is_empty() {
            continue;
        }
        let Some(source) = textures.find(mesh.texture_id, frame.images) else {
            skipped.textures += 1;
            continue;
        };
        let cutter = Cutter {
            mesh,
            source,
            clip,
            pixels_per_point: frame.pixels_per_point,
            primitive: i as u32,
            seed: seed(mesh.texture_id, source),
            open: None,
            items,
        };
        skipped.triangles += cutter.run();
    }
    skipped
}

/// What all items of a mesh depend on.
fn seed(id: TextureId, source: Source<'_>) -> u64 {
    let (kind, number) = match id {
        TextureId::Managed(number) => (1, number),
        TextureId::User(number) => (2, number),
    };
    let [version, size] = source.stamp();
    [kind, number, version, size].into_iter().fold(0, step)
}

struct Cutter<'a> {
    mesh: &'a Mesh,
    source: Source<'a>,
    clip: Area,
    pixels_per_point: f32,
    primitive: u32,
    seed: u64,
    /// A group that may grow.
    open: Option<Group>,
    items: &'a mut Vec<Item>,
}

#[derive(Debug, Clone, Copy)]
struct Group {
    first: u32,
    count: u32,
    area: Area,
    hash: u64,
}

impl Cutter<'_> {
    /// The number of triangles that cannot be painted.
    fn run(mut self) -> u32 {
        let mut skipped = 0;
        let mut at = 0;
        while let Some(three) = self.vertices::<3>(at) {
            if let Some(quad) = self.quad(at) {
                self.close();
                self.push_quad(quad, at);
                at += 6;
                continue;
            }
            let area = three.and_then(|three| self.triangle_area(three));
            match (three, area) {
                (Some(three), Some(area)) => self.push_triangle(at, area, three),
                // A gap in the indices closes the group.
                _ => {
                    self.close();
                    skipped += 1;
                }
            }
            at += 3;
        }
        self.close();
        skipped
    }

    /// The vertices of the next `N` indices: `None` past the end, `Some(None)` for an index beyond the vertices.
    fn vertices<const N: usize>(&self, at: usize) -> Option<Option<[Vertex; N]>> {
        let indices: &[u32; N] = self.mesh.indices.get(at..at + N)?.try_into().ok()?;
        let mut vertices = [Vertex::default(); N];
        for (vertex, index) in vertices.iter_mut().zip(indices) {
            match self.mesh.vertices.get(*index as usize) {
                Some(found) => *vertex = *found,
                None => return Some(None),
            }
        }
        Some(Some(vertices))
    }

    /// The two triangles at `at` as a rectangle, if they are one.
    fn quad(&self, at: usize) -> Option<Quad> {
        let six = self.vertices::<6>(at)??;
        if six.iter().any(|vertex| vertex.color != six[0].color) {
            return None;
        }
        let [low, high] = bounds(&six)?;
        // Bit 0: on the right side, bit 1: on the lower one.
        let code = |vertex: Vertex| -> Option<usize> {
            let side = |v: f32, axis: usize| match v {
                v if v == low[axis] => Some(0),
                v if v == high[axis] => Some(1),
                _ => None,
            };
            Some(side(vertex.pos.x, 0)? | (side(vertex.pos.y, 1)? << 1))
        };
        let mut corners: [Option<Vertex>; 4] = [None; 4];
        let mut seen = [0_usize; 2];
        for (i, vertex) in six.into_iter().enumerate() {
            let code = code(vertex)?;
            seen[i / 3] |= 1 << code;
            // Where two vertices share a corner they agree in everything.
            if corners[code]
                .replace(vertex)
                .is_some_and(|other| !same_uv(&other, &vertex))
            {
                return None;
            }
        }
        let missing = seen.map(|seen| 15 ^ seen);
        // Each triangle has three corners, and what one lacks is diagonal to what the other lacks.
        let is_whole = missing.iter().all(|m| m.count_ones() == 1)
            && missing[0].trailing_zeros() ^ missing[1].trailing_zeros() == 3;
        let [left_top, right_top, left_bottom, right_bottom] = corners;
        let (a, b, c, d) = (left_top?.uv, right_top?.uv, left_bottom?.uv, right_bottom?.uv);
        let is_even = a.x == c.x && b.x == d.x && a.y == b.y && c.y == d.y;
        (is_whole && is_even).then(|| self.quad_of([low, high], [a.x, a.y, d.x, d.y], six[0]))?
    }

    fn quad_of(&self, [low, high]: [[f32; 2]; 2], uv: [f32; 4], vertex: Vertex) -> Option<Quad> {
        let is_finite = low.iter().chain(&high).all(|side| side.is_finite());
        let ends = [(low, [uv[0], uv[1]]), (high, [uv[2], uv[3]])].map(|(pos, uv)| {
            let (pos, uv) = (pos.into(), uv.into());
            Corner::new(&Vertex { pos, uv, ..vertex }, self.pixels_per_point)
        });
        // A fill may be as large as it likes; a texture on it would be placed wrongly.
        let is_near = ends.iter().all(Option::is_some);
        let is_usable = is_near || (is_finite && is_solid(uv) && uv[0].is_finite() && uv[1].is_finite());
        let side = |v: f32| snap_clamped(v, self.pixels_per_point);
        is_usable.then(|| Quad {
            sides: [side(low[0]), side(low[1]), side(high[0]), side(high[1])],
            uv,
            tint: argb(vertex.color),
        })
    }

    fn push_quad(&mut self, quad: Quad, at: usize) {
        let area = quad.area().intersect(self.clip);
        if area.is_empty() {
            return;
        }
        let kind = match self.source {
            source if is_solid(quad.uv) => Kind::Fill(multiply(quad.tint, source.at([quad.uv[0], quad.uv[1]]))),
            Source::Lent(_) if quad.tint >> 24 == 0xFF => Kind::Image(quad),
            _ => Kind::Blend(quad),
        };
        let hash = match kind {
            // Nothing is added and nothing covered.
            Kind::Fill(0) => return,
            // Its colour is all there is to it: a font that gains a letter changes no fill.
            Kind::Fill(colour) => step(0, u64::from(colour)),
            _ => {
                let vertices = self.vertices::<6>(at).flatten();
                let vertices = vertices.iter().flatten();
                vertices.fold(self.seed, step_vertex)
            }
        };
        self.push(area, kind, hash);
    }

    /// The pixels that a triangle may cover; `None` where it cannot be painted.
    fn triangle_area(&self, three: [Vertex; 3]) -> Option<Area> {
        let mut area = Area::NOTHING;
        for vertex in three {
            let [x, y] = Corner::new(&vertex, self.pixels_per_point)?.at.map(first_pixel);
            let (x1, y1) = (x + 1, y + 1);
            area = area.union(Area { x0: x, y0: y, x1, y1 });
        }
        Some(area.intersect(self.clip))
    }

    fn push_triangle(&mut self, at: usize, area: Area, three: [Vertex; 3]) {
        if area.is_empty() {
            // What is clipped away leaves no gap: it may be painted with its neighbours.
            return self.close();
        }
        let hash = |hash: u64| three.iter().fold(hash, step_vertex);
        if let Some(group) = &mut self.open {
            let union = group.area.union(area);
            let is_small = union.x1 - union.x0 <= WIDEST && union.y1 - union.y0 <= WIDEST;
            if is_small && group.count < MOST {
                group.area = union;
                group.count += 1;
                group.hash = hash(group.hash);
                return;
            }
        }
        self.close();
        self.open = Some(Group {
            first: at as u32,
            count: 1,
            area,
            hash: hash(self.seed),
        });
    }

    fn close(&mut self) {
        if let Some(Group {
            first,
            count,
            area,
            hash,
        }) = self.open.take()
        {
            self.push(area, Kind::Triangles { first, count }, hash);
        }
    }

    fn push(&mut self, area: Area, kind: Kind, hash: u64) {
        // The clip is in the hash, as the same triangles elsewhere clipped are others.
        let words = [area.x0, area.y0, area.x1, area.y1].map(|side| u64::from(side.unsigned_abs()));
        let hash = words.into_iter().fold(hash, step);
        self.items.push(Item {
            area,
            kind,
            primitive: self.primitive,
            hash,
        });
    }
}

/// Compares numbers: positions of egui panic where they are none.
fn same_uv(a: &Vertex, b: &Vertex) -> bool {
    a.uv.x == b.uv.x && a.uv.y == b.uv.y
}

/// Whether the texture is the same everywhere.
fn is_solid(uv: [f32; 4]) -> bool {
    uv[0] == uv[2] && uv[1] == uv[3]
}

/// The least and greatest position; `None` where they are the same in one axis or not numbers.
fn bounds(vertices: &[Vertex; 6]) -> Option<[[f32; 2]; 2]> {
    let [a, b, c] = [vertices[0].pos, vertices[1].pos, vertices[2].pos];
    let low = [a.x.min(b.x).min(c.x), a.y.min(b.y).min(c.y)];
    let high = [a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y)];
    (low[0] < high[0] && low[1] < high[1]).then_some([low, high])
}
