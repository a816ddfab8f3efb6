//! `remote-proc send`: shows a run of this machine to others.
//!
//! It reads the run's bus as any other program may, and publishes nothing there: no query and no message from outside can come to it.
//! Voxels are answered for on a thread of their own, so that a slow receiver's examination never holds up a pose.

mod answers;
mod examination;
mod organs;
mod outlets;
mod voxels;

use std::mem::ManuallyDrop;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

use bus::clock::{self, monotonic_ns};
use bus::message::{TissueHeader, ToolPose, Wire};
use bus::port::{HeadedSubscriber, Subscriber};
use bus::process::{JoinError, StopFlag};
use bus::run::{RunContext, RunError, run_dir};
use bus::topic::{TISSUE, TOOL_POSE};
use bus::wake::Waits;
use bus::{Bus, BusError};
use scene::{Scene, SceneError};

use crate::linger::let_go_at_once;
use crate::protocol::{Channel, Facts, VERSION, hex, payloads};
use crate::session::{Opened, SessionError};
use answers::Answers;
use examination::Shown;
use outlets::{Outlets, States};

/// Between two looks at what wakes nobody.
const TICK: Duration = Duration::from_millis(20);
/// Between two looks whether the run still goes on.
const LOOK: Duration = Duration::from_millis(500);

/// What is shown, and where.
#[derive(Debug, Clone)]
pub struct Sending {
    /// The run.
    pub run: String,
    /// Where receivers come.
    pub listen: String,
    /// The folder with the sender's keys.
    pub keys: Option<PathBuf>,
}

/// Why nothing is sent, or not any longer.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    /// There is no such run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Its scene.
    #[error("the run's scene: {0}")]
    Scene(#[from] SceneError),
    /// Signals.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The link.
    #[error(transparent)]
    Link(#[from] SessionError),
    /// Its poses are none of the present.
    #[error("run {run:?} is {what}: only a run that navigates on this machine is shown on another; {instead}")]
    NotLive {
        /// The run.
        run: String,
        /// What it is.
        what: &'static str,
        /// What to do.
        instead: &'static str,
    },
}

/// Shows the run until it ends or this process is asked to stop.
///
/// # Errors
/// Each variant of [`SendError`].
pub fn send(sending: &Sending) -> Result<(), SendError> {
    let (run, text) = RunContext::load_with_scene(&run_dir(&sending.run)?, None)?;
    live(&run)?;
    let scene = Scene::parse(&text, &run.scene_path())?;
    let stop = StopFlag::install(false)?;
    let bus = Bus::join(&run)?;
    let arriving = Arriving::open(&bus, &scene)?;
    let link = crate::session::listen(&sending.listen, sending.keys.as_deref())?;
    let mut sender = Sender::open(&bus, &scene, (&run, &text), link)?;
    bus::stderr_line!(
        "remote-proc: run {:?} is shown to who comes to {}",
        run.name,
        sending.listen
    );
    let waits = Waits::every(TICK).message(&arriving.poses, None);
    let waits = arriving.states.iter().fold(waits, Waits::headed);
    waits.run(|| {
        if stop.is_set() {
            return ControlFlow::Break(Ok(()));
        }
        match sender.step(&arriving, &run) {
            Ok(true) => ControlFlow::Continue(()),
            Ok(false) => ControlFlow::Break(Ok(())),
            Err(error) => ControlFlow::Break(Err(error)),
        }
    })?
}

fn live(run: &RunContext) -> Result<(), SendError> {
    let (what, instead) = match (&run.replay, &run.remote) {
        (Some(_), _) => ("a replay", "copy the recording, and replay it there"),
        (_, Some(_)) => ("another machine's", "let each receiver come to the machine where it is"),
        _ if run.simulated_time => ("in simulated time", "run it again there: it is the same everywhere"),
        _ if run.planning => ("a plan being made", "copy the plan"),
        _ => return Ok(()),
    };
    Err(SendError::NotLive {
        run: run.name.clone(),
        what,
        instead,
    })
}

/// What wakes the sender.
struct Arriving {
    poses: Subscriber<ToolPose>,
    /// In a run whose organs move.
    states: Option<HeadedSubscriber<TissueHeader, f32>>,
}

impl Arriving {
    fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
        let states = scene.tissue.is_some();
        let states = states.then(|| HeadedSubscriber::open_waking(bus, &TISSUE, TISSUE.buffer));
        Ok(Self {
            poses: Subscriber::open_waking(bus, &TOOL_POSE, "", TOOL_POSE.buffer)?,
            states: states.transpose()?,
        })
    }
}

