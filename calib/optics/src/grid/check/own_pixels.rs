//! What the pixels of each disc say of its outline, whatever its own grey and the light about it are.
//!
//! The normal equations of one disc (outline 5, blur, contrast, a plane of grey) with the four of grey eliminated: they are
//! linear, so that what is left is exact for the outline given. Light that no plane of the whole image follows moves nothing so.

use std::collections::HashMap;

use nalgebra::{Matrix2, Matrix4, Matrix4x6, Matrix6, Vector2, Vector4, Vector6};

use crate::disc::{Blurred, Ellipse, Equations, REACH, Raster, Sums};
use crate::grid::fit::paper_edge::Border;
use crate::grid::lattice::Cell;
use crate::image::Image;

/// The fewest pixels that tell an outline and four numbers of grey.
// Twice the ten numbers: outline 5, blur 1, grey 4.
const MIN_PIXELS: usize = 20;
/// Windows are thinned where so many pixels are left.
const THINNED_FROM_PIXELS: usize = 60;
/// Discs up to so many steps away may be seen by a disc's pixels.
const AROUND_STEPS: i32 = 3;

/// A disc as it is when its pixels are chosen.
pub(crate) struct Chosen {
    pub(crate) cell: Cell,
    pub(crate) outline: Ellipse,
    /// Pixels for a step of the grid there.
    pub(crate) pitch: Matrix2<f64>,
}

/// Which pixels are looked at, of discs that have many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Part {
    All,
    /// One of so many, all over.
    Pixels(usize),
    /// Those of one of so many rows.
    Rows(usize),
}

/// A disc's pixels: nearer to it than to the next place of the grid, and near its outline.
struct Window {
    columns: [usize; 2],
    /// Each row's pixels.
    rows: Vec<(usize, Vec<usize>)>,
    /// Where its plane of grey has its value.
    origin: Vector2<f64>,
    /// The discs about it whose blur may reach it.
    near: Vec<usize>,
}

/// The light about a disc.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Greys {
    /// Disc less paper at the disc's middle, grey levels.
    pub(crate) contrast: f64,
    /// How that changes along x and y, a pixel: what the discs about it say, not its own pixels.
    pub(crate) change: Vector2<f64>,
    /// The paper's grey at the disc's middle and its slopes.
    pub(crate) paper: [f64; 3],
}

/// What a disc's pixels say of outline and blur.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) matrix: Matrix6<f64>,
    pub(crate) vector: Vector6<f64>,
    pub(crate) squares: f64,
    pub(crate) pixels: usize,
    pub(crate) greys: Greys,
}

/// Discs and their pixels.
pub(crate) struct OwnPixels<'a> {
    image: &'a Image,
    windows: Vec<Window>,
}

/// One set of outlines that all discs are asked for.
pub(crate) struct Guess<'a> {
    pub(crate) outlines: &'a [Ellipse],
    pub(crate) sigma: f64,
    pub(crate) greys: &'a [Greys],
}

/// Room that is used again from disc to disc.
#[derive(Default)]
pub(crate) struct Room {
    own: Raster,
    others: Vec<Raster>,
}

impl<'a> OwnPixels<'a> {
    /// Pixels up to `margin` from the outlines, and not nearer than `clear` to where paper is not taken for granted, pixels.
    pub(crate) fn new(
        image: &'a Image,
        chosen: &[Chosen],
        sigma: f64,
        margin: f64,
        clear: f64,
        part: Part,
    ) -> Option<Self> {
        let (width, height) = (image.width(), image.height());
        let box_of = |c: &Chosen, margin: f64| Blurred::new(c.outline, sigma).window(margin, width, height);
        let reached: Vec<_> = chosen.iter().map(|c| box_of(c, REACH * sigma)).collect();
        let places: HashMap<Cell, usize> = chosen.iter().enumerate().map(|(i, c)| (c.cell, i)).collect();
        let border = Border::of(chosen.iter().map(|c| c.cell));
        let one = |c: &Chosen| {
            let [columns, rows] = box_of(c, margin);
            // The derivative at the disc is enough for half a step.
            let back = c.pitch.try_inverse()?;
            let area = (columns[1] - columns[0]) * (rows[1] - rows[0]);
            // A large disc has more pixels than its centre needs: some of them say it nearly as well.
            let [thin, every] = match part {
                Part::Pixels(n) if area >= THINNED_FROM_PIXELS * n => [n, 1],
                Part::Rows(n) if area >= THINNED_FROM_PIXELS * n => [1, n],
                _ => [1, 1],
            };
            let range = border.range(c.cell, &c.pitch, clear, 0.5);
            let own = |x: usize, y: usize| {
                let off = back * (Vector2::new(x as f64, y as f64) - c.outline.centre);
                (x + 2 * y).is_multiple_of(thin) && range.holds(&off)
            };
            let row = |y: usize| (y, (columns[0]..columns[1]).filter(|x| own(*x, y)).collect::<Vec<_>>());
            // Only discs whose blur reaches the window are taken out of its pixels; a few steps away is far enough to look.
            let around = (-AROUND_STEPS..=AROUND_STEPS)
                .flat_map(|dy| (-AROUND_STEPS..=AROUND_STEPS).map(move |dx| [dx, dy]))
                .filter(|d| *d != [0, 0]);
            let near = around.filter_map(|[dx, dy]| places.get(&[c.cell[0] + dx, c.cell[1] + dy]).copied());
            let meets = |j: &usize| meet(reached[*j][0], columns) && meet(reached[*j][1], rows);
            Some(Window {
                columns,
                rows: (rows[0]..rows[1])
                    .filter(|y| y.is_multiple_of(every))
                    .map(row)
                    .collect(),
                origin: c.outline.centre,
                near: near.filter(meets).collect(),
            })
        };
        let windows: Option<Vec<Window>> = chosen.iter().map(one).collect();
        Some(Self {
            image,
            windows: windows?,
        })
    }

