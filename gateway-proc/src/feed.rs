//! From the bus to the clients: a thread that takes poses, markers, words and images, and never waits for a client.

mod images;
mod markers;
mod priority;
mod times;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

use bus::clock;
use bus::life::LifeLine;
use bus::message::{Ages, Guide, MarkerFrame, ToolPose, Workflow};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::session::{Lead, Session};
use bus::topic::{GUIDE, MARKERS, TOOL_POSE, WORKFLOW};
use bus::wake::Waits;
use bus::{Bus, BusError};
use igtl::Stamp;
use scene::Scene;

use crate::client::Known;
use crate::hall::{Hall, Kept};
use crate::mailbox::Slot;
use crate::points::points;
use crate::standing::{Follower, Remark, Rules, Standing};
use crate::tell::{Told, stage, status, string, tdata, words};
use images::Images;
use markers::Markers;
use times::Times;

/// Poses that wait at most while the thread is elsewhere; the newest is what counts.
const ROOM: usize = 64;
/// So soon a pose that has grown old is told as such.
const TICK: Duration = Duration::from_millis(10);
/// Between two heart-beats, ns.
const BEAT_NS: i64 = 500_000_000;
/// Why nothing is said of markers any more.
const ENDED: &str = "ENDED: the run has ended";
/// Between two alarms, ns: a source that gives one after the other is told of once.
const ALARM_NS: i64 = 200_000_000;

/// The thread's ends of the topics, and what it has made of them.
struct Feed {
    hall: Arc<Hall>,
    known: Arc<Known>,
    scene: Scene,
    session: Session,
    times: Times,
    follower: Follower,
    guides: Subscriber<Guide>,
    workflows: Subscriber<Workflow>,
    markers: Option<Markers>,
    images: Images,
    /// The places that a replay went to.
    places: Lead,
    /// Poses are written by this thread itself.
    is_at_once: bool,
    /// What was told last of the tool.
    told: Option<(Standing, String)>,
    stage: String,
    next_beat_ns: i64,
    next_alarm_ns: i64,
    /// Points were said.
    has_points: bool,
    // The bus goes last.
    _bus: Bus,
}

/// What one such thread needs.
pub(crate) struct Needs {
    pub(crate) run: RunContext,
    pub(crate) scene: Scene,
    pub(crate) life: LifeLine,
    pub(crate) hall: Arc<Hall>,
    pub(crate) known: Arc<Known>,
}

/// Follows the run until the process is to stop. Says through `opened` that all topics are open.
///
/// # Errors
/// [`BusError`].
pub(crate) fn follow(needs: Needs, opened: &Sender<()>) -> Result<(), BusError> {
    let bus = Bus::join_with(&needs.run, needs.life)?;
    let poses: Subscriber<ToolPose> = Subscriber::open_waking(&bus, &TOOL_POSE, "", ROOM)?;
    let frames: Option<Subscriber<MarkerFrame>> = needs
        .known
        .has_markers
        .then(|| Subscriber::open_waking(&bus, &MARKERS, "", ROOM))
        .transpose()?;
    let stop = needs.known.stop.clone();
    let mut feed = Feed::open(bus, needs)?;
    // Nobody waits for this where the process has failed meanwhile.
    let _ = opened.send(());
    let mut waits = Waits::every(TICK).message(&poses, None);
    if let Some(frames) = &frames {
        waits = waits.message(frames, None);
    }
    waits.run(|| {
        if stop.is_set() {
            feed.say_goodbye();
            return ControlFlow::Break(Ok(()));
        }
        match feed.step(&poses, frames.as_ref()) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => ControlFlow::Break(Err(error)),
        }
    })?
}

impl Feed {
    fn open(bus: Bus, needs: Needs) -> Result<Self, BusError> {
        let Needs {
            run,
            scene,
            hall,
            known,
            ..
        } = needs;
        let limits = &scene.limits;
        let rules = Rules {
            ages: Ages::of(limits),
            // In a replay too, as the images do.
            frozen_ns: scene.frozen().map(clock::ns),
        };
        let times = Times {
            epoch_ns: run.epoch_ns,
            stale_ns: clock::ns(limits.stale),
            is_present: known.origin.is_present(),
        };
        let mut feed = Self {
            session: Session::open(&bus, &run)?,
            guides: Subscriber::open(&bus, &GUIDE, "", GUIDE.buffer)?,
            workflows: Subscriber::open(&bus, &WORKFLOW, "", 1)?,
            markers: known.has_markers.then(|| Markers::new(clock::ns(limits.frozen))),
            images: Images::open(&bus, &scene, &known)?,
            follower: Follower::new(rules),
            times,
            hall,
            known,
            scene,
            places: Lead::default(),
            is_at_once: priority::is_real_time(),
            told: None,
            stage: String::new(),
            next_beat_ns: i64::MIN,
            next_alarm_ns: i64::MIN,
            has_points: false,
            _bus: bus,
        };
        feed.say_points(None);
        Ok(feed)
    }

