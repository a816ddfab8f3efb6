//! What a law answers, and the derivatives of the determinant that most of them share.
//!
//! Second-order tensors are vectors of 4, column by column: `(11, 21, 12, 22)`.

use nalgebra::{Matrix2, Matrix4, Vector4};

/// Density, stress and tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// `w`, energy by reference area (units of stress).
    pub density: f64,
    /// First Piola-Kirchhoff stress `P = dw/dF`.
    pub stress: Vector4<f64>,
    /// `dP/dF`, symmetric.
    pub tangent: Matrix4<f64>,
}

/// A measure of the change of volume, zero at rest, with first derivative `tr dG` there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// Its value, dimensionless.
    pub theta: f64,
    /// `d theta / dF`.
    pub gradient: Vector4<f64>,
    /// The second derivative.
    pub hessian: Matrix4<f64>,
}

impl Response {
    /// `self + (lambda / 2) theta^2`.
    pub(crate) fn with_volume(&self, lambda: f64, volume: &Volume) -> Self {
        let p = lambda * volume.theta;
        let outer = volume.gradient * volume.gradient.transpose();
        Self {
            density: self.density + 0.5 * p * volume.theta,
            stress: self.stress + volume.gradient * p,
            tangent: self.tangent + outer * lambda + volume.hessian * p,
        }
    }
}

/// The four entries, column by column.
#[inline]
pub(crate) fn vector(m: &Matrix2<f64>) -> Vector4<f64> {
    Vector4::new(m[(0, 0)], m[(1, 0)], m[(0, 1)], m[(1, 1)])
}

/// The cofactors of a 2 x 2 matrix: linear in it.
#[inline]
pub(crate) fn cofactor(m: &Vector4<f64>) -> Vector4<f64> {
    Vector4::new(m[3], -m[2], -m[1], m[0])
}

/// The matrix of [`cofactor`], the second derivative of the determinant.
pub(crate) const COFACTOR: Matrix4<f64> = Matrix4::new(
    0.0, 0.0, 0.0, 1.0, //
    0.0, 0.0, -1.0, 0.0, //
    0.0, -1.0, 0.0, 0.0, //
    1.0, 0.0, 0.0, 0.0,
);

/// The identity as a vector.
pub(crate) const IDENTITY: Vector4<f64> = Vector4::new(1.0, 0.0, 0.0, 1.0);

/// `J - 1 = tr G + det G`, without the cancellation of `det(I + G) - 1`.
#[inline]
pub(crate) fn excess(g: &Vector4<f64>) -> f64 {
    g[0] + g[3] + (g[0] * g[3] - g[1] * g[2])
}

/// A function of `J` as a function of `F`, from its value and derivatives.
pub(crate) fn of_determinant(g: &Vector4<f64>, value: f64, first: f64, second: f64) -> Response {
    let cofactor = IDENTITY + cofactor(g);
    Response {
        density: value,
        stress: cofactor * first,
        tangent: COFACTOR * first + cofactor * cofactor.transpose() * second,
    }
}
