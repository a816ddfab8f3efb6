//! What happened: poses, images, latencies, restarts. Fed by the run, read by the report and the status.

pub(crate) mod accuracy;
pub(crate) mod memory;
pub(crate) mod presence;
mod samples;
pub(crate) mod tissue;

use bus::clock::ms;
use bus::continuity::{Break, Continuity};
use bus::message::{FrameStamp, FrameState, Lost, ToolPose, Tracked, VolumeHash, VolumeHeader};
use fit::Histogram;
use geometry::{Point, Tool, VolumeGrid};
use serde::Serialize;

use crate::metrics::accuracy::AccuracyBook;
use crate::metrics::samples::{ALL, Samples};
use crate::metrics::tissue::TissueBook;

/// The way of a pose to its pixels, stage by stage.
pub(crate) const STAGES: [&str; 5] = [
    "capture_to_publish",
    "publish_to_seen",
    "seen_to_rendered",
    "rendered_to_framed",
    "pose_to_pixels",
];

/// The metrics of one run.
#[derive(Debug, Default)]
pub(crate) struct Metrics {
    pub(crate) poses: PoseCounts,
    pub(crate) accuracy: AccuracyBook,
    /// What the newest valid pose rests on.
    pub(crate) registration_id: Option<u64>,
    pub(crate) views: Vec<ViewBook>,
    latencies: Latencies,
    samples: Samples,
    pub(crate) tissue: TissueBook,
    pub(crate) restarts: Vec<Restart>,
    pub(crate) volume: Option<VolumeHeader>,
    /// Where its voxels lie.
    grid: Option<VolumeGrid>,
    /// A view has shown another volume than the loader's: that must never be.
    pub(crate) foreign_volume: bool,
    /// How much older than their arrival poses may have been at most, ms: what the localizer noted.
    pub(crate) older_ms: u64,
    continuity: Continuity,
    /// The newest samples with what they came to, oldest first.
    recent: std::collections::VecDeque<(ToolPose, Tracked)>,
    /// They are of another place of a replay than the next one.
    jumped: bool,
    /// Since a replay was begun, or went elsewhere, a sample of the place has come.
    is_there: bool,
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
    /// How often the numbers began anew, backwards or far ahead.
    pub(crate) counted_anew: u64,
    /// How often a pose rested on another registration than the one before.
    pub(crate) registration_changes: u64,
}

impl PoseCounts {
    /// What was wrong with the stream, in words.
    pub(crate) fn problems(&self) -> impl Iterator<Item = String> {
        let found = [
            (
                self.refused,
                "samples on the pose topic were not poses (not a rotation, out of this world, captured before the one before, \
                 or with its number) and were not shown",
            ),
            (
                self.registration_changes,
                "times a pose rested on another registration than the one before: REGISTRATION CHANGED",
            ),
            (
                self.counted_anew,
                "times the numbers of poses began anew: the source was started again, or there were two",
            ),
        ];
        let found = found.into_iter().filter(|(count, _)| *count > 0);
        found.map(|(count, words)| format!("{count} {words}"))
    }
}

/// What a sample is judged by beside those before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judging {
    /// When it was taken, on the session's clock.
    pub(crate) now_ns: i64,
    /// See [`Continuity::judge`].
    pub(crate) frozen_ns: Option<i64>,
    /// `None` in a run that navigates.
    pub(crate) replay: Option<Place>,
}

/// Where a replay is: see `recorder::replay::lead`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// What was published before the first moment that is replayed is no part of the replay: it says what that goes on from.
    pub(crate) first_ns: i64,
    /// Where the clock was set last. Of what was published before it, and comes first behind a jump, nothing is missing.
    pub(crate) set_ns: i64,
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

impl Restart {
    /// The cause of one that a person wanted.
    pub(crate) const ASKED: &'static str = "restarted as asked";

    /// When and why, for people.
    pub(crate) fn words(&self) -> String {
        // Negative before the navigation began; never a zero with a sign.
        let at_s = (100.0 * self.at_s).round() / 100.0 + 0.0;
        format!("at {at_s:.2} s: {}", self.cause)
    }
}

/// Percentiles of one stage, ms.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Latency {
    pub(crate) p50: f64,
    pub(crate) p95: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
    pub(crate) count: u64,
}

