//! `remote-proc receive`: another machine's run on this machine's bus, as a process of a run that `pilot remote` starts.
//!
//! It publishes the examination, once it is whole and its hash is the sender's, the clock that poses are old by, and the messages as
//! they come, bit for bit. It sends nothing but questions: about the run, the clock, and pieces of the voxels.

mod clock;
mod examination;
mod inbox;
mod line;
mod organs;
mod outputs;

use std::ops::ControlFlow;
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::time::Duration;

use bus::BusError;
use bus::clock::monotonic_ns;
use bus::message::{ProcessState, VolumeHash};
use bus::process::{JoinError, Membership, Process};
use bus::wake::Waits;

use crate::protocol::{Channel, Envelope, Facts};
use clock::SenderClock;
pub(crate) use clock::ask as ask_clock;
pub use examination::ExaminationError;
use examination::{Examination, Step};
pub(crate) use inbox::words;
use inbox::{Asked, Inbox, Incoming};
use line::Line;
use outputs::Outputs;

/// Its name in the run.
pub(crate) const NAME: &str = "remote";
/// Between two looks at what wakes nobody.
const TICK: Duration = Duration::from_millis(20);

/// Between two questions what the run is, where there was no answer.
const AGAIN: Duration = Duration::from_millis(500);

/// What is received, and from where.
#[derive(Debug, Clone)]
pub struct Receiving {
    /// Where the sender listens.
    pub endpoint: String,
    /// The folder with the receiver's keys.
    pub keys: Option<PathBuf>,
    /// The run, as [`Facts::run_id`] has it.
    pub session: u64,
}

/// Why nothing is received any more.
#[derive(Debug, thiserror::Error)]
pub enum ReceiveError {
    /// It could not join the run.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The examination.
    #[error("the examination of {endpoint}: {source}")]
    Examination {
        /// The sender.
        endpoint: String,
        /// Why not.
        source: ExaminationError,
    },
    /// Messages cannot be waited for.
    #[error("waiting for the link: {0}")]
    Waiting(std::io::Error),
}

/// Receives until asked to stop.
///
/// # Errors
/// Each variant of [`ReceiveError`].
pub fn receive(receiving: &Receiving, membership: &Membership) -> Result<(), ReceiveError> {
    let process = Process::join(NAME, membership)?;
    let (inbox, wakes) = Inbox::open().map_err(ReceiveError::Waiting)?;
    let mut receiver = Receiver::open(process, receiving, inbox.clone())?;
    Waits::every(TICK).readable(wakes.as_fd()).run(|| {
        inbox::drain(&wakes);
        match receiver.step() {
            Ok(true) => ControlFlow::Continue(()),
            Ok(false) => ControlFlow::Break(Ok(())),
            Err(error) => ControlFlow::Break(Err(error)),
        }
    })?
}

/// Another machine's run being received.
struct Receiver {
    process: Process,
    endpoint: String,
    run: u64,
    inbox: Inbox,
    line: Line,
    clock: SenderClock,
    examination: Examination,
    outputs: Outputs,
    /// When the sender is asked next what its run is.
    next_facts_ns: i64,
    /// The sender serves another run now, or speaks another language: nothing of it is shown.
    refused: Option<String>,
    /// The sender whose facts were found good; nothing of another is shown before its own are.
    sender: Option<u64>,
    /// The sender that answered last.
    answering: Option<u64>,
}

impl Receiver {
    fn open(mut process: Process, receiving: &Receiving, inbox: Inbox) -> Result<Self, ReceiveError> {
        // Who follows on one that died finds the examination in memory already.
        let held = process.volumes()?.poll()?.map(|volume| volume.hash());
        Ok(Self {
            endpoint: receiving.endpoint.clone(),
            run: receiving.session,
            line: Line::new(receiving.endpoint.clone(), receiving.keys.clone(), inbox.clone()),
            clock: SenderClock::open(&process.bus)?,
            examination: Examination::new(held),
            outputs: Outputs::open(&process.bus)?,
            next_facts_ns: i64::MAX,
            refused: None,
            sender: None,
            answering: None,
            process,
            inbox,
        })
    }

    /// Once round; whether to go on.
    fn step(&mut self) -> Result<bool, ReceiveError> {
        if self.process.stop.is_set() {
            self.process.beat(ProcessState::Stopping, "asked to stop")?;
            return Ok(false);
        }
        let now = monotonic_ns();
        self.line.step(now);
        self.clock.look_for_sleep();
        // Clocks first: a pose is judged by what was known of the clock when it was published.
        let (clocks, rest): (Vec<_>, Vec<_>) = self.inbox.take().into_iter().partition(Incoming::is_clock);
        for incoming in clocks.into_iter().chain(rest) {
            self.take(incoming)?;
        }
        if let Some(session) = self.line.session() {
            if now >= self.next_facts_ns {
                self.next_facts_ns = i64::MAX;
                line::ask_facts(session, &self.inbox);
            }
            self.clock.ask(session, &self.inbox, now);
            self.examination.ask(session, &self.inbox, now);
            self.outputs.organs.ask(session, &self.inbox, now);
        }
        self.outputs.step(now);
        self.outputs.serve_late_joiners();
        self.clock.serve_late_joiners();
        self.examination.serve_late_joiners();
        self.beat(now)?;
        Ok(true)
    }

