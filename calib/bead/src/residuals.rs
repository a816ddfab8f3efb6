//! What neither the ball nor the field around it explains: small in a bead, and no larger where the ball shines than around.
//!
//! With V the covariance of the voxels, D its part that is independent of all other voxels and r the residuals, the field's
//! likeliest values leave `D V^-1 r`. A voxel as the others predict it is off by `(V^-1 r)_i / (V^-1)_ii`, of variance
//! `1 / (V^-1)_ii` (Rasmussen and Williams 2006, 5.12).

use nalgebra::{DVector, Dyn, linalg::Cholesky};

use super::background_field::{Spread, VoxelShare};

/// Of the ball's greatest share: where its residual counts.
const BRIGHT_SHARE: f64 = 0.1;
/// Share of a voxel from which the ball shines in it.
const SHINES_SHARE: f64 = 0.02;
/// Share from which the ball hides what is behind it.
const COVERED_SHARE: f64 = 0.7;

pub(super) struct Leftover {
    seen: Vec<VoxelShare>,
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
    pub(super) fn of(spread: &Spread, seen: Vec<VoxelShare>, residuals: &DVector<f64>) -> Option<Self> {
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
            .filter(|(s, _)| s.share > BRIGHT_SHARE * greatest);
        root_mean(bright.map(|(_, own)| own * own))
    }

    /// The field's greatest likely value over its mean, HU, where the ball leaves at least 0.3 of a voxel to it.
    pub(super) fn brightest_hu(&self) -> f64 {
        let open = self
            .seen
            .iter()
            .zip(&self.visible_hu)
            .filter(|(s, _)| s.share < COVERED_SHARE);
        // The ball leaves the share 1 - f of the field to be seen, here at least 0.3: the division is safe.
        open.map(|(s, visible)| visible / (1.0 - s.share)).fold(0.0, f64::max)
    }

    /// How far voxels in which the ball shines are off what the others predict, in deviations, over the same of those in
    /// which it does not. Infinite where there are no such voxels. Inverts the covariance.
    pub(super) fn unevenness(&self) -> f64 {
        let inverse = self.factor.inverse();
        let squares = |shines: bool| {
            let own = (0..self.seen.len()).filter(move |i| (self.seen[*i].share > SHINES_SHARE) == shines);
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

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::tests::specimen::Random;
    use super::*;

    const SPREAD: Spread = Spread {
        smooth_hu: 100.0,
        noise_hu: 10.0,
    };

    /// A ball that shines in the middle of 7 x 7 x 7 voxels.
    fn seen() -> Vec<VoxelShare> {
        let place = |i: i32| Vector3::new(i % 7 - 3, i / 7 % 7 - 3, i / 49 - 3).map(f64::from);
        let one = |i: i32| {
            let share = (1.5 - 0.6 * place(i).norm()).clamp(0.0, 1.0);
            VoxelShare {
                place: place(i),
                share,
                signal: 2000.0 * share,
            }
        };
        (0..343).map(one).collect()
    }

    /// A draw of the field and the noise, in units of the covariance.
    fn drawn(seen: &[VoxelShare], random: &mut Random) -> DVector<f64> {
        let white: DVector<f64> = DVector::from_iterator(seen.len(), (0..seen.len()).map(|_| random.normal()));
        SPREAD.factor(seen).unwrap().l() * white
    }

    #[test]
    fn what_the_model_leaves_is_even_and_what_is_no_ball_is_not() {
        let (seen, mut random): (Vec<VoxelShare>, _) = (seen(), Random(5));
        for _ in 0..8 {
            let mut residuals = drawn(&seen, &mut random);
            let even = Leftover::of(&SPREAD, seen.clone(), &residuals).unwrap();
            // Of some 60 voxels inside and 280 outside: 1 to 10 %, of which four.
            let ratio = even.unevenness();
            assert!((0.6..1.4).contains(&ratio), "{ratio}");
            // 60 HU to and fro within the ball, six deviations of the noise, which no field follows.
            for (i, voxel) in seen.iter().enumerate().filter(|(_, s)| s.share > 0.02) {
                residuals[i] += 60.0 * (f64::from(u8::from(voxel.place.sum() as i32 % 2 == 0)) - 0.5);
            }
            let off = Leftover::of(&SPREAD, seen.clone(), &residuals).unwrap();
            assert!(off.unevenness() > 1.7 * ratio, "{} {ratio}", off.unevenness());
            assert!(off.residual_hu() > even.residual_hu());
        }
    }

    /// Leaving each out in turn and predicting it from the others is what the inverse says.
    #[test]
    fn a_voxel_is_off_what_the_others_predict_as_the_inverse_says() {
        let seen: Vec<VoxelShare> = seen().into_iter().step_by(11).collect();
        let residuals = drawn(&seen, &mut Random(9));
        let left = Leftover::of(&SPREAD, seen.clone(), &residuals).unwrap();
        let inverse = left.factor.inverse();
        for i in 0..seen.len() {
            let others: Vec<VoxelShare> = seen
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, s)| *s)
                .collect();
            let known = residuals.clone().remove_row(i);
            let factor = SPREAD.factor(&others).unwrap();
            let mixed = DVector::from_iterator(others.len(), others.iter().map(|o| SPREAD.between(&seen[i], o)));
            let predicted = mixed.dot(&factor.solve(&known));
            let variance =
                SPREAD.between(&seen[i], &seen[i]) + SPREAD.alone(&seen[i]) - mixed.dot(&factor.solve(&mixed));
            // Rounding: the covariance's condition is below 1e4.
            let off = residuals[i] - predicted;
            assert!(
                (off - left.weights[i] / inverse[(i, i)]).abs() < 1e-8 * (1.0 + off.abs()),
                "{i}"
            );
            assert!((variance * inverse[(i, i)] - 1.0).abs() < 1e-10, "{i}");
        }
    }

    #[test]
    fn the_field_is_as_bright_as_what_is_seen_of_it() {
        let seen = seen();
        let behind = |s: &VoxelShare| (1.0 - s.share) * if s.place.x > 1.0 { 900.0 } else { 0.0 };
        let residuals = DVector::from_iterator(seen.len(), seen.iter().map(behind));
        let wide = Spread {
            smooth_hu: 900.0,
            noise_hu: 1.0,
        };
        let found = Leftover::of(&wide, seen, &residuals).unwrap().brightest_hu();
        // A step is followed but for some of the noise.
        assert!((found - 900.0).abs() < 9.0, "{found}");
    }
}
