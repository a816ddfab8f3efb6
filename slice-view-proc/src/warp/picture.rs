//! Slices of organs where they lie now.

use geometry::SlicePlane;

use super::cut::Piece;
use super::lattice::Lattice;
use super::quadratic::{bend, bernstein, halves};
use super::raster::{Canvas, FARTHEST, FOLDED, PART};
use super::shape::{Held, Placed, Shape};

/// Organs in one image, at most.
const MOST_ORGANS: usize = 64;
/// A bound on the distance from the plane counts as crossing it within this part of the largest distance: rounding of either side.
const CROSSING: f64 = 1e-9;
/// Corners of pieces are moved to the raster's grid, by half of 1/256 of a pixel along both axes: so far from its cube a pixel may be drawn.
const GRID_PART: f64 = 1.0 / 256.0;
/// Half the square of the radius of the ball about a tetrahedron, by the square of the piece's side: a linear function through the corners is
/// off by at most so much of the second derivative within.
const CHORD: f64 = 3.0 / 8.0;

/// An organ where it lies now.
#[derive(Debug, Clone, Copy)]
pub struct Organ<'a> {
    /// The organ at rest.
    pub shape: &'a Shape,
    /// Its nodes now, mm in the CT's frame.
    pub places: &'a [[f32; 3]],
}

/// What lies at a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pixel {
    /// No organ, now or at rest: the CT as it is.
    #[default]
    Outside,
    /// The organ of this number, from 0.
    Inside(u8),
    /// An organ was here at rest and has gone, or its region reaches beyond its cubes here: nothing is known of what is here now.
    Vacated,
    /// More than one organ, or one twice; of one that is folded, cubes that its surface cuts count whole.
    Twice,
}

/// An image of places.
#[derive(Debug, Clone, Default)]
pub struct Warped {
    /// Row by row.
    pub pixels: Vec<Pixel>,
    /// The place at rest of what lies at a pixel, mm in the CT's frame: the pixel's own where nothing moved; of no meaning where two claim
    /// it, or it is vacated.
    pub rest: Vec<[f32; 3]>,
    /// An estimate of how far `rest` may be from the place that the organs' quadratic maps give, mm, without the rounding of `rest`: of each cube
    /// the bend of its map and a part of a pixel, by the largest stretch of its pieces that were cut. A neighbour that is stretched far more and not cut
    /// is not in it. Outside the organs 0.
    pub error_mm: f64,
    /// Pixels that more than one claims.
    pub twice: usize,
}

/// Why there is no image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoWarp {
    /// Too many organs.
    #[error("{0} organs; {MOST_ORGANS} are allowed")]
    Organs(usize),
    /// Places of another mesh.
    #[error("organ {organ}: places of {found} nodes; its mesh has {expected}")]
    Nodes {
        /// Its number, from 0.
        organ: usize,
        /// Places.
        found: usize,
        /// Nodes.
        expected: usize,
    },
    /// A node is at no place.
    #[error("organ {organ}: node {node} lies at {place:?} mm")]
    Place {
        /// Its number, from 0.
        organ: usize,
        /// The node.
        node: usize,
        /// Where.
        place: [f32; 3],
    },
    /// Pixels that are too small for the organ's pieces.
    #[error("organ {0}: a piece is larger than 131072 pixels")]
    Pixels(usize),
}

/// Draws organs where they lie now, one image after the other in the same memory.
#[derive(Debug, Clone, Default)]
pub struct Warp {
    lattice: Lattice,
    canvas: Canvas,
    found: Warped,
}

impl Warp {
    /// The places at rest of what the plane shows.
    ///
    /// # Errors
    /// [`NoWarp`]; then there is no image.
    pub fn draw(&mut self, plane: &SlicePlane, organs: &[Organ<'_>]) -> Result<&Warped, NoWarp> {
        for (number, organ) in organs.iter().enumerate() {
            check(number, organ)?;
        }
        if organs.len() > MOST_ORGANS {
            return Err(NoWarp::Organs(organs.len()));
        }
        let size = plane.size().map(|n| n as usize);
        self.canvas.begin(size);
        self.found.begin(size[0] * size[1]);
        let view = View::of(plane);
        for (number, organ) in organs.iter().enumerate() {
            self.canvas.begin(size);
            self.lattice.begin(organ.shape);
            let mut drawing = Drawing {
                view: &view,
                organ,
                lattice: &mut self.lattice,
                canvas: &mut self.canvas,
                stretch: 0.0,
            };
            let drawn = drawing.cubes();
            self.found.take(&mut self.canvas, size[0], organ.shape, number as u8);
            // What a refusal has drawn so far is taken away first: the next image begins with an empty canvas.
            self.found.error_mm = self.found.error_mm.max(drawn.ok_or(NoWarp::Pixels(number))?);
        }
        self.found.rest(&view, size, organs);
        Ok(&self.found)
    }
}

fn check(number: usize, organ: &Organ<'_>) -> Result<(), NoWarp> {
    let [found, expected] = [organ.places.len(), organ.shape.nodes];
    if found != expected {
        return Err(NoWarp::Nodes {
            organ: number,
            found,
            expected,
        });
    }
    let bad = organ
        .places
        .iter()
        .position(|place| !place.iter().all(|x| x.is_finite()));
    bad.map_or(Ok(()), |node| {
        Err(NoWarp::Place {
            organ: number,
            node,
            place: organ.places[node],
        })
    })
}

/// The plane as numbers: from the CT's frame to columns, rows and mm behind it, and back.
#[derive(Debug)]
struct View {
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    pixel_mm: f64,
    size: [f64; 2],
}

impl View {
    fn of(plane: &SlicePlane) -> Self {
        let axes = [plane.right(), plane.down(), plane.into_screen()];
        Self {
            origin: plane.origin().mm(),
            axes: axes.map(|axis| axis.components()),
            pixel_mm: plane.pixel_mm(),
            size: plane.size().map(f64::from),
        }
    }

