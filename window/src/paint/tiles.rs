//! Which parts of the screen differ from a frame before.
//!
//! The screen is divided into tiles. What a tile shows depends on the items that touch it, in their order, and on nothing
//! else: a hash of them stands for the tile. An opaque item that covers the tile begins its hash anew, as nothing below shows.
//! A tile whose hash is that of a frame before is left as it is; that another content has the same hash has a chance of 2^-64.

use std::ops::Range;

use super::area::Area;
use super::item::{Item, step};

/// Columns and rows of a tile, pixels.
pub(super) const SIDE: i32 = 32;
/// Frames that are remembered: as many as a window system has buffers, and one.
const REMEMBERED: usize = 4;
/// Rectangles of damage among which one is looked for that a run of tiles makes higher.
const LOOK_BACK: usize = 64;

/// The tiles of a screen.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    size: [u32; 2],
    columns: usize,
    rows: usize,
    /// Of this frame.
    hashes: Vec<u64>,
    /// The first item that shows, for each tile.
    first: Vec<u32>,
    /// The items that touch each row of tiles.
    touching: Vec<Vec<u32>>,
    /// Hashes of frames before, the newest first.
    before: Vec<Vec<u64>>,
    /// How many of these hold something.
    known: usize,
}

impl Tiles {
    /// Forgets what was painted.
    pub(crate) fn forget(&mut self) {
        self.known = 0;
    }

    /// Begins a frame.
    pub(crate) fn begin(&mut self, size: [u32; 2]) {
        if self.size != size {
            let count = |n: u32| n.div_ceil(SIDE.unsigned_abs()) as usize;
            (self.columns, self.rows) = (count(size[0]), count(size[1]));
            self.size = size;
            self.forget();
        }
        let tiles = self.columns * self.rows;
        self.hashes.clear();
        self.hashes.resize(tiles, 0);
        self.first.clear();
        self.first.resize(tiles, 0);
        self.touching.iter_mut().for_each(Vec::clear);
        self.touching.resize_with(self.rows, Vec::new);
    }

    /// Adds an item above those before; `index` is its place.
    pub(crate) fn add(&mut self, index: u32, item: &Item) {
        let [columns, rows] = touched(item.area);
        let is_opaque = item.is_opaque();
        for row in rows {
            self.touching[row].push(index);
            for column in columns.clone() {
                let at = row * self.columns + column;
                if is_opaque && item.area.holds(self.tile(column..column + 1, row)) {
                    self.first[at] = index;
                    self.hashes[at] = step(0, item.hash);
                } else {
                    self.hashes[at] = step(self.hashes[at], item.hash);
                }
            }
        }
    }

    /// The pixels of some tiles of a row.
    pub(crate) fn tile(&self, columns: Range<usize>, row: usize) -> Area {
        let side = |tile: usize| (tile as i32).saturating_mul(SIDE);
        Area {
            x0: side(columns.start),
            y0: side(row),
            x1: side(columns.end),
            y1: side(row + 1),
        }
        .intersect(Area::screen(self.size))
    }

    /// Rows of tiles.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// The next tiles of `row`, from `column` on, that differ from the frame `age` frames before.
    pub(crate) fn next_changed(&self, row: usize, column: usize, age: usize) -> Option<Range<usize>> {
        let start = (column..self.columns).find(|column| self.differs(row, *column, age))?;
        let end = (start..self.columns).find(|column| !self.differs(row, *column, age));
        Some(start..end.unwrap_or(self.columns))
    }

    fn differs(&self, row: usize, column: usize, age: usize) -> bool {
        let at = row * self.columns + column;
        age == 0 || age > self.known || self.before[age - 1][at] != self.hashes[at]
    }

    /// The items that touch `row`, in their order.
    pub(crate) fn touching(&self, row: usize) -> &[u32] {
        &self.touching[row]
    }

    /// The next of `columns` where item `index` is not hidden by one above that covers the whole tile.
    pub(crate) fn next_seen(&self, row: usize, columns: Range<usize>, index: u32) -> Option<Range<usize>> {
        let is_seen = |column: &usize| self.first[row * self.columns + column] <= index;
        let start = columns.clone().find(is_seen)?;
        let end = (start..columns.end).find(|column| !is_seen(column));
        Some(start..end.unwrap_or(columns.end))
    }

    /// Writes the tiles that differ from the frame before to `damage`, as rectangles that do not overlap.
    pub(crate) fn damage(&self, age: usize, damage: &mut Vec<Area>) {
        damage.clear();
        // Where the memory's content is unknown, so may be the screen's.
        let age = age.min(1);
        for row in 0..self.rows {
            let mut column = 0;
            while let Some(run) = self.next_changed(row, column, age) {
                column = run.end;
                let area = self.tile(run, row);
                // A run below one of the same width makes that higher. Looking far back would cost more than it saves.
                let near = damage.iter_mut().rev().take(LOOK_BACK);
                let same = |other: &&mut Area| other.x0 == area.x0 && other.x1 == area.x1 && other.y1 == area.y0;
                match near.into_iter().find(same) {
                    Some(above) => above.y1 = area.y1,
                    None => damage.push(area),
                }
            }
        }
    }

    /// Ends a frame: its hashes are what the next one is compared with.
    pub(crate) fn end(&mut self) {
        if self.before.len() < REMEMBERED {
            self.before.push(Vec::new());
        }
        self.before.rotate_right(1);
        std::mem::swap(&mut self.before[0], &mut self.hashes);
        self.known = (self.known + 1).min(self.before.len());
    }
}

/// Columns and rows of the tiles that an area touches.
pub(crate) fn touched(area: Area) -> [Range<usize>; 2] {
    let range = |from: i32, to: i32| {
        let start = (from.max(0) / SIDE) as usize;
        start..(((to.max(0) + SIDE - 1) / SIDE) as usize).max(start)
    };
    [range(area.x0, area.x1), range(area.y0, area.y1)]
}
