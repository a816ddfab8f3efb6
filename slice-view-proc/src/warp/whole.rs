//! A cube that is bent little, drawn without its pieces: its outline is that of the pieces, but within it lies the inverse of the quadratic
//! map itself, by Newton's method on a coarse grid of pixels.

use super::corners::Corners;
use super::inverse::{LEFT, Map, Stretch};
use super::outline::{MOST_SPAN, Outline};
use super::placed::Held;
use super::raster::{Canvas, PART};
use super::sheet::{MOST_TILE, Sheet};

/// By how much the slope may change within a cube, of the slope in its middle: below 1 nothing is turned inside out.
const MOST_CHANGE: f32 = 0.95;
/// By how much the slope may change from a node to the pixels about it, of the slope there.
const MOST_BETWEEN: f64 = 0.3;
/// What lies between nodes may be off by so much, mm, by its bound: of large pieces a third of theirs would be more than a pixel.
const MOST_OFF_MM: f64 = 0.2;
/// Columns and rows of nodes, at most.
const FAR: f64 = 32_768.0;

/// Memory for one cube after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Whole {
    outlines: [Outline; 2],
    sheet: Sheet,
}

/// Where a cube is at rest, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seat {
    pub(super) middle: [f64; 3],
    /// Half its side.
    pub(super) half: f64,
}

/// How exact a cube is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Drawn {
    /// How far the places that are drawn may be from the quadratic map's, mm at rest.
    pub(super) error_mm: f64,
    /// The largest stretch from now to rest.
    pub(super) stretch: f64,
    /// How far the outline may be from the faces, mm now.
    pub(super) border_mm: f64,
}

impl Whole {
    /// Draws a cube; none where that must be left to its pieces, and then nothing was drawn.
    #[inline(always)]
    pub(super) fn draw(
        &mut self,
        corners: &mut Corners<'_>,
        seat: &Seat,
        pixel_mm: f64,
        canvas: &mut Canvas,
    ) -> Option<Drawn> {
        let span = corners.cube.span;
        let near = |node: &[f64; 3]| node[0].abs() <= FAR && node[1].abs() <= FAR;
        if span > MOST_SPAN || !corners.nodes.iter().all(near) {
            return None;
        }
        let map = Map::of(corners.nodes, 1.0 / pixel_mm)?;
        let own = map.stretch();
        let bend = map.bend(1.0);
        // A number that is none does not fit.
        let fits = own.norm.sqrt() * bend * 3.0_f32.sqrt() <= MOST_CHANGE;
        if !fits {
            return None;
        }
        let kinds = [Held::All, Held::Part];
        for (outline, kind) in self.outlines.iter_mut().zip(kinds) {
            outline.begin(canvas.size[1]);
            if corners.cube.holds(kind) {
                outline.trace(corners, kind);
                outline.close();
            }
        }
        if self.outlines.iter().any(Outline::is_full) {
            return None;
        }
        let mut tile = tile(span, own);
        let drawn = loop {
            if !self.sheet.lay(&self.outlines, tile, canvas.size[0], &map) {
                return Some(Drawn::default());
            }
            // Nodes nearer by reach less far beyond the cube, and the slope changes less between them.
            match self.solve(&map, tile, seat, pixel_mm) {
                Some(drawn) if tile == 1 || drawn.error_mm <= MOST_OFF_MM => break drawn,
                None if tile == 1 => return None,
                _ => tile /= 2,
            }
        };
        let Self { outlines, sheet } = self;
        sheet.take(seat.middle, seat.half);
        sheet.draw(outlines, [0, PART], canvas);
        let border_mm = f64::from(bend) / f64::from(span * span) * pixel_mm;
        Some(Drawn { border_mm, ..drawn })
    }

    /// Finds the nodes' places, and how far what lies between them may be from the map's inverse.
    #[inline(always)]
    fn solve(&mut self, map: &Map, tile: usize, seat: &Seat, pixel_mm: f64) -> Option<Drawn> {
        // Nodes lie outside of the cube by a tile and some, along both axes of the image.
        let beyond = map.slope.map(|row| 1.25 * tile as f32 * (row[0].abs() + row[1].abs()));
        let reach = 1.1 + beyond.into_iter().fold(0.0, f32::max);
        let bend = map.bend(reach);
        let found = map.solve(&mut self.sheet.nodes, bend)?;
        let fits = found.reach <= reach;
        if !fits {
            return None;
        }
        let [norm, within] = [found.stretch.norm.sqrt(), found.stretch.within].map(f64::from);
        let (bend, tile) = (f64::from(bend), if tile > 1 { tile as f64 } else { 0.0 });
        // A pixel is at most tile / sqrt 2 from a node.
        let between = norm * bend * tile * (within / 2.0).sqrt();
        let fits = between <= MOST_BETWEEN;
        if !fits {
            return None;
        }
        let grown = 1.0 / (1.0 - between);
        // Bilinear: an eighth of the square of the step times the second derivatives of the inverse along both axes.
        let bilinear = tile * tile / 8.0 * norm * within * bend * grown.powi(3);
        Some(Drawn {
            error_mm: (bilinear + LEFT) * seat.half,
            stretch: norm * grown * seat.half / pixel_mm,
            border_mm: 0.0,
        })
    }
}

/// Pixels from node to node: so that the grid's error is about a third of that of pieces.
fn tile(span: i32, stretch: Stretch) -> usize {
    let most = 4.0 / ((span * span) as f32 * stretch.within);
    let mut tile = MOST_TILE;
    while tile > 1 && (tile * tile) as f32 > most {
        tile /= 2;
    }
    tile
}
