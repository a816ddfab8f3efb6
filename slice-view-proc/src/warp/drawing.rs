//! One organ being drawn: its cubes, whole where they are bent little, else by pieces.

use super::border;
use super::corners::Corners;
use super::cut::Piece;
use super::image::Organ;
use super::lattice::Lattice;
use super::placed::{Held, Placed};
use super::quadratic::{bend, bernstein, halves};
use super::raster::{Canvas, FARTHEST};
use super::view::View;
use super::whole::{Drawn, Seat, Whole};

/// A bound on the distance from the plane counts as crossing it within this part of the largest distance: rounding of either side.
const CROSSING: f64 = 1e-9;
/// Corners of pieces are moved to the raster's grid, by half of 1/256 of a pixel along both axes: so far from its cube a pixel may be drawn.
const GRID_PART: f64 = 1.0 / 256.0;
/// Half the square of the radius of the ball about a tetrahedron, by the square of the piece's side: a linear function through the corners is
/// off by at most so much of the second derivative within.
const CHORD: f64 = 3.0 / 8.0;
/// A function that is quadratic along three axes leaves the range of its 27 values by at most so much of half its width: 1.25 an axis.
const BEYOND: f64 = 1.953_125;

/// Memory for one organ after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Tools {
    pub(super) lattice: Lattice,
    pub(super) canvas: Canvas,
    whole: Whole,
    /// No cube is drawn whole: slowly, for tests.
    pub(super) by_pieces: bool,
    behind: Vec<f64>,
    /// The cubes that were drawn whole and have a border, and how exact each is; none elsewhere.
    wholes: Vec<usize>,
    drawn: Vec<Option<Drawn>>,
}

/// One organ being drawn.
pub(super) struct Drawing<'a> {
    pub(super) view: &'a View,
    pub(super) organ: &'a Organ<'a>,
    pub(super) tools: &'a mut Tools,
    /// The largest from now to rest, of the cube at hand.
    pub(super) stretch: f64,
}

