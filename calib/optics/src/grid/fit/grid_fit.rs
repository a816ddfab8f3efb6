//! One fit of the whole grid to the pixels: homography, radius, blur, and planes of grey for discs and paper.

use std::collections::HashSet;

use fit::{Damping, End, Limits, Made, Rule, Step, least_squares, median};
use nalgebra::{Matrix3, SMatrix, SVector, Vector2};

use crate::disc::{Coverage, Ellipse};
use crate::grid::fit::disc_jacobian::{ellipse_slopes, point};
use crate::grid::fit::lens_model::LensModel;
use crate::grid::fit::normal_equations::{
    BLUR, DISC, Equations, HOMOGRAPHY, LEAST_BLUR, N, PAPER, Params, RADIUS, SHAPES, Sums, inverse, step,
};
use crate::grid::fit::sample_pixels::{Outlines, Pixel, SamplePixels};
use crate::grid::homography::{jacobian, project};
use crate::image::Image;

const MAX_STEPS: usize = 25;
/// Of the normal equations, as [`step`] holds back.
const DAMPING: Damping = Damping {
    start: 1e-3,
    rule: Rule::Factors {
        fall: 0.1,
        least: 1e-10,
        rise: 10.0,
        raised: 0.0,
    },
    most: 1e5,
    singular: true,
};
/// More damping than this makes a step short however far the least is.
const MOST_AT_END: f64 = 0.1;
/// Stop when the predicted remaining fall of chi squared is below this: sqrt(0.1) = 0.3 standard deviations in parameter
/// space.
const LAST_GAIN_CHI2: f64 = 0.1;
/// Pixels up to 2.5 blur deviations plus half a pixel from a disc's outline are fitted.
// At 2.5 deviations a blurred straight edge has 0.6 % of its contrast left: farther pixels tell grey alone.
pub(crate) const MARGIN_DEVIATIONS: f64 = 2.5;
/// The share of the contrast by which the model may be wrong at a pixel: larger residuals are outliers.
pub(crate) const MODEL_ERROR_CONTRAST: f64 = 0.08;
/// One of so many discs is enough for a coarse fit, and one of so many pixels where there are fewer discs than
/// [`THIN_BY_DISCS_FROM`].
const THIN_PART: usize = 5;
const THIN_BY_DISCS_FROM: usize = 50;
/// At the least blur edges are sharper than pixels, which the model cannot follow: what is left is no noise, and the
/// iteration ends with a step that lowers the sum of squares by less than this share.
const SHARP_GAIN: f64 = 0.01;
/// The unit of the planes of grey, pixels.
pub(crate) const SLOPE_UNIT_PX: f64 = 100.0;

/// A grid as its pixels show it.
#[derive(Debug, Clone)]
pub(crate) struct GridFit {
    /// From columns and rows to pixels.
    pub(crate) h: Matrix3<f64>,
    /// A disc's radius, steps of the grid.
    pub(crate) radius: f64,
    /// The blur's deviation, pixels.
    pub(crate) sigma: f64,
    /// Paper less disc, grey levels: value at `origin`, slopes per 100 px. Positive for dark discs.
    pub(crate) contrast: [f64; 3],
    pub(crate) origin: Vector2<f64>,
    /// The residuals' standard deviation, grey levels.
    pub(crate) noise: f64,
    /// Covariance of the eight entries of `h`, row by row. After [`End::Last`] it is that of the state before the last step.
    pub(crate) covariance: SMatrix<f64, 8, 8>,
    pub(crate) params: Params,
    /// The lens that the discs are seen through, where there is one.
    pub(crate) bent: Option<LensModel>,
}

/// What is fitted, and where.
pub(crate) struct Grid<'a> {
    pub(crate) image: &'a Image,
    pub(crate) cells: &'a [[i32; 2]],
    /// Places of large discs: pixels nearest to them are left out.
    pub(crate) marks: &'a HashSet<[i32; 2]>,
    pub(crate) bright: bool,
}

/// Which pixels are fitted.
struct Selection {
    /// Those of a fifth of the discs, or a fifth of the pixels where there are few discs.
    thin: bool,
    /// Pixels whose residual exceeds this share of the contrast, and five deviations of the noise, are left out.
    outlier_contrast: f64,
    /// Where the planes of grey have their values.
    origin: Vector2<f64>,
}

fn homography_of(p: &Params) -> Matrix3<f64> {
    Matrix3::new(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], 1.0)
}

/// The derivatives of a pixel's coverage by discs, by the first [`SHAPES`] parameters, and behind them the coverage itself.
type CoverageAndGradient = [f64; SHAPES + 1];

