//! What a person must be told of the stream of poses, for as long as it takes to be read.

use bus::continuity::Judged;
use bus::message::{ToolPose, Tracked};
use geometry::{Ct, Rigid, Tool};

/// How long a remark stands on the images, ns of the session's clock.
const STANDS_NS: i64 = 10_000_000_000;

/// Nobody knows for how long the measurement that is shown has stood still.
pub(crate) const UNJUDGED: &str = "STANDSTILL NOT JUDGED";

/// When something was last amiss, on the session's clock.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Remarks {
    registration_ns: Option<i64>,
    numbers_ns: Option<i64>,
    /// A sample from before the first one that is shown was seen.
    led: bool,
    /// The first measurement that was seen, where none was before it.
    first: Option<Rigid<Ct, Tool>>,
    /// The measurement that is shown is that one, and may have stood still before.
    unjudged: bool,
}

impl Remarks {
    /// Takes in what was found of a sample that was captured at `t_ns`.
    pub(crate) fn take(&mut self, judged: &Judged, t_ns: i64) {
        if judged.registration_before.is_some() {
            self.registration_ns = Some(t_ns);
        }
        if judged.broken.is_some_and(|broken| !broken.refuses()) {
            self.numbers_ns = Some(t_ns);
        }
    }

    /// It is known what came before the first sample that is shown.
    pub(crate) fn led(&mut self) {
        self.led = true;
    }

    /// Takes in a sample of a replay: for how long a measurement has stood still is known once it was seen to begin.
    pub(crate) fn standstill(&mut self, sample: &ToolPose, judged: &Judged) {
        self.unjudged = match judged.tracked {
            Tracked::Valid(at) if !self.led => *self.first.get_or_insert(at) == at,
            Tracked::Valid(_) | Tracked::Lost(_) => false,
        };
        // Who says that it has no noise is never taken to stand still.
        self.unjudged &= sample.flags & ToolPose::NOISELESS == 0;
    }

    /// What is to be said at `now_ns`.
    pub(crate) fn words(&self, now_ns: i64) -> Vec<&'static str> {
        let stands = |at: Option<i64>| at.is_some_and(|at| now_ns.saturating_sub(at) < STANDS_NS);
        let remarks = [
            (self.registration_ns, "REGISTRATION CHANGED"),
            (self.numbers_ns, "POSES ARE COUNTED ANEW"),
        ];
        let standing = remarks.into_iter().filter(|(at, _)| stands(*at));
        let unjudged = self.unjudged.then_some(UNJUDGED);
        standing.map(|(_, words)| words).chain(unjudged).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::continuity::Continuity;
    use geometry::Vector;

    /// What the images say of samples at these places, 100 ms apart; `flags` of each.
    fn said(led: bool, flags: u32, places: &[f64]) -> Vec<bool> {
        let (mut remarks, mut continuity) = (Remarks::default(), Continuity::default());
        if led {
            remarks.led();
        }
        let mut one = |(seq, x): (usize, &f64)| {
            let mut pose = ToolPose {
                seq: seq as u64,
                t_capture_ns: 100_000_000 * seq as i64,
                flags,
                ..ToolPose::EMPTY
            };
            let at = Rigid::from_rotation_vector(Vector::new(0.1, 0.2, 0.3), Vector::new(*x, 0.0, 0.0)).unwrap();
            pose.set(Tracked::Valid(at));
            let judged = continuity.judge(&pose, pose.tracked().unwrap(), Some(250_000_000));
            remarks.standstill(&pose, &judged);
            !remarks.words(0).is_empty()
        };
        places.iter().enumerate().map(&mut one).collect()
    }

    /// A renderer that came late to a replay that stands still called a measurement good that may have stood still for an hour.
    #[test]
    fn a_measurement_that_was_not_seen_to_begin_says_so() {
        assert_eq!(
            said(false, 0, &[1.0, 1.0, 2.0, 2.0, 1.5]),
            [true, true, false, false, false]
        );
        // Once it has stood still for too long it is no pose, and needs no remark.
        assert_eq!(said(false, 0, &[1.0; 5]), [true, true, true, false, false]);
        assert_eq!(said(true, 0, &[1.0; 3]), [false; 3]);
        assert_eq!(said(false, ToolPose::NOISELESS, &[1.0; 3]), [false; 3]);
    }
}
