//! A grid behind a lens: homography, what the lens moves, radius and blur, with their derivatives.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2};

use crate::disc::Ellipse;
use crate::grid::fit::disc_in_lens::outline;
use crate::grid::fit::disc_jacobian::{ellipse_slopes, point};
use crate::grid::fit::lens_polynomial::{FIELDS, NUMBERS as LENS, RADIAL, Warp};
use crate::grid::fit::normal_equations::LEAST_BLUR;
use crate::grid::homography::{jacobian, project};
use crate::grid::lattice::Cell;
use crate::image::Image;

/// Homography 8, lens, radius, blur.
pub(crate) const NUMBERS: usize = 8 + LENS + 2;
const RADIUS: usize = 8 + LENS;
pub(crate) const BLUR: usize = RADIUS + 1;
pub(crate) type Numbers = SVector<f64, NUMBERS>;
pub(crate) type Square = SMatrix<f64, NUMBERS, NUMBERS>;
/// Derivatives of an outline (centre 2, shape 3) and the blur.
pub(crate) type Slopes = SMatrix<f64, 6, NUMBERS>;
/// Derivatives of the image of a disc's centre.
pub(crate) type Tangent = SMatrix<f64, 2, NUMBERS>;

pub(crate) const MAX_STEPS: usize = 25;
/// What a lens's coefficients are expected to be at the most, at the image's corner: beyond what any lens does that shows a
/// picture, and so a hold only where the discs say nothing.
const LARGE_RADIAL: f64 = 0.5;
const LARGE_TANGENTIAL: f64 = 0.1;
const LARGE_MIDDLE: f64 = 0.4;
/// And where there are fewer discs than this, what is not radial or is of a high degree.
const FEW_DISCS: usize = 20;
const FEW_DISCS_FIELD: f64 = 1e-3;
/// The least share by which the lens may squeeze a place of the grid.
const LEAST_SLOPE: f64 = 0.05;

/// A grid behind a lens.
#[derive(Debug, Clone)]
pub(crate) struct LensModel {
    pub(crate) numbers: Numbers,
    warp: Warp,
}

impl LensModel {
    /// Of a homography, in an image of a size, without a lens.
    pub(crate) fn plane(h: &Matrix3<f64>, radius: f64, sigma: f64, image: &Image) -> Self {
        let size = Vector2::new(image.width() as f64, image.height() as f64);
        // Pixels have their centres at whole coordinates; with half the diagonal as the unit the corners lie at r = 1.
        let origin = size.add_scalar(-1.0) * 0.5;
        let mut numbers = Numbers::zeros();
        (0..8).for_each(|k| numbers[k] = h[(k / 3, k % 3)] / h[(2, 2)]);
        (numbers[RADIUS], numbers[BLUR]) = (radius, sigma);
        Self {
            numbers,
            warp: Warp::none(origin, 0.5 * size.norm()),
        }
    }

    fn with(&self, numbers: Numbers) -> Self {
        let coefficients = std::array::from_fn(|k| numbers[8 + k]);
        Self {
            numbers,
            warp: self.warp.lens(&coefficients),
        }
    }

    /// A step, by which the grid's middle is moved and turned as the derivatives say: what a step of the lens does to these in the
    /// second order, the homography takes back. Otherwise the squares were a bent valley along the lens's middle.
    pub(crate) fn moved(&self, change: &Numbers, cells: &[Cell]) -> Option<Self> {
        let plain = self.with(self.numbers + change);
        let middle = cells.iter().map(|c| point(*c)).sum::<Vector2<f64>>() / cells.len().max(1) as f64;
        let at = project(&self.h(), middle);
        let (mut value, mut slope) = (self.warp.at(at), self.warp.jet(at).slope);
        for (k, (by_value, by_slope)) in self.warp.by_numbers(at).iter().enumerate() {
            value += by_value * change[8 + k];
            slope += by_slope * change[8 + k];
        }
        // The affine map A for which the new lens after A has, at the middle, the value and the slope that the step
        // promised: A(at) = at + back (value - then.value), of slope back * slope.
        let then = plain.warp.jet(at);
        let back = then.slope.try_inverse()?;
        let linear = back * slope;
        let shift = at + back * (value - then.value) - linear * at;
        let mut affine = Matrix3::identity();
        affine.fixed_view_mut::<2, 2>(0, 0).copy_from(&linear);
        affine.fixed_view_mut::<2, 1>(0, 2).copy_from(&shift);
        let h = affine * plain.h();
        let mut numbers = plain.numbers;
        (0..8).for_each(|k| numbers[k] = h[(k / 3, k % 3)] / h[(2, 2)]);
        Some(Self { numbers, ..plain })
    }

