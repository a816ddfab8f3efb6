//! A pose that goes evenly with the order of the points.

use geometry::Frame;
use nalgebra::{SVector, Vector3};

use super::{Linear, Trend, beyond_chance, square};
use crate::solve::{Matrix8, Vector8};

/// A drift that residuals alone tell of is some millimetres at the points: what they hardly hold is not taken for more.
const DRIFT_MM: f64 = 2.0;
/// An F of six degrees over many is above this one time in twenty.
const BY_CHANCE: f64 = 2.19;

impl<F: Frame> Linear<'_, F> {
    /// The drift of the pose, and what it adds to the covariance.
    pub(super) fn order(&self) -> Option<(Trend, Matrix8)> {
        let cloud = &self.points.cloud;
        let total: f64 = cloud.votes.iter().sum();
        let mut before = 0.0;
        // From -0.5 to 0.5, each place counting as it does in the fit.
        let middle_of = |vote: &f64| {
            before += vote;
            (before - 0.5 * vote) / total - 0.5
        };
        let times: Vec<f64> = cloud.votes.iter().map(middle_of).collect();
        // Turns in mm at the points, so that all six have one unit.
        let r = cloud.radius_mm;
        let drift = |slope: &Vector8, time: f64| -> SVector<f64, 6> {
            let unit = SVector::<f64, 6>::from([1.0 / r, 1.0 / r, 1.0 / r, 1.0, 1.0, 1.0]);
            slope.fixed_rows::<6>(0).component_mul(&unit) * time
        };
        let rows = self.rows.rows.iter();
        let z: Vec<SVector<f64, 6>> = rows.map(|row| drift(&row.slope, times[row.point])).collect();
        let scored = self.score(&z, DRIFT_MM.powi(-2))?;
        let answer = scored.answer * scored.theta;
        let mut half = Vector8::zeros();
        half.fixed_rows_mut::<3>(0)
            .copy_from(&(scored.theta.fixed_rows::<3>(0) * (0.5 / r)));
        half.fixed_rows_mut::<3>(3)
            .copy_from(&(scored.theta.fixed_rows::<3>(3) * 0.5));
        // why: the fit is of the middle of the sweep, and the bone is now at one end of its way.
        let adds = (square(&(answer + half)) + square(&(answer - half))) * 0.5;
        let way: Vector3<f64> = scored.theta.fixed_rows::<3>(3).into();
        let trend = Trend {
            deviations: scored.deviations,
            mm: way.norm(),
            towards: way.try_normalize(0.0).unwrap_or_else(Vector3::zeros).into(),
        };
        Some((trend, adds * beyond_chance(scored.f, BY_CHANCE)))
    }
}
