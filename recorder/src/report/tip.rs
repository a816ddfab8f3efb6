//! The error at the tip: what the poses predicted, and where the tool was simulated what it was.

use std::collections::BTreeMap;

use bus::message::ToolPose;

use super::quantity::Quantity;
use crate::edit::compare::{Difference, Sample};

/// Poses that wait for their truth, or the other way round. Both are published together, so that few ever wait.
const WAITING: usize = 4096;
/// Errors from `LEAST_MM` to `MOST_MM` are told apart, as in the run's own report.
const LEAST_MM: f64 = 1e-3;
const MOST_MM: f64 = 1e3;

/// The capture as well as the number: a tracker that was started anew may count from 0 again.
type Key = (i64, u64);

/// Errors at the tip over time.
#[derive(Debug)]
pub(super) struct Tip {
    /// Predicted with the pose: 95 % of errors are below, mm. [`ToolPose::tip_95_mm`] has it.
    pub(super) predicted: Quantity,
    /// From the true tip to the measured one, mm.
    pub(super) found: Quantity,
    /// Poses with truth and prediction, and how many of them lie further off than they predicted.
    pub(super) compared: (u64, u64),
    /// True poses that came.
    pub(super) truths: u64,
    last: Option<u64>,
    last_found: Option<u64>,
    waiting: BTreeMap<Key, ToolPose>,
    waiting_truths: BTreeMap<Key, ToolPose>,
}

impl Default for Tip {
    fn default() -> Self {
        Self {
            predicted: Quantity::new(LEAST_MM, MOST_MM),
            found: Quantity::new(LEAST_MM, MOST_MM),
            compared: (0, 0),
            truths: 0,
            last: None,
            last_found: None,
            waiting: BTreeMap::new(),
            waiting_truths: BTreeMap::new(),
        }
    }
}

impl Tip {
    /// A pose that is one.
    pub(super) fn valid(&mut self, pose: &ToolPose) {
        if !follows(&mut self.last, pose.seq) {
            self.predicted.broken();
        }
        let t_ns = pose.t_capture_ns.max(0);
        match pose.tip_95_mm() {
            Some(mm) => self.predicted.add(t_ns, mm),
            None => self.predicted.unknown(t_ns),
        }
        match self.waiting_truths.remove(&key(pose)) {
            Some(truth) => self.pair(pose, &truth),
            None => wait(&mut self.waiting, pose),
        }
    }

    /// Where the simulated tool was.
    pub(super) fn truth(&mut self, truth: &ToolPose) {
        self.truths += 1;
        match self.waiting.remove(&key(truth)) {
            Some(pose) => self.pair(&pose, truth),
            None => wait(&mut self.waiting_truths, truth),
        }
    }

    fn pair(&mut self, pose: &ToolPose, truth: &ToolPose) {
        // A lost truth says nothing of the pose.
        let Some(mm) = Difference::of(pose.seq, &Sample::of(pose), &Sample::of(truth)).tip_mm() else {
            return;
        };
        if !follows(&mut self.last_found, pose.seq) {
            self.found.broken();
        }
        self.found.add(pose.t_capture_ns.max(0), mm);
        if let Some(predicted) = pose.tip_95_mm() {
            self.compared.0 += 1;
            self.compared.1 += u64::from(mm > predicted);
        }
    }
}

fn key(pose: &ToolPose) -> Key {
    (pose.t_capture_ns, pose.seq)
}

/// Whether this is the number behind the last one.
fn follows(last: &mut Option<u64>, seq: u64) -> bool {
    last.replace(seq).and_then(|last| last.checked_add(1)) == Some(seq)
}

fn wait(waiting: &mut BTreeMap<Key, ToolPose>, pose: &ToolPose) {
    if waiting.len() == WAITING {
        waiting.pop_first();
    }
    waiting.insert(key(pose), *pose);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use bus::message::{Lost, Tracked};

    #[test]
    fn truths_find_their_poses_in_whatever_order_they_come() {
        let mut tip = Tip::default();
        let moved = |seq: u64| {
            let mut truth = testing::pose(seq);
            truth.t_mm[0] += 2.0;
            truth
        };
        // Some before, some behind; one that never comes, one of another count, one that is lost.
        for seq in 0..10 {
            if seq % 2 == 0 {
                tip.truth(&moved(seq));
            }
            tip.valid(&testing::pose(seq));
        }
        for seq in [1, 3, 5] {
            tip.truth(&moved(seq));
        }
        let mut other = moved(7);
        other.t_capture_ns += 1;
        tip.truth(&other);
        let mut lost = testing::pose(9);
        lost.set(Tracked::Lost(Lost::NotSeen));
        tip.truth(&lost);
        let spread = tip.found.spread().unwrap();
        assert_eq!((spread.count, tip.compared, tip.truths), (8, (8, 8), 10));
        assert!((spread.max - 2.0).abs() < 1e-12 && (spread.min - 2.0).abs() < 1e-12);
        assert_eq!(tip.predicted.spread().unwrap().count, 10);
    }

    #[test]
    fn an_error_that_is_not_known_is_no_zero() {
        let mut tip = Tip::default();
        let mut pose = testing::pose(0);
        pose.flags = 0;
        tip.valid(&pose);
        assert_eq!((tip.predicted.spread(), tip.predicted.unknowns()), (None, 1));
    }

    #[test]
    fn who_waits_for_ever_takes_bounded_room() {
        let mut tip = Tip::default();
        (0..10_000).for_each(|seq| tip.valid(&testing::pose(seq)));
        assert_eq!(tip.waiting.len(), WAITING);
    }
}