    pub(crate) fn count(&self) -> usize {
        self.windows.len()
    }

    /// Shows each pixel of a disc: its column and its way from the disc's middle, the disc's coverage and contrast there, and
    /// the pixel less what other discs and the paper give.
    fn visit(&self, i: usize, all: &Guess, room: &mut Room, mut see: impl FnMut([f64; 3], &Raster, f64, f64)) {
        let (window, greys) = (&self.windows[i], &all.greys[i]);
        let Room { own, others } = room;
        own.set(all.outlines[i], all.sigma, window.columns);
        // Never made shorter: a raster keeps its memory from disc to disc.
        others.resize_with(window.near.len().max(others.len()), Raster::default);
        let near = &mut others[..window.near.len()];
        for (raster, j) in near.iter_mut().zip(&window.near) {
            raster.set(all.outlines[*j], all.sigma, window.columns);
        }
        for (y, pixels) in &window.rows {
            own.row(*y);
            near.iter_mut().for_each(|r| r.row(*y));
            for x in pixels {
                // From where the disc was when its pixels were chosen: greys stay about the same place while the
                // outline moves.
                let (dx, dy) = (*x as f64 - window.origin.x, *y as f64 - window.origin.y);
                let others = near.iter().zip(&window.near);
                let rest: f64 = others.map(|(r, j)| r.value(*x) * all.greys[*j].contrast).sum();
                let paper = greys.paper[0] + greys.paper[1] * dx + greys.paper[2] * dy;
                let contrast = greys.contrast + greys.change.x * dx + greys.change.y * dy;
                let value = f64::from(self.image.sample(*x, *y)) - paper - rest;
                see([*x as f64, dx, dy], own, contrast, value);
            }
        }
    }

    /// What a disc says, by pixels that are off by at most `limit`; none where that is too little.
    pub(crate) fn block(&self, i: usize, all: &Guess, limit: f64, room: &mut Room) -> Option<Block> {
        let (mut sums, greys) = (Sums::default(), all.greys[i]);
        self.visit(i, all, room, |[x, dx, dy], own, contrast, value| {
            let seen = own.at(x as usize);
            let residual = value - contrast * seen.value;
            if residual.abs() <= limit {
                let [a, b, c, d, e, f] = seen.slope.map(|s| s * contrast);
                // Room is for twelve numbers: outline and blur six, grey four, and two that stay 0.
                sums.add(&[a, b, c, d, e, f, seen.value, 1.0, dx, dy, 0.0, 0.0], residual);
            }
        });
        reduced(&sums.equations(), greys)
    }

    /// How far off each of a disc's pixels is.
    pub(crate) fn residuals(&self, i: usize, all: &Guess, room: &mut Room) -> Vec<f64> {
        let mut out = Vec::new();
        self.visit(i, all, room, |[x, ..], own, contrast, value| {
            out.push(value - contrast * own.value(x as usize));
        });
        out
    }

    /// Keeps some of a disc's pixels, in the order of [`OwnPixels::residuals`].
    pub(crate) fn retain(&mut self, i: usize, stays: &[bool]) {
        let mut next = stays.iter();
        for (_, pixels) in &mut self.windows[i].rows {
            pixels.retain(|_| next.next().copied().unwrap_or(true));
        }
    }
}

/// The normal equations without the greys, which are given the best values.
fn reduced(all: &Equations, greys: Greys) -> Option<Block> {
    if all.pixels < MIN_PIXELS {
        return None;
    }
    let grey: Matrix4<f64> = all.matrix.fixed_view::<4, 4>(6, 6).into_owned();
    let between: Matrix4x6<f64> = all.matrix.fixed_view::<4, 6>(6, 0).into_owned();
    let vector: Vector4<f64> = all.vector.fixed_rows::<4>(6).into_owned();
    // The Schur complement of the greys' block; without a factor the pixels do not tell contrast from paper.
    let factor = grey.cholesky()?;
    let (step, across) = (factor.solve(&vector), factor.solve(&between));
    Some(Block {
        matrix: all.matrix.fixed_view::<6, 6>(0, 0) - between.transpose() * across,
        vector: all.vector.fixed_rows::<6>(0) - between.transpose() * step,
        // The squares that the best greys leave; for a perfect fit rounding may take a little too much away.
        squares: (all.squares - vector.dot(&step)).max(0.0),
        pixels: all.pixels,
        greys: Greys {
            contrast: greys.contrast + step[0],
            paper: std::array::from_fn(|k| greys.paper[k] + step[k + 1]),
            ..greys
        },
    })
}

/// Whether two ranges have something in common.
fn meet(a: [usize; 2], b: [usize; 2]) -> bool {
    a[0] < b[1] && b[0] < a[1]
}
