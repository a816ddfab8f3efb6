//! Centres disc by disc, where a lens bends the grid.

use std::collections::BTreeMap;

use fit::median;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};

use crate::disc::{DiscFit, Ellipse, fit_disc, fit_expected};
use crate::grid::error::GridRefused;
use crate::grid::fit::disc_in_lens::outline;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::lens_polynomial::Warp;
use crate::grid::found::{Found, GridDisc, Measured, Refinement, missing};
use crate::grid::homography::{homography, jacobian, project};
use crate::grid::lattice::Cell;
use crate::grid::lattice::assignment::Assignment;
use crate::grid::lattice::sized::{SEEN, Search, SizedLattice, THERE};

/// The blur that the first fits start from, pixels, and how many they are.
const FIRST_BLUR_PX: f64 = 1.2;
const FIRST_FITS: usize = 9;
/// How far from where its neighbours say a disc may be that was looked for there, beside the pitch.
const NEAR_PITCHES: f64 = 0.12;
/// The share of the neighbours' contrast that must be seen where a disc is looked for, before its place, size and blur are
/// fitted: half a radius off, half of the contrast is still seen.
const GLIMPSE_CONTRAST: f64 = 0.25;
/// Neighbours up to so many columns and rows away tell how the lens bends the grid.
const BEND_REACH_STEPS: i32 = 2;

/// So many discs tell how the lens bends the grid by polynomials of the fifth and of the third degree.
const FIFTH_DEGREE_DISCS: usize = 60;
const THIRD_DEGREE_DISCS: usize = 25;

/// A lattice whose discs are fitted one by one.
pub(crate) struct DiscByDisc<'a> {
    pub(crate) search: &'a Search<'a>,
    pub(crate) sized: &'a SizedLattice,
    pub(crate) seat: Assignment,
}

/// What a single disc's fit says.
struct One {
    fit: DiscFit,
    mark: bool,
}

/// Fitted discs by column and row.
type Ones = BTreeMap<Cell, One>;

/// What a disc at a place is expected to be, by the others.
struct Expected {
    h: Matrix3<f64>,
    /// Beside the pitch.
    radius: f64,
    sigma: f64,
}

