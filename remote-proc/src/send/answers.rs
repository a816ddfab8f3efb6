//! What is answered: the facts, the clock, pieces of the voxels and of the organs at rest. Questions come on threads of the link.

use std::collections::HashMap;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bus::clock::{self, monotonic_ns};
use bus::run::RunContext;
use zenoh::Wait;
use zenoh::qos::CongestionControl;
use zenoh::query::Query;

use super::voxels;
use crate::protocol::{CLOCK, ClockAnswer, FACTS, Facts, MESH, PIECE};
use crate::session::{Opened, SessionError};

/// Questions that wait to be answered; who asks for more is told to ask again.
const WAITING: usize = 64;
/// Who has not asked for the clock for so long has gone.
const GONE: Duration = Duration::from_secs(2);
/// Receivers that are told apart; more are served, and not told of.
const RECEIVERS: usize = 64;

/// The facts as JSON; empty until there is an examination.
pub(super) type Told = Arc<Mutex<Vec<u8>>>;

/// Receivers by the number that each has drawn: when each asked last, on CLOCK_MONOTONIC.
type Seen = Arc<Mutex<HashMap<u64, i64>>>;

/// The questions' other end. Nothing is answered any more once it is dropped with its session.
pub(super) struct Answers {
    facts: Told,
    seen: Seen,
    told: usize,
}

impl Answers {
    /// `moves`: whether the run's organs move.
    pub(super) fn open(
        session: &Opened,
        (run, moves): (&RunContext, bool),
        (id, number): (u64, u64),
    ) -> Result<Self, SessionError> {
        let facts = Arc::new(Mutex::new(Vec::new()));
        let seen = Seen::default();
        let asked = serve((run.clone(), moves), facts.clone());
        // Whoever waits for room in the link's queues must not do so in its one thread.
        for key in [FACTS, PIECE, MESH] {
            let asked = asked.clone();
            answer(session, key, move |query| match asked.try_send(query) {
                Ok(()) => {}
                Err(TrySendError::Full(query)) => reply(&query, Err("too much is asked for at a time: ask again")),
                Err(TrySendError::Disconnected(query)) => reply(&query, Err("the run is not served any more")),
            })?;
        }
        let (epoch_ns, heard) = (run.epoch_ns, seen.clone());
        answer(session, CLOCK, move |query| {
            let heard_ns = monotonic_ns() - epoch_ns;
            // An answer goes by its question's rule, and one that may wait would do so in the link's one thread.
            if query.congestion_control() != CongestionControl::Drop {
                let _ = asked.try_send(query);
                return;
            }
            note(&heard, &query);
            let answered_ns = monotonic_ns() - epoch_ns;
            let told = ClockAnswer {
                heard_ns,
                answered_ns,
                run: id,
                sender: number,
            };
            reply(&query, Ok(told.bytes()));
        })?;
        Ok(Self { facts, seen, told: 0 })
    }

    /// What is answered to who asks what the run is.
    pub(super) fn told(&self, facts: &Facts) {
        let json = serde_json::to_vec(facts).unwrap_or_default();
        *self.facts.lock().unwrap_or_else(PoisonError::into_inner) = json;
    }

    /// Says on stderr how many receivers there are, where that has changed.
    pub(super) fn tell_receivers(&mut self) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let oldest_ns = monotonic_ns() - clock::ns(GONE);
        seen.retain(|_, last_ns| *last_ns >= oldest_ns);
        if seen.len() != self.told {
            self.told = seen.len();
            bus::stderr_line!("remote-proc: receivers: {}", self.told);
        }
    }
}

fn answer(session: &Opened, key: &'static str, by: impl Fn(Query) + Send + Sync + 'static) -> Result<(), SessionError> {
    let queryable = session.declare_queryable(key).callback(by).background().wait();
    queryable.map_err(|why| SessionError::declaring(key, &*why))
}

/// Who does not take the answer asks again.
pub(super) fn reply(query: &Query, answer: Result<Vec<u8>, &str>) {
    let _ = match answer {
        Ok(bytes) => query.reply(query.key_expr().clone(), bytes).wait(),
        Err(why) => query.reply_err(why).wait(),
    };
}

/// A receiver that asks for the clock says which it is.
fn note(seen: &Seen, query: &Query) {
    let said = query.payload().map(zenoh::bytes::ZBytes::to_bytes);
    let Some(number) = said.and_then(|bytes| Some(u64::from_le_bytes(bytes[..].try_into().ok()?))) else {
        return;
    };
    let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
    if seen.len() < RECEIVERS || seen.contains_key(&number) {
        seen.insert(number, monotonic_ns());
    }
}

/// Starts the thread that answers for facts and voxels: shared memory is mapped there once more, and copied by nobody.
fn serve((run, moves): (RunContext, bool), facts: Told) -> SyncSender<Query> {
    let (asked, questions) = sync_channel(WAITING);
    // It ends with the session, whose callbacks hold the other end.
    std::thread::spawn(move || {
        if let Err(error) = voxels::serve((&run, moves), &facts, &questions) {
            bus::stderr_line!("remote-proc: error: serving the examination: {error}");
        }
    });
    asked
}
