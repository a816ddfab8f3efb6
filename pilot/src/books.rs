//! What happened: poses, images, latencies, restarts. Fed by the run, read by the report and the status.

use bus::clock::ms;
use bus::message::{FrameStamp, FrameState, ToolPose, Tracked, VolumeHash, VolumeHeader};
use serde::Serialize;

use crate::accuracy::AccuracyBook;

/// The way of a pose to its pixels, stage by stage.
pub(crate) const STAGES: [&str; 5] = [
    "capture_to_publish",
    "publish_to_seen",
    "seen_to_rendered",
    "rendered_to_framed",
    "pose_to_pixels",
];

/// The books of one run.
#[derive(Debug, Default)]
pub(crate) struct Books {
    pub(crate) poses: PoseCounts,
    pub(crate) accuracy: AccuracyBook,
    /// What the newest valid pose rests on.
    pub(crate) registration_id: Option<u64>,
    pub(crate) views: Vec<ViewBook>,
    /// One list of durations (ns) for each of [`STAGES`].
    latencies: [Vec<i64>; 5],
    pub(crate) restarts: Vec<Restart>,
    pub(crate) volume: Option<VolumeHeader>,
    /// A view has shown another volume than the loader's: that must never be.
    pub(crate) foreign_volume: bool,
    /// The newest samples, oldest first.
    recent: std::collections::VecDeque<ToolPose>,
    /// They are of another place of a replay than the next one.
    jumped: bool,
}

/// Counts of samples on the pose topic.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct PoseCounts {
    /// Samples that came over the bus.
    pub(crate) published: u64,
    /// Of these, samples without a pose.
    pub(crate) lost: u64,
    /// Of these, samples refused at the door: NaN or not a rotation.
    pub(crate) refused: u64,
    /// Sequence numbers that never came.
    pub(crate) missing: u64,
}

/// One view.
#[derive(Debug, Default)]
pub(crate) struct ViewBook {
    /// Different poses shown.
    pub(crate) rendered: u64,
    /// Images that were older than the limit when they were handed over, and did not say so.
    pub(crate) unflagged_old: u64,
    pub(crate) last: Option<FrameStamp>,
    last_seq: Option<u64>,
}

/// A process that died and came back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Restart {
    pub(crate) process: String,
    /// Why it ended.
    pub(crate) cause: String,
    /// When it was noticed, seconds from the start of the navigation.
    pub(crate) at_s: f64,
    /// How long it took until its work was there again; `null`: not yet.
    pub(crate) live_again_s: Option<f64>,
    #[serde(skip)]
    pub(crate) at_ns: i64,
}

/// Percentiles of one stage, ms.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Latency {
    pub(crate) p50: f64,
    pub(crate) p95: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
    pub(crate) count: usize,
}

const RECENT: usize = 1024;

impl Books {
    pub(crate) fn new(views: usize) -> Self {
        Self {
            views: (0..views).map(|_| ViewBook::default()).collect(),
            ..Self::default()
        }
    }

    /// A sample came over the bus and was taken at `now_ns`.
    pub(crate) fn pose(&mut self, pose: ToolPose, now_ns: i64) {
        if std::mem::take(&mut self.jumped) {
            self.recent.clear();
        }
        if let Some(last) = self.recent.back() {
            self.poses.missing += pose.seq.saturating_sub(last.seq + 1);
        }
        self.poses.published += 1;
        match pose.tracked_at(now_ns) {
            Ok(Tracked::Valid(_)) => {
                self.accuracy.valid(&pose);
                self.registration_id = Some(pose.registration_id);
            }
            Ok(Tracked::Lost(reason)) => {
                self.poses.lost += 1;
                self.accuracy.lost(reason);
            }
            Err(_) => self.poses.refused += 1,
        }
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back(pose);
    }

    /// A replay went elsewhere: what comes is neither behind nor missing, and is shown anew.
    pub(crate) fn jumped(&mut self) {
        self.jumped = true;
        for view in &mut self.views {
            view.last_seq = None;
        }
    }

    /// The newest sample.
    pub(crate) fn newest_pose(&self) -> Option<&ToolPose> {
        self.recent.back()
    }

    /// The newest valid pose up to sample `seq`.
    pub(crate) fn valid_pose_until(&self, seq: u64) -> Option<ToolPose> {
        let valid = |p: &&ToolPose| p.seq <= seq && matches!(p.tracked(), Ok(Tracked::Valid(_)));
        self.recent.iter().rev().find(valid).copied()
    }

    /// A renderer has handed over an image. `stale_ns` is the scene's limit.
    pub(crate) fn frame(&mut self, stamp: &FrameStamp, stale_ns: i64) {
        let Some(view) = self.views.get_mut(stamp.view as usize) else {
            return;
        };
        let state = stamp.frame_state();
        let age = stamp.t_framed_ns - stamp.t_capture_ns;
        if state == Some(FrameState::Live) && stamp.on_request == 0 && age > stale_ns {
            view.unflagged_old += 1;
        }
        view.last = Some(*stamp);
        if let Some(volume) = &self.volume {
            self.foreign_volume |= volume.volume_hash() != stamp.volume();
        }
        let shows_pose = matches!(state, Some(FrameState::Live | FrameState::Stale));
        let is_new = view.last_seq.is_none_or(|last| stamp.seq > last);
        if shows_pose && is_new && stamp.on_request == 0 {
            view.last_seq = Some(stamp.seq);
            view.rendered += 1;
            let stages = [
                stamp.t_publish_ns - stamp.t_capture_ns,
                stamp.t_seen_ns - stamp.t_publish_ns,
                stamp.t_rendered_ns - stamp.t_seen_ns,
                stamp.t_framed_ns - stamp.t_rendered_ns,
                age,
            ];
            for (list, duration) in self.latencies.iter_mut().zip(stages) {
                list.push(duration);
            }
        }
    }