impl DiscByDisc<'_> {
    /// Fits every disc by itself, looks for those that are no candidates where their neighbours say, and corrects the
    /// perspective of each.
    pub(crate) fn found(&self) -> Result<Found, GridRefused> {
        let mut ones = self.of_candidates();
        let span = self.sized.placed.span.map(|[a, b]| (b - a + 1) as usize);
        let discs = span[0] * span[1];
        let needed = (SEEN * discs as f64).ceil() as usize;
        let few = |found: usize| GridRefused::TooFew { found, discs, needed };
        // All are judged by the same homography before any goes: their order does not count.
        let first = expected(&ones).ok_or_else(|| few(ones.len()))?;
        let alone: Vec<Cell> = ones
            .iter()
            .filter(|(c, o)| !first.holds(&ones, **c, o))
            .map(|(c, _)| *c)
            .collect();
        for cell in alone {
            ones.remove(&cell);
        }
        // Each round reaches one line further, and a disc found tells where the next one is.
        let mut new: Vec<Cell> = ones.keys().copied().collect();
        for _ in 0..self.search.spec.cols.max(self.search.spec.rows) {
            let expected = expected(&ones).ok_or_else(|| few(ones.len()))?;
            let more = self.looked_for(&ones, &expected, &new);
            if more.is_empty() {
                break;
            }
            new = more.iter().map(|m| m.0).collect();
            ones.extend(more);
        }
        let expected = expected(&ones).ok_or_else(|| few(ones.len()))?;
        if ones.len() < needed {
            return Err(few(ones.len()));
        }
        Ok(self.result(&ones, &expected))
    }

    /// What the border cuts is no start: it is looked for with the size of the others. The first fits tell the blur that
    /// the others start from.
    fn of_candidates(&self) -> Ones {
        let placed = &self.sized.placed;
        let uncut = placed.cells.iter().filter(|(_, i)| !self.search.blobs[**i].cut);
        let mut cells: Vec<(&Cell, &usize)> = uncut.collect();
        // In the order of cells, not of the hash map: which discs tell the first blur is then the same in every run.
        cells.sort_unstable();
        let (first, others) = cells.split_at(cells.len().min(FIRST_FITS));
        let mut ones = self.ones(first, FIRST_BLUR_PX);
        // All discs have about the same blur: a start that is right saves steps at each of the others.
        let told = median(ones.values().map(|o| o.fit.sigma).collect());
        ones.extend(self.ones(others, if ones.is_empty() { FIRST_BLUR_PX } else { told }));
        ones
    }

    fn ones(&self, cells: &[(&Cell, &usize)], sigma: f64) -> Ones {
        let image = self.search.image;
        let one = |(cell, i): &(&Cell, &usize)| {
            let blob = &self.search.blobs[**i];
            let start = Ellipse {
                centre: blob.at,
                shape: blob.shape,
            };
            let margin = margin(&start, &self.sized.placed.h, **cell);
            let fit = fit_disc(image, &start, sigma, margin).ok();
            let fit = fit.filter(|f| image.holds(f.ellipse.centre))?;
            let mark = self.sized.marks.contains(*cell);
            Some((self.seat.place(**cell), One { fit, mark }))
        };
        cells.iter().filter_map(one).collect()
    }

    /// Discs that are no candidates, or whose own outline was too bad a start, where their neighbours say, some of which
    /// are `new`: the others have nothing else to say than before.
    fn looked_for(&self, ones: &Ones, expected: &Expected, new: &[Cell]) -> Vec<(Cell, One)> {
        let last = [self.search.spec.cols as i32, self.search.spec.rows as i32];
        let all = (0..last[1]).flat_map(|r| (0..last[0]).map(move |c| [c, r]));
        let told = |c: &Cell| {
            new.iter()
                .any(|n| (0..2).all(|k| (n[k] - c[k]).abs() <= BEND_REACH_STEPS))
        };
        let free = all.filter(|c| !ones.contains_key(c) && told(c));
        let one = |cell: Cell| Some((cell, self.looked_at(ones, expected, cell)?));
        free.filter_map(one).collect()
    }

    /// The fit of the size that leaves the least.
    fn looked_at(&self, ones: &Ones, expected: &Expected, cell: Cell) -> Option<One> {
        let bent = bent(ones, expected, cell)?;
        let (image, at) = (self.search.image, project(&expected.h, point(cell)) + bent);
        let reach = NEAR_PITCHES * jacobian(&expected.h, point(cell)).singular_values().min();
        let last = Vector2::new(image.width() as f64, image.height() as f64).add_scalar(-1.0);
        // The place clamped to the image is the nearest one in it: farther than the reach, the centre cannot be inside.
        let in_image = (at - at.sup(&Vector2::zeros()).inf(&last)).norm() < reach;
        let large = self.mark_radius(ones, expected);
        // Where the description says nothing both sizes are tried, and the residuals decide.
        let sizes = match self.is_mark(cell) {
            _ if !in_image => return None,
            Some(true) => [large, None],
            Some(false) => [Some(expected.radius), None],
            None => [Some(expected.radius), large],
        };
        let contrast = GLIMPSE_CONTRAST * beside(ones, cell);
        let of = |size: Option<f64>| {
            let mut start = Ellipse::of_circle(&expected.h, point(cell), size?)?;
            start.centre += bent;
            let margin = margin(&start, &expected.h, cell);
            // To half of the way to where another disc is looked for, and back to where this one may be.
            let fit = fit_expected(image, &start, [expected.sigma, margin], 4.0 * reach, contrast)?;
            let mark = size != Some(expected.radius);
            let ratio = fit.ellipse.mean_radius() / start.mean_radius();
            // From 1.6 times the radius on it is a disc of the other kind, and a spot below its inverse is none.
            let held = image.holds(fit.ellipse.centre) && (0.6..1.6).contains(&ratio);
            let one = One { fit, mark };
            (held && expected.holds(ones, cell, &one)).then_some(one)
        };
        let found = sizes.into_iter().filter_map(of);
        // Noise is the residuals' deviation over about the same pixels.
        found.min_by(|a, b| a.fit.noise.total_cmp(&b.fit.noise))
    }

    /// Whether a large disc stands at a place, by the description; none where nothing is described.
    fn is_mark(&self, cell: Cell) -> Option<bool> {
        let marks = &self.search.spec.marks;
        (!marks.is_empty()).then(|| marks.iter().any(|m| m.map(|k| k as i32) == cell))
    }

    /// The large discs' radius beside the pitch, by those that were fitted or by their candidates.
    fn mark_radius(&self, ones: &Ones, expected: &Expected) -> Option<f64> {
        let fitted: Vec<f64> = ones
            .iter()
            .filter(|(_, o)| o.mark)
            .map(|(c, o)| radius(&expected.h, *c, o))
            .collect();
        if !fitted.is_empty() {
            return Some(median(fitted));
        }
        let placed = &self.sized.placed;
        let of = |c: &Cell| {
            let area = jacobian(&placed.h, point(*c)).determinant().abs();
            Some((self.search.blobs[*placed.cells.get(c)?].area / std::f64::consts::PI / area).sqrt())
        };
        let blobs: Vec<f64> = self.sized.marks.iter().filter_map(of).collect();
        (!blobs.is_empty()).then(|| median(blobs))
    }

    /// How the lens, or the sheet, moves discs off the homography: smooth polynomials through their centres.
    fn warp(&self, ones: &Ones, expected: &Expected) -> Warp {
        let (image, h) = (self.search.image, &expected.h);
        let size = Vector2::new(image.width() as f64, image.height() as f64);
        // The image's middle and half its diagonal, so that powers stay below 1 and normal equations are well
        // conditioned.
        let none = Warp::none(size.add_scalar(-1.0) * 0.5, 0.5 * size.norm());
        let degree = match ones.len() {
            FIFTH_DEGREE_DISCS.. => 5,
            THIRD_DEGREE_DISCS.. => 3,
            _ => return none,
        };
        let mut warp = none;
        // Centres of images are shifted by what the polynomials themselves say: some hundredths of a pixel, so that twice is
        // enough.
        for _ in 0..2 {
            let pair = |(c, o): (&Cell, &One)| {
                // Usual discs have one size by the median, which errs less than each one's own; marks may be of any.
                let radius = if o.mark { radius(h, *c, o) } else { expected.radius };
                let centre = o.fit.ellipse.centre - shift(h, &warp, *c, radius);
                (project(h, point(*c)), centre)
            };
            let pairs: Vec<_> = ones.iter().map(pair).collect();
            warp = none.through(&pairs, degree).unwrap_or(none);
        }
        warp
    }

    fn result(&self, ones: &Ones, expected: &Expected) -> Found {
        let (h, warp) = (&expected.h, self.warp(ones, expected));
        let mut squares = 0.0;
        let mut discs: Vec<GridDisc> = Vec::new();
        for (cell, one) in ones {
            let radius = one.fit.ellipse.mean_radius() / pitch(h, &warp, *cell).determinant().abs().sqrt();
            // A disc's image is an ellipse whose centre is not the image of the disc's: perspective and lens move it.
            let centre = one.fit.ellipse.centre - shift(h, &warp, *cell, radius);
            squares += (centre - project(h, point(*cell))).norm_squared();
            let [col, row] = cell.map(|k| k as usize);
            discs.push(GridDisc {
                col,
                row,
                at: centre,
                covariance: one.fit.covariance,
                mark: one.mark,
                measured: Some(Measured {
                    ellipse: one.fit.ellipse,
                    radius,
                }),
            });
        }
        discs.sort_by_key(|d| (d.row, d.col));
        let spec = self.search.spec;
        Found {
            missing: missing(&discs, spec),
            homography: *h,
            radius: expected.radius,
            sigma: expected.sigma,
            noise: median(usual(ones).map(|(_, o)| o.fit.noise).collect()),
            homography_rms_px: (squares / discs.len() as f64).sqrt(),
            misfit_px: 0.0,
            refinement: Refinement::Each,
            candidates: self.search.blobs.len(),
            alike: self.seat.alike,
            discs,
        }
    }
}

