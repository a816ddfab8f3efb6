//! One disc's centre by fitting the model of a blurred ellipse on a plane background to its pixels.

use ::fit::{Damping, End, Limits, Made, Rule, Step, least_squares};
use nalgebra::{Matrix2, Vector2};

use super::blurred::Blurred;
use super::ellipse::Ellipse;
use super::equations::{Equations, Information, N, Params, Sums};
use super::error::FitRefused;
use super::raster::Raster;
use crate::image::Image;

/// Discs that are there take 5 to 26.
const MAX_STEPS: usize = 40;
/// Discs that are where they are expected take fewer.
const FEW_STEPS: usize = 20;
/// A step that is to gain less of chi squared is the last, and one that has gained a tenth of it: 1e-2 is a tenth of any
/// parameter's deviation, of which the step leaves the square.
const LAST_GAIN_CHI2: f64 = 1e-2;
/// Windows of so many pixels are looked at by one of so many rows first (an odd number, so that both fields of an interlaced
/// image count), until a step is to gain less of chi squared.
const THINNED_FROM_PIXELS: usize = 600;
const THINNED_ROWS: usize = 3;
const THINNED_UNTIL_CHI2: f64 = 3.0;
/// How much of a step is held back far from the end, and near it.
const FAR_DAMPING: f64 = 1e-3;
const NEAR_DAMPING: f64 = 1e-6;

/// Of the diagonal of the normal equations. Halving and doubling by fixed factors wastes every second step in the curved valley
/// of blur, size and contrast.
fn damping(start: f64) -> Damping {
    Damping {
        start,
        rule: Rule::Gained { least: 1e-9 },
        // No step helps any more: the sum of squares is at its rounding.
        most: 1e6,
        singular: true,
    }
}
/// The largest semi-axis that is fitted, pixels.
const MAX_SEMI: f64 = 400.0;

/// A disc as its pixels show it.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscFit {
    /// Its outline, pixels.
    pub ellipse: Ellipse,
    /// The blur's deviation with the pixel's own area in it, pixels.
    pub sigma: f64,
    /// The disc's grey less that of its surroundings, grey levels.
    pub contrast: f64,
    /// The background's grey at the centre and its slope along x and y.
    pub background: [f64; 3],
    /// The residuals' standard deviation, grey levels: the noise where the model holds.
    pub noise: f64,
    /// Covariance of the centre for that noise, pixels squared.
    pub covariance: Matrix2<f64>,
    /// Pixels used.
    pub pixels: usize,
}

/// Fits a disc that lies about where `start` says, blurred by about `sigma` pixels.
///
/// All pixels within `margin` pixels of the outline are used, so that nothing else should lie there. The covariance
/// is the inverse of Fisher's information for the residuals' own variance, or that of rounding where it is larger.
///
/// # Errors
/// [`FitRefused`]: too few pixels, no contrast, no convergence, or a disc that runs away from where it was looked for.
pub fn fit_disc(image: &Image, start: &Ellipse, sigma: f64, margin: f64) -> Result<DiscFit, FitRefused> {
    let fit = Fit::new(image, start, sigma, margin, start.axes().semi[0] + 2.0)?;
    fit.found(fit.start(start, sigma)?)
}

/// Fits a disc that is expected where `start` says, up to `reach` pixels from there: none where its outline does not show
/// `contrast` from the beginning, of that sign.
pub(crate) fn fit_expected(
    image: &Image,
    start: &Ellipse,
    [sigma, margin]: [f64; 2],
    reach: f64,
    contrast: f64,
) -> Option<DiscFit> {
    let fit = Fit {
        steps: FEW_STEPS,
        ..Fit::new(image, start, sigma, margin, reach).ok()?
    };
    let params = fit.start(start, sigma).ok()?;
    (params[6] / contrast >= 1.0).then(|| fit.found(params).ok()).flatten()
}

struct Fit<'a> {
    image: &'a Image,
    /// Columns and rows.
    window: [[usize; 2]; 2],
    /// Where the background's plane has its value.
    origin: Vector2<f64>,
    /// How far from there the centre may go, pixels.
    reach: f64,
    /// The most steps, to what is near and from there.
    steps: usize,
}

