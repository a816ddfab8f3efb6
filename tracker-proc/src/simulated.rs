//! The simulated localizer: the gesture seen with noise and dropouts.

use bus::message::{Lost, Tracked};
use geometry::rotation::Rotation;
use geometry::uncertain::CovarianceError;
use geometry::{Ct, Point, Rigid, Tool, Tracker, Uncertain, Vector};
use scene::Simulation;
use scene::operating_room::Deviations;

use crate::errors::errors_about;
use crate::gesture::Gesture;
use chance::Chance;

/// The draw that decides on a dropout; 0 to 5 are the noise.
const DROPOUT_DRAW: u64 = 100;

/// A simulated localizer.
#[derive(Debug, Clone)]
pub struct Simulated {
    gesture: Gesture,
    simulation: Simulation,
    tracker_from_ct: Rigid<Tracker, Ct>,
    seed: u64,
    rate_hz: f64,
}

/// One sample: what was measured and what is true.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Script time, ns.
    pub t_device_ns: i64,
    /// The tool as the localizer sees it, or why it does not.
    pub tracker_from_tool: Result<Rigid<Tracker, Tool>, Lost>,
    /// Where the tool is.
    pub truth: Rigid<Ct, Tool>,
}

impl Simulated {
    /// A localizer that sees `gesture` with the imperfections of `simulation`.
    pub fn new(
        gesture: Gesture,
        simulation: Simulation,
        ct_from_tracker: &Rigid<Ct, Tracker>,
        seed: u64,
        rate_hz: f64,
    ) -> Self {
        Self {
            gesture,
            simulation,
            tracker_from_ct: ct_from_tracker.inverse(),
            seed,
            rate_hz,
        }
    }

    /// Whether a tool at rest gives the same numbers again and again.
    pub fn is_noiseless(&self) -> bool {
        self.simulation.noise_mm == 0.0 && self.simulation.noise_rad == 0.0
    }

    /// Script time of sample `seq`, ns.
    pub fn t_device_ns(&self, seq: u64) -> i64 {
        (seq as f64 * 1e9 / self.rate_hz).round() as i64
    }

    /// The last sample due at script time `t_ns`, or `None` before the first.
    pub fn due(&self, t_ns: i64) -> Option<u64> {
        (t_ns >= 0).then(|| (t_ns as f64 * self.rate_hz / 1e9) as u64)
    }

    /// Sample `seq`. The same for the same seed, always.
    pub fn sample(&self, seq: u64) -> Measured {
        let t_device_ns = self.t_device_ns(seq);
        let truth = self.gesture.ct_from_tool(t_device_ns as f64 / 1e9);
        let seen = if self.dropped_out(seq) {
            Err(Lost::NotSeen)
        } else {
            Ok(self.tracker_from_ct * self.disturbed(truth, seq))
        };
        Measured {
            t_device_ns,
            tracker_from_tool: seen,
            truth,
        }
    }

    /// The pose with noise: the tip moved in the patient, the tube turned about its tip.
    fn disturbed(&self, truth: Rigid<Ct, Tool>, seq: u64) -> Rigid<Ct, Tool> {
        let chance = Chance::new(self.seed, seq);
        let n = |draw| chance.normal(draw);
        let shift = Vector::<Ct>::new(n(0), n(1), n(2)) * self.simulation.noise_mm;
        let turn = Vector::<Tool>::new(n(3), n(4), n(5)) * self.simulation.noise_rad;
        let no_shift = Vector::new(0.0, 0.0, 0.0);
        let moved: Rigid<Ct, Ct> = Rigid::from_parts(Rotation::IDENTITY, shift);
        // The scene's noise and a normal draw are finite, so there always is such a turn.
        let turned: Rigid<Tool, Tool> = Rigid::from_rotation_vector(turn, no_shift).unwrap_or(Rigid::identity());
        moved * truth * turned
    }

    fn dropped_out(&self, seq: u64) -> bool {
        let lasts = u64::from(self.simulation.dropout_samples);
        let first = (seq + 1).saturating_sub(lasts);
        (first..=seq).any(|start| Chance::new(self.seed, start).uniform(DROPOUT_DRAW) < self.simulation.dropout)
    }

    /// A measured pose with the covariance of its noise, which moves the tip and turns the tube about it.
    ///
    /// # Errors
    /// [`CovarianceError`], where the scene's noise is beyond what a covariance can hold.
    pub fn uncertain(&self, measured: Rigid<Ct, Tool>) -> Result<Uncertain<Ct, Tool>, CovarianceError> {
        let noise = Deviations {
            shift_mm: self.simulation.noise_mm,
            turn_rad: self.simulation.noise_rad,
        };
        let tip = measured * Point::<Tool>::new(0.0, 0.0, 0.0);
        Ok(errors_about(tip, noise)? * measured)
    }
}

