//! The whole way from an image to a grid.

use std::collections::HashSet;

use nalgebra::Vector2;

use super::blob::{Blob, blobs};
use super::each;
use super::error::GridRefused;
use super::evidence::amplitude;
use super::found::{Found, GridDisc, GridSpec, Refinement};
use super::homography::{jacobian, project};
use super::lattice::{Cell, largest};
use super::place::{LINE, Placed, place};
use super::whole::{Grid, Whole, point};
use crate::image::{Image, noise_deviation, smoothed};

/// Smoothing before candidates are looked for, pixels: as little as the noise allows is tried first.
const SMOOTHING: [f64; 3] = [0.8, 1.4, 2.4];
/// The share of the discs that must be seen.
const SEEN: f64 = 0.6;
/// A disc is there with half of the expected contrast.
const THERE: f64 = 0.5;
/// Marks are so much larger than other discs.
const MARK: f64 = 1.6;
/// Centroids that lie so far off a homography, beside the pitch, speak of lens distortion.
const DISTORTED: f64 = 0.02;

/// Finds the grid in an image, gives each disc its column and row, and refines all centres.
///
/// Candidates are dark regions that hardly grow while the level rises; each disc's own ellipse is the measure of its
/// neighbourhood, so that tilt does not hide who is next to whom; a lattice grows from the best seeds; the basis in
/// which it fills the rectangle with round discs is its own. One photometric fit of the whole grid follows, and tells
/// for every place whether a disc is there. A grid of the wrong number of columns or rows is refused.
///
/// # Errors
/// [`GridRefused`], with the best partial evidence.
pub fn find(image: &Image, spec: &GridSpec) -> Result<Found, GridRefused> {
    spec.check(image)?;
    let noise = noise_deviation(image);
    let discs = spec.cols * spec.rows;
    let mut refused = GridRefused::NoLattice { candidates: 0, discs };
    for sigma in SMOOTHING {
        let plane = smoothed(image, sigma);
        // White noise through a Gaussian of sigma keeps 1 / (2 sqrt(pi) sigma) of its deviation.
        let left = (noise / (2.0 * std::f64::consts::PI.sqrt() * sigma)).min(noise);
        let found = Search {
            image,
            spec,
            blobs: blobs(&plane, left, spec.bright),
        }
        .run();
        match found {
            Ok(found) => return Ok(found),
            Err(error) if error.evidence() >= refused.evidence() => refused = error,
            Err(_) => {}
        }
    }
    Err(refused)
}

struct Search<'a> {
    image: &'a Image,
    spec: &'a GridSpec,
    blobs: Vec<Blob>,
}

