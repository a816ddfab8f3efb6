//! The replayer's process: reads the recording, drives the transport, publishes.

use std::path::PathBuf;
use std::time::Duration;

use bus::BusError;
use bus::clock::{self, monotonic_ns};
use bus::message::{ClockLaw, Command, CommandKind, ProcessState, ReplayState, ToolPose};
use bus::port::{CommandServer, Publisher, Request, VolumeSubscriber};
use bus::process::{JoinError, Process};
use bus::topic::{GROUND_TRUTH, SESSION_CLOCK, TOOL_POSE};

use super::Speed;
use super::images::{Images, ImagesError};
use super::lockstep::Lockstep;
use super::tape::Tape;
use super::timing::Timing;
use super::transport::{Act, Control, Transport};
use crate::damage::OpenError;
use crate::replay::account::{Account, AccountError};

/// The name of this process on the bus.
pub const NAME: &str = "replay";

/// Looks for requests at least this often, and gives late joiners the clock and the newest pose.
const LOOK_UP: Duration = Duration::from_millis(10);
/// While the images of a pose are awaited.
const NEXT_LOOK: Duration = Duration::from_micros(100);
/// A sleep ends late by some tens of microseconds: the last of a wait is spent awake.
const AWAKE: Duration = Duration::from_micros(150);
/// Poses passed over between two signs of life.
const PASSED: usize = 4096;

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
    /// Pictures into this folder, of every so many poses.
    pub images: Option<(PathBuf, u64)>,
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
    poses: Publisher<ToolPose>,
    truths: Publisher<ToolPose>,
    laws: Publisher<ClockLaw>,
    told: Option<ClockLaw>,
    lockstep: Lockstep,
    images: Option<Images>,
    /// A pose that is drawn and not yet pictured.
    unpictured: Option<ToolPose>,
    timing: Timing,
    published: u64,
    last: Option<ToolPose>,
    began_ns: i64,
    next_look_ns: i64,
}

/// Replays until the process is asked to stop.
///
/// # Errors
/// Each variant of [`ReplayError`].
pub fn replay(process: &mut Process, options: &Options) -> Result<(), ReplayError> {
    if !examined(process, options)? {
        return Ok(());
    }
    let server = CommandServer::open(&process.bus, NAME)?;
    let mut replayer = Replayer::open(process, options)?;
    while !process.stop.is_set() {
        while let Some(request) = server.next()? {
            replayer.answer(request)?;
        }
        replayer.turn(process)?;
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    replayer.write_account()
}

/// Waits for the volume and holds it against the recorded one; `false` where the process was stopped meanwhile.
fn examined(process: &mut Process, options: &Options) -> Result<bool, ReplayError> {
    let Some(replay) = process.run.replay.clone() else {
        return Err(ReplayError::NotAReplay(process.run.name.clone()));
    };
    let volumes = VolumeSubscriber::open(&process.bus)?;
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
            _ => Ok(true),
        };
    }
    Ok(false)
}

impl<'a> Replayer<'a> {
    fn open(process: &Process, options: &'a Options) -> Result<Self, ReplayError> {
        let bus = &process.bus;
        let mut transport = Transport::new(options.span_ns, options.speed, options.looping);
        if options.begin_ns > options.span_ns[0] {
            transport.control(Control::Seek(options.begin_ns), monotonic_ns());
        }
        let images = options.images.as_ref();
        let images = images.map(|(folder, every)| Images::open(bus, &process.scene, folder, *every));
        Ok(Self {
            options,
            transport,
            tape: Tape::open(&options.recording)?,
            poses: Publisher::open(bus, &TOOL_POSE, "")?,
            truths: Publisher::open(bus, &GROUND_TRUTH, "")?,
            laws: Publisher::open(bus, &SESSION_CLOCK, "")?,
            told: None,
            lockstep: Lockstep::open(bus, &process.scene)?,
            images: images.transpose()?,
            unpictured: None,
            timing: Timing::default(),
            published: 0,
            last: None,
            began_ns: monotonic_ns(),
            next_look_ns: 0,
        })
    }

    /// Once round.
    fn turn(&mut self, process: &mut Process) -> Result<(), ReplayError> {
        self.look_up(process)?;
        if !self.lockstep.is_drawn()? {
            std::thread::sleep(NEXT_LOOK);
            return Ok(());
        }
        self.picture(process)?;
        let was = self.transport.state();
        let act = self
            .transport
            .next(self.tape.peek().map(super::tape::Moment::due_ns), monotonic_ns());
        self.tell()?;
        match act {
            Act::Publish => self.publish()?,
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
            self.laws.serve_late_joiners();
            self.poses.serve_late_joiners();
        }
        Ok(())
    }

    /// Everybody must know the clock before the pose that it holds for.
    fn tell(&mut self) -> Result<(), BusError> {
        let law = self.transport.message();
        if self.told != Some(law) {
            self.laws.send(law)?;
            self.told = Some(law);
        }
        Ok(())
    }