/// A run being shown.
struct Sender {
    shown: Shown,
    facts: Facts,
    outlets: Outlets,
    states: States,
    answers: Answers,
    next_look_ns: i64,
    /// Whether connections are let go at once, as far as is known.
    lets_go: bool,
    /// Publishers and answers end with it. Left to the end of the process: see [`crate::session::ONE_THREAD`].
    _session: ManuallyDrop<Opened>,
}

impl Sender {
    fn open(bus: &Bus, scene: &Scene, (run, text): (&RunContext, &str), session: Opened) -> Result<Self, SendError> {
        let id = run_id(run, text);
        let number = monotonic_ns() as u64 ^ u64::from(std::process::id()) << 40;
        Ok(Self {
            shown: Shown::open(bus, scene)?,
            facts: Facts {
                version: VERSION,
                payloads: payloads(),
                run: run.name.clone(),
                run_id: format!("{id:016x}"),
                scene: text.to_owned(),
                volume: None,
            },
            states: States::open(bus, scene)?,
            answers: Answers::open(&session, (run, scene.tissue.is_some()), (id, number))?,
            outlets: Outlets::open(&session, (id, number))?,
            _session: ManuallyDrop::new(session),
            next_look_ns: 0,
            lets_go: true,
        })
    }

    /// Once round; whether the run goes on.
    fn step(&mut self, arriving: &Arriving, run: &RunContext) -> Result<bool, SendError> {
        while let Some(pose) = arriving.poses.next()? {
            self.outlets.put(Channel::Pose, pose.wire_bytes());
        }
        if let Some(states) = &arriving.states {
            while let Some(state) = states.next()? {
                self.outlets.put_state(&state);
            }
        }
        self.states.step(&mut self.outlets)?;
        if let Some(header) = self.shown.new_header()? {
            self.facts.volume = Some(hex(header.wire_bytes()));
            self.answers.told(&self.facts);
        }
        let now = monotonic_ns();
        if now >= self.next_look_ns {
            self.next_look_ns = now + clock::ns(LOOK);
            if !run.is_running() {
                bus::stderr_line!("remote-proc: run {:?} has ended", run.name);
                return Ok(false);
            }
            self.lets_go &= lets_go(self.lets_go);
            self.answers.tell_receivers();
            self.outlets.tell_refused();
        }
        Ok(true)
    }
}

/// Lets connections go at once; whether that can be done. That it cannot is said once.
fn lets_go(said_yet: bool) -> bool {
    let done = let_go_at_once();
    if let (Err(error), true) = (&done, said_yet) {
        bus::stderr_line!(
            "remote-proc: warning: a receiver that stands still will hold up the others for up to 10 s when it is given up, as the system \
             does not let this process look at its own connections: {error}"
        );
    }
    done.is_ok()
}

/// [`Facts::run_id`]: tells a run from every other, as its facts hold a key that was drawn for it, and a sender from one that speaks otherwise.
pub fn run_id(run: &RunContext, text: &str) -> u64 {
    let mut hasher = blake3::Hasher::new();
    hasher.update(run.facts_hash(text).as_bytes());
    for words in payloads().iter().chain([&VERSION.to_string()]) {
        hasher
            .update(&(words.len() as u64).to_le_bytes())
            .update(words.as_bytes());
    }
    let mut first = [0; 8];
    first.copy_from_slice(&hasher.finalize().as_bytes()[..8]);
    u64::from_le_bytes(first)
}
