//! One disc's centre by fitting the model of a blurred ellipse on a plane background to its pixels.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::blurred::Blurred;
use super::chi::ROUNDING;
use super::ellipse::Ellipse;
use super::error::FitRefused;
use super::raster::Raster;
use crate::image::Image;

/// Centre 2, shape 3, blur, contrast, background 3.
const N: usize = 10;
type Params = SVector<f64, N>;
type Information = SMatrix<f64, N, N>;

const MAX_STEPS: usize = 60;
/// The iteration ends where a step gains less of chi squared: 1e-4 is a hundredth of any parameter's deviation.
const SETTLED: f64 = 1e-4;
/// The largest semi-axis that is fitted, pixels.
const MAX_SEMI: f64 = 400.0;

/// A disc as its pixels show it.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscFit {
    /// Its outline, pixels.
    pub ellipse: Ellipse,
    /// The blur's deviation with the pixel's own area in it, pixels.
    pub sigma: f64,
    /// The disc's grey less that of its surroundings, steps of a sample.
    pub contrast: f64,
    /// The background's grey at the centre and its slope along x and y.
    pub background: [f64; 3],
    /// The residuals' standard deviation, steps of a sample: the noise where the model holds.
    pub noise: f64,
    /// Covariance of the centre for that noise, pixels squared.
    pub covariance: Matrix2<f64>,
    /// Pixels used.
    pub pixels: usize,
}

/// Normal equations at one set of parameters.
struct Equations {
    matrix: Information,
    vector: Params,
    squares: f64,
    pixels: usize,
}

/// Fits a disc that lies about where `start` says, blurred by about `sigma` pixels.
///
/// All pixels within `margin` pixels of the outline are used, so that nothing else should lie there. The covariance
/// is the inverse of Fisher's information for the residuals' own variance, or that of rounding where it is larger.
///
/// # Errors
/// [`FitRefused`]: too few pixels, no contrast, no convergence, or a disc that runs away from where it was looked for.
pub fn fit_disc(image: &Image, start: &Ellipse, sigma: f64, margin: f64) -> Result<DiscFit, FitRefused> {
    let [major, minor] = start.axes().semi;
    if !(minor > 0.0 && major <= MAX_SEMI && sigma > 0.0) {
        return Err(FitRefused::BadStart {
            semi: [major, minor],
            sigma,
        });
    }
    let window = Blurred::new(*start, sigma).window(margin, image.width(), image.height());
    let fit = Fit {
        image,
        window,
        origin: start.centre,
    };
    let params = fit.start(start, sigma)?;
    let (params, equations) = fit.solve(params)?;
    fit.result(params, &equations, start)
}

struct Fit<'a> {
    image: &'a Image,
    /// Columns and rows.
    window: [[usize; 2]; 2],
    /// Where the background's plane has its value.
    origin: Vector2<f64>,
}

fn ellipse_of(p: &Params) -> Ellipse {
    Ellipse {
        centre: Vector2::new(p[0], p[1]),
        shape: Matrix2::new(p[2], p[3], p[3], p[4]),
    }
}