    fn publish(&mut self) -> Result<(), ReplayError> {
        let Some(moment) = self.tape.take() else { return Ok(()) };
        let waits = self.transport.speed() == Speed::Max || self.transport.state() == ReplayState::Paused;
        if waits {
            self.lockstep.expect(&moment.pose)?;
            self.unpictured = Some(moment.pose);
        } else if let Some(when) = self.transport.law().when(moment.due_ns()) {
            self.timing.saw(monotonic_ns().saturating_sub(when));
        }
        self.poses.send(moment.pose)?;
        for truth in &moment.truths {
            self.truths.send(*truth)?;
        }
        self.published += 1;
        self.last = Some(moment.pose);
        Ok(())
    }

    /// Pictures are taken of poses that every view has drawn.
    fn picture(&mut self, process: &mut Process) -> Result<(), ReplayError> {
        let (Some(pose), Some(images)) = (self.unpictured.take(), &mut self.images) else {
            return Ok(());
        };
        images.pose(&pose, &mut || process.beat(ProcessState::Ready, "taking pictures"))?;
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

    /// Goes to the first pose that is due at `at_ns` or later.
    fn find(&mut self, at_ns: i64, process: &mut Process) -> Result<(), ReplayError> {
        self.lockstep.forget();
        self.unpictured = None;
        if self.tape.peek().is_none_or(|next| next.due_ns() > at_ns) {
            self.tape.rewind()?;
        }
        let mut passed = 0_usize;
        while self.tape.peek().is_some_and(|next| next.due_ns() < at_ns) && !process.stop.is_set() {
            self.tape.take();
            passed += 1;
            if passed.is_multiple_of(PASSED) {
                process.beat(ProcessState::Ready, "looking for the place in the recording")?;
            }
        }
        // The time that it took is not part of the replay.
        self.transport.found(at_ns, monotonic_ns());
        self.tell()?;
        Ok(())
    }

    fn answer(&mut self, request: Request) -> Result<(), ReplayError> {
        let command: Command = *request.command();
        match self.control(&command) {
            Ok(control) => {
                if matches!(control, Control::Seek(_)) {
                    self.lockstep.forget();
                }
                self.transport.control(control, monotonic_ns());
                self.tell()?;
                request.reply(Ok(&self.note()))?;
            }
            Err(why) => request.reply(Err(&why))?,
        }
        Ok(())
    }

    fn control(&self, command: &Command) -> Result<Control, String> {
        match command.command_kind() {
            Some(CommandKind::Pause) => Ok(Control::Pause),
            Some(CommandKind::Play) => Ok(Control::Play),
            Some(CommandKind::Step) => Ok(Control::Step),
            Some(CommandKind::Speed) => Speed::from_number(command.number).map(Control::Speed),
            Some(CommandKind::Seek) => {
                let last_s = self.seconds(self.options.span_ns[1]);
                let first_s = self.seconds(self.options.span_ns[0]);
                if !(first_s..=last_s).contains(&command.number) {
                    return Err(format!(
                        "there is no place {} s in this replay: it goes from {first_s:.3} s to {last_s:.3} s",
                        command.number
                    ));
                }
                Ok(Control::Seek(
                    self.options.zero_ns.saturating_add(clock::seconds(command.number)),
                ))
            }
            _ => Err("the replayer answers pause, play, step, seek and speed".to_owned()),
        }
    }

    /// A moment as people name it.
    fn seconds(&self, moment_ns: i64) -> f64 {
        clock::ms(moment_ns.saturating_sub(self.options.zero_ns)) / 1e3
    }

    /// Where the replay stands, for people.
    fn note(&self) -> String {
        let place = self.last.map_or(self.options.span_ns[0], |pose| pose.t_publish_ns);
        let pose = self.last.map_or("-".to_owned(), |pose| pose.seq.to_string());
        let (place, end) = (self.seconds(place), self.seconds(self.options.span_ns[1]));
        let state = self.transport.state().word();
        let waits = self.lockstep.missing().map(|name| format!(", for {name}"));
        let waits = waits.unwrap_or_default();
        format!(
            "pose {pose}, {place:.2} of {end:.2} s, {state}, speed {}{waits}",
            self.transport.speed()
        )
    }

    fn write_account(&self) -> Result<(), ReplayError> {
        let Some(path) = &self.options.account else {
            return Ok(());
        };
        let account = Account {
            recording: self.options.recording.display().to_string(),
            speed: self.transport.speed().to_string(),
            state: self.transport.state().word(),
            from_s: self.seconds(self.options.span_ns[0]),
            to_s: self.seconds(self.options.span_ns[1]),
            published: self.published,
            wall_s: clock::ms(monotonic_ns() - self.began_ns) / 1e3,
            lateness: self.timing.lateness(),
            images: self.images.as_ref().map_or(0, |images| images.written),
            images_missing: self.images.as_ref().map_or(0, |images| images.missing),
            images_reason: self
                .images
                .as_ref()
                .map(|images| images.reason.clone())
                .unwrap_or_default(),
        };
        Ok(account.write(path)?)
    }
}