    fn step(&mut self, poses: &Subscriber<ToolPose>, frames: Option<&Subscriber<MarkerFrame>>) -> Result<(), BusError> {
        let mut is_news = self.take_words()?;
        let came = self.take_poses(poses)?;
        let now_ns = self.session.clock().now_ns();
        // The session's clock may stand still; beats go by one that does not.
        let steady_ns = clock::monotonic_ns();
        let is_beat = steady_ns >= self.next_beat_ns;
        if is_beat {
            self.next_beat_ns = steady_ns.saturating_add(BEAT_NS);
            self.is_at_once = priority::is_real_time();
        }
        let markers = self.take_markers(frames, now_ns, is_beat)?;
        is_news |= markers;
        is_news |= self.tell_tool((came, markers), is_beat, now_ns);
        let withheld = self.follower.withheld();
        self.images
            .step(&self.hall, (now_ns, steady_ns), withheld, self.times)?;
        if is_news {
            self.hall.ring();
        }
        Ok(())
    }

    /// The C++ library 1.11 reads no POINT without points: it is sent only where there were some before.
    fn say_points(&mut self, guide: Option<&Guide>) {
        let (letter, is_empty) = points(&self.scene.targets, guide);
        if !is_empty || self.has_points {
            self.hall.say(Some(Kept::Points), letter);
        }
        self.has_points |= !is_empty;
    }

    /// What a person chose, and how far the run has come.
    fn take_words(&mut self) -> Result<bool, BusError> {
        let mut is_news = false;
        if let Some(guide) = self.guides.newest()? {
            self.say_points(Some(&guide));
            is_news = true;
        }
        if let Some(workflow) = self.workflows.newest()? {
            let stage = stage(&workflow, self.known.origin);
            if stage != self.stage {
                self.hall
                    .say(Some(Kept::Workflow), string("Workflow", &stage, Stamp::NONE));
                self.stage = stage;
                is_news = true;
            }
            let is_rejected = workflow.has(Workflow::REJECTED);
            self.hall
                .withhold(is_rejected.then_some("the examination is said not to be the patient's"));
            self.follower.take_workflow(workflow);
        }
        Ok(is_news)
    }

    /// Judges every pose that came; whether one did.
    fn take_poses(&mut self, poses: &Subscriber<ToolPose>) -> Result<bool, BusError> {
        let mut samples = Vec::new();
        while let Some(sample) = poses.next()? {
            samples.push(sample);
        }
        // After the poses were taken: a replayer has said before them what time it is.
        if self.session.follow()? {
            self.follower.forget();
            self.places.jumped();
            samples.retain(|sample| !self.session.is_yet_to_come(sample.t_publish_ns));
        }
        let mut came = false;
        for sample in &samples {
            if self.places.is_before_the_place(&self.session, sample.t_publish_ns) {
                self.follower.lead(*sample);
                continue;
            }
            self.places.came();
            came = true;
            let now_ns = self.session.clock().now_ns();
            for remark in self.follower.take(*sample, now_ns) {
                self.alarm(&remark);
            }
        }
        Ok(came)
    }

    /// The last that clients are told: who keeps what was sent last, and few do otherwise, must not keep a pose.
    fn say_goodbye(&mut self) {
        let origin = self.known.origin;
        let stamp = self.times.stamp(self.session.clock().now_ns());
        self.hall.claim.set(i64::MIN);
        let told = Told::tool(origin, &Standing::Ended, None, self.follower.workflow()).at(stamp, None);
        let all: Vec<Told> = std::iter::once(told)
            .chain(
                self.markers
                    .iter()
                    .flat_map(|_| Told::markers(&MarkerFrame::EMPTY, Some(ENDED))),
            )
            .collect();
        self.hall.put(Slot::Tdata, tdata(all.clone(), origin));
        let slots = [Slot::Tool, Slot::ToolMarker, Slot::ReferenceMarker];
        for (slot, told) in slots.into_iter().zip(all) {
            self.hall.put(slot, told.at(stamp, None).transform());
        }
        let said = words(&Standing::Ended, origin, self.follower.workflow());
        self.hall
            .put(Slot::Status, status(&Standing::Ended, origin, &said, stamp));
        self.hall.set_state(&said);
        self.hall.say(Some(Kept::State), string("State", &said, stamp));
        self.hall.end();
    }

