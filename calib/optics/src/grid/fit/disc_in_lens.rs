//! The image of a disc through a lens, as the ellipse that a fit to its pixels finds.
//!
//! A lens makes an egg of an ellipse. Where the blur is small beside the disc, pixels tell how far the rim is off along its
//! normal, each part of it by its length: a fit finds the ellipse of the least squares along the rim. That of moments is another
//! where discs are seen at a slant. With `n` the normal, `S` the shape and `h = sqrt(n^T S n)`, a step of the centre and of the shape
//! moves the rim along its normal by
//!
//! ```text
//! n . dc + n^T dS n / 2 h                                                                                       (1)
//! ```

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2};

use crate::disc::Ellipse;
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::lens_polynomial::{Jet, Warp};
use crate::grid::lattice::Cell;

/// Points on a rim.
// A field of the seventh degree leaves harmonics up to the tenth in the sums over a round rim, which more than ten
// equidistant points add up exactly.
const RIM_POINTS: usize = 16;

/// The image of a cell's disc: a circle of a radius in steps of the grid, through a homography and a lens.
pub(crate) fn outline(h: &Matrix3<f64>, warp: &Warp, cell: Cell, radius: f64) -> Option<Ellipse> {
    let plain = Ellipse::of_circle(h, point(cell), radius)?;
    through(warp, &warp.jet(plain.centre), &plain)
}

/// An ellipse through a lens whose jet at its centre is given.
pub(crate) fn through(warp: &Warp, jet: &Jet, plain: &Ellipse) -> Option<Ellipse> {
    // The unit circle through the root is the ellipse, and through the slope besides the image of it to the first
    // order.
    let root = plain.shape.cholesky()?.l();
    let affine = jet.slope * root;
    let shape = affine * affine.transpose();
    let (mut matrix, mut vector) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
    for k in 0..RIM_POINTS {
        let (s, c) = (k as f64 * std::f64::consts::TAU / RIM_POINTS as f64).sin_cos();
        let round = Vector2::new(c, s);
        // Only what the derivative leaves is fitted: small, so that the linear equation (1) holds.
        let off = warp.at(plain.centre + root * round) - jet.value - affine * round;
        // Even steps of the parameter are uneven ones along the rim: each point counts by the length of its part.
        let along = (affine * Vector2::new(-s, c)).norm();
        // A circle's normal goes through a map as its inverse transpose.
        let n = (affine.transpose().try_inverse()? * round).try_normalize(0.0)?;
        let twice = 2.0 * (n.transpose() * shape * n)[0].sqrt();
        let row = SVector::from([n.x, n.y, n.x * n.x / twice, 2.0 * n.x * n.y / twice, n.y * n.y / twice]);
        matrix += row * row.transpose() * along;
        vector += row * (along * n.dot(&off));
    }
    let step = matrix.cholesky()?.solve(&vector);
    let shape = shape + Matrix2::new(step[2], step[3], step[3], step[4]);
    // Both eigenvalues are positive; a NaN fails, too.
    (shape.determinant() > 0.0 && shape.trace() > 0.0).then(|| Ellipse {
        centre: jet.value + Vector2::new(step[0], step[1]),
        shape,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lens() -> Warp {
        Warp::none(Vector2::new(250.0, 260.0), 300.0).lens(&[-0.2, 0.07, 0.03, 0.02, -0.01, 0.03, 0.01])
    }

    #[test]
    fn without_a_lens_an_ellipse_is_itself() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let plain = Ellipse::of_circle(&h, point([3, 7]), 0.2).unwrap();
        let seen = outline(&h, &Warp::none(Vector2::zeros(), 300.0), [3, 7], 0.2).unwrap();
        // Rounding of places of some hundreds.
        assert!((seen.centre - plain.centre).norm() < 1e-11 && (seen.shape - plain.shape).norm() < 1e-10);
    }

    /// No step of the centre or the shape brings the ellipse nearer to the egg's rim, by points and lengths of its own.
    #[test]
    fn no_other_ellipse_is_nearer_to_the_rim() {
        let warp = lens();
        let plain = Ellipse {
            centre: Vector2::new(120.0, 400.0),
            shape: Matrix2::new(260.0, 60.0, 60.0, 40.0),
        };
        let seen = through(&warp, &warp.jet(plain.centre), &plain).unwrap();
        let (root, n) = (plain.shape.cholesky().unwrap().l(), 720);
        let rim: Vec<Vector2<f64>> = (0..n)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / f64::from(n)).sin_cos();
                warp.at(plain.centre + root * Vector2::new(c, s))
            })
            .collect();
        // To the first order a point is off by (1 - sqrt(x^T S^-1 x)) / |gradient of it|.
        let squares = |e: &Ellipse| -> f64 {
            let back = e.shape.try_inverse().unwrap();
            let one = |k: usize| {
                let (x, next) = (rim[k] - e.centre, rim[(k + 1) % rim.len()] - rim[k]);
                let f = (x.transpose() * back * x)[0].sqrt();
                ((f - 1.0) * f / (back * x).norm()).powi(2) * next.norm()
            };
            (0..rim.len()).map(one).sum()
        };
        let least = squares(&seen);
        for k in 0..5 {
            let moved = |by: f64| {
                let mut e = seen;
                match k {
                    0 | 1 => e.centre[k] += by,
                    2 => e.shape[(0, 0)] += by,
                    3 => e.shape += Matrix2::new(0.0, by, by, 0.0),
                    _ => e.shape[(1, 1)] += by,
                }
                squares(&e)
            };
            let step = if k < 2 { 1e-3 } else { 2e-2 };
            assert!(
                moved(step) > least && moved(-step) > least,
                "{k}: {least} {} {}",
                moved(step),
                moved(-step)
            );
        }
        assert!((seen.centre - warp.at(plain.centre)).norm() > 0.02);
    }
}
