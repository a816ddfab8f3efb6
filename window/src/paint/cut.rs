//! Meshes cut into items: rectangles that have a quick way of their own, and small groups of triangles.

use egui::TextureId;
use egui::epaint::{Mesh, Primitive, Vertex};

use super::area::Area;
use super::blend::multiply;
use super::item::{Corner, Item, Kind, Quad, first_pixel, step, step_vertex};
use super::rectangle;
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
        rectangle::find(self.vertices::<6>(at)??, self.pixels_per_point)
    }

    fn push_quad(&mut self, quad: Quad, at: usize) {
        let area = quad.area().intersect(self.clip);
        if area.is_empty() {
            return;
        }
        let kind = match self.source {
            source if quad.is_solid() => Kind::Fill(multiply(quad.tint, source.at([quad.uv[0], quad.uv[1]]))),
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
