//! The fit of the whole grid, line by line to its border, and what it found.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::error::GridRefused;
use super::evidence::amplitude;
use super::find::{Search, Sized};
use super::found::{Found, GridDisc, Refinement, missing};
use super::homography::project;
use super::lattice::Cell;
use super::place::LINE;
use super::seat::Seat;
use super::whole::{Grid, Whole, point};

/// The share of the discs that must be seen.
pub(crate) const SEEN: f64 = 0.6;
/// A disc is there with half of the expected contrast.
pub(crate) const THERE: f64 = 0.5;
/// And is not one of the grid with more than this share of it.
const NOT_THERE: f64 = 1.6;

/// The blur that the fit starts from, pixels.
const BLUR: f64 = 0.9;

/// A placed lattice on its way to a whole fit.
pub(crate) struct Lines<'a> {
    pub(crate) search: &'a Search<'a>,
    pub(crate) sized: &'a Sized,
}

impl Lines<'_> {
    /// The grid, or why it is refused; none where the model of the whole does not hold.
    pub(crate) fn found(&self) -> Option<Result<Found, GridRefused>> {
        let sized = self.sized;
        let mut fitted = sized.small.clone();
        let mut fit = self.grid(&fitted).near(&sized.placed.h, sized.radius, BLUR)?;
        let mut span = sized.placed.span;
        // Lines that candidates did not reach: as long as discs are seen there, one line further on each side.
        for _ in 0..self.search.spec.cols.max(self.search.spec.rows) {
            let grown = self.grown(&fit, span);
            if grown == span || self.search.view(sized, span, &fit.h).is_too_large() {
                break;
            }
            fitted.extend(self.seen(&fit, cells(grown).filter(|c| !holds(span, *c))));
            span = grown;
            fit = self.grid(&fitted).refit(&fit, true)?;
        }
        let view = self.search.view(sized, span, &fit.h);
        let seat = match view.seat() {
            Ok(seat) => seat,
            Err(refused) => return Some(Err(refused)),
        };
        let cells = self.there(&fit, self.all(&seat));
        let [columns, rows] = view.size();
        let needed = (SEEN * (columns * rows) as f64).ceil() as usize;
        let found = cells.len() + sized.marks.len();
        if found < needed {
            let discs = columns * rows;
            return Some(Err(GridRefused::TooFew { found, discs, needed }));
        }
        let fit = self.grid(&cells).refit(&fit, false)?;
        Some(self.result(&fit, &seat, &cells))
    }

    /// The lattice's cells of the whole grid.
    fn all(&self, seat: &Seat) -> [[i32; 2]; 2] {
        let last = [self.search.spec.cols as i32 - 1, self.search.spec.rows as i32 - 1];
        let (a, b) = (seat.cell([0, 0]), seat.cell(last));
        [0, 1].map(|k| [a[k].min(b[k]), a[k].max(b[k])])
    }

    fn grid<'b>(&'b self, cells: &'b [Cell]) -> Grid<'b> {
        Grid {
            image: self.search.image,
            cells,
            marks: &self.sized.marks,
            bright: self.search.spec.bright,
        }
    }

    /// Places of the span at which a disc is seen.
    fn there(&self, fit: &Whole, span: [[i32; 2]; 2]) -> Vec<Cell> {
        self.seen(fit, cells(span))
    }

    /// Those of some places at which a disc is seen.
    fn seen(&self, fit: &Whole, places: impl Iterator<Item = Cell>) -> Vec<Cell> {
        let seen = |cell: &Cell| {
            !self.sized.marks.contains(cell)
                && amplitude(self.search.image, fit, *cell)
                    .is_some_and(|[share, _]| (THERE..NOT_THERE).contains(&share))
        };
        places.filter(seen).collect()
    }

    /// The span with one line more on each side where such a line holds discs.
    fn grown(&self, fit: &Whole, span: [[i32; 2]; 2]) -> [[i32; 2]; 2] {
        let mut grown = span;
        for axis in 0..2 {
            for (end, by) in [(0, -1), (1, 1)] {
                let line = span[axis][end] + by;
                let across = span[1 - axis];
                let cells = (across[0]..=across[1]).map(|k| if axis == 0 { [line, k] } else { [k, line] });
                if self.is_line(fit, cells) {
                    grown[axis][end] = line;
                }
            }
        }
        grown
    }

    /// Whether discs lie along a line: more than the share that counts, and by their mean beyond doubt.
    fn is_line(&self, fit: &Whole, cells: impl Iterator<Item = Cell>) -> bool {
        let (mut count, mut seen, mut sum, mut weight) = (0, 0, 0.0, 0.0);
        for cell in cells {
            count += 1;
            if let Some([share, deviation]) = amplitude(self.search.image, fit, cell) {
                seen += usize::from((THERE..NOT_THERE).contains(&share));
                let w = deviation.max(1e-6).powi(-2);
                sum += w * share.clamp(-2.0, 2.0);
                weight += w;
            }
        }
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        seen as f64 >= 2.0 * LINE * f64::from(count) && mean > THERE && mean * weight.sqrt() > 6.0
    }

    fn result(&self, fit: &Whole, seat: &Seat, cells: &[Cell]) -> Result<Found, GridRefused> {
        let marks = &self.sized.marks;
        let disc = |cell: &Cell| {
            let (at, covariance) = centre(fit, *cell);
            let [col, row] = seat.place(*cell).map(|k| k as usize);
            let mark = marks.contains(cell);
            GridDisc {
                col,
                row,
                at,
                covariance,
                mark,
                measured: None,
            }
        };
        let mut discs: Vec<GridDisc> = cells.iter().chain(marks).map(disc).collect();
        discs.sort_by_key(|d| (d.row, d.col));
        let homography = fit.h * seat.lattice_from_grid();
        Ok(Found {
            missing: missing(&discs, self.search.spec),
            discs,
            homography: homography / homography[(2, 2)],
            radius: fit.radius,
            sigma: fit.sigma,
            noise: fit.noise,
            homography_rms_px: 0.0,
            refinement: Refinement::Whole,
            candidates: self.search.blobs.len(),
            alike: seat.alike,
        })
    }
}

/// All cells of a span.
fn cells([columns, rows]: [[i32; 2]; 2]) -> impl Iterator<Item = Cell> {
    (rows[0]..=rows[1]).flat_map(move |r| (columns[0]..=columns[1]).map(move |c| [c, r]))
}

fn holds(span: [[i32; 2]; 2], cell: Cell) -> bool {
    (0..2).all(|k| (span[k][0]..=span[k][1]).contains(&cell[k]))
}

/// The image of a cell's centre and its covariance.
fn centre(fit: &Whole, cell: Cell) -> (Vector2<f64>, Matrix2<f64>) {
    let (at, p) = (project(&fit.h, point(cell)), point(cell));
    let w = fit.h[(2, 0)] * p.x + fit.h[(2, 1)] * p.y + fit.h[(2, 2)];
    let mut slope = SMatrix::<f64, 2, 8>::zeros();
    for i in 0..2 {
        for (k, v) in [p.x, p.y, 1.0].iter().enumerate() {
            slope[(i, 3 * i + k)] = v / w;
        }
        (slope[(i, 6)], slope[(i, 7)]) = (-at[i] * p.x / w, -at[i] * p.y / w);
    }
    (at, slope * fit.covariance * slope.transpose())
}
