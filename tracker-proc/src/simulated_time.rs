//! Simulated time: each sample is published when every view has drawn the one before, and the session's clock shows no more than
//! the newest sample's time. What a run shows and records then is the same however busy the machine is.
//!
//! Who takes poses from a buffer (the pilot, a recorder) is waited for as well, so that none is lost there. A process that dies
//! is started again by the pilot and given the newest sample; one that lives and takes nothing is waited for only so long.

use std::time::Duration;

use bus::BusError;
use bus::clock::{self, Law, monotonic_ns};
use bus::lockstep::Lockstep;
use bus::message::{ClockLaw, Heartbeat, ProcessState, ReplayState};
use bus::port::{Publisher, Subscriber};
use bus::process::Process;
use bus::session::SIMULATED_START_NS;
use bus::topic::{FRAME_STAMP, HEARTBEAT, SESSION_CLOCK, TISSUE, TOOL_POSE};
use scene::Scene;

use crate::output::{LOOK_UP, Output};

/// While the images of a sample are awaited.
const NEXT_LOOK: Duration = Duration::from_micros(100);
/// A reader that takes nothing for so long is no longer waited for. The pilot restarts one that gives no sign of life.
const PATIENCE: Duration = Duration::from_secs(60);

/// Simulated time, as the tracker makes it.
pub(crate) struct SimulatedTime {
    laws: Publisher<ClockLaw>,
    lockstep: Lockstep,
    readers: Vec<Reader>,
    now_ns: i64,
    /// The first moment that is beyond the run.
    end_ns: i64,
    state: ReplayState,
    next_look_ns: i64,
}

/// A process that takes poses from a buffer, and says how far it has come.
struct Reader {
    name: &'static str,
    beats: Subscriber<Heartbeat>,
    /// So many samples fit into its buffers, with room to spare.
    window: u64,
    /// The number behind the newest sample that it has taken.
    taken: u64,
    /// When it was waited for first, since it took something last; on the machine's clock.
    waiting_since_ns: Option<i64>,
    given_up: bool,
}

impl SimulatedTime {
    /// Says to everybody that it is the moment of sample 0, or that at which a tracker that died had published last.
    ///
    /// # Errors
    /// [`BusError`].
    pub(crate) fn open(process: &mut Process, output: &Output) -> Result<Self, BusError> {
        let (bus, scene) = (&process.bus, &process.scene);
        let mut readers = vec![Reader::open(process, "pilot", pilots_window(scene))?];
        if scene.recording.is_some() {
            // It looks at the bus every 20 ms, and gives a sign of life every 100 ms.
            let room = match scene.tissue {
                Some(_) => TOOL_POSE.buffer.min(TISSUE.buffer),
                None => TOOL_POSE.buffer,
            };
            readers.push(Reader::open(process, "recorder", room as u64 / 2)?);
        }
        let mut time = Self {
            laws: Publisher::open(bus, &SESSION_CLOCK, "")?,
            lockstep: Lockstep::open(bus, scene, false)?,
            readers,
            now_ns: output.after_ns.unwrap_or(SIMULATED_START_NS),
            end_ns: SIMULATED_START_NS.saturating_add(process.run.duration_ns.unwrap_or(i64::MAX)),
            state: ReplayState::Playing,
            next_look_ns: 0,
        };
        time.set(process, time.now_ns)?;
        Ok(time)
    }

    /// Whether a sample due at `at_ns` has gone out already: a tracker that died had published it.
    pub(crate) fn is_past(output: &Output, at_ns: i64) -> bool {
        output.after_ns.is_some_and(|after_ns| at_ns <= after_ns)
    }

    /// Before sample `seq`, captured at `t_capture_ns`, is published at `at_ns`.
    ///
    /// # Errors
    /// [`BusError`].
    pub(crate) fn expect(
        &mut self,
        process: &Process,
        seq: u64,
        t_capture_ns: i64,
        at_ns: i64,
    ) -> Result<(), BusError> {
        self.lockstep.expect(seq, t_capture_ns)?;
        // Everybody must know the clock before the sample that it holds for.
        self.set(process, at_ns)
    }

