//! A picture of some of the images of a sequence, with what was seen in them.

use std::io;

use picture::{Anchor, Canvas, Line, Rgb};

/// Tiles of the picture: how many, side by side, and their width in pixels.
const TILES: usize = 24;
const ACROSS: u32 = 4;
const TILE: u32 = 400;
const TITLE: u32 = 20;
const MARK: Rgb = Rgb(255, 64, 64);
const WORDS: Rgb = Rgb(255, 230, 120);
/// Places of a line that are further apart than this share of a tile are of two pieces.
const GAP: f64 = 0.02;

/// What an image shows: places with their names, or why there are none.
pub(crate) type Shown = Result<Vec<([f64; 2], String)>, String>;

/// Some of the images, evenly over the sequence, with what was seen in them.
pub(crate) struct Sheet {
    canvas: Canvas,
    size: [usize; 2],
    tile_height: u32,
    every: usize,
    drawn: u32,
}

/// Where an image was drawn.
struct Tile {
    at: [f64; 2],
    scale: f64,
}

impl Tile {
    fn place(&self, px: [f64; 2]) -> [f64; 2] {
        [
            self.at[0] + (px[0] + 0.5) * self.scale,
            self.at[1] + f64::from(TITLE) + (px[1] + 0.5) * self.scale,
        ]
    }
}

impl Sheet {
    pub(crate) fn new(size: [usize; 2], count: usize) -> Self {
        let tiles = count.min(TILES) as u32;
        let tile_height = ((TILE as usize * size[1]).div_ceil(size[0]) as u32).clamp(20, 4 * TILE);
        let (across, down) = (tiles.min(ACROSS), tiles.div_ceil(ACROSS));
        Self {
            canvas: Canvas::new(across * TILE, down * (tile_height + TITLE)),
            size,
            tile_height,
            every: count.div_ceil(TILES),
            drawn: 0,
        }
    }

    /// Draws an image that is one of those shown, with circles and names.
    pub(crate) fn dots(&mut self, number: u32, grey: &[u8], seen: &Shown) {
        let words = match seen {
            Ok(points) => format!("{} points", points.len()),
            Err(why) => why.clone(),
        };
        let Some(tile) = self.tile(number, grey, &words) else {
            return;
        };
        for (px, name) in seen.iter().flatten() {
            let at = tile.place(*px);
            self.canvas.circle(at, 6.0, Line::solid(MARK, 1.0));
            self.canvas
                .text([at[0] + 8.0, at[1] - 8.0], name, 11.0, WORDS, Anchor::Left);
        }
    }

    /// The same with a line through places from left to right, in pieces where it has gaps.
    pub(crate) fn line(&mut self, number: u32, grey: &[u8], seen: Result<&[[f64; 2]], &str>) {
        let words = match seen {
            Ok(points) => format!("{} points", points.len()),
            Err(why) => why.to_owned(),
        };
        let Some(tile) = self.tile(number, grey, &words) else {
            return;
        };
        let mut piece: Vec<[f64; 2]> = Vec::new();
        for px in seen.unwrap_or_default() {
            let at = tile.place(*px);
            let is_far = |last: &[f64; 2]| (last[0] - at[0]).hypot(last[1] - at[1]) > GAP * f64::from(TILE);
            if piece.last().is_some_and(is_far) {
                self.canvas.polyline(&piece, Line::solid(MARK, 1.0));
                piece.clear();
            }
            piece.push(at);
        }
        self.canvas.polyline(&piece, Line::solid(MARK, 1.0));
    }

    /// The picture as PNG.
    pub(crate) fn png(&self) -> io::Result<Vec<u8>> {
        picture::encode_png(&self.canvas, &[]).map_err(io::Error::other)
    }

    /// Draws an image below its number and words; `None` for those that are not shown.
    fn tile(&mut self, number: u32, grey: &[u8], words: &str) -> Option<Tile> {
        if !(number as usize).is_multiple_of(self.every) {
            return None;
        }
        let (left, top) = (
            self.drawn % ACROSS * TILE,
            self.drawn / ACROSS * (self.tile_height + TITLE),
        );
        self.drawn += 1;
        let [columns, rows] = self.size;
        let scale = f64::from(TILE) / columns as f64;
        let mut rgba = Vec::with_capacity((TILE * self.tile_height * 4) as usize);
        for v in 0..self.tile_height {
            for u in 0..TILE {
                let at = [u, v].map(|x| ((f64::from(x) + 0.5) / scale) as usize);
                let inside = at[0] < columns && at[1] < rows;
                let value = if inside { grey[at[1] * columns + at[0]] } else { 0 };
                rgba.extend([value, value, value, 255]);
            }
        }
        self.canvas.paste(&rgba, TILE, left, top + TITLE);
        let words = format!("{number}: {}", words.chars().take(60).collect::<String>());
        let at = [left, top].map(f64::from);
        let title = [at[0] + 4.0, at[1] + 10.0];
        self.canvas.text(title, &words, 12.0, WORDS, Anchor::Left);
        Some(Tile { at, scale })
    }
}