    fn seen(&self, place: [f32; 3]) -> [f64; 3] {
        let from: [f64; 3] = std::array::from_fn(|a| f64::from(place[a]) - self.origin[a]);
        let along = self.axes.map(|axis| (0..3).map(|a| axis[a] * from[a]).sum::<f64>());
        [along[0] / self.pixel_mm, along[1] / self.pixel_mm, along[2]]
    }

    fn place(&self, column: usize, row: usize) -> [f64; 3] {
        let [x, y] = [column, row].map(|k| k as f64 * self.pixel_mm);
        std::array::from_fn(|a| self.origin[a] + self.axes[0][a] * x + self.axes[1][a] * y)
    }
}

/// One organ being drawn.
struct Drawing<'a> {
    view: &'a View,
    organ: &'a Organ<'a>,
    lattice: &'a mut Lattice,
    canvas: &'a mut Canvas,
    /// The largest from now to rest, of the cube at hand.
    stretch: f64,
}

impl Drawing<'_> {
    /// Draws all cubes: the distance of the pieces from the quadratic maps, at rest, mm; none where pixels are too small.
    fn cubes(&mut self) -> Option<f64> {
        let shape = self.organ.shape;
        let seen: Vec<[f64; 3]> = self.organ.places.iter().map(|place| self.view.seen(*place)).collect();
        let mut error = 0.0_f64;
        for cube in &shape.cubes {
            let nodes = cube.nodes.map(|node| seen[node as usize]);
            let depths = bernstein(&nodes.map(|node| node[2]));
            self.stretch = 0.0;
            self.descend(cube, &nodes, &depths, [0; 3], cube.span)?;
            if self.stretch > 0.0 {
                let places = cube.nodes.map(|node| self.organ.places[node as usize].map(f64::from));
                let chord = CHORD * bend(&places) / f64::from(cube.span * cube.span);
                error = error.max((chord + GRID_PART * self.view.pixel_mm) * self.stretch);
            }
        }
        Some(error)
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
        let held = cube.held[(low[0] + cube.span * (low[1] + cube.span * low[2])) as usize];
        if held == Held::Nothing {
            return Some(());
        }
        let shape = self.organ.shape;
        let low = std::array::from_fn(|a| low[a] + cube.corner[a]);
        let corners = self.lattice.piece(cube, nodes, low);
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
            low: shape.at(low),
            side: shape.piece_mm,
            part: held == Held::Part,
        };
        self.stretch = self.stretch.max(piece.draw(self.view.pixel_mm, self.canvas));
        Some(())
    }
}

impl Warped {
    fn begin(&mut self, count: usize) {
        self.pixels.clear();
        self.pixels.resize(count, Pixel::Outside);
        self.rest.resize(count, [0.0; 3]);
        (self.error_mm, self.twice) = (0.0, 0);
    }

    /// Takes over what was drawn of an organ, and leaves the canvas empty.
    fn take(&mut self, canvas: &mut Canvas, width: usize, shape: &Shape, number: u8) {
        let [columns, rows] = canvas.touched;
        for row in rows[0]..rows[1] {
            for at in row * width + columns[0]..row * width + columns[1] {
                let covered = std::mem::take(&mut canvas.covered[at]);
                let marks = std::mem::take(&mut canvas.marks[at]);
                let (rest, folded) = (canvas.rest[at], marks & FOLDED != 0);
                let once = covered == 1 && !folded;
                let beside = once && marks & PART != 0 && shape.region.at(rest.map(f64::from)) >= 0.0;
                if beside || (covered == 0 && !folded) {
                    continue;
                }
                let again = self.pixels[at] != Pixel::Outside || !once;
                self.pixels[at] = if again { Pixel::Twice } else { Pixel::Inside(number) };
                self.rest[at] = rest;
            }
        }
    }

    /// What no organ covers: vacated, or the CT as it is.
    fn rest(&mut self, view: &View, [width, height]: [usize; 2], organs: &[Organ<'_>]) {
        for row in 0..height {
            for column in 0..width {
                let at = row * width + column;
                match self.pixels[at] {
                    Pixel::Outside => {
                        let place = view.place(column, row);
                        self.rest[at] = place.map(|x| x as f32);
                        if organs.iter().any(|organ| organ.shape.region.at(place) < 0.0) {
                            self.pixels[at] = Pixel::Vacated;
                        }
                    }
                    Pixel::Twice => self.twice += 1,
                    Pixel::Inside(_) | Pixel::Vacated => {}
                }
            }
        }
    }
}
