//! What neither the ball nor the field around it explains: small in a bead, and no larger where the ball shines than around.
//!
//! With V the covariance of the voxels, D its part that is independent of all other voxels and r the residuals, the field's
//! likeliest values leave `D V^-1 r`. A voxel as the others predict it is off by `(V^-1 r)_i / (V^-1)_ii`, of variance
//! `1 / (V^-1)_ii` (Rasmussen and Williams 2006, 5.12).

use nalgebra::{DVector, Dyn, linalg::Cholesky};

use super::ground::{Seen, Spread};

/// Of the ball's greatest share: where its residual counts.
const BRIGHT: f64 = 0.1;
/// Share of a voxel from which the ball shines in it.
const SHINES: f64 = 0.02;
/// Share from which the ball hides what is behind it.
const COVERED: f64 = 0.7;

pub(super) struct Leftover {
    seen: Vec<Seen>,
    factor: Cholesky<f64, Dyn>,
    /// `V^-1 r`, 1/HU.
    weights: DVector<f64>,
    /// `D V^-1 r`, HU.
    own_hu: Vec<f64>,
    /// The field as far as the ball lets it be seen, HU.
    visible_hu: Vec<f64>,
}

impl Leftover {
    /// `None` where the covariance has no factor.
    pub(super) fn of(spread: &Spread, seen: Vec<Seen>, residuals: &DVector<f64>) -> Option<Self> {
        let factor = spread.factor(&seen)?;
        let weights = factor.solve(residuals);
        let own_hu: Vec<f64> = seen
            .iter()
            .zip(weights.iter())
            .map(|(s, w)| spread.alone(s) * w)
            .collect();
        let visible_hu = residuals.iter().zip(&own_hu).map(|(r, own)| r - own).collect();
        Some(Self {
            seen,
            factor,
            weights,
            own_hu,
            visible_hu,
        })
    }

    /// Its root mean square where the ball's signal is above a tenth of its greatest, HU.
    pub(super) fn residual_hu(&self) -> f64 {
        let greatest = self.seen.iter().map(|s| s.share).fold(0.0, f64::max);
        let bright = self
            .seen
            .iter()
            .zip(&self.own_hu)
            .filter(|(s, _)| s.share > BRIGHT * greatest);
        root_mean(bright.map(|(_, own)| own * own))
    }

    /// The field's greatest likely value over its mean, HU, where the ball leaves at least 0.3 of a voxel to it.
    pub(super) fn brightest_hu(&self) -> f64 {
        let open = self
            .seen
            .iter()
            .zip(&self.visible_hu)
            .filter(|(s, _)| s.share < COVERED);
        open.map(|(s, visible)| visible / (1.0 - s.share)).fold(0.0, f64::max)
    }

    /// How far voxels in which the ball shines are off what the others predict, in deviations, over the same of those in
    /// which it does not. Infinite where there are no such voxels. Inverts the covariance.
    pub(super) fn unevenness(&self) -> f64 {
        let inverse = self.factor.inverse();
        let squares = |shines: bool| {
            let own = (0..self.seen.len()).filter(move |i| (self.seen[*i].share > SHINES) == shines);
            let inverse = &inverse;
            root_mean(own.map(move |i| self.weights[i] * self.weights[i] / inverse[(i, i)]))
        };
        let ratio = squares(true) / squares(false);
        if ratio.is_finite() { ratio } else { f64::INFINITY }
    }
}

/// 0 of nothing.
fn root_mean(squares: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