    pub(crate) fn h(&self) -> Matrix3<f64> {
        let p = &self.numbers;
        Matrix3::new(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], 1.0)
    }

    pub(crate) fn radius(&self) -> f64 {
        self.numbers[RADIUS]
    }

    pub(crate) fn sigma(&self) -> f64 {
        self.numbers[BLUR]
    }

    /// What the lens does.
    pub(crate) fn warp(&self) -> &Warp {
        &self.warp
    }

    /// The image of a cell's centre.
    pub(crate) fn at(&self, cell: Cell) -> Vector2<f64> {
        self.warp.at(project(&self.h(), point(cell)))
    }

    /// Pixels for a step of the grid.
    pub(crate) fn pitch(&self, cell: Cell) -> Matrix2<f64> {
        let h = self.h();
        self.warp.jet(project(&h, point(cell))).slope * jacobian(&h, point(cell))
    }

    /// The image of a disc.
    pub(crate) fn outline(&self, cell: Cell) -> Option<Ellipse> {
        outline(&self.h(), &self.warp, cell, self.radius())
    }

    /// The derivatives of that and of the blur.
    ///
    /// What the lens's second derivatives move the centre by is taken as it is: a few hundredths of a pixel, of which a step
    /// changes a small part.
    pub(crate) fn slopes(&self, cell: Cell) -> Option<Slopes> {
        let h = self.h();
        let plain = Ellipse::of_circle(&h, point(cell), self.radius())?;
        let jet = self.warp.jet(plain.centre);
        let mut out = Slopes::zeros();
        let mut set = |column: usize, centre: Vector2<f64>, shape: Matrix2<f64>| {
            let all = [centre.x, centre.y, shape[(0, 0)], shape[(0, 1)], shape[(1, 1)]];
            all.iter().enumerate().for_each(|(i, v)| out[(i, column)] = *v);
        };
        // The derivative of J S J^T by the lens's slope J.
        let turned = |slope: &Matrix2<f64>| {
            let part = slope * plain.shape * jet.slope.transpose();
            part + part.transpose()
        };
        let by = ellipse_slopes(&h, point(cell), self.radius());
        let [x, y, xx, xy, yy] = by;
        // By the homography and the radius: the pinhole's derivatives, carried through the lens.
        for (k, (x, y)) in x.into_iter().zip(y).enumerate() {
            let centre = Vector2::new(x, y);
            let shape = Matrix2::new(xx[k], xy[k], xy[k], yy[k]);
            // A centre that moves sees another slope of the lens: its second derivatives along the way turn the shape,
            // too.
            let shape = jet.slope * shape * jet.slope.transpose() + turned(&jet.bent(centre));
            // The ninth of the pinhole's derivatives is that by the radius, which has its place behind the lens.
            set(if k < 8 { k } else { RADIUS }, jet.slope * centre, shape);
        }
        // By the lens's own numbers, at the place where a pinhole would show the disc.
        for (k, (value, slope)) in self.warp.by_numbers(plain.centre).iter().enumerate() {
            set(8 + k, *value, turned(slope));
        }
        out[(5, BLUR)] = 1.0;
        Some(out)
    }

    /// The derivatives of the image of a cell's centre.
    pub(crate) fn tangent(&self, cell: Cell) -> Tangent {
        let (h, p) = (self.h(), point(cell));
        let at = project(&h, p);
        let plane = plane_tangent(&h, cell);
        let jet = self.warp.jet(at);
        let mut out = Tangent::zeros();
        out.fixed_view_mut::<2, 8>(0, 0).copy_from(&(jet.slope * plane));
        for (k, (value, _)) in self.warp.by_numbers(at).iter().enumerate() {
            out.set_column(8 + k, value);
        }
        out
    }

    /// Whether all discs stand where the lens keeps one side of the paper in front.
    pub(crate) fn is_possible(&self, cells: &[Cell]) -> bool {
        let h = self.h();
        let squeezed = |cell: &Cell| {
            let at = project(&h, point(*cell));
            let slope = self.warp.jet(at).slope;
            // Where the symmetric part is positive, (q - p).(F(q) - F(p)) > 0 on any straight way from p to q: nothing
            // is folded.
            let least = slope.symmetric_part().symmetric_eigenvalues().min();
            // Negated as a whole, so that a NaN (a cell on the horizon) counts as squeezed.
            !(at.amax() < 1e6 && least > LEAST_SLOPE)
        };
        let [radius, sigma] = [self.radius(), self.sigma()];
        (0.02..0.5).contains(&radius)
            && (LEAST_BLUR..50.0).contains(&sigma)
            && self.numbers.iter().all(|v| v.is_finite())
            && !cells.iter().any(squeezed)
    }
}

