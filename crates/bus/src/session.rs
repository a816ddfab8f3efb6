//! The clock by which poses and images are young or old.
//!
//! In a run that navigates it is the run's clock. In a replay it is the clock of the run that was recorded, run through
//! anew: poses keep their stamps, and are as old when they are shown as they were then. It stands still while the replay
//! is paused, and follows the [`Law`] that the replayer publishes *before* the poses it holds for: whoever has taken a
//! pose from the bus calls [`Session::follow`] and then knows the time at which that pose was published.
//!
//! In a run in simulated time it is a clock that the tracker sets by the same messages: it shows when the newest sample was
//! published, from [`SIMULATED_START_NS`] on, and stands still until every view has drawn that sample. Nothing then depends on
//! how busy the machine is.
//!
//! Where another machine's run is shown it is the clock of that run, as far as it is known here: never behind it, so that nothing is
//! shown younger than it is ([`crate::clock::far`]). What it shows is live.
//!
//! Signs of life, patience and restarts go by [`crate::process::Process::clock`], which never stands still.

mod lead;

use crate::clock::{Clock, Law};
use crate::message::ClockLaw;
use crate::port::Subscriber;
use crate::run::RunContext;
use crate::topic::SESSION_CLOCK;
use crate::{Bus, BusError};

pub use lead::Lead;

/// When sample 0 is due in simulated time, ns. Not 0, which is the time of what has none.
pub const SIMULATED_START_NS: i64 = 1_000_000_000;

/// A process's view of the session's clock.
#[derive(Debug)]
pub struct Session {
    clock: Clock,
    laws: Option<Subscriber<ClockLaw>>,
    last: Option<ClockLaw>,
    kind: Kind,
}

/// Whose clock it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Live,
    Remote,
    Replay,
    Simulated,
}

impl Kind {
    fn of(run: &RunContext) -> Self {
        match (&run.replay, &run.remote, run.simulated_time) {
            (Some(_), ..) => Self::Replay,
            (None, Some(_), _) => Self::Remote,
            (None, None, true) => Self::Simulated,
            (None, None, false) => Self::Live,
        }
    }
}

impl Session {
    /// The clock of `run`. That of a replay, of another machine's run, and simulated time, stand at 0 until whoever sets it has spoken.
    ///
    /// # Errors
    /// [`BusError::Open`].
    pub fn open(bus: &Bus, run: &RunContext) -> Result<Self, BusError> {
        Ok(match Kind::of(run) {
            Kind::Live => Self::live(bus.clock().clone()),
            kind => Self {
                clock: Clock::ruled(Law::still(0)),
                laws: Some(Subscriber::open(bus, &SESSION_CLOCK, "", 1)?),
                last: None,
                kind,
            },
        })
    }

    /// A session that is not replayed.
    pub fn live(clock: Clock) -> Self {
        Self {
            clock,
            laws: None,
            last: None,
            kind: Kind::Live,
        }
    }

    /// Whether poses come out of a recording.
    pub fn is_replay(&self) -> bool {
        self.kind == Kind::Replay
    }

    /// Whether time is made up: in a replay, and in simulated time. Nothing is then live.
    pub fn is_ruled(&self) -> bool {
        matches!(self.kind, Kind::Replay | Kind::Simulated)
    }

    /// Whether another machine's run is shown: its poses are of the present, by a clock that is not this machine's.
    pub fn is_remote(&self) -> bool {
        self.kind == Kind::Remote
    }

    /// The clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Takes over the newest law. Returns whether the replay has gone elsewhere since the last call: what was shown last
    /// is then nothing to go on from.
    ///
    /// # Errors
    /// [`BusError::Transfer`]; [`BusError::Law`], and the clock goes on as it did.
    pub fn follow(&mut self) -> Result<bool, BusError> {
        let Some(laws) = &self.laws else { return Ok(false) };
        let Some(new) = laws.newest()? else { return Ok(false) };
        self.clock.rule(new.law()?);
        let jumped = self.last.is_some_and(|old| old.jumps != new.jumps);
        self.last = Some(new);
        Ok(jumped)
    }

