//! What a replay goes on from where it begins, or goes elsewhere.
//!
//! A sample is judged beside those before it (`bus::continuity`): a measurement that has stood still for too long is none. Behind a
//! jump nobody has seen any. The replayer reads what came before the place and tells of it, behind the clock and in front of the first
//! pose of the place, the samples of the measurements that a judge would have kept, the last of which is where nothing new began to come, and the
//! last sample of all. Whoever judges poses knows them by their publication, which lies before the place that the clock was set to, and draws none.

use bus::continuity::{Break, Continuity};
use bus::message::{Lost, ToolPose, Tracked};
use geometry::{Ct, Rigid, Tool};

/// Different measurements that are kept, as [`Continuity`] keeps them.
const KEPT: usize = 8;

/// Judges what a replay shows, as its views do.
#[derive(Debug, Default)]
pub(super) struct Judge {
    frozen_ns: Option<i64>,
    continuity: Continuity,
    /// The first samples of the newest different measurements, at most [`KEPT`], the newest last.
    kept: Vec<ToolPose>,
    /// The last sample that was not refused.
    last: Option<ToolPose>,
    /// The first measurement; `None` before it.
    first: Option<Rigid<Ct, Tool>>,
    /// Whether nothing was left out before what was judged first.
    from_the_start: bool,
    /// Whether another measurement has come since the first.
    has_changed: bool,
    verdict: Option<(ToolPose, Tracked)>,
}

impl Judge {
    /// Of samples whose measurement may stand still for so long; `None`: for ever.
    pub(super) fn new(frozen_ns: Option<i64>, from_the_start: bool) -> Self {
        Self {
            frozen_ns,
            from_the_start,
            ..Self::default()
        }
    }

    /// Judges the next sample.
    pub(super) fn take(&mut self, pose: &ToolPose) {
        let Ok(tracked) = pose.tracked() else {
            self.verdict = Some((*pose, Tracked::Lost(Lost::Refused)));
            return;
        };
        let judged = self.continuity.judge(pose, tracked, self.frozen_ns);
        self.verdict = Some((*pose, judged.tracked));
        if judged.broken.is_some_and(Break::refuses) {
            return;
        }
        self.last = Some(*pose);
        let Tracked::Valid(at) = tracked else { return };
        let is_noiseless = pose.flags & ToolPose::NOISELESS != 0;
        let is_kept = self.kept.iter().any(|kept| kept.tracked() == Ok(tracked));
        if is_noiseless || !is_kept {
            let gives_way = usize::from(self.kept.len() == KEPT);
            self.kept.drain(..gives_way);
            self.kept.push(*pose);
        }
        self.has_changed |= is_noiseless || *self.first.get_or_insert(at) != at;
    }

    /// Whether it is known for how long the measurement has stood still, where `pose` comes next, or was judged last.
    pub(super) fn is_known(&self, pose: Option<&ToolPose>) -> bool {
        let Some(limit_ns) = self.frozen_ns else { return true };
        let stands =
            |(pose, since): (&ToolPose, &ToolPose)| pose.t_capture_ns.saturating_sub(since.t_capture_ns) > limit_ns;
        self.from_the_start || self.has_changed || pose.zip(self.kept.last()).is_some_and(stands)
    }

    /// The samples of the measurements that are kept, and the last one; one, where it is the last of them.
    pub(super) fn told(&self) -> Vec<ToolPose> {
        let mut told: Vec<ToolPose> = self.kept.iter().copied().chain(self.last).collect();
        told.dedup();
        told
    }

    /// `pose` as it was judged, if it was the last one: without a pose where it came to none. Whether that was known.
    pub(super) fn judged(&self, pose: ToolPose) -> (ToolPose, bool) {
        let mut judged = pose;
        match self.verdict {
            Some((last, Tracked::Lost(reason))) if last == pose => {
                judged.set(Tracked::Lost(reason));
                (judged, true)
            }
            Some((last, Tracked::Valid(_))) if last == pose => (pose, self.is_known(Some(&pose))),
            _ => (pose, self.frozen_ns.is_none()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use proptest::prelude::*;

    const LIMIT_NS: i64 = 500_000_000;

    /// Poses at 60 Hz whose measurement stands still where the place is the one before.
    fn stream(places: &[u8]) -> Vec<ToolPose> {
        let one = |(seq, place): (usize, &u8)| {
            let mut pose = testing::pose(seq as u64);
            let at = testing::pose(u64::from(*place));
            (pose.q, pose.t_mm) = (at.q, at.t_mm);
            pose
        };
        places.iter().enumerate().map(one).collect()
    }

    proptest! {
        /// Wherever one goes in a recording, what is told of before it leads to what reading all of it gives.
        #[test]
        fn what_is_told_before_a_place_gives_the_verdict_of_everything(
            few in 1..12_u8, runs in prop::collection::vec((0..12_u8, 1..50_usize), 1..16), at in 0..800_usize
        ) {
            let places: Vec<u8> = runs.iter().flat_map(|(place, n)| std::iter::repeat_n(*place % few, *n)).collect();
            let poses = stream(&places);
            let at = at % poses.len();
            let mut all = Judge::new(Some(LIMIT_NS), true);
            poses[..at].iter().for_each(|pose| all.take(pose));
            // Some samples at most, to whom has seen nothing.
            let mut told = Judge::new(Some(LIMIT_NS), false);
            prop_assert!(all.told().len() <= KEPT + 1);
            all.told().iter().for_each(|pose| told.take(pose));
            for pose in &poses[at..] {
                all.take(pose);
                told.take(pose);
                prop_assert_eq!(all.judged(*pose).0, told.judged(*pose).0);
            }
        }
    }

    #[test]
    fn what_stood_still_before_it_was_seen_is_not_called_known() {
        let poses = stream(&[7; 60]);
        let mut judge = Judge::new(Some(LIMIT_NS), false);
        judge.take(&poses[0]);
        assert_eq!(judge.judged(poses[0]), (poses[0], false));
        assert!(!judge.is_known(Some(&poses[30])) && judge.is_known(Some(&poses[31])));
        poses.iter().for_each(|pose| judge.take(pose));
        let (judged, is_known) = judge.judged(poses[59]);
        assert_eq!((judged.tracked(), is_known), (Ok(Tracked::Lost(Lost::Frozen)), true));
        // A measurement that differs, a source without noise, and a scene whose source has none.
        let other = testing::pose(60);
        judge.take(&other);
        assert_eq!(judge.judged(other), (other, true));
        let noiseless = ToolPose {
            flags: ToolPose::NOISELESS,
            ..poses[0]
        };
        let mut judge = Judge::new(Some(LIMIT_NS), false);
        judge.take(&noiseless);
        assert_eq!(judge.judged(noiseless), (noiseless, true));
        assert_eq!(Judge::new(None, false).judged(other), (other, true));
    }
}
