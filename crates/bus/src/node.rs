//! A process's membership in a run: one iceoryx2 node with the run's own root path and prefix.

use std::time::Duration;

use iceoryx2::prelude::*;

use crate::clock::Clock;
use crate::life::LifeLine;
use crate::run::RunContext;
use crate::unfinished::Sweeper;

pub(crate) type Ipc = ipc::Service;

/// How many processes may take part in a topic at a time.
pub(crate) const MAX_NODES: usize = 32;

/// Why the bus did not do what was asked.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The run's root path or prefix is not acceptable to iceoryx2.
    #[error("joining run {run:?}: {why}")]
    Join {
        /// The run.
        run: String,
        /// iceoryx2's words.
        why: String,
    },
    /// A port could not be opened.
    #[error("opening topic {topic:?} to {what}: {why}")]
    Open {
        /// The topic.
        topic: String,
        /// The kind of port.
        what: &'static str,
        /// iceoryx2's words.
        why: String,
    },
    /// A message could not be sent or received.
    #[error("topic {topic:?}: {what}: {why}")]
    Transfer {
        /// The topic.
        topic: String,
        /// What was being done.
        what: &'static str,
        /// iceoryx2's words.
        why: String,
    },
    /// Nobody answered a request in time.
    #[error("{service}: no answer within {waited:?}")]
    NoAnswer {
        /// The service that was asked.
        service: String,
        /// How long the client waited.
        waited: Duration,
    },
    /// A header on the bus is impossible.
    #[error(transparent)]
    Header(#[from] crate::message::HeaderError),
    /// The replayer published an impossible clock.
    #[error("topic \"session-clock\": {0}")]
    Law(#[from] crate::clock::LawError),
}

/// What a process is to a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Guest,
    Member,
    Keeper,
}

/// A process's place on the bus of one run. Ports are opened through [`crate::port`]; they live on one thread.
#[derive(Debug)]
pub struct Bus {
    pub(crate) node: Node<Ipc>,
    clock: Clock,
    life: LifeLine,
    /// Takes away what dead processes left half made; the pilot has it, who alone frees their places.
    sweeper: Option<Sweeper>,
    /// Whether this is a program that the run does not name: it leaves places for those that the run does.
    is_guest: bool,
}

impl Bus {
    /// Joins a run as a guest: a program that the run's scene does not name. Guests leave some places of each topic free, so
    /// that a process of the run that is started again finds one, and are refused where only these are left.
    ///
    /// # Errors
    /// [`BusError::Join`].
    pub fn join(run: &RunContext) -> Result<Self, BusError> {
        Self::open(run, LifeLine::none(), Role::Guest)
    }

    /// Joins a run to ask its pilot for something, with a right to every place: whoever wants to stop a run can.
    ///
    /// # Errors
    /// [`BusError::Join`].
    pub fn operate(run: &RunContext) -> Result<Self, BusError> {
        Self::open(run, LifeLine::none(), Role::Member)
    }

    /// Joins a run as the process that its pilot hears of on `life`, or as a guest where no pilot does. Gives a sign of life at
    /// each try of whatever has to be tried more than once. The places of dead processes are freed by the run's pilot
    /// ([`Bus::keep`]), and by nobody else.
    ///
    /// # Errors
    /// [`BusError::Join`].
    pub fn join_with(run: &RunContext, life: LifeLine) -> Result<Self, BusError> {
        let role = match life.is_supervised() {
            true => Role::Member,
            false => Role::Guest,
        };
        Self::open(run, life, role)
    }

    /// Joins a run as its keeper: the one process that frees the places of those that died. A cleaner that is killed at its
    /// work leaves a dead process that nobody can ever remove, with the places it held; so none of those that are killed and
    /// started again may clean, and the pilot, with which all others die, does.
    ///
    /// # Errors
    /// [`BusError::Join`].
    pub fn keep(run: &RunContext) -> Result<Self, BusError> {
        Self::open(run, LifeLine::none(), Role::Keeper)
    }

    fn open(run: &RunContext, life: LifeLine, role: Role) -> Result<Self, BusError> {
        let fail = |why: String| BusError::Join {
            run: run.name.clone(),
            why,
        };
        // iceoryx2 explains itself on stderr; its errors reach the user through ours, once.
        set_log_level(LogLevel::Fatal);
        let config = config_of(run).map_err(|e| fail(format!("{e:?}")))?;
        let create = || {
            NodeBuilder::new()
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<Ipc>()
                .map_err(|e| fail(format!("{e:?}")))
        };
        let keeps = role == Role::Keeper;
        // Before anything is asked of iceoryx2, which might wait for what is half made.
        let sweeper = keeps.then(|| Sweeper::start(run.prefix()));
        let node = again_and_again(create, || life.beat())?;
        if keeps {
            run.close_shared_memory();
        }
        let clock = Clock::monotonic(run.epoch_ns);
        Ok(Self {
            node,
            clock,
            life,
            sweeper,
            is_guest: role == Role::Guest,
        })
    }

    /// The line on which this process gives signs of life beside the bus.
    pub fn life_line(&self) -> LifeLine {
        self.life
    }

    /// The run's clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Whether some places of each topic are not for this process: see [`Bus::join`].
    pub(crate) fn is_guest(&self) -> bool {
        self.is_guest
    }

    /// Frees the places of processes that died, so that their topics can be joined anew. Does nothing but for the run's
    /// keeper ([`Bus::keep`]). Returns how many could not be freed.
    pub fn remove_dead_processes(&self) -> u64 {
        match self.sweeper {
            Some(_) => self.node.try_cleanup_dead_nodes().failed_cleanups,
            None => 0,
        }
    }
}

/// Built in code: a configuration file of the machine's must not change how a navigator talks.
fn config_of(run: &RunContext) -> Result<Config, SemanticStringError> {
    let mut config = Config::default();
    let root = Path::new(run.ipc_root().as_os_str().as_encoded_bytes())?;
    config.global.set_root_path(&root);
    config.global.prefix = FileName::new(run.prefix().as_bytes())?;
    // Only the run's keeper cleans, and when it says so.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

/// Opening can fail for a moment while a dead process's place is being freed: tried again for up to two seconds.
pub(crate) fn patiently<T>(bus: &Bus, open: impl FnMut() -> Result<T, BusError>) -> Result<T, BusError> {
    let between = || {
        bus.life.beat();
        bus.remove_dead_processes();
    };
    again_and_again(open, between)
}

/// Tries for up to two seconds, with `between` after each failure.
fn again_and_again<T>(mut act: impl FnMut() -> Result<T, BusError>, between: impl Fn()) -> Result<T, BusError> {
    const TRIES: usize = 100;
    for _ in 1..TRIES {
        match act() {
            Ok(done) => return Ok(done),
            Err(_) => {
                between();
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    }
    act()
}