    fn take(&mut self, incoming: Incoming) -> Result<(), ReceiveError> {
        match incoming {
            Incoming::Opened(opened) => {
                if self.line.opened(opened, monotonic_ns()).is_some() {
                    self.next_facts_ns = 0;
                }
            }
            Incoming::Facts(Ok(bytes)) => self.facts(&bytes)?,
            Incoming::Looked(why) => self.line.looked(why, monotonic_ns()),
            Incoming::Facts(Err(why)) => {
                bus::stderr_line!("remote-proc: asking {} what it shows: {why}", self.endpoint);
                self.next_facts_ns = monotonic_ns().saturating_add(bus::clock::ns(AGAIN));
            }
            Incoming::Clock(asked) => self.clock(asked)?,
            Incoming::Piece(index, piece) => self.piece(index, piece)?,
            Incoming::Mesh(id, index, piece) => {
                if let Some(volume) = self.examination.there() {
                    let outputs = &mut self.outputs;
                    outputs.organs.take(&self.process.bus, ((id, index), piece), volume)?;
                }
            }
            Incoming::Message(channel, envelope, body) => self.message(channel, envelope, &body)?,
            Incoming::Odd(words) => self.refuse(&words),
        }
        Ok(())
    }

    fn clock(&mut self, asked: Asked) -> Result<(), ReceiveError> {
        let came_back = self.line.answered(monotonic_ns());
        // The sender is another one by now, or may be, and what was asked of the old one does not come.
        if came_back || self.answering != Some(asked.sender) {
            self.answering = Some(asked.sender);
            self.sender = None;
            self.examination.ask_anew();
            self.outputs.organs.ask_anew();
            self.next_facts_ns = 0;
        }
        // Another run has another clock, by which nothing that is shown here is old or young.
        match asked.run == self.run {
            true => Ok(self.clock.take(asked)?),
            false => Ok(()),
        }
    }

    fn facts(&mut self, bytes: &[u8]) -> Result<(), ReceiveError> {
        let read = Facts::read(bytes).and_then(|facts| Ok((facts.id()?, facts.header()?)));
        self.refused = match &read {
            Err(error) => Some(error.to_string()),
            Ok((id, _)) if *id != self.run => {
                Some("the sender shows another run by now: end this one, and start anew".to_owned())
            }
            Ok((_, None)) => Some("the sender has no examination".to_owned()),
            Ok((_, Some(_))) => None,
        };
        if let Some(why) = &self.refused {
            bus::stderr_line!("remote-proc: error: {}: {why}. Nothing of it is shown", self.endpoint);
        }
        let Ok((id, Some(header))) = read else { return Ok(()) };
        if id == self.run {
            self.sender = self.answering;
            let begun = self.examination.begin(&self.process.bus, header);
            begun.map_err(|source| self.of_examination(source))?;
        }
        Ok(())
    }

    fn piece(&mut self, index: u32, piece: Result<Vec<u8>, String>) -> Result<(), ReceiveError> {
        let process = &mut self.process;
        let alive = |words: &str| process.beat(ProcessState::Starting, words);
        let step = self.examination.take(index, piece, alive);
        if let Step::Whole(hash, seconds) = step.map_err(|source| self.of_examination(source))? {
            self.tell_whole(hash, seconds);
        }
        Ok(())
    }

    fn tell_whole(&mut self, hash: VolumeHash, seconds: f64) {
        bus::stderr_line!(
            "remote-proc: the examination {hash} is here after {seconds:.2} s, and is the sender's by its hash"
        );
    }

    fn of_examination(&self, source: ExaminationError) -> ReceiveError {
        ReceiveError::Examination {
            endpoint: self.endpoint.clone(),
            source,
        }
    }

    fn message(&mut self, channel: Channel, envelope: Envelope, body: &[u8]) -> Result<(), ReceiveError> {
        if envelope.run != self.run {
            self.refuse("a message of another run came");
            return Ok(());
        }
        // Who it is must be known, and the age of a pose or its state, and the examination that it is shown in.
        let is_good = self.refused.is_none() && self.sender == Some(envelope.sender);
        let may_show = self.clock.is_known() && self.examination.is_there();
        if !is_good || (matches!(channel, Channel::Pose | Channel::Tissue) && !may_show) {
            return Ok(());
        }
        if let Some(why) = self.outputs.send(channel, envelope, body, &mut self.process.counters)? {
            self.refuse(&why);
        }
        Ok(())
    }

    fn refuse(&mut self, why: &str) {
        if self.process.counters.refused == 0 {
            bus::stderr_line!("remote-proc: error: {why}. It is not shown; further ones are only counted");
        }
        self.process.counters.refused += 1;
    }

    fn beat(&mut self, now: i64) -> Result<(), ReceiveError> {
        let is_ready = self.examination.is_there() && self.clock.is_known();
        let state = match is_ready {
            true => ProcessState::Ready,
            false => ProcessState::Starting,
        };
        let note = || {
            let cut = self.line.trouble(now);
            let words = [
                self.refused.clone(),
                cut,
                self.examination.words(),
                self.outputs.lost(),
                self.outputs.organs.words(),
                self.outputs.words(),
                self.clock.words(now),
            ];
            words.into_iter().flatten().collect::<Vec<_>>().join(", ")
        };
        Ok(self.process.beat_with(state, note)?)
    }
}
