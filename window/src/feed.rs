//! What has come over the bus, kept until it is shown: images gathered by pose, the newest poses, what people chose.

use std::rc::Rc;

use bus::BusError;
use bus::clock;
use bus::gather::{Gather, PoseId, Set};
use bus::message::{
    FrameHeader, Guide, Heartbeat, Identity, Steps, Timeline, ToolPose, VolumeHash, Workflow, may_be_older_ms,
};
use bus::port::{Frame, VolumeSubscriber};
use bus::run::{ReplayOf, RunContext};
use bus::session::{SIMULATED_START_NS, Session};
use geometry::VolumeGrid;
use scene::Scene;

use crate::model::{Known, Recorded, pose_of, sighted};
use crate::ports::Ports;

/// As many poses as are kept for the sight: four seconds of sixty a second.
const KEPT_POSES: usize = 256;
/// What a localizer said so long ago it says no more: it gives a sign of life ten times a second.
const LOCALIZER_SILENT_NS: i64 = 2_000_000_000;

/// What has come.
#[derive(Debug)]
pub struct Feed {
    gather: Gather<Rc<Frame>>,
    /// Of each view, the image for the pose that was asked for last.
    held: Vec<Option<Rc<Frame>>>,
    poses: Vec<ToolPose>,
    guide: Option<Guide>,
    workflow: Option<Workflow>,
    steps: Option<Steps>,
    timeline: Option<Rc<Timeline>>,
    identity: Option<Identity>,
    volume: Option<(VolumeHash, VolumeGrid)>,
    volumes: VolumeSubscriber,
    recorder: Option<Heartbeat>,
    watcher: Option<Heartbeat>,
    localizer: Option<Heartbeat>,
    /// Chosen to be shown, with how they belong together.
    chosen: Vec<Option<Rc<Frame>>>,
    headers: Vec<Option<FrameHeader>>,
    set: Option<Set>,
}

impl Feed {
    /// Of a run with so many views; `volumes` says which examination it is of.
    pub fn new(views: usize, volumes: VolumeSubscriber) -> Self {
        Self {
            gather: Gather::new(views),
            held: (0..views).map(|_| None).collect(),
            poses: Vec::with_capacity(KEPT_POSES + 1),
            guide: None,
            workflow: None,
            steps: None,
            timeline: None,
            identity: None,
            volume: None,
            volumes,
            recorder: None,
            watcher: None,
            localizer: None,
            chosen: Vec::with_capacity(views),
            headers: Vec::with_capacity(views),
            set: None,
        }
    }

    /// A replay went elsewhere: what came before says nothing of what comes.
    pub fn forget(&mut self) {
        self.gather = Gather::new(self.held.len());
        self.poses.clear();
    }