const RECENT: usize = 1024;

impl Metrics {
    pub(crate) fn new(views: usize) -> Self {
        Self {
            views: (0..views).map(|_| ViewBook::default()).collect(),
            ..Self::default()
        }
    }

    /// A sample came over the bus.
    pub(crate) fn pose(&mut self, pose: ToolPose, by: Judging) {
        if std::mem::take(&mut self.jumped) {
            self.recent.clear();
            self.continuity = Continuity::default();
            self.is_there = false;
        }
        if by.replay.is_some_and(|place| pose.t_publish_ns < place.first_ns) {
            return self.lead(&pose, by);
        }
        let before_missing = self.poses.missing;
        self.poses.published += 1;
        let (tracked, is_refused) = self.judged(&pose, by);
        self.is_there |= by.replay.is_none_or(|place| pose.t_publish_ns >= place.set_ns);
        if !self.is_there {
            self.poses.missing = before_missing;
        }
        if !is_refused {
            self.samples.add(&pose);
        }
        match tracked {
            _ if is_refused => self.poses.refused += 1,
            Tracked::Valid(at) => {
                let outside = self.is_outside(&Tracked::Valid(at));
                self.accuracy.valid(&pose, outside);
                self.registration_id = Some(pose.registration_id);
            }
            Tracked::Lost(reason) => {
                self.poses.lost += 1;
                self.accuracy.lost(reason);
            }
        }
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back((pose, tracked));
    }

    /// What a sample is, by itself and after those before it, as the renderers judge it; and whether it is refused here (a
    /// tracker that refused its localizer's frame says so in a sample that is in order).
    fn judged(&mut self, pose: &ToolPose, by: Judging) -> (Tracked, bool) {
        let Ok(tracked) = pose.tracked_at(by.now_ns) else {
            return (Tracked::Lost(Lost::Refused), true);
        };
        let mut judged = self.continuity.judge(pose, tracked, by.frozen_ns);
        if by.replay.is_some() && judged.broken.is_some() {
            // A replay goes where it is told to; samples that were under way then come behind the news of it.
            self.continuity = Continuity::default();
            judged = self.continuity.judge(pose, tracked, by.frozen_ns);
        }
        self.poses.missing += judged.missing;
        self.poses.counted_anew += u64::from(judged.broken.is_some_and(|broken| !broken.refuses()));
        self.poses.registration_changes += u64::from(judged.registration_before.is_some());
        (judged.tracked, judged.broken.is_some_and(Break::refuses))
    }

    /// What comes is judged beside this one, from before what is replayed, which is counted as nothing.
    fn lead(&mut self, pose: &ToolPose, by: Judging) {
        let Ok(tracked) = pose.tracked() else { return };
        let judged = self.continuity.judge(pose, tracked, by.frozen_ns);
        if judged.broken.is_some_and(Break::refuses) {
            self.continuity = Continuity::default();
            self.continuity.judge(pose, tracked, by.frozen_ns);
        }
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
        self.recent.back().map(|(pose, _)| pose)
    }

    /// The newest sample with what it came to.
    pub(crate) fn newest(&self) -> Option<&(ToolPose, Tracked)> {
        self.recent.back()
    }

    /// Whether the tip of a pose is outside the examination, as far as that is known.
    pub(crate) fn is_outside(&self, tracked: &Tracked) -> bool {
        match (tracked, &self.grid) {
            (Tracked::Valid(at), Some(grid)) => !grid.holds(*at * Point::<Tool>::new(0.0, 0.0, 0.0)),
            _ => false,
        }
    }

    /// The newest valid pose up to sample `seq`.
    pub(crate) fn valid_pose_until(&self, seq: u64) -> Option<ToolPose> {
        let valid = |(p, tracked): &&(ToolPose, Tracked)| p.seq <= seq && matches!(tracked, Tracked::Valid(_));
        self.recent.iter().rev().find(valid).map(|(pose, _)| *pose)
    }

