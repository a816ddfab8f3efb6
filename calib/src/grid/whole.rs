//! One fit of the whole grid to the pixels: homography, radius, blur, and planes of grey for discs and paper.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

use super::homography::project;
use crate::disc::{Blurred, Ellipse};
use crate::image::Image;

/// Homography 8, radius, blur: what moves outlines.
const SHAPES: usize = 10;
/// With grey in discs 3 and around them 3.
const N: usize = 16;
type Params = SVector<f64, N>;
const MAX_STEPS: usize = 25;
/// The unit of the planes of grey, pixels.
const UNIT: f64 = 100.0;

/// A grid as its pixels show it.
#[derive(Debug, Clone)]
pub(crate) struct Whole {
    /// From columns and rows to pixels.
    pub(crate) h: Matrix3<f64>,
    /// A disc's radius, steps of the grid.
    pub(crate) radius: f64,
    /// The blur's deviation, pixels.
    pub(crate) sigma: f64,
    /// Paper less disc at a place, steps of a sample: value, slopes per 100 px about `origin`.
    pub(crate) contrast: [f64; 3],
    pub(crate) origin: Vector2<f64>,
    /// The residuals' deviation, steps of a sample.
    pub(crate) noise: f64,
    /// Covariance of the eight entries of `h`, row by row.
    pub(crate) covariance: SMatrix<f64, 8, 8>,
}

/// What is fitted, and where.
pub(crate) struct Grid<'a> {
    pub(crate) image: &'a Image,
    pub(crate) cells: &'a [[i32; 2]],
    pub(crate) bright: bool,
}

struct Equations {
    matrix: SMatrix<f64, N, N>,
    vector: Params,
    squares: f64,
    pixels: usize,
}

fn homography_of(p: &Params) -> Matrix3<f64> {
    Matrix3::new(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], 1.0)
}

/// A cell as a point of the grid's plane.
pub(crate) fn point(cell: [i32; 2]) -> Vector2<f64> {
    Vector2::new(f64::from(cell[0]), f64::from(cell[1]))
}

/// Derivatives of an ellipse's centre and shape (xx, xy, yy) by the entries of the homography and the radius.
fn ellipse_slopes(h: &Matrix3<f64>, at: Vector2<f64>, radius: f64) -> [[f64; 9]; 5] {
    let a = Vector3::new(at.x, at.y, 1.0);
    let mut dual = a * a.transpose();
    dual[(0, 0)] -= radius * radius;
    dual[(1, 1)] -= radius * radius;
    let image = h * dual * h.transpose();
    let w = image[(2, 2)];
    let centre = Vector2::new(image[(0, 2)], image[(1, 2)]) / w;
    let upper: Matrix2<f64> = image.fixed_view::<2, 2>(0, 0) / w;
    let mut out = [[0.0; 9]; 5];
    for k in 0..9 {
        let change = if k < 8 {
            let mut part = Matrix3::zeros();
            part.set_row(k / 3, &(dual * h.transpose()).row(k % 3));
            part + part.transpose()
        } else {
            let columns = h.fixed_view::<3, 2>(0, 0);
            -2.0 * radius * columns * columns.transpose()
        };
        let turn = change[(2, 2)] / w;
        let dc = Vector2::new(change[(0, 2)], change[(1, 2)]) / w - centre * turn;
        let ds =
            dc * centre.transpose() + centre * dc.transpose() - (change.fixed_view::<2, 2>(0, 0) / w - upper * turn);
        let all = [dc.x, dc.y, ds[(0, 0)], ds[(0, 1)], ds[(1, 1)]];
        all.iter().zip(&mut out).for_each(|(value, row)| row[k] = *value);
    }
    out
}

/// Pixels that see discs: where, how much, and the derivatives of that by the first [`SHAPES`] parameters.
struct Seen {
    slots: Vec<u32>,
    list: Vec<(u32, [f64; SHAPES + 1])>,
}

