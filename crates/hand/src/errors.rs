//! What a measured pose is off by, and what it says of it.
//!
//! The true pose is the measured one with two small motions after it: that of the localizer, drawn anew for each frame,
//! turning about the tip; and that of the registration, drawn once for a task, turning about the target. Both are
//! normal, alike along all axes.

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tool, Uncertain, Vector};
use guidance::sight::Covariance;
use nalgebra::{Matrix6, Vector6};

/// Standard deviations, along each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of the measured tip, mm: noise, independent from frame to frame.
    pub tip_mm: f64,
    /// Of the measured directions, rad.
    pub turn_rad: f64,
    /// Of the registration at the target, mm: the same throughout a task.
    pub registration_mm: f64,
    /// Of the registration's turn about the target, rad.
    pub registration_rad: f64,
    /// The pose states deviations this many times smaller than they are: 1 where it is right.
    pub understated: f64,
}

/// Direction noise that goes with noise of the tip, rad per mm: as in the demonstration's scene, 0.02 degrees with 0.1
/// mm.
const TURN_RAD_PER_MM: f64 = 0.2 * std::f64::consts::PI / 180.0;
/// Of the registration, in the study: mm at the target, and rad (0.1 degrees).
const REGISTRATION: [f64; 2] = [0.3, 0.1 * std::f64::consts::PI / 180.0];

impl Errors {
    /// No error, and a pose that says so.
    pub const NONE: Self = Self {
        tip_mm: 0.0,
        turn_rad: 0.0,
        registration_mm: 0.0,
        registration_rad: 0.0,
        understated: 1.0,
    };

    /// Those of the study, with so much noise of the tip, mm.
    pub fn noisy(tip_mm: f64) -> Self {
        let [registration_mm, registration_rad] = REGISTRATION;
        Self {
            tip_mm,
            turn_rad: TURN_RAD_PER_MM * tip_mm,
            registration_mm,
            registration_rad,
            understated: 1.0,
        }
    }

    /// The registration's motion, drawn.
    pub fn of_registration(&self, target: Point<Ct>, chance: Chance) -> Rigid<Ct, Ct> {
        motion(target, [self.registration_rad, self.registration_mm], chance)
    }

    /// The localizer's motion, drawn for one frame.
    pub fn of_frame(&self, tip: Point<Ct>, chance: Chance) -> Rigid<Ct, Ct> {
        motion(tip, [self.turn_rad, self.tip_mm], chance)
    }

    /// What a pose states of its error.
    pub fn stated(&self, pose: Rigid<Ct, Tool>, target: Point<Ct>) -> Covariance {
        let tip = pose * Point::<Tool>::new(0.0, 0.0, 0.0);
        let about = |c: Point<Ct>, deviations: [f64; 2]| {
            let [turn, shift] = deviations.map(|d| (d / self.understated).powi(2));
            let diagonal = Vector6::new(turn, turn, turn, shift, shift, shift);
            Uncertain::from_covariance_about(c, pose, Matrix6::from_diagonal(&diagonal)).map(|u| u.upper())
        };
        let both = [
            about(tip, [self.turn_rad, self.tip_mm]),
            about(target, [self.registration_rad, self.registration_mm]),
        ];
        let [Ok(localizer), Ok(registration)] = both else {
            return Covariance::Missing;
        };
        // Independent motions: their covariances add.
        let sum: [f64; 21] = std::array::from_fn(|k| localizer[k] + registration[k]);
        match sum.iter().all(|x| *x == 0.0) {
            true => Covariance::Exact,
            false => Covariance::Upper(sum),
        }
    }
}

/// A small motion about `c` with deviations of its turn, rad, and of its shift, mm.
fn motion(c: Point<Ct>, [turn_rad, shift_mm]: [f64; 2], chance: Chance) -> Rigid<Ct, Ct> {
    let vector = |deviation: f64, first: u64| {
        let [x, y, z] = [0, 1, 2].map(|k| deviation * chance.normal(first + k));
        Vector::<Ct>::new(x, y, z)
    };
    let (turn, shift) = (vector(turn_rad, 0), vector(shift_mm, 3));
    let about_origin = Rigid::from_rotation_vector(turn, Vector::new(0.0, 0.0, 0.0));
    let rotation = about_origin.unwrap_or_else(|_| Rigid::identity());
    // p -> exp(w) (p - c) + c + v.
    Rigid::from_parts(rotation.rotation(), (c - rotation * c) + shift)
}