impl Fit<'_> {
    /// Contrast and background by least squares for the starting outline: they are linear.
    fn start(&self, start: &Ellipse, sigma: f64) -> Result<Params, FitRefused> {
        let s = start.shape;
        let mut params = Params::zeros();
        let geometry = [start.centre.x, start.centre.y, s[(0, 0)], s[(0, 1)], s[(1, 1)], sigma];
        params.as_mut_slice()[..6].copy_from_slice(&geometry);
        let equations = self.equations(&params);
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

    fn equations(&self, params: &Params) -> Equations {
        let mut sums = Sums::default();
        let [columns, rows] = self.window;
        let mut model = Raster::default();
        model.set(ellipse_of(params), params[5], columns);
        for y in rows[0]..rows[1] {
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

    fn solve(&self, mut params: Params) -> Result<(Params, Equations), FitRefused> {
        let mut damping = Damping::new();
        let mut now = self.equations(&params);
        for _ in 0..MAX_STEPS {
            let Some((step, expected)) = damping.step(&now) else {
                damping.raise();
                continue;
            };
            let next = params + step;
            let then = is_possible(&next).then(|| self.equations(&next));
            match then {
                Some(then) if then.squares <= now.squares => {
                    let gained = now.squares - then.squares;
                    (params, now) = (next, then);
                    damping.lower(gained / expected.max(f64::MIN_POSITIVE));
                    if gained <= SETTLED * now.variance() {
                        return Ok((params, now));
                    }
                }
                _ => damping.raise(),
            }
            // No step helps any more: the sum of squares is at its rounding.
            if damping.factor > 1e6 {
                return Ok((params, now));
            }
        }
        Err(FitRefused::NoConvergence { steps: MAX_STEPS })
    }

    fn result(&self, params: Params, equations: &Equations, start: &Ellipse) -> Result<DiscFit, FitRefused> {
        let ellipse = ellipse_of(&params);
        let moved = (ellipse.centre - start.centre).norm();
        let reach = start.axes().semi[0] + 2.0;
        if moved > reach {
            return Err(FitRefused::RanAway { moved, reach });
        }
        let noise = (equations.squares / (equations.pixels - N) as f64).sqrt();
        let inverse = equations.matrix.cholesky().map(|c| c.inverse() * equations.variance());
        let inverse = inverse.ok_or(FitRefused::NoContrast {
            found: params[6],
            noise,
        })?;
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

impl Equations {
    /// The residuals' variance. Samples are whole: below the variance of rounding, residuals say nothing.
    fn variance(&self) -> f64 {
        (self.squares / (self.pixels - N) as f64).max(ROUNDING * ROUNDING)
    }
}

/// Parameters in whole groups of four.
const ROOM: usize = 12;

/// Normal equations as they are summed up; the lower triangle, row by row.
#[derive(Default)]
struct Sums {
    matrix: [[f64; ROOM]; ROOM],
    vector: [f64; ROOM],
    squares: f64,
    pixels: usize,
}

impl Sums {
    /// A pixel. Far from the edge it says nothing of the outline.
    fn add(&mut self, slope: &[f64; ROOM], residual: f64) {
        if slope[..4].iter().any(|s| *s != 0.0) {
            self.rows::<0, 4>(slope);
        }
        self.rows::<4, 8>(slope);
        self.rows::<8, 12>(slope);
        let vector = self.vector.iter_mut().zip(slope);
        vector.for_each(|(to, s)| *to += s * residual);
        self.squares += residual * residual;
        self.pixels += 1;
    }

    /// Four rows up to the diagonal, in whole groups of four: sizes that are known make one straight run of it.
    #[inline]
    fn rows<const FIRST: usize, const END: usize>(&mut self, slope: &[f64; ROOM]) {
        for i in FIRST..END {
            for j in 0..END {
                self.matrix[i][j] += slope[i] * slope[j];
            }
        }
    }

    fn equations(&self) -> Equations {
        let mut matrix = Information::from_fn(|i, j| self.matrix[i][j]);
        matrix.fill_upper_triangle_with_lower_triangle();
        Equations {
            matrix,
            vector: Params::from_fn(|i, _| self.vector[i]),
            squares: self.squares,
            pixels: self.pixels,
        }
    }
}

/// How much of a step's length is held back, by how well the last ones did what was expected of them (Nielsen 1999):
/// halving and doubling by fixed factors wastes every second step in the curved valley of blur, size and contrast.
struct Damping {
    factor: f64,
    rise: f64,
}

impl Damping {
    fn new() -> Self {
        Self {
            factor: 1e-3,
            rise: 2.0,
        }
    }

    /// The step, and what it would gain were the model linear; none where the equations are singular.
    fn step(&self, now: &Equations) -> Option<(Params, f64)> {
        let held = now.matrix.diagonal() * self.factor;
        let damped = now.matrix + Information::from_diagonal(&held);
        let step = damped.cholesky()?.solve(&now.vector);
        let expected = step.dot(&(now.vector + held.component_mul(&step)));
        Some((step, expected))
    }

    fn lower(&mut self, ratio: f64) {
        let factor = 1.0 - (2.0 * ratio - 1.0).powi(3);
        self.factor = (self.factor * factor.clamp(0.1, 2.0)).max(1e-9);
        self.rise = 2.0;
    }

    fn raise(&mut self) {
        self.factor *= self.rise;
        self.rise *= 2.0;
    }
}

fn is_possible(p: &Params) -> bool {
    let sigma = (0.2..100.0).contains(&p[5]);
    sigma && p[2] > 0.01 && p[2] * p[4] - p[3] * p[3] > 1e-4 && p[2] + p[4] < MAX_SEMI * MAX_SEMI
}
