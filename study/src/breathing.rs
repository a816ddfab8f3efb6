//! Organs that move with the breath.
//!
//! Along the patient's long axis, towards the feet on inspiration, after Lujan et al., "A method for incorporating organ motion due to
//! breathing into 3D dose calculations", Med Phys 26 (1999) 715, with the power that they use for a liver:
//!
//! ```text
//! d(t) = -mm cos^6(pi t / period + phase) z                                                                         (1)
//! ```
//!
//! so that d is 0 at the end of an expiration, near which an organ is for most of the time. What is bone, the skin and the markers on
//! them stay where they are.

use std::f64::consts::PI;

use chance::Chance;
use geometry::{Ct, Vector};

use crate::plan::Breathing;

/// Number of the phase among what is drawn of an operation.
const PHASE: u64 = 20;

/// How the organs of one operation move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breath {
    breathing: Breathing,
    phase_rad: f64,
}

impl Breath {
    /// That of the operation with this seed: where in a breath it begins is as likely anywhere.
    pub(crate) fn drawn(breathing: Breathing, seed: u64) -> Self {
        Self {
            breathing,
            // (1) comes again after a half turn.
            phase_rad: PI * Chance::new(seed, PHASE).uniform(0),
        }
    }

    /// How far organs have moved from where the CT has them, at this time of the room, s.
    pub(crate) fn moved(&self, t_s: f64) -> Vector<Ct> {
        let Breathing { mm, period_s } = self.breathing;
        // Of the turns whole ones are left out first: a localizer may have been on for years.
        let turns = (t_s / period_s).fract();
        let cos = (PI * turns + self.phase_rad).cos();
        Vector::new(0.0, 0.0, -mm * cos.powi(6))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF_LIVER: Breathing = Breathing {
        mm: 12.0,
        period_s: 5.0,
    };

    fn feet(breath: &Breath, t_s: f64) -> f64 {
        let [x, y, z] = breath.moved(t_s).mm();
        assert_eq!([x, y], [0.0; 2]);
        -z
    }

    /// cos^6 is at most 1/8 for half of the time: where cos^2 is at most 1/2.
    #[test]
    fn it_is_near_the_end_of_an_expiration_for_most_of_the_time() {
        let breath = Breath::drawn(OF_LIVER, 3);
        let all: Vec<f64> = (0..10_000)
            .map(|k| feet(&breath, 5.0 * f64::from(k) / 10_000.0))
            .collect();
        let near = all.iter().filter(|mm| **mm <= 12.0 / 8.0).count();
        assert!(near.abs_diff(5000) <= 2, "{near}");
        let most = all.iter().copied().fold(0.0, f64::max);
        let least = all.iter().copied().fold(12.0, f64::min);
        assert!(
            (most - 12.0).abs() < 1e-4 && (0.0..1e-9).contains(&least),
            "{least} {most}"
        );
        // The mean of cos^6 is 5/16.
        let mean = all.iter().sum::<f64>() / 1e4;
        assert!((mean - 12.0 * 5.0 / 16.0).abs() < 1e-6, "{mean}");
    }

    #[test]
    fn a_breath_comes_again_after_its_period_and_each_operation_has_its_own() {
        let (one, other) = (Breath::drawn(OF_LIVER, 3), Breath::drawn(OF_LIVER, 4));
        for t_s in [0.0, 1.3, 8e7 + 2.1] {
            // A time of 8e7 s is known to 1e-8 s.
            assert!((feet(&one, t_s) - feet(&one, t_s + 5.0)).abs() < 1e-6);
            assert!((feet(&one, t_s) - feet(&other, t_s)).abs() > 1e-3);
        }
    }
}
