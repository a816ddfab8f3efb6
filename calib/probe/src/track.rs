//! Poses over time: between those that were recorded, or the mean of neighbours.

use geometry::motion::Motion;
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Frame, Rigid, Vector};
use nalgebra::{Matrix2, Matrix2x6, Vector2, Vector3, Vector6};

/// A time beyond the ends by this is still given the pose of the end, s: clocks of image and pose differ by some ms.
const BEYOND_S: f64 = 0.5;
/// Neighbours within so many windows take part: what is further counts less than 2e-4.
const REACH: f64 = 4.0;

/// Poses of a marker in the order of their times.
#[derive(Debug, Clone)]
pub struct Track<To: Frame, From: Frame> {
    times: Vec<f64>,
    poses: Vec<Rigid<To, From>>,
    window_s: f64,
}

/// Why poses are no track.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// Fewer than two.
    #[error("{found} poses; at least 2 are needed")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// A time that is not after the one before.
    #[error("pose {index}: its time {t_s} s is not after the {before_s} s of the one before")]
    Order {
        /// Which, from 0.
        index: usize,
        /// Its time.
        t_s: f64,
        /// The one before.
        before_s: f64,
    },
    /// The window is not 0 to 1 s.
    #[error("the window is {found} s; 0 to 1 s are allowed")]
    Window {
        /// What was given.
        found: f64,
    },
}

impl<To: Frame, From: Frame> Track<To, From> {
    /// A track of poses and their times, s. With a window above 0 each pose is that of a straight motion fitted to
    /// its neighbours, which
    /// count by a normal curve of that deviation, s: noise that differs from pose to pose falls, and turns sharper
    /// than the window are
    /// cut.
    ///
    /// # Errors
    /// Each variant of [`TrackError`].
    pub fn new(timed: &[(f64, Rigid<To, From>)], window_s: f64) -> Result<Self, TrackError> {
        if timed.len() < 2 {
            return Err(TrackError::TooFew { found: timed.len() });
        }
        if !(0.0..=1.0).contains(&window_s) {
            return Err(TrackError::Window { found: window_s });
        }
        for (i, pair) in timed.windows(2).enumerate() {
            let (before_s, t_s) = (pair[0].0, pair[1].0);
            if t_s.is_nan() || before_s.is_nan() || t_s <= before_s {
                return Err(TrackError::Order {
                    index: i + 1,
                    t_s,
                    before_s,
                });
            }
        }
        Ok(Self {
            times: timed.iter().map(|(t, _)| *t).collect(),
            poses: timed.iter().map(|(_, pose)| *pose).collect(),
            window_s,
        })
    }

    /// Whether each pose is a mean of neighbours that reaches over the time between two of them.
    pub fn is_mean(&self) -> bool {
        let gaps = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        self.window_s > 0.0 && self.window_s >= fit::median(gaps)
    }