    /// Takes in what has come.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn take(&mut self, ports: &Ports) -> Result<(), BusError> {
        // What was shown is let go of first, as only so many images may be held.
        self.chosen.clear();
        for (view, port) in ports.views.iter().enumerate() {
            if let Some(frame) = port.newest()? {
                let pose = PoseId::of(&frame.header().stamp);
                self.gather.put(view, pose, Rc::new(frame));
            }
        }
        for (held, port) in self.held.iter_mut().zip(&ports.held) {
            if let Some(frame) = port.newest()? {
                *held = Some(Rc::new(frame));
            }
        }
        while let Some(pose) = ports.poses.next()? {
            if self.poses.len() == KEPT_POSES {
                self.poses.remove(0);
            }
            self.poses.push(pose);
        }
        self.guide = ports.guide.newest()?.or(self.guide);
        self.workflow = ports.workflow.newest()?.or(self.workflow);
        if let Some(steps) = &ports.steps {
            self.steps = steps.newest()?.or(self.steps);
        }
        if let Some(timeline) = &ports.timeline
            && let Some(newest) = timeline.newest()?
        {
            self.timeline = Some(Rc::new(newest));
        }
        self.identity = ports.identity.newest()?.or(self.identity);
        if let Some(recorder) = &ports.recorder {
            self.recorder = recorder.newest()?.or(self.recorder);
        }
        self.watcher = ports.watcher.newest()?.or(self.watcher);
        if let Some(localizer) = &ports.localizer {
            self.localizer = localizer.newest()?.or(self.localizer);
        }
        // The first is the run's: whatever a loader publishes later is shown by nobody.
        if let (None, Some(volume)) = (self.volume, self.volumes.poll()?) {
            self.volume = Some((volume.hash(), *volume.grid()));
        }
        Ok(())
    }

    /// Chooses what is to be shown at `now_ns` on the session's clock; returns how the images belong together.
    pub fn choose(&mut self, now_ns: i64, stale_ns: i64) -> Option<Set> {
        let live = self.gather.decide(now_ns, stale_ns);
        let held = self.guide.and_then(|guide| guide.held());
        self.chosen.clear();
        match held {
            Some(pose) => {
                let of_pose = |frame: &&Rc<Frame>| PoseId::of(&frame.header().stamp) == pose;
                self.chosen
                    .extend(self.held.iter().map(|frame| frame.as_ref().filter(of_pose).cloned()));
                let missing = self.chosen.iter().filter(|frame| frame.is_none()).count();
                self.set = Some(match missing {
                    0 => Set::One(pose),
                    missing => Set::Mixed { poses: 0, missing },
                });
            }
            None => {
                self.chosen.extend(self.gather.frames().map(|frame| frame.cloned()));
                self.set = live;
            }
        }
        self.headers.clear();
        self.headers.extend(
            self.chosen
                .iter()
                .map(|frame| frame.as_ref().map(|frame| *frame.header())),
        );
        self.set
    }

    /// The images chosen, view by view.
    pub fn frames(&self) -> &[Option<Rc<Frame>>] {
        &self.chosen
    }

    /// The pose of the image that the sight is of, or of any image: what is held when a person holds.
    pub fn pose_shown(&self, scene: &Scene) -> Option<ToolPose> {
        let shown = sighted(scene, &self.headers)?;
        self.pose(PoseId::of(&shown.stamp))
    }

    /// The pose that is held, where the image of a view is missing: whoever holds without a screen has none drawn, nor has a recording.
    pub fn held_undrawn(&self) -> Option<ToolPose> {
        let held = self.guide.and_then(|guide| guide.held())?;
        let is_missing = self.chosen.iter().any(Option::is_none);
        self.pose(held).filter(|_| is_missing)
    }

    fn pose(&self, id: PoseId) -> Option<ToolPose> {
        pose_of(&self.poses, id).copied()
    }

    /// The run's examination.
    pub fn volume(&self) -> Option<VolumeHash> {
        self.volume.as_ref().map(|(hash, _)| *hash)
    }

    /// How its voxels lie in the patient; `None` before it is known.
    pub fn grid(&self) -> Option<&VolumeGrid> {
        self.volume.as_ref().map(|(_, grid)| grid)
    }

    /// How far the run has come.
    pub const fn workflow(&self) -> Option<Workflow> {
        self.workflow
    }

    /// What the recording that is replayed holds.
    pub fn timeline(&self) -> Option<&Rc<Timeline>> {
        self.timeline.as_ref()
    }

    /// Where the person stands on her way to it.
    pub const fn steps(&self) -> Option<&Steps> {
        self.steps.as_ref()
    }

    /// The guide as it came last.
    pub fn guide(&self) -> Option<Guide> {
        self.guide
    }

    /// All of it, for a [`Model`](crate::model::Model).
    pub fn known<'a>(
        &'a self,
        scene: &'a Scene,
        session: &Session,
        now: Now,
        replay: Option<&'a ReplayOf>,
    ) -> Known<'a> {
        let recorder = scene.recording.as_ref().map(|_| {
            let age = self.recorder.map_or(0, |beat| now.run_ns.saturating_sub(beat.t_ns));
            (self.recorder, age)
        });
        Known {
            scene,
            now_ns: now.session_ns,
            headers: &self.headers,
            set: self.set,
            poses: &self.poses,
            guide: self.guide,
            workflow: self.workflow,
            steps: self.steps,
            identity: self.identity,
            volume: self.volume(),
            recorder,
            watched_ns: self
                .watcher
                .filter(|beat| beat.t_painted_ns > 0)
                .map(|beat| now.run_ns.saturating_sub(beat.t_painted_ns)),
            may_restart_localizer: self
                .localizer
                .filter(|beat| now.run_ns.saturating_sub(beat.t_ns) <= LOCALIZER_SILENT_NS)
                .is_some_and(|beat| leads_on_by_restart(&beat.note_text())),
            is_replay: session.is_replay(),
            law: session.replay().copied(),
            timeline: self.timeline.as_ref(),
            recorded_in: replay.map(|replay| replay.volume_hash.as_deref().map_or(Recorded::Unknown, Recorded::In)),
            is_simulated: session.is_ruled() && !session.is_replay(),
            began_ns: now.began_ns,
        }
    }
}

/// Whether what a localizer notes is got over by starting it anew: poses that may be older than their stamps, or that it says so.
fn leads_on_by_restart(note: &str) -> bool {
    may_be_older_ms(note).is_some_and(|ms| ms > 0) || note.contains("pilot restart localizer")
}

/// The moment of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Now {
    /// On the session's clock.
    pub session_ns: i64,
    /// On the run's clock, which never stands still.
    pub run_ns: i64,
    /// When the navigation began, on the session's clock.
    pub began_ns: Option<i64>,
}

/// The age at which a pose counts as old, ns.
pub fn stale_ns(scene: &Scene) -> i64 {
    clock::ns(scene.limits.stale)
}

/// When the navigation began, ns on the session's clock: simulated time begins with it, and a replay's clock shows the recorded run's.
pub fn began_ns(run: &RunContext) -> Option<i64> {
    let began_ns = run.began_ns().filter(|_| run.replay.is_none());
    match run.simulated_time {
        true => began_ns.map(|_| SIMULATED_START_NS),
        false => began_ns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a machine that loaded for a minute, REC stood at 00:00:00 for the first minute of simulated time.
    #[test]
    fn simulated_time_begins_with_the_navigation() {
        let folder = tempfile::tempdir().unwrap();
        let mut run = RunContext::new(folder.path(), 0).unwrap();
        assert_eq!(began_ns(&run), None);
        run.begin(60_000_000_000).unwrap();
        assert_eq!(began_ns(&run), Some(60_000_000_000));
        run.simulated_time = true;
        assert_eq!(began_ns(&run), Some(SIMULATED_START_NS));
        run.replay = Some(ReplayOf {
            recording: "s.mcap".into(),
            volume_hash: None,
            tissue_again: false,
        });
        assert_eq!(began_ns(&run), None);
    }
}
