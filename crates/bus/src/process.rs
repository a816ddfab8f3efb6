//! What every process of a run does alike: join, give signs of life, stop in an orderly way, die with the pilot.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rustix::fs::Mode;
use rustix::process::Signal;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use thread_priority::ThreadPriority;
use thread_priority::unix::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ScheduleParams, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use crate::clock::{self, Clock};
use crate::life::LifeLine;
use crate::message::{Counters, Heartbeat, ProcessState};
use crate::port::{HandedVolume, Publisher, VolumeSubscriber};
use crate::run::{RunContext, RunError};
use crate::session::Session;
use crate::topic::HEARTBEAT;
use crate::{Bus, BusError};
use scene::{Scene, SceneError};

mod parent;

pub use parent::take_leave;

/// In it the pilot hands the hash of the run's files to the processes that it starts.
pub const FACTS_VARIABLE: &str = "TROCAR_FACTS";
/// Of 1 to 99: below what a system gives its own threads.
const REAL_TIME_PRIORITY: i32 = 10;
/// Between two signs of life.
const BEAT: Duration = Duration::from_millis(100);

/// How a process finds its run.
#[derive(Debug, Clone)]
pub struct Membership {
    /// The run's folder.
    pub run_dir: PathBuf,
    /// The pilot that started this process; with it this process dies ([`take_leave`]: soon after).
    pub parent: Option<u32>,
}

/// Why a process could not join.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// The run's folder.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run's scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Signals cannot be caught.
    #[error("catching signals: {0}")]
    Signals(std::io::Error),
    /// The pilot was gone before this process could tie itself to it.
    #[error("the pilot (process {0}) that started this process has gone")]
    Orphan(u32),
}

/// Set once the process is asked to stop.
#[derive(Debug, Clone, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Catches SIGTERM, and SIGINT and SIGHUP too unless `supervised`: then Ctrl-C and a terminal that is closed are the
    /// pilot's to handle.
    ///
    /// # Errors
    /// [`JoinError::Signals`].
    pub fn install(supervised: bool) -> Result<Self, JoinError> {
        let stop = Self::default();
        let ignored = Arc::new(AtomicBool::new(false));
        let interrupt = if supervised { ignored } else { stop.0.clone() };
        signal_hook::flag::register(SIGTERM, stop.0.clone()).map_err(JoinError::Signals)?;
        for signal in [SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, interrupt.clone()).map_err(JoinError::Signals)?;
        }
        Ok(stop)
    }

    /// Whether the process was asked to stop.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A process that has joined its run.
#[derive(Debug)]
pub struct Process {
    /// The run.
    pub run: RunContext,
    /// The run's scene, checked.
    pub scene: Scene,
    /// The bus.
    pub bus: Bus,
    /// Poses and images are as old as its clock says: the run's clock, or that of a replay.
    pub session: Session,
    /// Set once the process is asked to stop.
    pub stop: StopFlag,
    /// What the process has done so far; goes out with each sign of life.
    pub counters: Counters,
    /// Of the operator's window: the code painted last and when, ns on the run's clock; of its watcher, the code read last. Goes out with
    /// each sign of life.
    pub painted: (u64, i64),
    heartbeat: Publisher<Heartbeat>,
    handed: Option<HandedVolume>,
    next_beat_ns: i64,
    state: ProcessState,
}

impl Process {
    /// Joins the run as `name`, the process's name in the scene.
    ///
    /// # Errors
    /// Each variant of [`JoinError`].
    pub fn join(name: &str, membership: &Membership) -> Result<Self, JoinError> {
        if let Some(parent) = membership.parent {
            parent::die_with(parent, Signal::KILL)?;
        }
        // The pilot hears of this process from here on, however long it takes to join.
        let life = match membership.parent {
            Some(_) => LifeLine::to_pilot(),
            None => LifeLine::none(),
        };
        life.beat();
        let stop = StopFlag::install(membership.parent.is_some())?;
        let is_supervised = membership.parent.is_some();
        let hash = std::env::var(FACTS_VARIABLE).ok().filter(|_| is_supervised);
        let (run, scene) = RunContext::load_with_scene(&membership.run_dir, hash.as_deref())?;
        let scene = Scene::parse(&scene, &run.scene_path())?;
        match scene.priorities.is_real_time(name) {
            true => take_real_time(name),
            false => take_priority(name, scene.priorities.of(name)),
        }
        let bus = Bus::join_with(&run, life)?;
        let heartbeat = Publisher::open(&bus, &HEARTBEAT, name)?;
        let mut process = Self {
            session: Session::open(&bus, &run)?,
            run,
            scene,
            bus,
            stop,
            counters: Counters::default(),
            painted: (0, 0),
            heartbeat,
            handed: is_supervised.then(HandedVolume::received).flatten(),
            next_beat_ns: i64::MIN,
            state: ProcessState::Starting,
        };
        process.beat(ProcessState::Starting, "joined")?;
        Ok(process)
    }

