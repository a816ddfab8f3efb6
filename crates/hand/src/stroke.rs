//! One stroke of the hand: the smoothest way from rest to rest.
//!
//! Of all motions from rest to rest in a time T that with the least mean square jerk is (Flash and Hogan 1985)
//!
//! ```text
//! x(u) = a + (b - a) (10 u^3 - 15 u^4 + 6 u^5),   u = t / T
//! ```
//!
//! straight, with a bell of a speed whose peak is 15/8 of the mean.

use crate::tube::Posture;

/// The peak of a stroke's speed, parts of its mean.
pub const PEAK: f64 = 1.875;

/// Which part of the stroke is done at the part `u` of its time; 0 before it and 1 after it.
pub fn part(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

/// The speed at the part `u` of the time, parts of the mean.
pub fn speed(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    30.0 * (u * (1.0 - u)).powi(2)
}

/// A stroke from one posture to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// When it begins, s.
    pub begin_s: f64,
    /// How long it takes, s; above zero.
    pub duration_s: f64,
    /// Where it begins.
    pub from: Posture,
    /// Where it ends, with what the hand errs by.
    pub to: Posture,
}

impl Stroke {
    /// When it ends, s.
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.duration_s
    }

    /// Where the tube stands at a time, s.
    pub fn at(&self, t_s: f64) -> Posture {
        let done = part((t_s - self.begin_s) / self.duration_s);
        // So written that both ends are exact.
        let between = |a: f64, b: f64| (1.0 - done) * a + done * b;
        Posture {
            tilt: [0, 1].map(|k| between(self.from.tilt[k], self.to.tilt[k])),
            depth_mm: between(self.from.depth_mm, self.to.depth_mm),
        }
    }
}
