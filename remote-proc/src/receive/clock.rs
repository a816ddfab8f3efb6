//! The sender's clock on this machine's bus: see [`bus::clock::far`].

use std::time::Duration;

use bus::clock::far::{Exchange, FarClock};
use bus::clock::{monotonic_ns, ms, ns, slept_ns};
use bus::message::ClockLaw;
use bus::port::Publisher;
use bus::topic::SESSION_CLOCK;
use bus::{Bus, BusError};
use zenoh::Wait;
use zenoh::qos::{CongestionControl, Priority};

use super::inbox::{Asked, Inbox, Incoming};
use crate::protocol::{CLOCK, ClockAnswer};
use crate::session::Opened;

/// Between two questions: the clocks may drift apart by a tenth of a millisecond meanwhile.
const EVERY: Duration = Duration::from_millis(100);
/// An answer that took longer says less than those before it.
const WITHIN: Duration = Duration::from_secs(5);

/// Reading two clocks takes a moment: so much is no sleep.
const AWAKE_NS: i64 = 1_000_000;

/// What is known of the sender's clock, and told.
pub(super) struct SenderClock {
    far: FarClock,
    laws: Publisher<ClockLaw>,
    next_ns: i64,
    slept_ns: i64,
    /// Tells this receiver from others.
    number: u64,
}

impl SenderClock {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            far: FarClock::default(),
            laws: Publisher::open(bus, &SESSION_CLOCK, "")?,
            next_ns: i64::MIN,
            slept_ns: slept_ns(),
            number: (monotonic_ns() as u64).rotate_left(24) ^ u64::from(std::process::id()),
        })
    }

    pub(super) fn is_known(&self) -> bool {
        self.far.latest().is_some()
    }

    /// Asks, where it is time to.
    pub(super) fn ask(&mut self, session: &Opened, inbox: &Inbox, now: i64) {
        if now < self.next_ns {
            return;
        }
        self.next_ns = now + ns(EVERY);
        ask(session, self.number, {
            let to = inbox.clone();
            move |asked| to.put(Incoming::Clock(asked))
        });
    }

    /// Takes in an answer, and tells what is known now.
    pub(super) fn take(&mut self, asked: Asked) -> Result<(), BusError> {
        self.look_for_sleep();
        // What was asked before this machine slept knows nothing of that.
        if self.slept_ns - asked.slept_ns > AWAKE_NS {
            return Ok(());
        }
        let exchange = asked.exchange;
        match self.far.take(exchange) {
            Ok(false) => {}
            Ok(true) => bus::stderr_line!("remote-proc: warning: the sender's clock was set, or stood still"),
            Err(error) => {
                bus::stderr_line!("remote-proc: warning: {error}");
                return Ok(());
            }
        }
        self.tell()
    }

    /// While this machine slept the sender's clock went on.
    pub(super) fn look_for_sleep(&mut self) {
        let slept = slept_ns();
        if slept - self.slept_ns > AWAKE_NS {
            self.far.stood_still(slept - self.slept_ns);
            self.slept_ns = slept;
            // Late is worse than unsaid: whoever takes a pose now finds the old law otherwise.
            let _ = self.tell();
        }
    }

    fn tell(&self) -> Result<(), BusError> {
        let Some(law) = self.far.latest() else { return Ok(()) };
        let (anchor_ns, anchor_monotonic_ns) = law.anchor();
        self.laws.send(ClockLaw {
            anchor_ns,
            anchor_monotonic_ns,
            rate: law.rate(),
            speed: 1.0,
            ..ClockLaw::default()
        })
    }

    pub(super) fn serve_late_joiners(&self) {
        self.laws.serve_late_joiners();
    }

    /// How well it is known, in words.
    pub(super) fn words(&self, now: i64) -> Option<String> {
        let uncertain_ns = self.far.uncertain_ns(now)?;
        Some(format!("clock known to {:.2} ms", ms(uncertain_ns)))
    }
}

/// Asks the sender for its clock; `then` is called on a thread of the link.
pub(crate) fn ask(session: &Opened, number: u64, then: impl Fn(Asked) + Send + Sync + 'static) {
    let (slept_ns, sent_ns) = (slept_ns(), monotonic_ns());
    let asked = session
        .get(CLOCK)
        .payload(number.to_le_bytes())
        .timeout(WITHIN)
        .express(true)
        .priority(Priority::RealTime)
        // The answer goes by this rule too: it never waits.
        .congestion_control(CongestionControl::Drop)
        .callback(move |reply| {
            let came_ns = monotonic_ns();
            let Ok(sample) = reply.result() else { return };
            let Some(answer) = ClockAnswer::read(&sample.payload().to_bytes()) else {
                return;
            };
            let exchange = Exchange {
                sent_ns,
                heard_ns: answer.heard_ns,
                answered_ns: answer.answered_ns,
                came_ns,
            };
            let (run, sender) = (answer.run, answer.sender);
            then(Asked {
                exchange,
                run,
                sender,
                slept_ns,
            });
        })
        .wait();
    // A question that did not go out is one that is not answered: the line sees to that.
    let _ = asked;
}