impl Grid<'_> {
    /// Fits from a homography, a radius in steps of the grid, and a blur in pixels. None where it does not settle on a
    /// grid that stands out.
    pub(crate) fn fit(&self, h: &Matrix3<f64>, radius: f64, sigma: f64) -> Option<Whole> {
        let origin = self.cells.iter().map(|c| project(h, point(*c))).sum::<Vector2<f64>>() / self.cells.len() as f64;
        let mut params = Params::zeros();
        let h = h / h[(2, 2)];
        (0..8).for_each(|k| params[k] = h[(k / 3, k % 3)]);
        (params[8], params[9]) = (radius, sigma);
        self.set_greys(&mut params, origin)?;
        let start = params;
        let mut now = self.equations(&params, &start, origin)?;
        let mut damping = 1e-3;
        for _ in 0..MAX_STEPS {
            let next = step(&now, damping).map(|s| params + s).filter(is_possible);
            let then = next.and_then(|next| Some((next, self.equations(&next, &start, origin)?)));
            match then {
                Some((next, then)) if then.squares <= now.squares => {
                    let gained = (now.squares - then.squares) / now.squares.max(1e-12);
                    (params, now, damping) = (next, then, (damping * 0.1_f64).max(1e-10));
                    // A gain of 1e-7 of the squares of some 1e4 pixels is 1e-3 of chi squared: 0.03 deviations.
                    if gained < 1e-7 {
                        break;
                    }
                }
                _ => damping *= 10.0,
            }
            if damping > 1e5 {
                break;
            }
        }
        self.result(&params, &now, origin)
    }

    /// The planes of grey by least squares for the outlines given: they are linear.
    fn set_greys(&self, params: &mut Params, origin: Vector2<f64>) -> Option<()> {
        let now = self.equations(params, params, origin)?;
        let linear = now.matrix.fixed_view::<6, 6>(SHAPES, SHAPES).into_owned().cholesky()?;
        let greys = linear.solve(&now.vector.fixed_rows::<6>(SHAPES).into_owned());
        params.fixed_rows_mut::<6>(SHAPES).copy_from(&greys);
        Some(())
    }

    fn result(&self, params: &Params, now: &Equations, origin: Vector2<f64>) -> Option<Whole> {
        let noise = (now.squares / (now.pixels.checked_sub(N)? as f64)).sqrt();
        let covariance = inverse(&now.matrix)? * (noise * noise);
        // A step of the discs' grey: contrast is that of the paper less the discs, positive for dark ones.
        let contrast = [0, 1, 2].map(|k| -params[SHAPES + k]);
        let right = if self.bright {
            contrast[0] < 0.0
        } else {
            contrast[0] > 0.0
        };
        right.then(|| Whole {
            h: homography_of(params),
            radius: params[8],
            sigma: params[9],
            contrast,
            origin,
            noise,
            covariance: covariance.fixed_view::<8, 8>(0, 0).into_owned(),
        })
    }

    /// Which pixels count is up to `start`: were it up to the parameters, smaller discs would leave out residuals.
    fn seen(&self, params: &Params, start: &Params) -> Option<Seen> {
        let (width, height) = (self.image.width(), self.image.height());
        let (h, h0) = (homography_of(params), homography_of(start));
        let back = h0.try_inverse()?;
        let mut seen = Seen {
            slots: vec![u32::MAX; width * height],
            list: Vec::new(),
        };
        for cell in self.cells {
            let at = point(*cell);
            let model = Blurred::new(Ellipse::of_circle(&h, at, params[8])?, params[9]);
            let slopes = ellipse_slopes(&h, at, params[8]);
            let around = Blurred::new(Ellipse::of_circle(&h0, at, start[8])?, start[9]);
            let [columns, rows] = around.window(3.0 * start[9] + 1.0, width, height);
            for y in rows[0]..rows[1] {
                for x in columns[0]..columns[1] {
                    let off = project(&back, Vector2::new(x as f64, y as f64)) - at;
                    // Beyond three quarters of a step there may be the end of the paper.
                    if off.x.abs() > 0.75 || off.y.abs() > 0.75 {
                        continue;
                    }
                    let coverage = model.at(x as f64, y as f64);
                    seen.add(y * width + x, &coverage, &slopes);
                }
            }
        }
        Some(seen)
    }

    fn equations(&self, params: &Params, start: &Params, origin: Vector2<f64>) -> Option<Equations> {
        let seen = self.seen(params, start)?;
        let width = self.image.width();
        let mut out = Equations {
            matrix: SMatrix::zeros(),
            vector: Params::zeros(),
            squares: 0.0,
            pixels: seen.list.len(),
        };
        for (pixel, values) in &seen.list {
            let (x, y) = (*pixel as usize % width, *pixel as usize / width);
            let place = [1.0, (x as f64 - origin.x) / UNIT, (y as f64 - origin.y) / UNIT];
            let plane = |k: usize| (0..3).map(|i| params[k + i] * place[i]).sum::<f64>();
            let (disc, paper, f) = (plane(SHAPES), plane(SHAPES + 3), values[SHAPES]);
            let residual = f64::from(self.image.sample(x, y)) - paper - disc * f;
            let mut slope = [0.0; N];
            (0..SHAPES).for_each(|k| slope[k] = values[k] * disc);
            for (i, share) in place.iter().enumerate() {
                slope[SHAPES + i] = share * f;
                slope[SHAPES + 3 + i] = *share;
            }
            for (i, a) in slope.iter().enumerate() {
                out.vector[i] += a * residual;
                for (j, b) in slope.iter().enumerate().take(i + 1) {
                    out.matrix[(i, j)] += a * b;
                }
            }
            out.squares += residual * residual;
        }
        out.matrix.fill_upper_triangle_with_lower_triangle();
        (out.pixels > 2 * N).then_some(out)
    }
}

