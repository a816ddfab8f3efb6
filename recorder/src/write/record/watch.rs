//! What happens around the poses: states of the processes, events, changes of tracking.

use bus::message::{Event, Guide, Heartbeat, Level, ToolPose, Tracked, Workflow};
use bus::port::Subscriber;
use bus::topic::{EVENT, GUIDE, HEARTBEAT, WORKFLOW};
use bus::{Bus, BusError};
use scene::Scene;

use crate::wire::proto::{self, Log, ProcessStatus};
use crate::write::pose_log::{Entry, Take};

/// Taken in one turn from one process; more wait for the next.
const EVENTS: usize = 64;
/// Who dials a localizer.
const LOCALIZER: &str = "localizer";

/// A process whose state is followed.
#[derive(Debug)]
struct Followed {
    name: String,
    beats: Subscriber<Heartbeat>,
    /// Its number, its state and its words without their numbers.
    last: Option<(u32, u32, String)>,
}

/// Follows the processes of a run.
#[derive(Debug)]
pub(crate) struct Watch {
    followed: Vec<Followed>,
    /// Of the pilot, and of the process that dials a localizer.
    events: Vec<(&'static str, Subscriber<Event>)>,
    guides: Subscriber<Guide>,
    workflows: Subscriber<Workflow>,
    tracking: Option<u32>,
}

impl Watch {
    /// Subscribes to the processes that `scene` needs.
    pub(crate) fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
        let renderers = scene.renderers();
        let names = renderers.iter().map(|(plane, _)| plane.process());
        let localizer = scene.localizer.is_some().then(|| LOCALIZER.to_owned());
        let names = ["volume-loader".to_owned(), "tracker".to_owned()]
            .into_iter()
            .chain(localizer)
            .chain(names);
        let followed = names.map(|name| {
            Ok(Followed {
                beats: Subscriber::open(bus, &HEARTBEAT, &name, 1)?,
                name,
                last: None,
            })
        });
        let localizer = scene.localizer.is_some().then_some(LOCALIZER);
        let tellers = ["pilot"].into_iter().chain(localizer);
        let events = tellers.map(|name| Ok((name, Subscriber::open(bus, &EVENT, name, EVENT.buffer)?)));
        Ok(Self {
            followed: followed.collect::<Result<_, BusError>>()?,
            events: events.collect::<Result<_, BusError>>()?,
            guides: Subscriber::open(bus, &GUIDE, "", GUIDE.buffer)?,
            workflows: Subscriber::open(bus, &WORKFLOW, "", WORKFLOW.buffer)?,
            tracking: None,
        })
    }

    /// Records what has changed.
    pub(crate) fn step(&mut self, now_ns: i64, series: &mut impl Take) -> Result<(), BusError> {
        for followed in &mut self.followed {
            let Some(beat) = followed.beats.newest()? else { continue };
            if followed.differs(&beat) {
                let status = ProcessStatus::new(&followed.name, &beat);
                series.put(now_ns, Entry::Status(&status));
                let ProcessStatus { state, pid, note, .. } = status;
                let words = format!("{state} (process {pid}): {note}");
                let log = Log::new(beat.t_ns, Level::Info, &followed.name, words);
                series.put(now_ns, Entry::Log(beat.t_ns, &log));
            }
        }
        for (name, events) in &self.events {
            for _ in 0..EVENTS {
                let Some(event) = events.next()? else { break };
                let log = Log::new(event.t_ns, event.level(), name, event.words());
                series.put(now_ns, Entry::Log(event.t_ns, &log));
            }
        }
        self.choices(now_ns, series)
    }

    /// Records what a person chose, and how far the run has come.
    fn choices(&self, now_ns: i64, series: &mut impl Take) -> Result<(), BusError> {
        for _ in 0..EVENTS {
            let Some(guide) = self.guides.next()? else { break };
            series.guide(now_ns, &proto::Guide::from(&guide));
        }
        for _ in 0..EVENTS {
            let Some(workflow) = self.workflows.next()? else { break };
            series.workflow(now_ns, &proto::Workflow::from(&workflow));
        }
        Ok(())
    }

    /// Records that tracking was lost or is back.
    pub(crate) fn pose(&mut self, now_ns: i64, pose: &ToolPose, series: &mut impl Take) {
        if self.tracking.replace(pose.status) == Some(pose.status) {
            return;
        }
        let (level, words) = match pose.tracked() {
            Ok(Tracked::Valid(_)) => (Level::Info, "tracked".to_owned()),
            Ok(Tracked::Lost(reason)) => (Level::Warning, reason.words().to_owned()),
            Err(error) => (Level::Error, error.to_string()),
        };
        let words = format!("from pose {} on: {words}", pose.seq);
        let log = Log::new(pose.t_capture_ns, level, "tracking", words);
        series.put(now_ns, Entry::Log(pose.t_capture_ns, &log));
    }
}

impl Followed {
    /// Whether a sign of life says something else than the one before; numbers in its words grow all the time.
    fn differs(&mut self, beat: &Heartbeat) -> bool {
        let mut words = beat.note_text();
        words.retain(|c| !c.is_ascii_digit() && c != '.');
        let new = Some((beat.pid, beat.state, words));
        let differs = self.last != new;
        self.last = new;
        differs
    }
}
