//! The fit of the whole grid, line by line to its border, and what it found.

use nalgebra::{Matrix3, Vector2};

use crate::grid::check::agreement::Model;
use crate::grid::disc_fit_by_disc::DiscByDisc;
use crate::grid::error::GridRefused;
use crate::grid::fit::disc_score::amplitude;
use crate::grid::fit::grid_fit::{Grid, GridFit};
use crate::grid::fit::lens_fit::LensFit;
use crate::grid::fit::lens_model::{LensModel, through_points};
use crate::grid::found::{Found, GridDisc, Refinement, missing};
use crate::grid::homography::{homography, project};
use crate::grid::lattice::Cell;
use crate::grid::lattice::assignment::Assignment;
use crate::grid::lattice::index_lattice::LINE;
use crate::grid::lattice::sized::{SEEN, Search, SizedLattice, THERE};

/// A disc of more than this share of the expected contrast is none of the grid.
const NOT_THERE: f64 = 1.6;

/// The blur that the fit starts from, pixels.
const FIRST_BLUR_PX: f64 = 0.9;

/// The least short semi-axis, pixels, of discs that are fitted by themselves where the whole does not tell.
const LEAST_OWN_SEMI_PX: f64 = 1.5;

/// A placed lattice on its way to a whole fit.
pub(crate) struct Growth<'a> {
    pub(crate) search: &'a Search<'a>,
    pub(crate) sized: &'a SizedLattice,
}

/// A fit again from one to nearly the same discs, to a part of what is to be seen or to all of it.
type Refit<'a> = &'a dyn Fn(&GridFit, &[Cell], bool) -> Option<GridFit>;

/// A fit that knows its border, with the seat of its cells and those at which a disc is seen.
type Bordered = (GridFit, Assignment, Vec<Cell>);