impl Seen {
    fn add(&mut self, pixel: usize, coverage: &crate::disc::Coverage, slopes: &[[f64; 9]; 5]) {
        if self.slots[pixel] == u32::MAX {
            self.slots[pixel] = self.list.len() as u32;
            self.list.push((pixel as u32, [0.0; SHAPES + 1]));
        }
        let values = &mut self.list[self.slots[pixel] as usize].1;
        // Discs do not overlap, so that what a pixel sees of several is their sum.
        values[SHAPES] += coverage.value;
        values[9] += coverage.slope[5];
        if coverage.slope[..5].iter().any(|s| *s != 0.0) {
            for (slope, row) in coverage.slope.iter().zip(slopes) {
                (0..9).for_each(|k| values[k] += slope * row[k]);
            }
        }
    }
}

/// The inverse through the correlation matrix: parameters differ in size by 1e5.
fn inverse(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let scale = matrix.diagonal().map(|d| 1.0 / d.max(1e-300).sqrt());
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(SMatrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

fn step(equations: &Equations, damping: f64) -> Option<Params> {
    let mut damped = equations.matrix;
    (0..N).for_each(|k| damped[(k, k)] *= 1.0 + damping);
    Some(inverse(&damped)? * equations.vector)
}

fn is_possible(p: &Params) -> bool {
    (0.02..0.5).contains(&p[8]) && (0.25..50.0).contains(&p[9]) && p.iter().all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_an_ellipse_agree_with_differences() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let (at, radius) = (Vector2::new(3.0, 7.0), 0.19);
        let slopes = ellipse_slopes(&h, at, radius);
        for k in 0..9 {
            let e = [1e-4, 1e-4, 1e-3, 1e-4, 1e-4, 1e-3, 1e-7, 1e-7, 1e-5][k];
            let moved = |sign: f64| {
                let (mut g, mut r) = (h, radius);
                if k < 8 {
                    g[(k / 3, k % 3)] += sign * e
                } else {
                    r += sign * e
                }
                let ellipse = Ellipse::of_circle(&g, at, r).unwrap();
                let s = ellipse.shape;
                [ellipse.centre.x, ellipse.centre.y, s[(0, 0)], s[(0, 1)], s[(1, 1)]]
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            for (i, row) in slopes.iter().enumerate() {
                let difference = (up[i] - down[i]) / (2.0 * e);
                let error = (row[k] - difference).abs();
                let allowed = 1e-4 * (1.0 + difference.abs());
                assert!(error < allowed, "{k} {i}: {} {difference}", row[k]);
            }
        }
    }
}
