//! The replayer's process: reads the recording, drives the transport, publishes.

mod answer;
mod beside;
mod organs;
mod outlet;
mod place;
mod send;

use std::path::PathBuf;
use std::time::Duration;

use bus::BusError;
use bus::clock::{self, monotonic_ns};
use bus::lockstep::Lockstep;
use bus::message::{ClockLaw, Guide, ProcessState, Timeline, TissueHeader, ToolPose};
use bus::port::{CommandServer, Publisher};
use bus::process::{JoinError, Process};
use bus::topic::{GROUND_TRUTH, GUIDE, SESSION_CLOCK, TIMELINE, TISSUE_ASKED};

use super::Speed;
use super::choices::Choices;
use super::images::{Images, ImagesError};
use super::lead::Judge;
use super::moment::Moments;
use super::tape::{Delivery, Tape};
use super::timing::Timing;
use super::transport::{Act, Control, Transport};
use crate::read::damage::OpenError;
use crate::replay::account::AccountError;
use crate::report::basis::Limits;
use beside::Reading;
use organs::Organs;
use outlet::{Outlet, UsOutlet};

/// The name of this process on the bus.
pub const NAME: &str = "replay";

/// Looks for requests at least this often, and gives late joiners the clock and the newest pose.
const LOOK_UP: Duration = Duration::from_millis(10);
/// While the images of a pose are awaited.
const NEXT_LOOK: Duration = Duration::from_micros(100);
/// A sleep ends late by some tens of microseconds: the last of a wait is spent awake.
const AWAKE: Duration = Duration::from_micros(150);

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The recording.
    pub recording: PathBuf,
    /// The first and the last moment, ns on the recorded run's clock.
    pub span_ns: [i64; 2],
    /// Where to begin: `span_ns[0]`, or later for a process that takes up the work of one that died.
    pub begin_ns: i64,
    /// The zero of the places that a person names, ns on the recorded run's clock.
    pub zero_ns: i64,
    /// How fast.
    pub speed: Speed,
    /// Again and again.
    pub looping: bool,
    /// Also in another examination than the recorded one: every image says so.
    pub force: bool,
    /// The frames of the localizer in place of the poses: the run's tracker makes those of them again.
    pub frames: Option<Delivery>,
    /// Pictures into this folder, of every so many poses.
    pub images: Option<(PathBuf, u64)>,
    /// Moments that are asked for go into this folder.
    pub moments: Option<PathBuf>,
    /// What the recording holds over its time is read and told.
    pub has_timeline: bool,
    /// What came of it goes here, as JSON.
    pub account: Option<PathBuf>,
}

/// Why a replay does not go on.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The recording cannot be read.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The pictures.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// The account of it.
    #[error(transparent)]
    Account(#[from] AccountError),
    /// The run is not a replay.
    #[error(
        "run {0:?} is not a replay: it has a tracker of its own. `pilot replay FILE` starts a run that this process joins"
    )]
    NotAReplay(String),
    /// Another examination.
    #[error(
        "{recording} was recorded in examination {recorded}, and this run has loaded {loaded}: tube and anatomy would not \
         belong together. Give the recorded one with `--volume PATH`; with `--force` it is replayed all the same, and every \
         image says so"
    )]
    OtherVolume {
        /// The recording.
        recording: PathBuf,
        /// The hash of the examination that was navigated in.
        recorded: String,
        /// The hash of the one that is loaded.
        loaded: String,
    },
}

/// A replay that is going.
struct Replayer<'a> {
    options: &'a Options,
    transport: Transport,
    tape: Tape,
    outlet: Outlet,
    truths: Publisher<ToolPose>,
    images_of_probe: UsOutlet,
    /// Where the recording says where organs were.
    organs: Option<Organs>,
    /// Where a model answers poses again: which ones.
    asked: Option<Publisher<TissueHeader>>,
    guides: Publisher<Guide>,
    choices: Choices,
    /// What cannot be read of the choices.
    unread: Vec<String>,
    laws: Publisher<ClockLaw>,
    /// Where a window shows a bar.
    timelines: Option<Publisher<Timeline>>,
    beside: Option<Reading>,
    /// Opened when the first is asked for.
    moments: Option<Moments>,
    /// The examination that is shown.
    shown_volume: String,
    told: Option<ClockLaw>,
    lockstep: Lockstep,
    images: Option<Images>,
    /// For how long a measurement may stand still, ns.
    frozen_ns: Option<i64>,
    /// What is shown is judged as the views judge it.
    judge: Judge,
    /// When the first pose was published of which the judge knows for how long its measurement had stood still.
    judged_from_ns: i64,
    /// A pose that is drawn and not yet pictured.
    unpictured: Option<ToolPose>,
    timing: Timing,
    published: u64,
    without_frames: u64,
    without_state: u64,
    unanswered: u64,
    /// When something was published last, on the machine's clock.
    published_ns: i64,
    last: Option<ToolPose>,
    began_ns: i64,
    next_look_ns: i64,
    /// What was told of what cannot be read.
    said: Vec<String>,
}