    fn alarm(&mut self, remark: &Remark) {
        let steady_ns = clock::monotonic_ns();
        let is_due = steady_ns >= self.next_alarm_ns || matches!(remark, Remark::Registration { .. });
        if is_due {
            self.next_alarm_ns = steady_ns.saturating_add(ALARM_NS);
            self.hall.say(None, string("Alarm", &remark.to_string(), Stamp::NONE));
        }
    }

    fn take_markers(
        &mut self,
        frames: Option<&Subscriber<MarkerFrame>>,
        now_ns: i64,
        is_beat: bool,
    ) -> Result<bool, BusError> {
        let (Some(frames), Some(markers)) = (frames, &mut self.markers) else {
            return Ok(false);
        };
        while let Some(frame) = frames.next()? {
            markers.take(frame, now_ns);
        }
        let is_news = markers.step(now_ns, self.times, is_beat);
        if is_news {
            for (slot, told) in [Slot::ToolMarker, Slot::ReferenceMarker]
                .into_iter()
                .zip(markers.told())
            {
                self.hall.put(slot, told.transform());
            }
        }
        Ok(is_news)
    }

    /// Says how the tool is where that is news; whether there is more to be said than a pose.
    fn tell_tool(&mut self, (came, has_markers): (bool, bool), is_beat: bool, now_ns: i64) -> bool {
        let standing = self.follower.standing(now_ns);
        let origin = self.known.origin;
        let is_other = self.told.as_ref().is_none_or(|(told, _)| !told.says_as(&standing));
        let is_valid = matches!(standing, Standing::Valid(_));
        // A pose is sent once; that there is none is said again and again, as silence is taken for validity.
        let is_due = came || is_other || (is_beat && !is_valid);
        let sample = self.follower.sample();
        let workflow = self.follower.workflow();
        let captured_ns = sample.map_or(now_ns, |sample| sample.t_capture_ns);
        let pose_stamp = self.times.stamp(captured_ns);
        let until_ns = self.times.until_ns(captured_ns);
        // Before anybody is told: what claimed another pose holds for this one, or for none.
        self.hall.claim.set(if is_valid {
            until_ns.unwrap_or(i64::MAX)
        } else {
            i64::MIN
        });
        if is_due || has_markers {
            let stamp = if is_valid { pose_stamp } else { self.times.stamp(now_ns) };
            let told = Told::tool(origin, &standing, sample, workflow).at(stamp, until_ns);
            if is_due {
                // Now: whatever else is to be said can wait, and a pose cannot.
                let at_once = self.is_at_once.then(clock::monotonic_ns);
                self.hall.post(Slot::Tool, told.transform(), at_once);
            }
            // Of a frame whose pose is to come, the tools are told with it.
            if is_due || !is_valid {
                let beside = |markers: &Markers| match is_valid {
                    true => markers.of_moment(captured_ns),
                    false => markers.told(),
                };
                let markers = self.markers.iter().flat_map(beside);
                let all: Vec<Told> = std::iter::once(told).chain(markers).collect();
                self.hall.put(Slot::Tdata, tdata(all, origin));
                self.hall.ring_streams();
            }
        }
        let is_told = self.tell_status(standing, is_beat, now_ns);
        has_markers || is_told
    }

    /// Says the same in words where they are others, and as the heart-beat; whether anything was said.
    fn tell_status(&mut self, standing: Standing, is_beat: bool, now_ns: i64) -> bool {
        let origin = self.known.origin;
        let said = words(&standing, origin, self.follower.workflow());
        let is_new = self.told.as_ref().is_none_or(|(_, before)| *before != said);
        if is_new || is_beat {
            let claim = matches!(standing, Standing::Valid(_)).then(|| self.hall.claim.clone());
            let stamp = self.times.stamp(now_ns);
            let beat = status(&standing, origin, &said, stamp).claiming(claim.clone());
            self.hall.put(Slot::Status, beat);
            if is_new {
                self.hall.set_state(&said);
                let state = string("State", &said, stamp).claiming(claim);
                self.hall.say(Some(Kept::State), state);
            }
        }
        self.told = Some((standing, said));
        is_new || is_beat
    }
}