    /// The loader has published: for the first time, or the same examination again after a restart.
    pub(crate) fn volume(&mut self, header: VolumeHeader) {
        if let Some(old) = &self.volume {
            self.foreign_volume |= old.volume_hash() != header.volume_hash();
        }
        self.volume = Some(header);
    }

    /// The volume's identity, as soon as it is known.
    pub(crate) fn volume_hash(&self) -> Option<VolumeHash> {
        self.volume.as_ref().map(VolumeHeader::volume_hash)
    }

    /// The work of `process` is there again.
    pub(crate) fn live_again(&mut self, process: &str, now_ns: i64) {
        for restart in &mut self.restarts {
            if restart.process == process && restart.live_again_s.is_none() && now_ns > restart.at_ns {
                restart.live_again_s = Some(ms(now_ns - restart.at_ns) / 1e3);
            }
        }
    }

    /// The percentiles of each stage.
    pub(crate) fn latencies(&self) -> impl Iterator<Item = (&'static str, Latency)> {
        STAGES
            .into_iter()
            .zip(&self.latencies)
            .map(|(stage, list)| (stage, percentiles(list)))
    }
}

/// Percentiles by nearest rank; all zero for an empty list.
fn percentiles(durations_ns: &[i64]) -> Latency {
    let mut sorted = durations_ns.to_vec();
    sorted.sort_unstable();
    let rank = |p: f64| {
        let i = (p * sorted.len() as f64).ceil() as usize;
        sorted.get(i.saturating_sub(1)).map_or(0.0, |&ns| ms(ns))
    };
    Latency {
        p50: rank(0.50),
        p95: rank(0.95),
        p99: rank(0.99),
        max: rank(1.0),
        count: sorted.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Lost;
    use geometry::Rigid;

    fn pose(seq: u64, tracked: Tracked) -> ToolPose {
        let mut pose = ToolPose { seq, ..ToolPose::EMPTY };
        pose.set(tracked);
        pose
    }

    #[test]
    fn percentiles_are_nearest_rank() {
        let list: Vec<i64> = (1..=100).map(|i| i * 1_000_000).collect();
        let l = percentiles(&list);
        assert_eq!((l.p50, l.p95, l.p99, l.max, l.count), (50.0, 95.0, 99.0, 100.0, 100));
        assert_eq!(percentiles(&[]), Latency::default());
        assert_eq!(percentiles(&[7_000_000]).p99, 7.0);
    }

    #[test]
    fn poses_are_counted_by_kind_and_gaps_too() {
        let mut books = Books::new(1);
        books.pose(pose(0, Tracked::Valid(Rigid::identity())), 0);
        books.pose(pose(3, Tracked::Lost(Lost::NotSeen)), 0);
        let mut bad = pose(4, Tracked::Valid(Rigid::identity()));
        bad.q[0] = f64::NAN;
        books.pose(bad, 0);
        let expected = PoseCounts {
            published: 3,
            lost: 1,
            refused: 1,
            missing: 2,
        };
        assert_eq!(books.poses, expected);
        assert_eq!(books.valid_pose_until(9).map(|p| p.seq), Some(0));
    }

    #[test]
    fn old_images_that_claim_to_be_live_are_found() {
        let mut books = Books::new(1);
        let stamp = FrameStamp {
            t_framed_ns: 101,
            ..FrameStamp::default()
        };
        books.frame(&stamp, 100);
        assert_eq!(books.views[0].unflagged_old, 1);
        let said = FrameStamp {
            state: FrameState::Stale.code(),
            seq: 1,
            ..stamp
        };
        books.frame(&said, 100);
        assert_eq!((books.views[0].unflagged_old, books.views[0].rendered), (1, 2));
    }

    #[test]
    fn what_a_replay_passes_over_is_not_missing_and_what_comes_again_is_shown_again() {
        let mut books = Books::new(1);
        let stamp = |seq| FrameStamp {
            seq,
            ..FrameStamp::default()
        };
        for seq in [7, 100, 3] {
            books.pose(pose(seq, Tracked::Valid(Rigid::identity())), 0);
            books.frame(&stamp(seq), 100);
            books.jumped();
            // Until the next one comes, it is the newest there is.
            assert_eq!(books.newest_pose().map(|p| p.seq), Some(seq));
        }
        assert_eq!((books.poses.missing, books.views[0].rendered), (0, 3));
    }

    #[test]
    fn the_same_pose_drawn_again_is_not_a_latency() {
        let mut books = Books::new(1);
        for _ in 0..3 {
            books.frame(&FrameStamp::default(), 100);
        }
        assert_eq!(books.views[0].rendered, 1);
        assert_eq!(books.latencies().last().map(|(_, l)| l.count), Some(1));
    }
}