impl Expected {
    /// Whether a disc is where its neighbours say and as dark as they are: light falls off towards an image's corners.
    fn holds(&self, ones: &Ones, cell: Cell, one: &One) -> bool {
        let Some(bent) = bent(ones, self, cell) else {
            return false;
        };
        let off = one.fit.ellipse.centre - project(&self.h, point(cell)) - bent;
        let pitch = jacobian(&self.h, point(cell)).singular_values().min();
        // `bent` needs three neighbours, so that there is a contrast to compare with.
        off.norm() < NEAR_PITCHES * pitch && one.fit.contrast / beside(ones, cell) > THERE
    }
}

/// The neighbours' contrast.
fn beside(ones: &Ones, cell: Cell) -> f64 {
    median(around(ones, cell).map(|(_, o)| o.fit.contrast).collect())
}

/// How far from a disc pixels are its own: its neighbours' edges lie a pitch less two radii away.
fn margin(start: &Ellipse, h: &Matrix3<f64>, cell: Cell) -> f64 {
    // The shortest way to a neighbour at this tilt.
    let pitch = jacobian(h, point(cell)).singular_values().min();
    // Half of the gap, so that a neighbour's blurred edge stays outside; two pixels at least hold an edge, and more
    // than eight tell of paper alone.
    (0.5 * (pitch - 2.0 * start.axes().semi[0])).clamp(2.0, 8.0)
}

