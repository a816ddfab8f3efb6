//! The painter that needs no card.

use egui::epaint::Primitive;

use super::area::{Area, Canvas};
use super::blend::{argb, over_row};
use super::cut::cut;
use super::image::{self, Scratch};
use super::item::{Corner, Item, Kind, step};
use super::texture::{Source, Texels, Textures};
use super::tiles::{Tiles, touched};
use super::{Frame, PaintError, Painted, Painter, Pixels, quad, triangle};

/// Paints into memory, one thread, whatever differs from the frame before. Takes no memory once its like was painted.
#[derive(Debug, Default)]
pub struct CpuPainter {
    textures: Textures,
    items: Vec<Item>,
    tiles: Tiles,
    scratch: Scratch,
    damage: Vec<Area>,
}

impl CpuPainter {
    /// A painter without textures.
    pub fn new() -> Self {
        Self::default()
    }

    /// The next frame is painted and reported as a whole: for a frame that was painted and never shown.
    pub fn forget(&mut self) {
        self.tiles.forget();
    }

    /// Cuts the frame into items and adds them to the tiles; the counts of what was skipped.
    fn prepare(&mut self, frame: &Frame<'_>) -> super::Skipped {
        let colour = argb(frame.clear) | 0xFF00_0000;
        self.items.clear();
        self.items.push(Item {
            area: Area::screen(frame.size),
            kind: Kind::Fill(colour),
            primitive: 0,
            hash: step(u64::from(frame.pixels_per_point.to_bits()), u64::from(colour)),
        });
        let skipped = cut(frame, &self.textures, &mut self.items);
        self.tiles.begin(frame.size);
        for (index, item) in self.items.iter().enumerate() {
            self.tiles.add(index as u32, item);
        }
        skipped
    }

    fn paint_changed(&mut self, frame: &Frame<'_>, target: Pixels<'_>) {
        let mut brush = Brush {
            frame,
            textures: &self.textures,
            scratch: &mut self.scratch,
            canvas: Canvas {
                pixels: target.pixels,
                columns: frame.size[0] as usize,
            },
        };
        let age = usize::from(target.age);
        // Row by row of tiles: what lies below and what lies above are painted while the row is in a near cache.
        for row in 0..self.tiles.rows() {
            let mut column = 0;
            while let Some(run) = self.tiles.next_changed(row, column, age) {
                column = run.end;
                for index in self.tiles.touching(row) {
                    let item = &self.items[*index as usize];
                    let [across, _] = touched(item.area);
                    let (mut from, to) = (across.start.max(run.start), across.end.min(run.end));
                    while let Some(seen) = self.tiles.next_seen(row, from..to, *index) {
                        from = seen.end;
                        brush.paint(item, item.area.intersect(self.tiles.tile(seen, row)));
                    }
                }
            }
        }
    }
}

impl Painter for CpuPainter {
    type Target<'t> = Pixels<'t>;

    fn paint(&mut self, frame: Frame<'_>, target: Pixels<'_>) -> Result<Painted<'_>, PaintError> {
        self.textures.set(frame.textures);
        let [columns, rows] = frame.size;
        let found = target.pixels.len();
        if (columns as usize).checked_mul(rows as usize) != Some(found) {
            self.textures.free(frame.textures);
            self.forget();
            return Err(PaintError::Size { columns, rows, found });
        }
        let skipped = self.prepare(&frame);
        let age = usize::from(target.age);
        self.paint_changed(&frame, target);
        self.tiles.damage(age, &mut self.damage);
        self.tiles.end();
        self.textures.free(frame.textures);
        Ok(Painted {
            damage: &self.damage,
            skipped,
        })
    }
}

/// What items are painted with.
struct Brush<'a> {
    frame: &'a Frame<'a>,
    textures: &'a Textures,
    scratch: &'a mut Scratch,
    canvas: Canvas<'a>,
}

impl Brush<'_> {
    /// Paints the part of an item that lies in `area`.
    fn paint(&mut self, item: &Item, area: Area) {
        if let Kind::Fill(colour) = item.kind {
            for y in area.y0..area.y1 {
                over_row(self.canvas.row(y, area.x0, area.x1), colour);
            }
            return;
        }
        let primitive = self.frame.primitives.get(item.primitive as usize);
        let Some(Primitive::Mesh(mesh)) = primitive.map(|clipped| &clipped.primitive) else {
            return;
        };
        let Some(source) = self.textures.find(mesh.texture_id, self.frame.images) else {
            return;
        };
        match (&item.kind, source) {
            // A single column has no pairs to go between.
            (Kind::Image(quad), Source::Lent(image)) if image.size()[0] > 1 => {
                image::paint(&mut self.canvas, image, quad, area, self.scratch);
            }
            (Kind::Image(quad) | Kind::Blend(quad), source) => quad::paint(&mut self.canvas, source, quad, area),
            (Kind::Triangles { first, count }, source) => {
                let start = *first as usize;
                let indices = mesh.indices.get(start..start + 3 * *count as usize).unwrap_or_default();
                for three in indices.as_chunks::<3>().0 {
                    let corner = |index: u32| {
                        let vertex = mesh.vertices.get(index as usize)?;
                        Corner::new(vertex, self.frame.pixels_per_point)
                    };
                    if let [Some(a), Some(b), Some(c)] = three.map(corner) {
                        triangle::paint(&mut self.canvas, source, [a, b, c], area);
                    }
                }
            }
            (Kind::Fill(_), _) => {}
        }
    }
}