impl Growth<'_> {
    /// The grid, or why it is refused; none where no model of the whole holds.
    ///
    /// Without a lens first; where single discs say that this is wrong, behind one.
    pub(crate) fn found(&self) -> Option<Result<Found, GridRefused>> {
        let sized = self.sized;
        let fit = self
            .grid(&sized.small)
            .fit_coarse(&sized.placed.h, sized.radius, FIRST_BLUR_PX)?;
        let refit = |fit: &GridFit, cells: &[Cell], thin: bool| self.grid(cells).refit(fit, thin);
        let (fit, seat, cells) = match self.bordered(fit, &refit)? {
            Ok(bordered) => bordered,
            Err(refused) => return Some(Err(refused)),
        };
        let fit = refit(&fit, &cells, false)?;
        let model = Model::plane(self.search.image, &fit, &cells);
        if model.is_seen() {
            let start = LensModel::plane(&fit.h, fit.radius, fit.sigma, self.search.image);
            let plane = self.result(&model, &seat, &cells);
            let lens = self
                .behind(&start)
                .and_then(Result::ok)
                // A plane that single discs have elsewhere states errors that do not hold: it is not compared by them.
                .filter(|l| model.is_off() || is_nearer(l, &plane));
            return Some(Ok(lens.unwrap_or(plane)));
        }
        Some(Ok(self.result(&model, &seat, &cells)))
    }

    /// The grid behind a lens that is seen by the candidates themselves.
    pub(crate) fn bent(&self) -> Option<Result<Found, GridRefused>> {
        let placed = &self.sized.placed;
        let uncut = placed.cells.iter().filter(|(_, i)| !self.search.blobs[**i].cut);
        let mut points: Vec<(Cell, Vector2<f64>)> = uncut.map(|(c, i)| (*c, self.search.blobs[*i].at)).collect();
        // A hash map's order changes from run to run, and with it the rounding of the sums.
        points.sort_unstable_by_key(|p| p.0);
        let plane = LensModel::plane(&placed.h, self.sized.radius, FIRST_BLUR_PX, self.search.image);
        // A plane's outlines lie off the discs by all that the lens does: the centroids take most of it out first.
        self.behind(&through_points(&plane, &points)?)
    }

    /// The grid behind a lens, disc by disc where that is seen to be wrong and single discs tell more.
    fn behind(&self, start: &LensModel) -> Option<Result<Found, GridRefused>> {
        let sheet = LensFit {
            image: self.search.image,
            bright: self.search.spec.bright,
        };
        let fitted = sheet.fit_coarse(start, &self.sized.small)?;
        // Always by a part of the pixels: the fit to all of them follows once the border is known.
        let refit = |fit: &GridFit, cells: &[Cell], _| GridFit::of_bent(&sheet.nearer(fit.bent.as_ref()?, cells)?);
        let (fit, seat, cells) = match self.bordered(GridFit::of_bent(&fitted)?, &refit)? {
            Ok(bordered) => bordered,
            Err(refused) => return Some(Err(refused)),
        };
        let fitted = sheet.refit(fit.bent.as_ref()?, &cells)?;
        let model = Model::bent(GridFit::of_bent(&fitted)?, &fitted);
        let found = self.result(&model, &seat, &cells);
        if model.is_seen() && self.is_large(&fit) {
            let each = DiscByDisc {
                search: self.search,
                sized: self.sized,
                seat,
            };
            let each = each.found().ok().filter(|e| is_nearer(e, &found));
            return Some(Ok(each.unwrap_or(found)));
        }
        Some(Ok(found))
    }

    /// Whether discs in the middle are so large that each can be fitted by itself.
    fn is_large(&self, fit: &GridFit) -> bool {
        let [columns, rows] = self.sized.placed.span.map(|s| (s[0] + s[1]) / 2);
        let outline = fit.outline([columns, rows]);
        outline.is_some_and(|o| o.axes().semi[1] > LEAST_OWN_SEMI_PX)
    }

    /// The fit line by line to its border.
    fn bordered(&self, first: GridFit, refit: Refit) -> Option<Result<Bordered, GridRefused>> {
        let sized = self.sized;
        let (mut fit, mut fitted, mut span) = (first, sized.small.clone(), sized.placed.span);
        // Lines that candidates did not reach: as long as discs are seen there, one line further on each side.
        // A round adds a line on a side: a grid is whole after as many as its longer side has.
        for _ in 0..self.search.spec.cols.max(self.search.spec.rows) {
            let grown = self.grown(&fit, span);
            if grown == span || self.search.view(sized, span, &fit.h).is_too_large() {
                break;
            }
            // Places of the span are fitted already, or were seen to be none.
            fitted.extend(self.seen(&fit, cells(grown).filter(|c| !holds(span, *c))));
            span = grown;
            fit = refit(&fit, &fitted, true)?;
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
        Some(Ok((fit, seat, cells)))
    }

    /// The lattice's cells of the whole grid.
    fn all(&self, seat: &Assignment) -> [[i32; 2]; 2] {
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
    fn there(&self, fit: &GridFit, span: [[i32; 2]; 2]) -> Vec<Cell> {
        self.seen(fit, cells(span))
    }

    /// Those of some places at which a disc is seen.
    fn seen(&self, fit: &GridFit, places: impl Iterator<Item = Cell>) -> Vec<Cell> {
        let seen = |cell: &Cell| {
            !self.sized.marks.contains(cell)
                && amplitude(self.search.image, fit, *cell, false)
                    .is_some_and(|[share, _]| (THERE..NOT_THERE).contains(&share))
        };
        places.filter(seen).collect()
    }

    /// The span with one line more on each side where such a line holds discs.
    fn grown(&self, fit: &GridFit, span: [[i32; 2]; 2]) -> [[i32; 2]; 2] {
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
    fn is_line(&self, fit: &GridFit, cells: impl Iterator<Item = Cell>) -> bool {
        let (mut count, mut seen, mut sum, mut weight) = (0, 0, 0.0, 0.0);
        for cell in cells {
            count += 1;
            if let Some([share, deviation]) = amplitude(self.search.image, fit, cell, true) {
                seen += usize::from((THERE..NOT_THERE).contains(&share));
                // An image without noise has deviations of 0, which would weigh without bound.
                let w = deviation.max(1e-6).powi(-2);
                // Glare at one place must not make a line of discs, nor take one away.
                sum += w * share.clamp(-2.0, 2.0);
                weight += w;
            }
        }
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        // Twice the share that candidates need: a false line makes the grid too large, and refuses it.
        seen as f64 >= 2.0 * LINE * f64::from(count) && mean > THERE && mean * weight.sqrt() > 6.0
    }

    fn result(&self, model: &Model, seat: &Assignment, cells: &[Cell]) -> Found {
        let marks = &self.sized.marks;
        let fit = &model.fit;
        let disc = |cell: &Cell| {
            let [col, row] = seat.place(*cell).map(|k| k as usize);
            GridDisc {
                col,
                row,
                at: fit.at(*cell),
                covariance: model.covariance(*cell),
                mark: marks.contains(cell),
                measured: None,
            }
        };
        // Large discs were left out of the fit, which has the usual radius; their centres follow from the plane or the
        // lens.
        let mut discs: Vec<GridDisc> = cells.iter().chain(marks).map(disc).collect();
        // The marks come from a hash set: only sorted is the order the same from run to run.
        discs.sort_by_key(|d| (d.row, d.col));
        // A lens bends the grid: the homography is then only the nearest one, and its residual says how far off.
        let (homography, homography_rms_px) = match &fit.bent {
            Some(_) => nearest(&discs).unwrap_or((fit.h, f64::NAN)),
            None => (fit.h * seat.lattice_from_grid(), 0.0),
        };
        Found {
            missing: missing(&discs, self.search.spec),
            discs,
            homography: homography / homography[(2, 2)],
            radius: fit.radius,
            sigma: fit.sigma,
            noise: fit.noise,
            homography_rms_px,
            misfit_px: model.misfit_px(),
            refinement: match fit.bent {
                Some(_) => Refinement::Lens,
                None => Refinement::Whole,
            },
            candidates: self.search.blobs.len(),
            alike: seat.alike,
        }
    }
}

/// The homography nearest to discs, and how far they are off it.
fn nearest(discs: &[GridDisc]) -> Option<(Matrix3<f64>, f64)> {
    let place = |d: &GridDisc| Vector2::new(d.col as f64, d.row as f64);
    let pairs: Vec<_> = discs.iter().map(|d| (place(d), d.at)).collect();
    let h = homography(&pairs)?;
    let squares: f64 = pairs.iter().map(|(p, at)| (project(&h, *p) - at).norm_squared()).sum();
    Some((h, (squares / pairs.len() as f64).sqrt()))
}

/// Whether one result states smaller errors than another, and has nearly as many discs.
fn is_nearer(one: &Found, other: &Found) -> bool {
    let mean = |f: &Found| f.discs.iter().map(|d| d.covariance.trace()).sum::<f64>() / f.discs.len() as f64;
    // A model that loses more than one disc in twenty may owe its small errors to leaving out the hard ones.
    one.discs.len() * 20 >= other.discs.len() * 19 && mean(one) < mean(other)
}

/// All cells of a span.
fn cells([columns, rows]: [[i32; 2]; 2]) -> impl Iterator<Item = Cell> {
    (rows[0]..=rows[1]).flat_map(move |r| (columns[0]..=columns[1]).map(move |c| [c, r]))
}

fn holds(span: [[i32; 2]; 2], cell: Cell) -> bool {
    (0..2).all(|k| (span[k][0]..=span[k][1]).contains(&cell[k]))
}