fn ellipse_of(p: &Params) -> Ellipse {
    Ellipse {
        centre: Vector2::new(p[0], p[1]),
        shape: Matrix2::new(p[2], p[3], p[3], p[4]),
    }
}

impl<'a> Fit<'a> {
    fn new(image: &'a Image, start: &Ellipse, sigma: f64, margin: f64, reach: f64) -> Result<Self, FitRefused> {
        let semi = start.axes().semi;
        if !(semi[1] > 0.0 && semi[0] <= MAX_SEMI && sigma > 0.0) {
            return Err(FitRefused::BadStart { semi, sigma });
        }
        let window = Blurred::new(*start, sigma).window(margin, image.width(), image.height());
        Ok(Self {
            image,
            window,
            origin: start.centre,
            reach,
            steps: MAX_STEPS,
        })
    }

    fn found(&self, params: Params) -> Result<DiscFit, FitRefused> {
        let (params, equations) = self.solve(params)?;
        self.result(params, &equations)
    }

    /// Contrast and background by least squares for the starting outline: they are linear.
    fn start(&self, start: &Ellipse, sigma: f64) -> Result<Params, FitRefused> {
        let s = start.shape;
        let mut params = Params::zeros();
        let geometry = [start.centre.x, start.centre.y, s[(0, 0)], s[(0, 1)], s[(1, 1)], sigma];
        params.as_mut_slice()[..6].copy_from_slice(&geometry);
        let equations = self.equations(&params, self.thin());
        if equations.pixels < 2 * N {
            return Err(FitRefused::TooFewPixels {
                found: equations.pixels,
                needed: 2 * N,
            });
        }
        let linear = equations.matrix.fixed_view::<4, 4>(6, 6).into_owned();
        let step = linear
            .cholesky()
            .map(|c| c.solve(&equations.vector.fixed_rows::<4>(6).into_owned()));
        let step = step.ok_or(FitRefused::NoContrast { found: 0.0, noise: 0.0 })?;
        params.fixed_rows_mut::<4>(6).copy_from(&step);
        Ok(params)
    }

    /// Of one of so many rows.
    fn equations(&self, params: &Params, every: usize) -> Equations {
        let mut sums = Sums::default();
        let [columns, rows] = self.window;
        let mut model = Raster::default();
        model.set(ellipse_of(params), params[5], columns);
        for y in (rows[0] + every / 2..rows[1]).step_by(every) {
            let row = self.image.row(y);
            model.row(y);
            for (x, sample) in row.iter().enumerate().take(columns[1]).skip(columns[0]) {
                let seen = model.at(x);
                let (dx, dy) = (x as f64 - self.origin.x, y as f64 - self.origin.y);
                let background = params[7] + params[8] * dx + params[9] * dy;
                let residual = f64::from(*sample) - background - params[6] * seen.value;
                let [a, b, c, d, e, f] = seen.slope.map(|s| s * params[6]);
                sums.add(&[a, b, c, d, e, f, seen.value, 1.0, dx, dy, 0.0, 0.0], residual);
            }
        }
        sums.equations()
    }

    /// The least squares nearest to the start. A third of the rows are enough to come near.
    fn solve(&self, start: Params) -> Result<(Params, Equations), FitRefused> {
        let every = self.thin();
        if every == 1 {
            return self.settled(start, FAR_DAMPING, 1, LAST_GAIN_CHI2);
        }
        let (near, _) = self.settled(start, FAR_DAMPING, every, THINNED_UNTIL_CHI2)?;
        self.settled(near, NEAR_DAMPING, 1, LAST_GAIN_CHI2)
    }

    /// One of so many rows is enough to come near.
    fn thin(&self) -> usize {
        let [columns, rows] = self.window.map(|[first, end]| end - first);
        let enough = columns * rows >= THINNED_FROM_PIXELS && rows >= 3 * THINNED_ROWS;
        if enough { THINNED_ROWS } else { 1 }
    }