    /// Nothing was published.
    pub(crate) fn forget(&mut self) {
        self.lockstep.forget();
    }

    /// Waits until every view has drawn sample `seq` and nobody's buffer is in danger. Returns whether the run goes on.
    ///
    /// # Errors
    /// [`BusError`].
    pub(crate) fn wait(&mut self, process: &mut Process, output: &Output, seq: u64) -> Result<bool, BusError> {
        while !process.stop.is_set() {
            self.look_up(process, output, ProcessState::Ready)?;
            if self.lockstep.is_drawn()? && self.is_taken(seq)? {
                return Ok(true);
            }
            std::thread::sleep(NEXT_LOOK);
        }
        Ok(false)
    }

    /// The time is over: everybody is told, and the process idles until it is asked to stop.
    ///
    /// # Errors
    /// [`BusError`].
    pub(crate) fn end(mut self, process: &mut Process, output: &Output) -> Result<(), BusError> {
        self.state = ReplayState::Ended;
        let end_ns = self.end_ns.max(self.now_ns);
        if !process.stop.is_set() {
            self.set(process, end_ns)?;
        }
        while !process.stop.is_set() {
            self.look_up(process, output, ProcessState::Stopping)?;
            std::thread::sleep(LOOK_UP);
        }
        process.beat(ProcessState::Stopping, "asked to stop")
    }

    fn set(&mut self, process: &Process, now_ns: i64) -> Result<(), BusError> {
        self.now_ns = now_ns;
        process.session.clock().rule(Law::still(now_ns));
        self.laws.send(ClockLaw {
            anchor_ns: now_ns,
            first_ns: SIMULATED_START_NS,
            last_ns: self.end_ns,
            speed: f64::INFINITY,
            state: self.state.code(),
            ..ClockLaw::default()
        })
    }

    /// Signs of life, and what those are due who came late.
    fn look_up(&mut self, process: &mut Process, output: &Output, state: ProcessState) -> Result<(), BusError> {
        process.beat(state, "in simulated time")?;
        let now_ns = monotonic_ns();
        if now_ns >= self.next_look_ns {
            self.next_look_ns = now_ns + clock::ns(LOOK_UP);
            self.laws.serve_late_joiners();
            output.poses.serve_late_joiners();
        }
        Ok(())
    }

    fn is_taken(&mut self, seq: u64) -> Result<bool, BusError> {
        let mut all = true;
        for reader in &mut self.readers {
            all &= reader.keeps_up_with(seq)?;
        }
        Ok(all)
    }
}

impl Reader {
    fn open(process: &Process, name: &'static str, window: u64) -> Result<Self, BusError> {
        Ok(Self {
            name,
            beats: Subscriber::open(&process.bus, &HEARTBEAT, name, 1)?,
            window,
            taken: 0,
            waiting_since_ns: None,
            given_up: false,
        })
    }

    fn keeps_up_with(&mut self, seq: u64) -> Result<bool, BusError> {
        if let Some(beat) = self.beats.newest()?
            && beat.counters.published != self.taken
        {
            self.taken = beat.counters.published;
            self.waiting_since_ns = None;
            self.given_up = false;
        }
        if seq < self.taken.saturating_add(self.window) || self.given_up {
            return Ok(true);
        }
        let now_ns = monotonic_ns();
        if now_ns - *self.waiting_since_ns.get_or_insert(now_ns) > clock::ns(PATIENCE) {
            bus::stderr_line!(
                "tracker: the {} takes no poses; simulated time goes on without it",
                self.name
            );
            self.given_up = true;
        }
        Ok(false)
    }
}

/// The pilot takes the stamps of every view too: as many as the views of one renderer for each sample.
fn pilots_window(scene: &Scene) -> u64 {
    let most = scene.renderers().iter().map(|(_, views)| views.len()).max();
    (FRAME_STAMP.buffer / 2 / most.unwrap_or(1).max(1)) as u64
}
