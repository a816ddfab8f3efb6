//! The watcher's process: look, judge, cover, twenty times a second.

use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{Event, Heartbeat, Level, ProcessState};
use bus::port::{Publisher, Subscriber};
use bus::process::{Membership, Process};
use bus::topic::{EVENT, HEARTBEAT};

use super::cover::Extent;
use super::error::{RunError, ScreenError};
use super::eyes::{Eyes, Glance};
use super::judge::{Fault, Limits, Reading, Seen, State, Verdict, step};
use super::words;
use crate::code::key;

/// The process's name in the run, and that of the one it watches.
pub(crate) const NAME: &str = "window-watch";
const WATCHED: &str = "window";
/// Between two tries to reach a display that is not there.
const RETRY: Duration = Duration::from_secs(1);

/// What a person may ask for on the command line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Options {
    /// A picture that stands for longer is a fault.
    pub(super) limit: Duration,
    /// Between two looks.
    pub(super) look: Duration,
    /// A window that is silent on the bus for longer is a fault.
    pub(super) silent: Duration,
    /// So many newer pictures lift a cover.
    pub(super) good: u32,
}

/// Watches until asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(super) fn run(membership: &Membership, display: &str, options: Options) -> Result<(), RunError> {
    let mut process = Process::join(NAME, membership)?;
    let mut watcher = Watcher::open(&process, display, options)?;
    let mut due_ns = process.clock().now_ns();
    while !process.stop.is_set() {
        follow(&mut process)?;
        watcher.listen()?;
        watcher.turn(&mut process)?;
        process.beat(ProcessState::Ready, &watcher.note)?;
        // Looks that were missed are not made up for.
        due_ns = (due_ns + clock::ns(options.look)).max(process.clock().now_ns());
        process.clock().sleep_until(due_ns);
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// Takes over the clock of a replay. An impossible one is refused, and the clock goes on as it did.
fn follow(process: &mut Process) -> Result<(), BusError> {
    match process.session.follow() {
        Ok(_) | Err(BusError::Law(_)) => Ok(()),
        Err(error) => Err(error),
    }
}

struct Watcher {
    display: String,
    limits: Limits,
    key: u32,
    heartbeats: Subscriber<Heartbeat>,
    events: Publisher<Event>,
    told: u64,
    heard: Option<Heartbeat>,
    state: State,
    eyes: Option<Eyes>,
    /// When a display that could not be reached is tried again, ns.
    retry_ns: i64,
    /// Where the window was last; the cover of a window that has gone stays there.
    last: Option<Extent>,
    fault: Option<Fault>,
    note: String,
}

impl Watcher {
    fn open(process: &Process, display: &str, options: Options) -> Result<Self, BusError> {
        Ok(Self {
            display: display.to_owned(),
            limits: Limits {
                standing_ns: clock::ns(options.limit),
                stale_ns: clock::ns(process.scene.limits.stale),
                silent_ns: clock::ns(options.silent),
                good: options.good,
            },
            key: key(process.run.epoch_ns),
            heartbeats: Subscriber::open(&process.bus, &HEARTBEAT, WATCHED, 1)?,
            events: Publisher::open(&process.bus, &EVENT, NAME)?,
            told: 0,
            heard: None,
            state: State::default(),
            eyes: None,
            retry_ns: i64::MIN,
            last: None,
            fault: None,
            note: String::new(),
        })
    }

    fn listen(&mut self) -> Result<(), BusError> {
        self.heard = self.heartbeats.newest()?.or(self.heard);
        Ok(())
    }

    /// One look, and what follows from it. A display that cannot be reached ends nothing.
    fn turn(&mut self, process: &mut Process) -> Result<(), BusError> {
        let now_ns = process.clock().now_ns();
        if self.eyes.is_none() && now_ns < self.retry_ns {
            return Ok(());
        }
        if let Err(error) = self.try_turn(process) {
            let words = format!("the display {} cannot be seen: {error}", self.display);
            // Once for each time that it is lost.
            if self.note != words {
                self.tell(process, Level::Error, &words)?;
            }
            self.note = words;
            self.eyes = None;
            self.retry_ns = process.clock().now_ns() + clock::ns(RETRY);
        }
        Ok(())
    }

    fn try_turn(&mut self, process: &mut Process) -> Result<(), ScreenError> {
        let mut eyes = match self.eyes.take() {
            Some(eyes) => eyes,
            None => Eyes::open(&self.display)?,
        };
        let glance = eyes.look(self.key, process.clock())?;
        process.counters.published += 1;
        if let Seen::Code(_, code) = glance.seen {
            process.painted = (code.word(), glance.t_ns);
        }
        let verdict = self.judge(process, &glance);
        match (verdict, self.last) {
            (Verdict::Bad(fault, for_ns), Some(extent)) => eyes.cover(extent, fault, for_ns, glance.t_ns)?,
            _ => eyes.uncover()?,
        }
        self.eyes = Some(eyes);
        self.report(process, verdict);
        Ok(())
    }

    fn judge(&mut self, process: &Process, glance: &Glance) -> Verdict {
        // A window that has gone leaves no cell to be kept free.
        self.last = match glance.extent {
            Some(extent) => Some(extent),
            None => self.last.map(|last| Extent { hole: None, ..last }),
        };
        let session = &process.session;
        // Poses in a run that navigates here are aged by the run's own clock, at the moment of the look; those of another machine a
        // moment later, by what is known of that one's.
        let t_session_ns = match session.is_ruled() || session.is_remote() {
            true => session.clock().now_ns(),
            false => glance.t_ns,
        };
        let reading = Reading {
            seen: glance.seen,
            t_session_ns,
            is_replay: session.is_replay(),
            t_heard_ns: self.heard.map(|heard| heard.t_ns),
            is_ending: self
                .heard
                .is_some_and(|heard| heard.process_state() == ProcessState::Stopping),
        };
        let (state, verdict) = step(&self.limits, self.state, &reading, glance.t_ns);
        self.state = state;
        verdict
    }

    /// Says what has changed, and what is.
    fn report(&mut self, process: &mut Process, verdict: Verdict) {
        let fault = match verdict {
            Verdict::Bad(fault, _) => Some(fault),
            _ => None,
        };
        process.counters.lost += u64::from(fault.is_some());
        self.note = match verdict {
            Verdict::Waiting => "waits for the window".to_owned(),
            Verdict::Closed => "the window was closed".to_owned(),
            Verdict::Good => "the screen is what it says".to_owned(),
            Verdict::Bad(fault, for_ns) => format!(
                "covers the screen: {}, {:.1} s",
                words::name(fault),
                for_ns as f64 / 1e9
            ),
        };
        let told = match (self.fault, verdict) {
            (None, Verdict::Bad(fault, for_ns)) => {
                let words = format!(
                    "the screen is covered: {}: {}",
                    words::headline(fault, for_ns),
                    words::reason(fault)
                );
                self.tell(process, Level::Error, &words)
            }
            (Some(_), Verdict::Good) => self.tell(process, Level::Info, "the screen is what it says again"),
            _ => Ok(()),
        };
        // The cover stands whatever becomes of the words about it.
        let _ = told;
        self.fault = fault;
    }

    fn tell(&mut self, process: &Process, level: Level, words: &str) -> Result<(), BusError> {
        bus::stderr_line!("{NAME}: {words}");
        let event = Event::new(self.told, process.clock().now_ns(), level, words);
        self.told += 1;
        self.events.send(event)
    }
}
