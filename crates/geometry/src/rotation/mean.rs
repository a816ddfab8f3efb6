//! Means of rotations.

use nalgebra::{Matrix4, Vector4};

use super::error::finite;
use super::{Rotation, RotationError, RotationVector};

/// The rotation whose matrix is nearest to the weighted mean matrix (Frobenius): the eigenvector of the sum of w q qT
/// (Markley 2007). Weights need not add up to 1.
///
/// Domain: any rotations with a single nearest one. Error: about 20 eps divided by the gap between the two largest
/// eigenvalues, as a share of the largest; 20 eps for rotations that lie together.
///
/// # Errors
/// [`RotationError::Count`], [`RotationError::Weight`], [`RotationError::Nan`], [`RotationError::Infinite`];
/// [`RotationError::NoMean`] where the gap is below 1e-12 of the largest eigenvalue.
pub fn chordal_mean(rotations: &[Rotation], weights: &[f64]) -> Result<Rotation, RotationError> {
    let most = check(rotations, weights)?;
    let sum = rotations
        .iter()
        .zip(weights)
        .fold(Matrix4::zeros(), |sum: Matrix4<f64>, (r, w)| {
            let q = Vector4::from(r.quaternion());
            // Divided by the largest, so that weights of any scale add up.
            sum + q * q.transpose() * (w / most)
        });
    let eigen = sum.symmetric_eigen();
    let best = eigen.eigenvalues.imax();
    let second = (0..4)
        .filter(|&i| i != best)
        .map(|i| eigen.eigenvalues[i])
        .fold(0.0, f64::max);
    // Two eigenvalues alike leave a whole circle of means, and rounding would choose one.
    if eigen.eigenvalues[best] - second < 1e-12 * eigen.eigenvalues[best] {
        return Err(RotationError::NoMean);
    }
    Rotation::normalised(eigen.eigenvectors.column(best).into_owned().into()).ok_or(RotationError::NoMean)
}

/// The rotation that minimises the weighted sum of squared angles: the Riemannian centre of mass, by Newton-like steps
/// in the tangent space from the chordal mean.
///
/// Domain: rotations within pi/2 of one another, where it is unique; wider sets that converge give a local minimum.
/// Error: 8 ulp of 1 (the steps stop below 4 ulp).
///
/// # Errors
/// Those of [`chordal_mean`]; [`RotationError::NoMean`] also where 100 steps do not settle.
pub fn geodesic_mean(rotations: &[Rotation], weights: &[f64]) -> Result<Rotation, RotationError> {
    let mut mean = chordal_mean(rotations, weights)?;
    // Over the largest first: weights near the largest number would overflow their sum.
    let most = weights.iter().copied().fold(0.0, f64::max);
    let total: f64 = weights.iter().map(|w| w / most).sum();
    for _ in 0..100 {
        let back = mean.inverse();
        // The gradient of the sum of squared angles is minus twice the sum of the logarithms seen from the mean.
        let step = rotations.iter().zip(weights).fold([0.0; 3], |sum: [f64; 3], (r, w)| {
            let v = (back * *r).vector().radians();
            [0, 1, 2].map(|i| sum[i] + w / most / total * v[i])
        });
        let step = RotationVector::new(step)?;
        mean = mean * Rotation::from_vector(step);
        if step.angle() < 4.0 * f64::EPSILON {
            return Ok(mean);
        }
    }
    Err(RotationError::NoMean)
}

/// Checks counts and weights, and returns the largest weight.
fn check(rotations: &[Rotation], weights: &[f64]) -> Result<f64, RotationError> {
    if rotations.is_empty() || rotations.len() != weights.len() {
        return Err(RotationError::Count {
            rotations: rotations.len(),
            weights: weights.len(),
        });
    }
    finite("weights", weights)?;
    if let Some(index) = weights.iter().position(|&w| w < 0.0) {
        return Err(RotationError::Weight { index });
    }
    let most = weights.iter().copied().fold(0.0, f64::max);
    if most == 0.0 {
        Err(RotationError::Weight { index: 0 })
    } else {
        Ok(most)
    }
}
