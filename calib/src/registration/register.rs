//! A registration with all that is known of its error; conventions are those of [`super::statistics`].

use geometry::{Frame, Point, Vector};
use nalgebra::{Matrix3, Matrix6};

use super::pairs::{coordinates, vector};
use super::statistics::{Noise, compliance, displacement, inertia, moved_to_origin};
use super::{Fit, Method, Pairs, Refused, fit, leave_one_out};

/// A registration with all that is known of its error.
#[derive(Debug, Clone)]
pub struct Registration<To: Frame, From: Frame> {
    /// The transform, its condition and its certificate.
    pub fit: Fit<To, From>,
    /// Fiducial registration error of each pair: distance after registration, mm. Index as the pairs.
    pub fre_mm: Vec<f64>,
    /// Root of the weighted mean of their squares, mm: divides by N, or by the sum of the weights.
    pub fre_rms_mm: f64,
    /// Distance of each pair under the transform fitted to all others, mm; `None` where the others do not determine
    /// one.
    pub leave_one_out_mm: Vec<Option<f64>>,
    /// Number of pairs of weight above zero.
    pub(crate) effective: usize,
    /// Weighted mean of `x x^T`, `x = R b'` about the centre, in `To`, mm^2.
    pub(crate) inertia: Matrix3<f64>,
}

/// Registers paired points, with residuals and what the error estimates need.
///
/// # Errors
/// Those of [`fit()`].
pub fn register<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    method: Method,
) -> Result<Registration<To, From>, Refused> {
    let fit = fit(pairs, method)?;
    let points = pairs.to.iter().zip(pairs.from);
    let (inertia, effective) = inertia(&fit, pairs);
    Ok(Registration {
        fre_mm: points.map(|(a, b)| fit.residual_mm(*a, *b)).collect(),
        fre_rms_mm: fit.fre_rms_mm(pairs),
        leave_one_out_mm: leave_one_out::residuals(pairs, method)?,
        effective,
        inertia,
        fit,
    })
}

impl<To: Frame, From: Frame> Registration<To, From> {
    /// The noise that explains the residuals: `sigma^2 = N FRE_rms^2 / (3 N - 6)`, since six parameters were fitted.
    pub fn estimated_noise(&self) -> Noise {
        // `Moments::of` refuses fewer than three pairs that carry weight, so the divisor is 3 at least.
        let n = self.effective as f64;
        Noise {
            sigma_mm: self.fre_rms_mm * (n / (3.0 * n - 6.0)).sqrt(),
        }
    }

    /// Degrees of freedom of the residuals: `3 N - 6`.
    pub fn freedom(&self) -> u32 {
        u32::try_from(self.effective)
            .unwrap_or(u32::MAX / 3)
            .saturating_mul(3)
            .saturating_sub(6)
    }

    /// Covariance of the transform, 6 x 6: (rotation vector, translation) in `To`, rad and mm, where the true transform
    /// is `p -> exp(w) (R p + t) + v` with `(w, v)` of this covariance.
    ///
    /// Holds where weights are inverse to variances. `None` where the `From` cloud is a line to rounding.
    pub fn covariance(&self, noise: Noise) -> Option<Matrix6<f64>> {
        let variance = noise.sigma_mm * noise.sigma_mm / self.effective as f64;
        // About the centre the weighted mean of b' is zero: turn and shift do not correlate, and the two diagonal
        // blocks are the whole covariance. The lever of the centre brings the correlation, below.
        let mut covariance = Matrix6::identity() * variance;
        let turn = compliance(&self.inertia)? * variance;
        covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        Some(moved_to_origin(covariance, &self.fit.moments.mean(0)))
    }

    /// Root mean square target registration error predicted at `target`, mm: `TRE^2 = FLE^2 / N (1 + 1/3 sum d_k^2 /
    /// f_k^2)` (Fitzpatrick, West and Maurer 1998). Infinite where the `From` cloud is a line to rounding.
    pub fn predicted_tre_mm(&self, noise: Noise, target: Point<To>) -> f64 {
        // About the centre, where turn and shift are independent, so that their squares add up.
        let d = coordinates(target) - self.fit.moments.mean(0);
        let variance = noise.sigma_mm * noise.sigma_mm / self.effective as f64;
        compliance(&self.inertia).map_or(f64::INFINITY, |c| (variance * displacement(&c, &d)).sqrt())
    }

    /// The centre of the points in `To` relative to its origin: where the predicted error is least, `sigma sqrt(3 /
    /// N)`.
    pub fn centre(&self) -> Vector<To> {
        vector(self.fit.moments.mean(0))
    }
}