/// Replays until the process is asked to stop.
///
/// # Errors
/// Each variant of [`ReplayError`].
pub fn replay(process: &mut Process, options: &Options) -> Result<(), ReplayError> {
    let Some(shown_volume) = examined(process, options)? else {
        return Ok(());
    };
    let server = CommandServer::open(&process.bus, NAME)?;
    let mut replayer = Replayer::open(process, options, shown_volume)?;
    while !process.stop.is_set() {
        // One a turn: who asks again and again does not keep the poses from going out.
        if let Some(request) = server.next()? {
            replayer.answer(request, process)?;
        }
        replayer.turn(process)?;
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    replayer.write_account()
}

/// Waits for the volume and holds it against the recorded one; its hash, or `None` where the process was stopped meanwhile.
fn examined(process: &mut Process, options: &Options) -> Result<Option<String>, ReplayError> {
    let Some(replay) = process.run.replay.clone() else {
        return Err(ReplayError::NotAReplay(process.run.name.clone()));
    };
    let volumes = process.volumes()?;
    while !process.stop.is_set() {
        process.beat(ProcessState::Starting, "waiting for the volume")?;
        let Some(volume) = volumes.poll()? else {
            std::thread::sleep(LOOK_UP);
            continue;
        };
        let loaded = volume.hash().to_string();
        return match replay.volume_hash {
            Some(recorded) if recorded != loaded && !options.force => Err(ReplayError::OtherVolume {
                recording: options.recording.clone(),
                recorded,
                loaded,
            }),
            _ => Ok(Some(loaded)),
        };
    }
    Ok(None)
}

impl<'a> Replayer<'a> {
    fn open(process: &Process, options: &'a Options, shown_volume: String) -> Result<Self, ReplayError> {
        let bus = &process.bus;
        let mut transport = Transport::new(options.span_ns, options.zero_ns, options.speed, options.looping);
        if options.begin_ns > options.span_ns[0] {
            transport.control(Control::Seek(options.begin_ns), monotonic_ns());
        }
        let tape = match options.frames {
            Some(delivery) => Tape::with_frames(&options.recording, delivery)?,
            None => Tape::open(&options.recording)?,
        };
        let mut found = tape.session().guides()?;
        let is_answered = process.run.replay.as_ref().is_some_and(|replay| replay.tissue_again);
        let organs = match options.frames {
            None if process.scene.tissue.is_some() && !is_answered => {
                Organs::open(bus, tape.session(), &mut found.unread)?
            }
            _ => None,
        };
        let images = options.images.as_ref();
        let images = images.map(|(folder, every)| Images::open(bus, &process.scene, folder, *every));
        Ok(Self {
            options,
            transport,
            tape,
            outlet: Outlet::open(bus, options.frames)?,
            truths: Publisher::open(bus, &GROUND_TRUTH, "")?,
            images_of_probe: UsOutlet::default(),
            organs,
            asked: is_answered
                .then(|| Publisher::open(bus, &TISSUE_ASKED, ""))
                .transpose()?,
            guides: Publisher::open(bus, &GUIDE, "")?,
            choices: Choices::new(found.messages),
            unread: found.unread,
            laws: Publisher::open(bus, &SESSION_CLOCK, "")?,
            timelines: match options.has_timeline {
                true => Some(Publisher::open(bus, &TIMELINE, "")?),
                false => None,
            },
            beside: None,
            moments: None,
            shown_volume,
            told: None,
            lockstep: Lockstep::open(bus, &process.scene, options.frames.is_some())?,
            images: images.transpose()?,
            frozen_ns: Limits::of(&process.scene).frozen_ns,
            judge: Judge::default(),
            judged_from_ns: i64::MIN,
            unpictured: None,
            timing: Timing::default(),
            published: 0,
            without_frames: 0,
            without_state: 0,
            unanswered: 0,
            published_ns: 0,
            last: None,
            began_ns: monotonic_ns(),
            next_look_ns: 0,
            said: Vec::new(),
        })
    }

    /// Once round.
    fn turn(&mut self, process: &mut Process) -> Result<(), ReplayError> {
        self.look_up(process)?;
        if !self.lockstep.is_drawn()? {
            std::thread::sleep(NEXT_LOOK);
            self.lose_patience();
            return Ok(());
        }
        self.picture(process)?;
        let was = self.transport.state();
        let act = self
            .transport
            .next(self.tape.peek().map(super::tape::Moment::due_ns), monotonic_ns());
        self.tell()?;
        match act {
            Act::Publish => self.publish(process)?,
            Act::Sleep(until_ns) => self.sleep(until_ns),
            Act::Find(at_ns) => self.find(at_ns, process)?,
            Act::Idle if was != self.transport.state() => self.write_account()?,
            Act::Idle => std::thread::sleep(LOOK_UP),
        }
        process.counters.published = self.published;
        Ok(())
    }

    /// Signs of life, and what those are due who came late.
    fn look_up(&mut self, process: &mut Process) -> Result<(), ReplayError> {
        process.beat(ProcessState::Ready, &self.note())?;
        let now = monotonic_ns();
        if now >= self.next_look_ns {
            self.next_look_ns = now + clock::ns(LOOK_UP);
            self.read_beside(now, Limits::of(&process.scene));
            self.say_unread();
            self.laws.serve_late_joiners();
            // Before the poses that they are of.
            self.organs.iter().for_each(Organs::serve_late_joiners);
            self.asked.iter().for_each(Publisher::serve_late_joiners);
            self.outlet.serve_late_joiners();
            self.guides.serve_late_joiners();
            self.tell_timeline()?;
            // Also while no pose comes.
            self.choose(self.transport.law().at(now))?;
        }
        Ok(())
    }

    fn sleep(&self, until_ns: i64) {
        let now = monotonic_ns();
        let asleep_ns = until_ns.saturating_sub(now).saturating_sub(clock::ns(AWAKE));
        if let Ok(asleep_ns) = u64::try_from(asleep_ns) {
            std::thread::sleep(Duration::from_nanos(asleep_ns).min(LOOK_UP));
            return;
        }
        while monotonic_ns() < until_ns {
            std::hint::spin_loop();
        }
    }
}