impl Drawing<'_> {
    /// Draws all cubes: the distance of what is drawn from the quadratic maps, at rest, mm; none where pixels are too small.
    #[inline(always)]
    pub(super) fn cubes(&mut self) -> Option<f64> {
        let (shape, view, places) = (self.organ.shape, self.view, self.organ.places);
        let behind = &mut self.tools.behind;
        behind.resize(places.len(), 0.0);
        for (behind, place) in behind.iter_mut().zip(places) {
            *behind = view.behind(*place);
        }
        self.tools.wholes.clear();
        self.tools.drawn.clear();
        self.tools.drawn.resize(shape.cubes.len(), None);
        let (mut error, mut most) = (0.0_f64, Drawn::default());
        for (number, cube) in shape.cubes.iter().enumerate() {
            if !self.is_near(cube) {
                continue;
            }
            let mut nodes = [[0.0; 3]; 27];
            for (seen, node) in nodes.iter_mut().zip(cube.nodes) {
                *seen = view.seen(places[node as usize]);
            }
            if self.is_beside(&nodes) {
                continue;
            }
            let Some(drawn) = self.whole(cube, &nodes) else {
                error = error.max(self.pieces(cube, &nodes)?);
                continue;
            };
            error = error.max(drawn.error_mm + GRID_PART * view.pixel_mm * drawn.stretch);
            most.error_mm = most.error_mm.max(drawn.error_mm);
            most.stretch = most.stretch.max(drawn.stretch);
            most.border_mm = most.border_mm.max(drawn.border_mm);
            if drawn.border_mm > 0.0 {
                self.tools.wholes.push(number);
                self.tools.drawn[number] = Some(drawn);
            }
        }
        Some(error.max(most.error_mm + self.border(&most)))
    }

    /// How far places are off that are drawn on the wrong side of a border: the outline is not the faces.
    fn border(&self, most: &Drawn) -> f64 {
        let (shape, tools) = (self.organ.shape, &*self.tools);
        let grid = GRID_PART * self.view.pixel_mm;
        let Some(beside) = &shape.beside else {
            // What a place moves by on either side.
            return 2.0 * (most.border_mm + grid) * most.stretch;
        };
        let mut off = 0.0_f64;
        for number in &tools.wholes {
            // Of two that are drawn whole the lower one serves.
            let cube = &shape.cubes[*number];
            let wanted = |other: usize, axis: usize, upper: bool| {
                let serves = upper || tools.drawn[other].is_none() || shape.cubes[other].span != cube.span;
                serves && border::is_cut(cube, &tools.behind, axis, upper)
            };
            let jump = border::jump(&shape.cubes, &beside[*number], *number, self.organ.places, wanted);
            let near = self.about(*number, &beside[*number], most);
            // So far beyond its cube at rest, by the difference of the maps there, and back to rest.
            off = off.max(jump / shape.piece_mm * (near.border_mm + grid) * near.stretch * near.stretch);
        }
        off
    }

    /// The largest border and stretch of a cube and those beside it; of one that is not drawn whole, as of the worst.
    fn about(&self, number: usize, beside: &border::Beside, most: &Drawn) -> Drawn {
        let drawn = &self.tools.drawn;
        let all = beside.iter().flatten().filter_map(|other| drawn.get(*other as usize));
        let mut found = drawn[number].unwrap_or(*most);
        for other in all.map(|other| other.unwrap_or(*most)) {
            found.border_mm = found.border_mm.max(other.border_mm);
            found.stretch = found.stretch.max(other.stretch);
        }
        found
    }

    /// Whether the plane may pass through a cube.
    #[inline(always)]
    fn is_near(&self, cube: &Placed) -> bool {
        let behind = &self.tools.behind;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for node in cube.nodes {
            let own = behind[node as usize];
            least = if own < least { own } else { least };
            most = if own > most { own } else { most };
        }
        // Corners of two pieces an axis are nodes.
        let beyond = if cube.span > 2 {
            (BEYOND - 1.0) * 0.5 * (most - least)
        } else {
            0.0
        };
        let rounding = CROSSING * most.max(-least);
        least - beyond <= rounding && most + beyond >= -rounding && cube.uniform != Some(Held::Nothing)
    }

    /// Whether all of a cube lies beside the image.
    #[inline(always)]
    fn is_beside(&self, nodes: &[[f64; 3]; 27]) -> bool {
        (0..2).any(|a| {
            let least = nodes.iter().map(|node| node[a]).fold(f64::INFINITY, f64::min);
            let most = nodes.iter().map(|node| node[a]).fold(f64::NEG_INFINITY, f64::max);
            let beyond = (BEYOND - 1.0) * 0.5 * (most - least);
            most + beyond < -1.0 || least - beyond > self.view.size[a]
        })
    }

    #[inline(always)]
    fn whole(&mut self, cube: &Placed, nodes: &[[f64; 3]; 27]) -> Option<Drawn> {
        if self.tools.by_pieces {
            return None;
        }
        let shape = self.organ.shape;
        let half = 0.5 * shape.piece_mm * f64::from(cube.span);
        let seat = Seat {
            middle: shape.at(cube.corner).map(|x| x + half),
            half,
        };
        let Tools {
            lattice, canvas, whole, ..
        } = &mut *self.tools;
        let mut corners = Corners::of(lattice, cube, nodes);
        whole.draw(&mut corners, &seat, self.view.pixel_mm, canvas)
    }

    /// Draws a cube by its pieces: their distance from the quadratic map.
    #[inline(never)]
    fn pieces(&mut self, cube: &Placed, nodes: &[[f64; 3]; 27]) -> Option<f64> {
        let depths = bernstein(&nodes.map(|node| node[2]));
        self.stretch = 0.0;
        self.descend(cube, nodes, &depths, [0; 3], cube.span)?;
        if self.stretch <= 0.0 {
            return Some(0.0);
        }
        let places = cube.nodes.map(|node| self.organ.places[node as usize].map(f64::from));
        let chord = CHORD * bend(&places) / f64::from(cube.span * cube.span);
        Some((chord + GRID_PART * self.view.pixel_mm) * self.stretch)
    }

    /// Draws a block of pieces, `low` and `span` in pieces within the cube, whose distances from the plane have these coefficients.
    fn descend(
        &mut self,
        cube: &Placed,
        nodes: &[[f64; 3]; 27],
        depths: &[f64; 27],
        low: [i32; 3],
        span: i32,
    ) -> Option<()> {
        let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let most = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let rounding = CROSSING * most.max(-least);
        if least > rounding || most < -rounding {
            return Some(());
        }
        if span == 1 {
            return self.piece(cube, nodes, low);
        }
        let half = span / 2;
        for (x, along_x) in halves(depths, 0).iter().enumerate() {
            for (y, along_y) in halves(along_x, 1).iter().enumerate() {
                for (z, depths) in halves(along_y, 2).iter().enumerate() {
                    let step = [x, y, z].map(|k| k as i32 * half);
                    let low = std::array::from_fn(|a| low[a] + step[a]);
                    self.descend(cube, nodes, depths, low, half)?;
                }
            }
        }
        Some(())
    }

    fn piece(&mut self, cube: &Placed, nodes: &[[f64; 3]; 27], low: [i32; 3]) -> Option<()> {
        let held = cube.held(low);
        if held == Held::Nothing {
            return Some(());
        }
        let shape = self.organ.shape;
        let corners = self.tools.lattice.piece(cube, nodes, low);
        for a in 0..2 {
            let least = corners.iter().map(|c| c[a]).fold(f64::INFINITY, f64::min);
            let most = corners.iter().map(|c| c[a]).fold(f64::NEG_INFINITY, f64::max);
            if most < -1.0 || least > self.view.size[a] {
                return Some(());
            }
            if least < -FARTHEST || most > FARTHEST {
                return None;
            }
        }
        let piece = Piece {
            corners,
            low: shape.at(std::array::from_fn(|a| low[a] + cube.corner[a])),
            side: shape.piece_mm,
            part: held == Held::Part,
        };
        self.stretch = self.stretch.max(piece.draw(self.view.pixel_mm, &mut self.tools.canvas));
        Some(())
    }
}
