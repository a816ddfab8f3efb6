//! The noise of poses and what it makes of a residual.

use nalgebra::{Matrix3, Vector3};

/// Noise of a pose: translation and rotation each isotropic, independent of one another.
///
/// Tip, pivot, weights and covariance depend on the ratio alone: the size is measured by the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseNoise {
    /// Standard deviation of the translation along each axis, mm.
    pub sigma_mm: f64,
    /// Standard deviation of the rotation about each axis, rad.
    pub sigma_rad: f64,
}

impl Default for PoseNoise {
    /// 0.1 mm and 0.1 degrees: an optical tracker's marker of 50 mm.
    fn default() -> Self {
        Self {
            sigma_mm: 0.1,
            sigma_rad: 0.1_f64.to_radians(),
        }
    }
}

impl PoseNoise {
    pub(crate) fn is_good(&self) -> bool {
        self.sigma_mm > 0.0 && self.sigma_mm.is_finite() && self.sigma_rad >= 0.0 && self.sigma_rad.is_finite()
    }
}

/// The covariance of a residual `r = R x + t - c` and its inverse, for a lever `y = R x` of given length.
///
/// `S = st^2 I + sr^2 (|y|^2 I - y y^T)` has the eigenvalues `st^2` along `y` and `st^2 + sr^2 |y|^2` across, so that
/// `S^-1 = a I + b y y^T`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    along: f64,
    across: f64,
    /// Inverse variance across, `a`.
    pub(super) a: f64,
    /// `b`, per mm^2.
    pub(super) b: f64,
    /// `sr^2 / across`: the most likely error of the rotation is `turn y x r`, rad per mm^2.
    pub(super) turn: f64,
    squared: f64,
}

impl Spread {
    pub(super) fn new(noise: &PoseNoise, lever: &Vector3<f64>) -> Self {
        let squared = lever.norm_squared();
        let along = noise.sigma_mm * noise.sigma_mm;
        let turn = noise.sigma_rad * noise.sigma_rad;
        let across = along + turn * squared;
        // (1 / along - 1 / across) / |y|^2, without the cancellation.
        Self {
            along,
            across,
            a: 1.0 / across,
            b: turn / (along * across),
            turn: turn / across,
            squared,
        }
    }

    /// `S` for the lever `y`.
    pub(super) fn covariance(&self, y: &Vector3<f64>) -> Matrix3<f64> {
        if self.squared == 0.0 {
            return Matrix3::identity() * self.along;
        }
        // The lever's length is that of the tip in every pose, so that it is computed once.
        let part = (self.along - self.across) / self.squared;
        Matrix3::identity() * self.across + y * y.transpose() * part
    }

    /// `r^T S^-1 r`.
    pub(super) fn square(&self, y: &Vector3<f64>, r: &Vector3<f64>) -> f64 {
        let along = y.dot(r);
        self.a * r.norm_squared() + self.b * along * along
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        for (sigma_rad, lever) in [(0.0, 160.0), (1e-3, 0.0), (1e-3, 160.0), (0.1, 1e4)] {
            let noise = PoseNoise {
                sigma_mm: 0.1,
                sigma_rad,
            };
            let y = Vector3::new(0.6, 0.0, 0.8) * lever;
            let spread = Spread::new(&noise, &y);
            let inverse = Matrix3::identity() * spread.a + y * y.transpose() * spread.b;
            let cross = y.cross_matrix();
            let direct = Matrix3::identity() * 0.01 + cross * cross.transpose() * (sigma_rad * sigma_rad);
            // Products of entries whose ratio is the condition, some roundings each.
            let condition = 1.0 + (sigma_rad * lever / 0.1).powi(2);
            let bound = 16.0 * f64::EPSILON * condition;
            assert!((inverse * direct - Matrix3::identity()).norm() < bound, "{noise:?}");
            assert!((spread.covariance(&y) - direct).norm() < bound * direct.norm());
        }
    }
}