/// Pixels for a step of the grid.
fn pitch(h: &Matrix3<f64>, warp: &Warp, cell: Cell) -> Matrix2<f64> {
    warp.jet(project(h, point(cell))).slope * jacobian(h, point(cell))
}

/// How far perspective and lens move the centre of a disc's image off the image of its centre.
fn shift(h: &Matrix3<f64>, warp: &Warp, cell: Cell, radius: f64) -> Vector2<f64> {
    let seen = outline(h, warp, cell, radius);
    seen.map_or(Vector2::zeros(), |e| e.centre - warp.at(project(h, point(cell))))
}

/// A fitted disc's radius beside the pitch.
fn radius(h: &Matrix3<f64>, cell: Cell, one: &One) -> f64 {
    one.fit.ellipse.mean_radius() / jacobian(h, point(cell)).determinant().abs().sqrt()
}

fn usual(ones: &Ones) -> impl Iterator<Item = (&Cell, &One)> {
    ones.iter().filter(|(_, o)| !o.mark)
}

fn expected(ones: &Ones) -> Option<Expected> {
    let pairs: Vec<_> = ones.iter().map(|(c, o)| (point(*c), o.fit.ellipse.centre)).collect();
    let h = homography(&pairs)?;
    let of = |value: &dyn Fn(&Cell, &One) -> f64| median(usual(ones).map(|(c, o)| value(c, o)).collect());
    Some(Expected {
        radius: of(&|c, o| radius(&h, *c, o)),
        sigma: of(&|_, o| o.fit.sigma),
        h,
    })
}

/// The neighbours of a place up to [`BEND_REACH_STEPS`] columns and rows away, with where they are.
fn around(ones: &Ones, cell: Cell) -> impl Iterator<Item = (Cell, &One)> {
    let lines = move |r: i32| (-BEND_REACH_STEPS..=BEND_REACH_STEPS).map(move |c| [cell[0] + c, cell[1] + r]);
    let all = (-BEND_REACH_STEPS..=BEND_REACH_STEPS)
        .flat_map(lines)
        .filter(move |near| *near != cell);
    all.filter_map(|near| Some((near, ones.get(&near)?)))
}

/// How far off the homography a disc at a place is expected: the plane through how far its neighbours are, which bends
/// at a corner as it does there; none where there are fewer than 3 of them, or all on a line.
fn bent(ones: &Ones, expected: &Expected, cell: Cell) -> Option<Vector2<f64>> {
    let (mut matrix, mut vectors) = (Matrix3::zeros(), Matrix3x2::zeros());
    for (near, one) in around(ones, cell) {
        let off = one.fit.ellipse.centre - project(&expected.h, point(near));
        let [c, r] = [0, 1].map(|k| f64::from(near[k] - cell[k]));
        let row = Vector3::new(1.0, c, r);
        matrix += row * row.transpose();
        vectors += row * off.transpose();
    }
    // Counts and small whole numbers: a determinant below 1 is none.
    let plane = (matrix.determinant() > 0.5).then(|| matrix.try_inverse()).flatten()? * vectors;
    // The plane's constant is its value at the cell, from which columns and rows are counted.
    Some(plane.row(0).transpose())
}