    /// A renderer has handed over an image. `stale_ns` is the scene's limit.
    pub(crate) fn frame(&mut self, stamp: &FrameStamp, stale_ns: i64) {
        let Some(view) = self.views.get_mut(stamp.view as usize) else {
            return;
        };
        let state = stamp.frame_state();
        // Stamps are other processes' numbers: the difference of two may not fit.
        let age = stamp.t_framed_ns.saturating_sub(stamp.t_capture_ns);
        if state == Some(FrameState::Live) && stamp.on_request == 0 && age > stale_ns {
            view.unflagged_old += 1;
        }
        // What was asked for is not what the view shows.
        if stamp.on_request == 0 {
            view.last = Some(*stamp);
        }
        if let Some(volume) = &self.volume {
            self.foreign_volume |= volume.volume_hash() != stamp.volume();
        }
        let shows_pose = matches!(
            state,
            Some(FrameState::Live | FrameState::Stale | FrameState::Requested)
        );
        self.tissue.said(stamp);
        let is_new = view.last_seq.is_none_or(|last| stamp.seq > last);
        if shows_pose && is_new && stamp.on_request == 0 {
            view.last_seq = Some(stamp.seq);
            view.rendered += 1;
            let stages = [
                stamp.t_publish_ns.saturating_sub(stamp.t_capture_ns),
                stamp.t_seen_ns.saturating_sub(stamp.t_publish_ns),
                stamp.t_rendered_ns.saturating_sub(stamp.t_seen_ns),
                stamp.t_framed_ns.saturating_sub(stamp.t_rendered_ns),
                age,
            ];
            self.latencies.add(stages);
            self.tissue.frame(stamp, age);
        }
    }

    /// The loader has published: for the first time, or the same examination again after a restart.
    pub(crate) fn volume(&mut self, header: VolumeHeader) {
        // Renderers stay with the first examination, and so do the pictures and the report.
        let is_other = |first: &VolumeHeader| first.volume_hash() != header.volume_hash();
        if self.volume.as_ref().is_some_and(is_other) {
            self.foreign_volume = true;
            return;
        }
        self.grid = header.grid().ok();
        self.volume = Some(header);
    }

    /// The volume's identity, as soon as it is known.
    pub(crate) fn volume_hash(&self) -> Option<VolumeHash> {
        self.volume.as_ref().map(VolumeHeader::volume_hash)
    }

    /// The endings of `process` before that of the run, in their order.
    pub(crate) fn endings_of(&self, process: &str) -> impl DoubleEndedIterator<Item = &Restart> {
        self.restarts.iter().filter(move |restart| restart.process == process)
    }

    /// The work of `process` is there again.
    pub(crate) fn live_again(&mut self, process: &str, now_ns: i64) {
        for restart in &mut self.restarts {
            if restart.process == process && restart.live_again_s.is_none() && now_ns > restart.at_ns {
                restart.live_again_s = Some(ms(now_ns - restart.at_ns) / 1e3);
            }
        }
    }

    /// How many samples were the same measurement again and again.
    pub(crate) fn frozen(&self) -> u64 {
        self.accuracy.lost_by(Lost::Frozen)
    }

    /// The percentiles of each stage, and of what no image may have shown.
    pub(crate) fn all_latencies(&self) -> impl Iterator<Item = (&'static str, Latency)> {
        self.latencies().chain([(ALL, self.samples.latency())])
    }

    /// The percentiles of each stage, of what images showed.
    pub(crate) fn latencies(&self) -> impl Iterator<Item = (&'static str, Latency)> {
        STAGES.into_iter().zip(self.latencies.0.iter().map(percentiles))
    }
}

/// Durations, ms: one histogram for each of [`STAGES`], from a microsecond to a quarter of an hour.
#[derive(Debug)]
struct Latencies([Histogram; STAGES.len()]);

impl Default for Latencies {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Histogram::new(1e-3, 1e6)))
    }
}

impl Latencies {
    fn add(&mut self, durations_ns: [i64; STAGES.len()]) {
        for (histogram, ns) in self.0.iter_mut().zip(durations_ns) {
            histogram.add(ms(ns));
        }
    }
}

/// Percentiles by nearest rank, to 1 %; the largest exactly.
fn percentiles(durations_ms: &Histogram) -> Latency {
    Latency {
        p50: durations_ms.quantile(0.50),
        p95: durations_ms.quantile(0.95),
        p99: durations_ms.quantile(0.99),
        max: durations_ms.most(),
        count: durations_ms.count(),
    }
}

#[cfg(test)]
mod tests;
