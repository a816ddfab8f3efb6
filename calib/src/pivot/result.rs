//! What a pivot calibration found.

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Matrix6};

use super::{Method, PoseNoise};
use crate::coverage::Coverage;

/// Tip and pivot with all that is known of their error. Lists have one entry per pose.
#[derive(Debug, Clone)]
pub struct Pivot<To: Frame, From: Frame> {
    /// How it was found.
    pub method: Method,
    /// The tip in the marker, mm.
    pub tip: Point<From>,
    /// Where it stayed, in the tracker, mm.
    pub pivot: Point<To>,
    /// Distance of the tip's place from the pivot, `abs(R x + t - c)`, mm.
    pub residuals_mm: Vec<f64>,
    /// The weight in the solution, 0 to 1: 0 for a pose that slipped.
    pub weights: Vec<f64>,
    /// Poses of weight above zero.
    pub inliers: usize,
    /// Root mean square of the residuals of the inliers as lengths, mm: divides by their number.
    pub rms_mm: f64,
    /// The same of the three components as numbers, mm: divides by three times their number.
    pub rms_scalar_mm: f64,
    /// As `rms_mm`, of all poses.
    pub rms_all_mm: f64,
    /// The longest residual of an inlier, mm.
    pub worst_mm: f64,
    /// Covariance of (tip in the marker, pivot in the tracker), mm^2, from the ratio of the noises given and the size of
    /// the residuals found; of a biased method it does not hold the bias. `None` where the method has none: two-step and
    /// sphere, or no residual is beyond rounding.
    pub covariance: Option<Matrix6<f64>>,
    /// The residuals' size in units of the noise given, by their median: 1 where the noise given is right. `None` where the
    /// method has no weights.
    pub noise_ratio: Option<f64>,
    /// Condition number of the equations `(R_i, -I)`: relative error of the tip per relative error of the data, about the
    /// reciprocal of the opening.
    pub condition: f64,
    /// The noise that the inliers' residuals show: along the lever there is only that of the translation, across it that
    /// of the rotation too. The rotation's is 0 where it does not show.
    pub estimated: PoseNoise,
    /// The turns of the inliers.
    pub coverage: Coverage<From>,
}

impl<To: Frame, From: Frame> Pivot<To, From> {
    /// Covariance of the tip, mm^2, in the marker.
    pub fn tip_covariance(&self) -> Option<Matrix3<f64>> {
        self.covariance.map(|c| c.fixed_view::<3, 3>(0, 0).into_owned())
    }

    /// Root mean square error of the tip by the covariance, mm.
    pub fn tip_error_rms_mm(&self) -> Option<f64> {
        self.tip_covariance().map(|c| c.trace().max(0.0).sqrt())
    }
}
