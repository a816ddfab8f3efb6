//! A tube that moves from one pose to another, against a point that moves too.

use nalgebra::{Isometry3, Point3, Vector3};

use super::screw::Screw;
use super::{Tube, TubeError};

/// Steps before a sweep gives up; a graze at the tolerance takes about the root of relative motion over tolerance.
const MOST_STEPS: usize = 100_000;

/// Why a sweep has no answer.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// The place, its way or the tolerance is NaN, infinite, or the tolerance not above zero.
    #[error("a place, a way or a tolerance is not finite, or the tolerance is not above zero")]
    Number,
    /// The point slides along the tube too long just beyond the tolerance.
    #[error("the point grazes the tube for too long: free until {free_until}, undecided afterwards")]
    Undecided {
        /// No touch before this time.
        free_until: f64,
    },
}

/// A tube on a steady twist from its pose to another, over the time from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    tube: Tube,
    screw: Screw,
}

impl Sweep {
    /// From the tube's pose to `to` by the steady twist between them, the shorter way round (of two halves of a turn, either).
    ///
    /// # Errors
    ///
    /// [`TubeError::Pose`] where a number of `to` is not finite.
    pub fn new(tube: Tube, to: Isometry3<f64>) -> Result<Self, TubeError> {
        super::check_pose(&to)?;
        let screw = Screw::between(*tube.pose(), &to);
        Ok(Self { tube, screw })
    }

    /// The pose at a time between 0 and 1.
    #[must_use]
    pub fn pose(&self, time: f64) -> Isometry3<f64> {
        self.screw.pose(time)
    }

    /// The tube at a time between 0 and 1.
    ///
    /// # Errors
    ///
    /// [`TubeError::Pose`] where the time is not finite.
    pub fn tube(&self, time: f64) -> Result<Tube, TubeError> {
        self.tube.at(self.pose(time))
    }

    /// A time until which the point `x + t d` (world) is free of the moving tube, and at which it is within `tolerance` of it;
    /// none where it is free from 0 to 1. 0 where `x` starts within the tolerance, or inside.
    ///
    /// Never later than the first touch, but for rounding; a point that passes by within `tolerance` may be reported.
    ///
    /// Seen from the tube the point runs on a curve that departs from its chord over a step of `h` by at most `M h^2 / 8`, `M` the
    /// bound on its second derivative. Each step is the chord against the tube grown by that much, in closed form.
    ///
    /// # Errors
    ///
    /// [`SweepError::Number`], or [`SweepError::Undecided`] after a hundred thousand steps.
    pub fn first_touch(&self, x: &Vector3<f64>, d: &Vector3<f64>, tolerance: f64) -> Result<Option<f64>, SweepError> {
        let finite = x.iter().chain(d.iter()).all(|c| c.is_finite()) && tolerance.is_finite();
        if !(finite && tolerance > 0.0) {
            return Err(SweepError::Number);
        }
        let bend = self.bend(x, d);
        let mut time = 0.0;
        for _ in 0..MOST_STEPS {
            let here = self.seen(x, d, time);
            // Measured anew at each step, so that the errors of chords do not add up.
            let gap = self.gap(&here);
            if gap <= tolerance {
                return Ok(Some(time));
            }
            // The curve may leave the chord by half the gap, so that the step begins outside of the grown tube.
            let step = (4.0 * gap / bend).sqrt().min(1.0 - time);
            let growth = bend * step * step / 8.0;
            let way = self.seen(x, d, time + step) - here;
            match self.tube.first_touch_grown(&here, &way, growth) {
                // No way left that the clock can tell: the gap is rounding, whatever the tolerance asked.
                Some(part) if time + part * step <= time => return Ok(Some(time)),
                Some(part) => time += part * step,
                None if time + step >= 1.0 => return Ok(None),
                None => time += step,
            }
        }
        Err(SweepError::Undecided { free_until: time })
    }

    /// The point at a time, in the tube's frame.
    fn seen(&self, x: &Vector3<f64>, d: &Vector3<f64>, time: f64) -> Vector3<f64> {
        let place = Point3::from(x + d * time);
        self.pose(time).inverse_transform_point(&place).coords
    }

    fn gap(&self, seen: &Vector3<f64>) -> f64 {
        let values = self.tube.cones.iter().map(|cone| cone.value(seen));
        values.fold(f64::INFINITY, f64::min)
    }

    /// Bound on the second derivative of the point's curve in the tube's frame.
    ///
    /// With the world's origin at `x`, angular velocity `w` and velocity `v` of the moving space there, the curve has velocity
    /// `q = d - v - w x (t d)` but for a rotation, and second derivative `-w x d - w x q`.
    fn bend(&self, x: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
        let turn = self.screw.turn.norm();
        let way = d.norm();
        let relative = (d - self.screw.velocity(x)).norm();
        // Lengths in the place of vectors, and 1 in the place of the time: too large at times, never too small.
        turn * (way + relative + turn * way)
    }
}