    /// First and last time, s.
    pub fn span_s(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// The pose at a time, s; `None` where it lies more than half a second beyond the ends, or in a gap so wide that
    /// no window reaches
    /// over it.
    pub fn at(&self, t_s: f64) -> Option<Rigid<To, From>> {
        let (first, last) = self.span_s();
        if !(first - BEYOND_S..=last + BEYOND_S).contains(&t_s) {
            return None;
        }
        let after = self.times.partition_point(|t| *t < t_s);
        let nearest = self.nearest(t_s, after);
        // Too few neighbours for a straight motion: what was recorded is all there is.
        self.mean(t_s, nearest).or_else(|| self.between(t_s, after))
    }

    fn nearest(&self, t_s: f64, after: usize) -> usize {
        let after = after.min(self.times.len() - 1);
        let before = after.saturating_sub(1);
        let away = |i: usize| (self.times[i] - t_s).abs();
        if away(before) < away(after) { before } else { after }
    }

    /// The pose on the straight motion between its two neighbours, or beyond the ends on that of the last two.
    fn between(&self, t_s: f64, after: usize) -> Option<Rigid<To, From>> {
        let i = after.clamp(1, self.times.len() - 1);
        let share = (t_s - self.times[i - 1]) / (self.times[i] - self.times[i - 1]);
        let to = away(&self.poses[i - 1], &self.poses[i]);
        moved(&self.poses[i - 1], &(to * share))
    }

    /// The straight motion that fits the neighbours best, at `t_s`.
    fn mean(&self, t_s: f64, nearest: usize) -> Option<Rigid<To, From>> {
        if self.window_s == 0.0 {
            return None;
        }
        let reach = REACH * self.window_s;
        let low = self.times.partition_point(|t| *t < t_s - reach);
        let high = self.times.partition_point(|t| *t <= t_s + reach);
        if high < low + 3 {
            return None;
        }
        let origin = self.poses.get(nearest)?;
        // A straight line in time, weighted: value at t_s and slope (local linear regression).
        let (mut normal, mut right) = (Matrix2::<f64>::zeros(), Matrix2x6::<f64>::zeros());
        for i in low..high {
            let d = (self.times[i] - t_s) / self.window_s;
            let weight = (-0.5 * d * d).exp();
            let basis = Vector2::new(1.0, d);
            normal += basis * basis.transpose() * weight;
            right += basis * away(origin, &self.poses[i]).transpose() * weight;
        }
        // Neighbours at nearly one time give no slope, and none is needed from them.
        let solved = normal
            .cholesky()
            .filter(|_| normal.determinant() > 1e-9 * normal[(0, 0)].powi(2))?;
        let line = solved.solve(&right);
        moved(origin, &line.row(0).transpose())
    }
}

/// Turn and shift from one pose to another, each in place: the turn about the origin of `From`, which the shift moves.
fn away<To, From>(a: &Rigid<To, From>, b: &Rigid<To, From>) -> Vector6<f64> {
    let turn = (b.rotation() * a.rotation().inverse()).vector().radians();
    let shift = Vector3::from(b.translation_mm()) - Vector3::from(a.translation_mm());
    Vector6::new(turn[0], turn[1], turn[2], shift.x, shift.y, shift.z)
}

fn moved<To, From>(a: &Rigid<To, From>, by: &Vector6<f64>) -> Option<Rigid<To, From>> {
    let motion = Motion {
        turn: by.fixed_rows::<3>(0).into_owned(),
        shift: by.fixed_rows::<3>(3).into_owned(),
    };
    let turn = Rotation::from_vector(RotationVector::new(motion.turn.into()).ok()?);
    let t = Vector3::from(a.translation_mm()) + motion.shift;
    Some(Rigid::from_parts(turn * a.rotation(), Vector::new(t.x, t.y, t.z)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Probe, Reference};

    fn pose(t: f64) -> Rigid<Reference, Probe> {
        // A screw: constant speed, so that both the straight motion and its mean are exact in the shift.
        Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.3 * t), Vector::new(5.0 * t, -2.0 * t, 40.0)).unwrap()
    }

    #[test]
    fn a_steady_motion_is_met_between_and_beyond_the_poses() {
        let timed: Vec<_> = (0..50)
            .map(|i| (f64::from(i) * 0.08, pose(f64::from(i) * 0.08)))
            .collect();
        for window in [0.0, 0.1] {
            let track = Track::new(&timed, window).unwrap();
            for t in [-0.1, 0.0, 0.03, 1.0, 2.345, 3.92, 4.1] {
                let (found, truth) = (track.at(t).unwrap(), pose(t));
                assert!((found.rotation().distance(truth.rotation())) < 1e-12, "{window} {t}");
                let off = Vector3::from(found.translation_mm()) - Vector3::from(truth.translation_mm());
                assert!(off.norm() < 1e-12, "{window} {t}: {off}");
            }
            assert!(track.at(-0.6).is_none() && track.at(f64::NAN).is_none());
        }
    }

    #[test]
    fn times_that_do_not_rise_are_refused() {
        let wrong = |times: [f64; 3]| Track::new(&times.map(|t| (t, pose(0.0))), 0.0).unwrap_err();
        assert_eq!(
            wrong([0.0, 1.0, 1.0]),
            TrackError::Order {
                index: 2,
                t_s: 1.0,
                before_s: 1.0
            }
        );
        assert!(matches!(
            wrong([0.0, f64::NAN, 1.0]),
            TrackError::Order { index: 1, .. }
        ));
        assert!(matches!(
            Track::new(&[(0.0, pose(0.0))], 0.0),
            Err(TrackError::TooFew { found: 1 })
        ));
    }
}