    /// The run's clock, that of signs of life and of everything else that does not stand still with a replay.
    pub fn clock(&self) -> &Clock {
        self.bus.clock()
    }

    /// Subscribes to the volume. Where the run has one, the first that asks has it at once, whatever its loader does; this process
    /// does not keep its memory any longer.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn volumes(&mut self) -> Result<VolumeSubscriber, BusError> {
        let handed = self.handed.take();
        VolumeSubscriber::open_with(&self.bus, handed.as_ref())
    }

    /// Gives a sign of life if one is due or the state has changed.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn beat(&mut self, state: ProcessState, note: &str) -> Result<(), BusError> {
        self.beat_with(state, || note)
    }

    /// The same of words that take time to be found: they are asked for where a sign is given, and not on every turn.
    ///
    /// # Errors
    /// [`BusError::Transfer`].
    pub fn beat_with<W>(&mut self, state: ProcessState, note: impl FnOnce() -> W) -> Result<(), BusError>
    where
        W: AsRef<str>,
    {
        let now = self.clock().now_ns();
        if now < self.next_beat_ns && state == self.state {
            return Ok(());
        }
        self.state = state;
        self.next_beat_ns = now + clock::ns(BEAT);
        let (code, t_ns) = self.painted;
        let beat = Heartbeat::new(state, now, self.counters, note().as_ref()).painted(code, t_ns);
        self.heartbeat.send(beat)
    }
}

/// Asks for the nice value `nice`, for this thread and those that it starts. A navigation goes on where the system refuses one.
fn take_priority(name: &str, nice: i32) {
    if nice != 0
        && let Err(error) = rustix::process::setpriority_process(None, nice)
    {
        crate::stderr_line!(
            "{name}: warning: the system refuses the priority {nice} that the scene asks for ({error}); below 0 it takes CAP_SYS_NICE, or \
             a limit (`ulimit -e`) that allows it"
        );
    }
}

/// Asks to be served before whatever has no such priority, for this thread and those that it starts. The kernel leaves others a
/// twentieth of the time all the same.
fn take_real_time(name: &str) {
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::RoundRobin);
    let priority = ThreadPriority::from_posix(ScheduleParams {
        sched_priority: REAL_TIME_PRIORITY,
    });
    if let Err(error) = set_thread_priority_and_policy(thread_native_id(), priority, policy) {
        crate::stderr_line!(
            "{name}: warning: the system refuses the real-time priority that the scene asks for ({error}); it takes CAP_SYS_NICE, or \
             a limit (`ulimit -r`) that allows it"
        );
    }
}

/// Lets this thread, and those that it starts, be served as any other: what it does can wait, whatever its process is for.
pub fn leave_real_time() {
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    // Everybody may ask for less.
    let _ = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, policy);
}

/// From here on the files and folders that this process and its children make are open to their user only.
pub fn keep_to_oneself() {
    rustix::process::umask(Mode::RWXG | Mode::RWXO);
}

/// Writes a line to stderr, for whoever looks on. Where that cannot be written (a log on a full disk, a terminal that was
/// closed) the line is lost and the process goes on: nobody's navigation ends for want of a log. Control characters, which come with names
/// and files from outside and would move a terminal's cursor over what stands there, are shown as `?`.
pub fn say(words: std::fmt::Arguments<'_>) {
    // One write for the whole line, so that lines of several processes do not mix.
    let _ = std::io::stderr().write_all(plain(&format!("{words}\n")).as_bytes());
}

fn plain(words: &str) -> String {
    words.replace(|c: char| c.is_control() && !matches!(c, '\n' | '\t'), "?")
}

/// [`process::say`](crate::process::say) with the arguments of [`format!`]; `eprintln!` would panic where stderr is full.
#[macro_export]
macro_rules! stderr_line {
    ($($words:tt)*) => {
        $crate::process::say(format_args!($($words)*))
    };
}

/// The end of a binary's main: success, or the error as one paragraph on stderr and exit code 1.
pub fn exit<E: std::error::Error>(binary: &str, result: Result<(), E>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(format_args!("{binary}: error: {error}"));
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    /// A file's name could write over the line that refused it.
    #[test]
    fn what_is_said_moves_no_cursor() {
        assert_eq!(plain("a\u{1b}[2K\rb\u{9b}c\u{7}\td\n"), "a?[2K?b?c?\td\n");
        assert_eq!(plain("caf\u{e9} \u{65e5}"), "caf\u{e9} \u{65e5}");
    }
}