impl Grid<'_> {
    /// A coarse fit from a homography, a radius in steps of the grid, and a blur in pixels, to a fifth of the discs or
    /// pixels. None where it does not converge, or not to discs of the contrast's sign.
    pub(crate) fn fit_coarse(&self, h: &Matrix3<f64>, radius: f64, sigma: f64) -> Option<GridFit> {
        let mut params = Params::zeros();
        // Cell (0, 0) is the lattice's seed, which lies in the image: its depth, this entry, does not vanish.
        let h = h / h[(2, 2)];
        (0..HOMOGRAPHY).for_each(|k| params[k] = h[(k / 3, k % 3)]);
        (params[RADIUS], params[BLUR]) = (radius, sigma);
        // About the middle of the grid the planes' values and slopes are hardly correlated.
        let origin = self.cells.iter().map(|c| project(&h, point(*c))).sum::<Vector2<f64>>() / self.cells.len() as f64;
        let select = |outlier_contrast: f64| Selection {
            thin: true,
            outlier_contrast,
            origin,
        };
        // With all greys at 0 the residuals are the samples themselves, and one linear solution gives the planes.
        let greys = self.greys(&params, &select(1.0))?;
        params.fixed_rows_mut::<6>(DISC).copy_from(&greys);
        // Outliers are rejected more strictly the second time: at first outlines are half a pixel off.
        let (params, _) = self.minimise(params, select(0.5))?;
        let (params, now) = self.minimise(params, select(0.15))?;
        self.result(&params, &now, origin)
    }

    /// The planes of grey that fit best with the outlines given.
    fn greys(&self, params: &Params, selection: &Selection) -> Option<SVector<f64, 6>> {
        self.equations(&self.sample_pixels(params, selection)?, params, selection)?
            .greys()
    }

    /// The fit again from one to nearly the same discs, to all that is to be seen or to a fifth of it.
    pub(crate) fn refit(&self, from: &GridFit, thin: bool) -> Option<GridFit> {
        let selection = Selection {
            thin,
            outlier_contrast: MODEL_ERROR_CONTRAST,
            origin: from.origin,
        };
        let (params, now) = self.minimise(from.params, selection)?;
        self.result(&params, &now, from.origin)
    }

    /// Least squares over the selected pixels: the parameters, and the normal equations. Those are of the state before the
    /// last step where the iteration ended by [`End::Last`], and so is the covariance made of them.
    ///
    /// Pixels with large residuals at the start (glare, dirt, spots that are no discs) are left out from then on.
    fn minimise(&self, start: Params, selection: Selection) -> Option<(Params, Equations)> {
        let mut sample = self.sample_pixels(&start, &selection)?;
        self.reject_outliers(&mut sample, &start, &selection)?;
        let problem = GridProblem {
            grid: self,
            sample: &sample,
            selection: &selection,
        };
        let limits = Limits {
            flat: 1.0,
            ..Limits::tries(MAX_STEPS)
        };
        let mut outcome = least_squares(&problem, start, DAMPING, limits)?;
        // Not converged: its covariance would be that of a state which is not the minimum.
        if outcome.end == End::OutOfSteps {
            return None;
        }
        // The last step is made without evaluating where it leads: matrix and squares are those before it, and the squares
        // are lessened by what the linear model predicts.
        if outcome.end == End::Last {
            outcome.at.squares -= outcome.gain;
        }
        Some((outcome.state, outcome.at))
    }

    /// How far outlines shift from one set of parameters to another, in units of the blur: the larger it is, the less linear
    /// is the step.
    fn relative_outline_shift(&self, from: &Params, to: &Params) -> f64 {
        let (a, b) = (homography_of(from), homography_of(to));
        let shift = |cell: &[i32; 2]| {
            let at = point(*cell);
            // Pixels to a step of the grid.
            let local_scale = jacobian(&a, at).determinant().abs().sqrt();
            (project(&b, at) - project(&a, at)).norm() + local_scale * (to[RADIUS] - from[RADIUS]).abs()
        };
        // The most over the discs, not the mean: one outline that moves by more than its blur is enough for a step that
        // is not linear.
        let most = self.cells.iter().map(shift).fold(0.0, f64::max);
        (most + (to[BLUR] - from[BLUR]).abs()) / from[BLUR]
    }

    fn result(&self, params: &Params, now: &Equations, origin: Vector2<f64>) -> Option<GridFit> {
        // `equations` refuses 2 N pixels and fewer: degrees of freedom are left.
        let noise = (now.squares / (now.pixels.checked_sub(N)? as f64)).sqrt();
        // Grey levels are whole numbers: residuals below the deviation of their rounding do not make the fit more certain.
        let covariance = inverse(&now.matrix)? * (noise * noise).max(1.0 / 12.0);
        // The parameters hold disc - paper; contrast is paper - disc, so negate.
        let contrast = [0, 1, 2].map(|k| -params[DISC + k]);
        let has_sign = if self.bright {
            contrast[0] < 0.0
        } else {
            contrast[0] > 0.0
        };
        has_sign.then(|| GridFit {
            h: homography_of(params),
            radius: params[RADIUS],
            sigma: params[BLUR],
            contrast,
            origin,
            noise,
            covariance: covariance.fixed_view::<8, 8>(0, 0).into_owned(),
            params: *params,
            bent: None,
        })
    }

    /// The selected pixels about the outlines at the start. Were they chosen by the current parameters, smaller discs would
    /// leave out residuals.
    fn sample_pixels(&self, start: &Params, selection: &Selection) -> Option<SamplePixels> {
        let by_discs = selection.thin && self.cells.len() >= THIN_BY_DISCS_FROM;
        let is_mark = |place: Vector2<f64>| {
            !self.marks.is_empty() && self.marks.contains(&[place.x.round() as i32, place.y.round() as i32])
        };
        let outlines = Outlines {
            h: homography_of(start),
            radius: start[RADIUS],
            sigma: start[BLUR],
            margin: MARGIN_DEVIATIONS * start[BLUR] + 0.5,
            thin: if selection.thin && !by_discs { THIN_PART } else { 1 },
            is_left_out: &is_mark,
        };
        // A knight's steps: one of any 5 in a row or a column, so that all parts of the grid count.
        let is_taken = |c: &&[i32; 2]| !by_discs || (c[0] + 2 * c[1]).rem_euclid(THIN_PART as i32) == 0;
        let cells: Vec<[i32; 2]> = self.cells.iter().filter(is_taken).copied().collect();
        SamplePixels::new(&outlines, &cells, self.cells, [self.image.width(), self.image.height()])
    }

    fn equations(&self, sample: &SamplePixels, params: &Params, selection: &Selection) -> Option<Equations> {
        let (h, mut sums) = (homography_of(params), Sums::default());
        // Discs are visited one by one: what a pixel sees of several is whole only after the last.
        let mut shared = vec![[0.0; SHAPES + 1]; sample.shared.len()];
        let begin = |cell: [i32; 2]| {
            let ellipse = Ellipse::of_circle(&h, point(cell), params[RADIUS])?;
            Some((ellipse, params[BLUR], ellipse_slopes(&h, point(cell), params[RADIUS])))
        };
        sample.visit(begin, |raster, slopes, pixel, y| {
            let x = pixel.x as usize;
            let mut alone = [0.0; SHAPES + 1];
            // Discs do not overlap, so that what a pixel sees of several is their sum.
            let values = pixel.shared().map_or(&mut alone, |i| &mut shared[i]);
            add(values, &raster.at(x), slopes);
            if pixel.shared().is_none() {
                self.accumulate(&mut sums, params, selection, &alone, [x, y]);
            }
        })?;
        for (values, at) in shared.iter().zip(&sample.shared) {
            self.accumulate(&mut sums, params, selection, values, at.map(|k| k as usize));
        }
        let out = sums.equations(sample.count());
        // Fewer residuals than twice the parameters tell next to nothing of the noise.
        (out.pixels > 2 * N).then_some(out)
    }

    /// Adds a pixel to the normal equations.
    fn accumulate(
        &self,
        sums: &mut Sums,
        params: &Params,
        selection: &Selection,
        values: &CoverageAndGradient,
        at: [usize; 2],
    ) {
        let (basis, coverage) = (selection.basis(at), values[SHAPES]);
        let (disc, residual) = self.residual(params, &basis, coverage, at);
        // The model is paper + coverage disc: its derivatives by the disc's plane are coverage times the basis, by the
        // paper's the basis.
        let greys = [
            coverage,
            coverage * basis[1],
            coverage * basis[2],
            1.0,
            basis[1],
            basis[2],
        ];
        sums.add(&values[..SHAPES], disc, &greys, residual);
    }

    /// Grey of the disc less the paper at a pixel, and the pixel less the model.
    fn residual(&self, params: &Params, basis: &[f64; 3], coverage: f64, [x, y]: [usize; 2]) -> (f64, f64) {
        let plane = |k: usize| (0..3).map(|i| params[k + i] * basis[i]).sum::<f64>();
        let (disc, paper) = (plane(DISC), plane(PAPER));
        (disc, f64::from(self.image.sample(x, y)) - paper - disc * coverage)
    }

    /// Leaves out pixels whose residuals are larger than noise and wrong outlines make them.
    fn reject_outliers(&self, sample: &mut SamplePixels, params: &Params, selection: &Selection) -> Option<()> {
        let h = homography_of(params);
        let size = |coverage: f64, at: [usize; 2]| self.residual(params, &selection.basis(at), coverage, at).1.abs();
        let (mut shared, mut alone) = (vec![0.0; sample.shared.len()], Vec::new());
        let begin = |cell: [i32; 2]| Some((Ellipse::of_circle(&h, point(cell), params[RADIUS])?, params[BLUR], ()));
        sample.visit(begin, |raster, (), pixel: Pixel, y| {
            let x = pixel.x as usize;
            match pixel.shared() {
                Some(i) => shared[i] += raster.value(x),
                None => alone.push(size(raster.value(x), [x, y])),
            }
        })?;
        let several = shared.iter().zip(&sample.shared);
        let shared: Vec<f64> = several
            .map(|(coverage, at)| size(*coverage, at.map(|k| k as usize)))
            .collect();
        // Five standard deviations: for normal noise one is 1.4826 times the median of the sizes.
        let median = median(alone.iter().chain(&shared).copied().collect());
        // The share of the contrast keeps pixels whose residuals come of outlines that are wrong as yet: those pixels are
        // what moves them.
        let outlier_threshold = (5.0 * 1.4826 * median).max(selection.outlier_contrast * params[DISC].abs());
        if alone.iter().chain(&shared).any(|r| *r > outlier_threshold) {
            let stays = |sizes: &[f64]| sizes.iter().map(|r| *r <= outlier_threshold).collect::<Vec<bool>>();
            sample.retain(&stays(&alone), &stays(&shared));
        }
        Some(())
    }
}