/// The derivatives of the image of a cell under a homography by its first eight entries, row by row.
pub(crate) fn plane_tangent(h: &Matrix3<f64>, cell: Cell) -> SMatrix<f64, 2, 8> {
    let (at, p) = (project(h, point(cell)), point(cell));
    // Row i of the homography moves coordinate i by p / w, the last row, which divides, by -at p / w.
    let w = h[(2, 0)] * p.x + h[(2, 1)] * p.y + h[(2, 2)];
    let mut slope = SMatrix::<f64, 2, 8>::zeros();
    for i in 0..2 {
        for (k, v) in [p.x, p.y, 1.0].iter().enumerate() {
            slope[(i, 3 * i + k)] = v / w;
        }
        (slope[(i, 6)], slope[(i, 7)]) = (-at[i] * p.x / w, -at[i] * p.y / w);
    }
    slope
}

/// One over the squares of what a lens's numbers are expected to be.
pub(crate) fn prior(discs: usize) -> Numbers {
    let mut out = Numbers::zeros();
    for k in 0..LENS {
        // The first radial term is nearly all of an ordinary lens: it alone is free with few discs.
        let free = discs >= FEW_DISCS || k == 0;
        out[8 + k] = match k {
            _ if !free => FEW_DISCS_FIELD,
            FIELDS.. => LARGE_MIDDLE,
            RADIAL.. => LARGE_TANGENTIAL,
            _ => LARGE_RADIAL,
        }
        .powi(-2);
    }
    out
}

/// A step of least squares held back by a share of the diagonal, and what it is to gain.
pub(crate) fn step(matrix: &Square, vector: &Numbers, damping: f64, blur_held: bool) -> Option<(Numbers, f64)> {
    // As in the plane's normal equations: damping by the diagonal, and the fall of the squares of the damped step.
    let held = matrix.diagonal() * damping;
    let (mut damped, mut vector) = (matrix + Square::from_diagonal(&held), *vector);
    if blur_held {
        damped.row_mut(BLUR).fill(0.0);
        damped.column_mut(BLUR).fill(0.0);
        (damped[(BLUR, BLUR)], vector[BLUR]) = (1.0, 0.0);
    }
    let step = inverse(&damped)? * vector;
    Some((step, step.dot(&(vector + held.component_mul(&step)))))
}

/// Through the correlation matrix: numbers differ in size by 1e7.
pub(crate) fn inverse(matrix: &Square) -> Option<Square> {
    let scale = matrix.diagonal().map(|d| 1.0 / d.max(1e-300).sqrt());
    let scaled = Square::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(Square::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// Centres that are known to about a tenth of a pixel: a homography and a lens through them.
pub(crate) fn through_points(start: &LensModel, points: &[(Cell, Vector2<f64>)]) -> Option<LensModel> {
    let cells: Vec<Cell> = points.iter().map(|p| p.0).collect();
    let (mut bent, prior) = (start.clone(), prior(points.len()));
    let cost = |b: &LensModel| -> f64 {
        // Squares of pixels beside the prior as it is, which so counts as if centres were known to one pixel.
        let off = points.iter().map(|(c, at)| (at - b.at(*c)).norm_squared()).sum::<f64>();
        off + b.numbers.component_mul(&b.numbers).dot(&prior)
    };
    let (mut now, mut damping) = (cost(&bent), 1e-3);
    for _ in 0..MAX_STEPS {
        let mut matrix = Square::from_diagonal(&prior);
        let mut vector = -prior.component_mul(&bent.numbers);
        for (cell, at) in points {
            let tangent = bent.tangent(*cell);
            matrix += tangent.transpose() * tangent;
            vector += tangent.transpose() * (at - bent.at(*cell));
        }
        // Neither radius nor blur is in the centres.
        // With anything but 0 there the matrix is regular, and both steps vanish as their vector does.
        (matrix[(RADIUS, RADIUS)], matrix[(BLUR, BLUR)]) = (1.0, 1.0);
        let next = step(&matrix, &vector, damping, false).and_then(|(s, _)| bent.moved(&s, &cells));
        let next = next.filter(|b| b.is_possible(&cells));
        let then = next.as_ref().map(&cost);
        match (next, then) {
            (Some(next), Some(then)) if then <= now => {
                // What follows is a fit to the pixels: a start that is a thousandth better saves none of its steps.
                let gained = 1.0 - then / now;
                (bent, now, damping) = (next, then, (0.1_f64 * damping).max(1e-9));
                if gained < 1e-3 {
                    break;
                }
            }
            _ => damping *= 10.0,
        }
        if damping > 1e5 {
            break;
        }
    }
    Some(bent)
}