    /// The least squares of one of so many rows, to where a step is to gain less of chi squared than `least`.
    fn settled(&self, start: Params, held: f64, every: usize, least: f64) -> Result<(Params, Equations), FitRefused> {
        let limits = Limits {
            flat: 1.0,
            ..Limits::tries(self.steps)
        };
        let rows = Rows {
            fit: self,
            every,
            least,
        };
        let end = least_squares(&rows, start, damping(held), limits);
        let end = end.ok_or(FitRefused::NoConvergence { steps: self.steps })?;
        if end.end != End::Last {
            self.stayed(&end.state)?;
        }
        match end.end {
            End::OutOfSteps => Err(FitRefused::NoConvergence { steps: self.steps }),
            _ => Ok((end.state, end.at)),
        }
    }

    fn moved(&self, params: &Params) -> f64 {
        (ellipse_of(params).centre - self.origin).norm()
    }

    /// What leaves its place does not come back to it.
    fn stayed(&self, params: &Params) -> Result<(), FitRefused> {
        let (moved, reach) = (self.moved(params), self.reach);
        if moved > reach {
            return Err(FitRefused::RanAway { moved, reach });
        }
        Ok(())
    }

    fn result(&self, params: Params, equations: &Equations) -> Result<DiscFit, FitRefused> {
        let ellipse = ellipse_of(&params);
        let noise = (equations.squares / (equations.pixels - N) as f64).sqrt();
        let inverse = equations.matrix.cholesky().map(|c| c.inverse() * equations.variance());
        let inverse = inverse.ok_or(FitRefused::NoContrast {
            found: params[6],
            noise,
        })?;
        // Below three deviations of itself a contrast may be noise, and the centre is that of nothing.
        if params[6].powi(2) < 9.0 * inverse[(6, 6)] {
            return Err(FitRefused::NoContrast {
                found: params[6],
                noise,
            });
        }
        let slope = Vector2::new(params[8], params[9]);
        let at_centre = params[7] + slope.dot(&(ellipse.centre - self.origin));
        Ok(DiscFit {
            ellipse,
            sigma: params[5],
            contrast: params[6],
            background: [at_centre, slope.x, slope.y],
            noise,
            covariance: inverse.fixed_view::<2, 2>(0, 0).into_owned(),
            pixels: equations.pixels,
        })
    }
}

/// One of so many rows, to where a step is to gain less of chi squared than `least`.
struct Rows<'a> {
    fit: &'a Fit<'a>,
    every: usize,
    least: f64,
}

impl ::fit::Problem for Rows<'_> {
    type State = Params;
    type At = Equations;

    fn look(&self, params: &Params) -> Option<(f64, Equations)> {
        let equations = self.fit.equations(params, self.every);
        Some((equations.squares, equations))
    }

    fn step(&self, params: &Params, now: &Equations, damping: f64) -> Option<Step<Params>> {
        let held = now.matrix.diagonal() * damping;
        let damped = now.matrix + Information::from_diagonal(&held);
        let step = damped.cholesky()?.solve(&now.vector);
        let to = params + step;
        is_possible(&to).then(|| Step {
            to,
            length: step.norm(),
            gain: step.dot(&(now.vector + held.component_mul(&step))),
        })
    }

    /// Held back by next to nothing, a step that is to gain so little is right without a look at where it leads.
    fn is_last(&self, step: &Step<Params>, now: &Equations, damping: f64) -> bool {
        step.gain <= self.least * now.variance() && damping <= FAR_DAMPING
    }

    fn is_settled(&self, made: &Made<'_, Params, Equations>) -> bool {
        let little = made.from - made.to <= 0.1 * self.least * made.at.variance();
        little || self.fit.moved(made.state) > self.fit.reach
    }
}

fn is_possible(p: &Params) -> bool {
    let sigma = (0.2..100.0).contains(&p[5]);
    sigma && p[2] > 0.01 && p[2] * p[4] - p[3] * p[3] > 1e-4 && p[2] + p[4] < MAX_SEMI * MAX_SEMI
}