/// Adds a pixel's coverage by one disc, whose outline has the given derivatives by homography and radius.
fn add(values: &mut CoverageAndGradient, coverage: &Coverage, slopes: &[[f64; BLUR]; 5]) {
    values[SHAPES] += coverage.value;
    values[BLUR] += coverage.slope[5];
    // Farther from the edge than the blur reaches a coverage has no slopes, and most pixels lie there.
    if coverage.slope[..5].iter().any(|s| *s != 0.0) {
        for (slope, row) in coverage.slope.iter().zip(slopes) {
            (0..BLUR).for_each(|k| values[k] += slope * row[k]);
        }
    }
}

impl Selection {
    /// The planes of grey are linear in these.
    fn basis(&self, [x, y]: [usize; 2]) -> [f64; 3] {
        [
            1.0,
            (x as f64 - self.origin.x) / SLOPE_UNIT_PX,
            (y as f64 - self.origin.y) / SLOPE_UNIT_PX,
        ]
    }
}

/// The fit of a grid to its selected pixels.
struct GridProblem<'a> {
    grid: &'a Grid<'a>,
    sample: &'a SamplePixels,
    selection: &'a Selection,
}

impl fit::Problem for GridProblem<'_> {
    type State = Params;
    type At = Equations;

    fn look(&self, params: &Params) -> Option<(f64, Equations)> {
        let equations = self.grid.equations(self.sample, params, self.selection)?;
        Some((equations.squares, equations))
    }

    fn step(&self, params: &Params, now: &Equations, damping: f64) -> Option<Step<Params>> {
        let (to, gain) = next(params, now, damping)?;
        let length = self.grid.relative_outline_shift(params, &to);
        is_possible(&to).then_some(Step { to, length, gain })
    }

    /// The gain that remains after a step of Gauss and Newton is taken to scale with (step / blur)^2. A step that damping
    /// alone made short gains little, too, and says nothing of what remains.
    fn is_last(&self, step: &Step<Params>, now: &Equations, damping: f64) -> bool {
        if damping > MOST_AT_END {
            return false;
        }
        let remaining = step.gain * step.length.powi(2).min(1.0);
        remaining < LAST_GAIN_CHI2 * now.squares / now.pixels as f64
    }

    fn is_settled(&self, made: &Made<'_, Params, Equations>) -> bool {
        made.state[BLUR] <= LEAST_BLUR && 1.0 - made.to / made.from < SHARP_GAIN
    }
}

/// The parameters after a step, and by how much the squares fall with it were the model linear. A blur that would fall below
/// the least is held there: it would creep towards it otherwise, by less from step to step.
fn next(params: &Params, now: &Equations, damping: f64) -> Option<(Params, f64)> {
    let (change, expected) = step(now, damping, false)?;
    if params[BLUR] + change[BLUR] >= LEAST_BLUR {
        return Some((params + change, expected));
    }
    let (change, expected) = step(now, damping, true)?;
    let mut next = params + change;
    next[BLUR] = LEAST_BLUR;
    Some((next, expected))
}

fn is_possible(p: &Params) -> bool {
    // Discs whose radius is half a pitch touch: beyond, what a pixel sees of several is no longer their sum.
    (0.02..0.5).contains(&p[RADIUS]) && (LEAST_BLUR..50.0).contains(&p[BLUR]) && p.iter().all(|v| v.is_finite())
}