impl Search<'_> {
    fn run(&self) -> Result<Found, GridRefused> {
        let (candidates, discs) = (self.blobs.len(), self.spec.cols * self.spec.rows);
        let none = GridRefused::NoLattice { candidates, discs };
        let lattice = largest(&self.blobs, discs * 9 / 10);
        if lattice.cells.len() < 9 {
            return Err(none);
        }
        let size = [self.spec.cols as i32, self.spec.rows as i32];
        let placed = place(&self.blobs, &lattice, size).ok_or(none.clone())?;
        let marks = self.marks(&placed);
        let (radius, distorted) = self.measure(&placed, &marks);
        if !distorted && let Some(found) = self.whole(&placed, &marks, radius) {
            return found;
        }
        self.right_size(placed.span, placed.cells.len())?;
        each::refine(self.image, self.spec, &self.blobs, &placed, &marks, candidates)
    }

    /// Radii beside the pitch, by area.
    fn radius(&self, placed: &Placed, cell: &Cell, i: usize) -> f64 {
        let area = jacobian(&placed.h, point(*cell)).determinant().abs();
        (self.blobs[i].area / std::f64::consts::PI / area).sqrt()
    }

    fn marks(&self, placed: &Placed) -> HashSet<Cell> {
        let mut radii: Vec<f64> = placed.cells.iter().map(|(c, i)| self.radius(placed, c, *i)).collect();
        radii.sort_by(f64::total_cmp);
        let median = radii[radii.len() / 2];
        let large = placed
            .cells
            .iter()
            .filter(|(c, i)| self.radius(placed, c, **i) > MARK * median);
        large.map(|(c, _)| *c).collect()
    }

    /// The median radius beside the pitch, and whether the lens distorts.
    fn measure(&self, placed: &Placed, marks: &HashSet<Cell>) -> (f64, bool) {
        let small = placed.cells.iter().filter(|(c, _)| !marks.contains(*c));
        let mut radii: Vec<f64> = small.map(|(c, i)| self.radius(placed, c, *i)).collect();
        radii.sort_by(f64::total_cmp);
        let squares = placed.cells.iter().map(|(c, i)| {
            let off = self.blobs[*i].at - project(&placed.h, point(*c));
            let pitch = jacobian(&placed.h, point(*c)).determinant().abs().sqrt();
            [off.norm_squared(), pitch * pitch]
        });
        let [off, pitch] = squares.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        let distorted = off > DISTORTED * DISTORTED * pitch && off / placed.cells.len() as f64 > 0.5;
        (radii.get(radii.len() / 2).copied().unwrap_or(0.2).min(0.45), distorted)
    }

    fn right_size(&self, span: [[i32; 2]; 2], found: usize) -> Result<(), GridRefused> {
        let seen = span.map(|[a, b]| (b - a + 1).max(0) as usize);
        if seen == [self.spec.cols, self.spec.rows] {
            return Ok(());
        }
        Err(GridRefused::WrongSize {
            candidates: self.blobs.len(),
            found,
            seen_cols: seen[0],
            seen_rows: seen[1],
            cols: self.spec.cols,
            rows: self.spec.rows,
        })
    }

    /// The fit of the whole grid; none where its model does not hold.
    fn whole(&self, placed: &Placed, marks: &HashSet<Cell>, radius: f64) -> Option<Result<Found, GridRefused>> {
        let mut cells: Vec<Cell> = placed.cells.keys().filter(|c| !marks.contains(*c)).copied().collect();
        cells.sort_unstable();
        let mut fit = self.fit(&cells, &placed.h, radius, 0.9)?;
        let mut span = placed.span;
        // Lines that candidates did not reach: as long as discs are seen there, one line further on each side.
        for _ in 0..2 * (self.spec.cols + self.spec.rows) {
            let Some(grown) = self.grown(&fit, span) else { break };
            span = grown;
            cells = self.there(&fit, span, marks);
            fit = self.fit(&cells, &fit.h, fit.radius, fit.sigma)?;
        }
        cells = self.there(&fit, span, marks);
        fit = self.fit(&cells, &fit.h, fit.radius, fit.sigma)?;
        if let Err(refused) = self.right_size(span, cells.len()) {
            return Some(Err(refused));
        }
        let needed = (SEEN * (self.spec.cols * self.spec.rows) as f64).ceil() as usize;
        if cells.len() + marks.len() < needed {
            let (found, discs) = (cells.len() + marks.len(), self.spec.cols * self.spec.rows);
            return Some(Err(GridRefused::TooFew { found, discs, needed }));
        }
        Some(Ok(self.found(&fit, span, &cells, marks)))
    }

    fn fit(&self, cells: &[Cell], h: &nalgebra::Matrix3<f64>, radius: f64, sigma: f64) -> Option<Whole> {
        let (image, bright) = (self.image, self.spec.bright);
        Grid { image, cells, bright }.fit(h, radius, sigma)
    }

    /// Places of the span at which a disc is seen.
    fn there(&self, fit: &Whole, span: [[i32; 2]; 2], marks: &HashSet<Cell>) -> Vec<Cell> {
        let [columns, rows] = span.map(|[a, b]| a..=b);
        let all = rows.flat_map(|r| columns.clone().map(move |c| [c, r]));
        let seen = |cell: &Cell| {
            let found = amplitude(self.image, fit, *cell);
            !marks.contains(cell) && found.is_some_and(|[share, _]| (THERE..1.6).contains(&share))
        };
        all.filter(seen).collect()
    }

    /// The span with one line more, where such a line holds discs.
    fn grown(&self, fit: &Whole, span: [[i32; 2]; 2]) -> Option<[[i32; 2]; 2]> {
        for axis in 0..2 {
            for (end, by) in [(0, -1), (1, 1)] {
                let line = span[axis][end] + by;
                let across = span[1 - axis];
                let cells = (across[0]..=across[1]).map(|k| if axis == 0 { [line, k] } else { [k, line] });
                if self.is_line(fit, cells) {
                    let mut grown = span;
                    grown[axis][end] = line;
                    return Some(grown);
                }
            }
        }
        None
    }

    /// Whether discs lie along a line: more than the share that counts, and by their mean beyond doubt.
    fn is_line(&self, fit: &Whole, cells: impl Iterator<Item = Cell>) -> bool {
        let (mut count, mut seen, mut sum, mut weight) = (0, 0, 0.0, 0.0);
        for cell in cells {
            count += 1;
            if let Some([share, deviation]) = amplitude(self.image, fit, cell) {
                seen += usize::from((THERE..1.6).contains(&share));
                let w = deviation.max(1e-6).powi(-2);
                sum += w * share.clamp(-2.0, 2.0);
                weight += w;
            }
        }
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        seen as f64 >= 2.0 * LINE * f64::from(count) && mean > THERE && mean * weight.sqrt() > 6.0
    }

    fn found(&self, fit: &Whole, span: [[i32; 2]; 2], cells: &[Cell], marks: &HashSet<Cell>) -> Found {
        let first = [span[0][0], span[1][0]];
        let index = |c: &Cell| [(c[0] - first[0]) as usize, (c[1] - first[1]) as usize];
        let mut discs: Vec<GridDisc> = Vec::new();
        for cell in cells.iter().chain(marks) {
            let [col, row] = index(cell);
            let (at, covariance) = centre(fit, *cell);
            discs.push(GridDisc {
                col,
                row,
                at,
                covariance,
                mark: marks.contains(cell),
            });
        }
        discs.sort_by_key(|d| (d.row, d.col));
        let shift = nalgebra::Matrix3::new(
            1.0,
            0.0,
            f64::from(first[0]),
            0.0,
            1.0,
            f64::from(first[1]),
            0.0,
            0.0,
            1.0,
        );
        let homography = fit.h * shift;
        Found {
            missing: missing(&discs, self.spec),
            discs,
            homography: homography / homography[(2, 2)],
            radius: fit.radius,
            sigma: fit.sigma,
            noise: fit.noise,
            homography_rms_px: 0.0,
            refinement: Refinement::Whole,
            candidates: self.blobs.len(),
        }
    }
}

/// Places of the grid without a disc.
pub(crate) fn missing(discs: &[GridDisc], spec: &GridSpec) -> Vec<[usize; 2]> {
    let there: HashSet<[usize; 2]> = discs.iter().map(|d| [d.col, d.row]).collect();
    let all = (0..spec.rows).flat_map(|r| (0..spec.cols).map(move |c| [c, r]));
    all.filter(|cell| !there.contains(cell)).collect()
}

/// The image of a cell's centre and its covariance.
fn centre(fit: &Whole, cell: Cell) -> (Vector2<f64>, nalgebra::Matrix2<f64>) {
    let (at, p) = (project(&fit.h, point(cell)), point(cell));
    let w = fit.h[(2, 0)] * p.x + fit.h[(2, 1)] * p.y + fit.h[(2, 2)];
    let mut slope = nalgebra::SMatrix::<f64, 2, 8>::zeros();
    for i in 0..2 {
        [p.x, p.y, 1.0]
            .iter()
            .enumerate()
            .for_each(|(k, v)| slope[(i, 3 * i + k)] = v / w);
        (slope[(i, 6)], slope[(i, 7)]) = (-at[i] * p.x / w, -at[i] * p.y / w);
    }
    (at, slope * fit.covariance * slope.transpose())
}