    /// Whether what was published at `t_publish_ns` belongs to a time that is still to come: it was taken from the bus just
    /// before the replay went back. Never so in a run that navigates, where such a stamp is an error.
    pub fn is_yet_to_come(&self, t_publish_ns: i64) -> bool {
        self.is_replay() && t_publish_ns > self.clock.now_ns()
    }

    /// Where the replay, or the run in simulated time, stands; `None` in a run that navigates, and before anybody has spoken.
    pub fn replay(&self) -> Option<&ClockLaw> {
        self.last.as_ref().filter(|_| self.is_ruled())
    }

    /// Whether nobody knows for how long the measurement of a pose of a replay, published at `t_publish_ns`, had stood still.
    pub fn is_unjudged(&self, t_publish_ns: i64) -> bool {
        let law = self.replay().filter(|_| self.is_replay());
        law.is_some_and(|law| t_publish_ns < law.judged_from_ns)
    }

    /// Whether the clock shows anything: that of another machine's run is not known before its first law, and until then nobody can say
    /// how old a pose is.
    pub fn is_known(&self) -> bool {
        !self.is_remote() || self.last.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic_ns;
    use crate::port::Publisher;
    use crate::run::ReplayOf;

    #[test]
    fn nothing_is_yet_to_come_in_a_run_that_navigates() {
        assert!(!Session::live(Clock::fake(5)).is_yet_to_come(i64::MAX));
    }

    #[test]
    fn simulated_time_is_ruled_and_no_replay() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let mut run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        run.simulated_time = true;
        let bus = Bus::join(&run).unwrap();
        let laws = Publisher::open(&bus, &SESSION_CLOCK, "").unwrap();
        let mut session = Session::open(&bus, &run).unwrap();
        assert!(session.is_ruled() && !session.is_replay());
        laws.send(ClockLaw {
            anchor_ns: SIMULATED_START_NS,
            ..ClockLaw::default()
        })
        .unwrap();
        session.follow().unwrap();
        assert_eq!(session.clock().now_ns(), SIMULATED_START_NS);
        assert!(!session.is_yet_to_come(i64::MAX));
        drop((laws, session, bus));
        run.sweep();
    }

    #[test]
    fn processes_follow_the_replayer() {
        let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
        let mut run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        let bus = Bus::join(&run).unwrap();
        assert!(!Session::open(&bus, &run).unwrap().is_replay());
        run.replay = Some(ReplayOf {
            recording: "s.mcap".into(),
            volume_hash: None,
            tissue_again: false,
        });
        let laws = Publisher::open(&bus, &SESSION_CLOCK, "").unwrap();
        let mut session = Session::open(&bus, &run).unwrap();
        assert_eq!((session.follow().unwrap(), session.clock().now_ns()), (false, 0));
        let still = |now_ns, jumps| ClockLaw {
            anchor_ns: now_ns,
            jumps,
            ..ClockLaw::default()
        };
        laws.send(still(77, 0)).unwrap();
        assert_eq!((session.follow().unwrap(), session.clock().now_ns()), (false, 77));
        laws.send(still(5, 1)).unwrap();
        assert_eq!((session.follow().unwrap(), session.clock().now_ns()), (true, 5));
        // A pose taken before the replay went back, and the first one behind.
        assert!(session.is_yet_to_come(77) && !session.is_yet_to_come(5));
        // Who comes late is told where the clock stands.
        let mut late = Session::open(&bus, &run).unwrap();
        laws.serve_late_joiners();
        assert_eq!((late.follow().unwrap(), late.clock().now_ns()), (false, 5));
        laws.send(ClockLaw {
            rate: f64::NAN,
            ..still(6, 1)
        })
        .unwrap();
        let error = session.follow().unwrap_err().to_string();
        assert!(error.contains("NaN times the speed"), "{error}");
        assert_eq!(session.clock().now_ns(), 5);
        drop((laws, session, late, bus));
        run.sweep();
    }
}
