//! The fit of the whole grid, line by line to its border, and what it found.

use nalgebra::{Matrix3, Vector2};

use super::bent::{Bent, through_points};
use super::each::Each;
use super::error::GridRefused;
use super::evidence::amplitude;
use super::found::{Found, GridDisc, Refinement, missing};
use super::homography::{homography, project};
use super::lattice::Cell;
use super::model::Model;
use super::place::LINE;
use super::search::{SEEN, Search, Sized, THERE};
use super::seat::Seat;
use super::sheet::Sheet;
use super::whole::{Grid, Whole};

/// And is not one of the grid with more than this share of it.
const NOT_THERE: f64 = 1.6;

/// The blur that the fit starts from, pixels.
const BLUR: f64 = 0.9;

/// The least short semi-axis, pixels, of discs that are fitted by themselves where the whole does not tell.
const ALONE: f64 = 1.5;

/// A placed lattice on its way to a whole fit.
pub(crate) struct Lines<'a> {
    pub(crate) search: &'a Search<'a>,
    pub(crate) sized: &'a Sized,
}

/// A fit again from one to nearly the same discs, to a part of what is to be seen or to all of it.
type Refit<'a> = &'a dyn Fn(&Whole, &[Cell], bool) -> Option<Whole>;

/// A fit that knows its border, with the seat of its cells and those at which a disc is seen.
type Bordered = (Whole, Seat, Vec<Cell>);

impl Lines<'_> {
    /// The grid, or why it is refused; none where no model of the whole holds.
    ///
    /// Without a lens first; where single discs say that this is wrong, behind one.
    pub(crate) fn found(&self) -> Option<Result<Found, GridRefused>> {
        let sized = self.sized;
        let fit = self.grid(&sized.small).near(&sized.placed.h, sized.radius, BLUR)?;
        let refit = |fit: &Whole, cells: &[Cell], thin: bool| self.grid(cells).refit(fit, thin);
        let (fit, seat, cells) = match self.bordered(fit, &refit)? {
            Ok(bordered) => bordered,
            Err(refused) => return Some(Err(refused)),
        };
        let fit = refit(&fit, &cells, false)?;
        let model = Model::plane(self.search.image, &fit, &cells);
        if model.is_seen() {
            let start = Bent::plane(&fit.h, fit.radius, fit.sigma, self.search.image);
            let plane = self.result(&model, &seat, &cells);
            let lens = self
                .behind(&start)
                .and_then(Result::ok)
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
        points.sort_unstable_by_key(|p| p.0);
        let plane = Bent::plane(&placed.h, self.sized.radius, BLUR, self.search.image);
        self.behind(&through_points(&plane, &points)?)
    }

    /// The grid behind a lens, disc by disc where that is seen to be wrong and single discs tell more.
    fn behind(&self, start: &Bent) -> Option<Result<Found, GridRefused>> {
        let sheet = Sheet {
            image: self.search.image,
            bright: self.search.spec.bright,
        };
        let fitted = sheet.near(start, &self.sized.small)?;
        let refit = |fit: &Whole, cells: &[Cell], _| Whole::of_bent(&sheet.nearer(fit.bent.as_ref()?, cells)?);
        let (fit, seat, cells) = match self.bordered(Whole::of_bent(&fitted)?, &refit)? {
            Ok(bordered) => bordered,
            Err(refused) => return Some(Err(refused)),
        };
        let fitted = sheet.refit(fit.bent.as_ref()?, &cells)?;
        let model = Model::bent(Whole::of_bent(&fitted)?, &fitted);
        let found = self.result(&model, &seat, &cells);
        if model.is_seen() && self.is_large(&fit) {
            let each = Each {
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
    fn is_large(&self, fit: &Whole) -> bool {
        let [columns, rows] = self.sized.placed.span.map(|s| (s[0] + s[1]) / 2);
        let outline = fit.outline([columns, rows]);
        outline.is_some_and(|o| o.axes().semi[1] > ALONE)
    }

    /// The fit line by line to its border.
    fn bordered(&self, first: Whole, refit: Refit) -> Option<Result<Bordered, GridRefused>> {
        let sized = self.sized;
        let (mut fit, mut fitted, mut span) = (first, sized.small.clone(), sized.placed.span);
        // Lines that candidates did not reach: as long as discs are seen there, one line further on each side.
        for _ in 0..self.search.spec.cols.max(self.search.spec.rows) {
            let grown = self.grown(&fit, span);
            if grown == span || self.search.view(sized, span, &fit.h).is_too_large() {
                break;
            }
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
                && amplitude(self.search.image, fit, *cell, false)
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
            if let Some([share, deviation]) = amplitude(self.search.image, fit, cell, true) {
                seen += usize::from((THERE..NOT_THERE).contains(&share));
                let w = deviation.max(1e-6).powi(-2);
                sum += w * share.clamp(-2.0, 2.0);
                weight += w;
            }
        }
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        seen as f64 >= 2.0 * LINE * f64::from(count) && mean > THERE && mean * weight.sqrt() > 6.0
    }

    fn result(&self, model: &Model, seat: &Seat, cells: &[Cell]) -> Found {
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
        let mut discs: Vec<GridDisc> = cells.iter().chain(marks).map(disc).collect();
        discs.sort_by_key(|d| (d.row, d.col));
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
    one.discs.len() * 20 >= other.discs.len() * 19 && mean(one) < mean(other)
}

/// All cells of a span.
fn cells([columns, rows]: [[i32; 2]; 2]) -> impl Iterator<Item = Cell> {
    (rows[0]..=rows[1]).flat_map(move |r| (columns[0]..=columns[1]).map(move |c| [c, r]))
}

fn holds(span: [[i32; 2]; 2], cell: Cell) -> bool {
    (0..2).all(|k| (span[k][0]..=span[k][1]).contains(&cell[k]))
}