impl Measured {
    /// `ct_from_tool = ct_from_tracker * tracker_from_tool`, or why there is none.
    pub fn tracked(&self, ct_from_tracker: &Rigid<Ct, Tracker>) -> Tracked {
        match self.tracker_from_tool {
            Ok(tracker_from_tool) => Tracked::Valid(*ct_from_tracker * tracker_from_tool),
            Err(reason) => Tracked::Lost(reason),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Scene, TrackerSource};
    use std::path::Path;

    fn simulated(text: &str) -> (Simulated, Rigid<Ct, Tracker>) {
        let scene = Scene::parse(text, Path::new("s.toml")).unwrap();
        let TrackerSource::Simulated(simulation) = scene.tracker.source else {
            panic!("simulated by default")
        };
        let gesture = Gesture::new(&simulation.approach, Point::new(0.0, 0.0, 0.0), None).unwrap();
        let ct_from_tracker = scene.tracker.ct_from_tracker;
        let simulated = Simulated::new(gesture, simulation, &ct_from_tracker, scene.seed, scene.tracker.rate_hz);
        (simulated, ct_from_tracker)
    }

    #[test]
    fn without_imperfections_the_measurement_is_the_truth() {
        let (s, ct_from_tracker) = simulated(
            "[tracker]\nnoise_mm = 0\nnoise_deg = 0\n[tracker.ct_from_tracker]\nquaternion = [0.6, 0, 0.8, 0]\ntranslation_mm = [900, -300, 1500]",
        );
        for seq in [0, 17, 500] {
            let measured = s.sample(seq);
            let Tracked::Valid(pose) = measured.tracked(&ct_from_tracker) else {
                panic!("no dropouts")
            };
            let far = Point::<Tool>::new(0.0, 0.0, -200.0);
            // There and back through coordinates of about 2000 mm.
            assert!((pose * far).distance(measured.truth * far) < 30.0 * 2000.0 * f64::EPSILON);
        }
    }

    #[test]
    fn noise_has_the_stated_size() {
        let (s, ct_from_tracker) = simulated("[tracker]\nnoise_mm = 0.3\nnoise_deg = 0");
        let n = 20_000;
        let sum: f64 = (0..n)
            .map(|seq| {
                let m = s.sample(seq);
                let Tracked::Valid(pose) = m.tracked(&ct_from_tracker) else {
                    panic!()
                };
                let origin = Point::<Tool>::new(0.0, 0.0, 0.0);
                (pose * origin).distance(m.truth * origin).powi(2)
            })
            .sum();
        let deviation = (sum / n as f64 / 3.0).sqrt();
        // Five standard errors of a deviation: 5 / sqrt(2 * 3 n).
        assert!(
            (deviation / 0.3 - 1.0).abs() < 5.0 / (6.0 * n as f64).sqrt(),
            "{deviation}"
        );
    }

    /// The noise turns the tube about its tip; a covariance that turned it about the CT's origin predicted 0.35 mm more at a tip
    /// 1 m from there.
    #[test]
    fn the_covariance_predicts_the_noise_at_the_tip_wherever_it_is() {
        let (s, ct_from_tracker) = simulated("[tracker]\nnoise_mm = 0.1\nnoise_deg = 0.02");
        let Tracked::Valid(near) = s.sample(0).tracked(&ct_from_tracker) else {
            panic!("no dropouts")
        };
        let far = Rigid::from_parts(near.rotation(), Vector::new(700.0, -100.0, 700.0));
        for pose in [near, far] {
            let at_tip = s.uncertain(pose).unwrap() * Point::<Tool>::new(0.0, 0.0, 0.0);
            // Cancellation of the lever's squares, see geometry::uncertain.
            assert!(
                (at_tip.covariance().trace() - 0.03).abs() < 1e-9,
                "{}",
                at_tip.covariance()
            );
        }
    }

    #[test]
    fn dropouts_last_and_repeat() {
        let (s, _) = simulated("[tracker]\ndropout = 0.01\ndropout_samples = 6");
        let lost: Vec<bool> = (0..6000).map(|seq| s.sample(seq).tracker_from_tool.is_err()).collect();
        assert_eq!(
            lost,
            (0..6000)
                .map(|seq| s.sample(seq).tracker_from_tool.is_err())
                .collect::<Vec<_>>()
        );
        let part = lost.iter().filter(|&&l| l).count() as f64 / 6000.0;
        // 1 - 0.99^6 = 0.0585; runs make the spread wide.
        assert!((0.03..0.09).contains(&part), "{part}");
        let shortest = lost
            .split(|&l| !l)
            .filter(|run| !run.is_empty())
            .map(<[bool]>::len)
            .min();
        assert!(shortest >= Some(5), "{shortest:?}");
    }

    #[test]
    fn samples_are_due_at_their_times() {
        let (s, _) = simulated("");
        assert_eq!(s.due(-1), None);
        for seq in [0, 1, 59, 600] {
            let due = s.due(s.t_device_ns(seq) + 1);
            assert_eq!(due, Some(seq));
        }
    }
}
