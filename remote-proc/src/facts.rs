//! `remote-proc facts`: what a sender shows, for the pilot that is to show it.

use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

use bus::clock::far::FarClock;
use bus::clock::monotonic_ns;
use serde::Serialize;
use zenoh::Wait;

use crate::protocol::{FACTS, Facts, FactsError};
use crate::receive::{ask_clock, words};
use crate::session::{Opened, SessionError, dial};

/// How long a sender may take to answer.
const WITHIN: Duration = Duration::from_secs(5);
/// Between two questions.
const AGAIN: Duration = Duration::from_millis(50);
/// How long one answer about the clock is waited for.
const ANSWERED_WITHIN: Duration = Duration::from_millis(500);
/// Answers about its clock.
const ASKED: usize = 8;

/// Why nothing is known of a sender.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// There is no session.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// Nobody answered.
    #[error(
        "{endpoint}: somebody is there, and does not answer what it shows: {why}. Is it `remote-proc send`, of the same version, and are \
         these keys among those that it lets in?"
    )]
    Silent {
        /// Where.
        endpoint: String,
        /// The link's words.
        why: String,
    },
    /// The answer.
    #[error("{endpoint}: {source}")]
    Facts {
        /// Where.
        endpoint: String,
        /// What is wrong with it.
        source: FactsError,
    },
    /// It has no examination yet.
    #[error("{endpoint}: run {run:?} has no examination yet: ask again when it is loaded")]
    NoVolume {
        /// Where.
        endpoint: String,
        /// The run.
        run: String,
    },
}

/// What is said of a sender, as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Told {
    run: String,
    session: String,
    scene: String,
    volume_hash: String,
    dims: [u32; 3],
    /// What its clock shows, about, when CLOCK_MONOTONIC shows `monotonic_ns` here.
    now_ns: i64,
    monotonic_ns: i64,
    /// How far off that may be.
    uncertain_ns: i64,
}

/// Asks the sender at `endpoint`.
///
/// # Errors
/// Each variant of [`AskError`].
pub fn ask(endpoint: &str, keys: Option<&Path>) -> Result<Told, AskError> {
    // Left to the end of the process: closing would write to the connection from this thread, while the link's reads it.
    let session = ManuallyDrop::new(dial(endpoint, keys)?);
    let of = |source| AskError::Facts {
        endpoint: endpoint.to_owned(),
        source,
    };
    let silent = |why: String| AskError::Silent {
        endpoint: endpoint.to_owned(),
        why,
    };
    let facts = Facts::read(&asked(&session).map_err(silent)?).map_err(of)?;
    let header = facts.header().map_err(of)?.ok_or_else(|| AskError::NoVolume {
        endpoint: endpoint.to_owned(),
        run: facts.run.clone(),
    })?;
    let clock = clock(&session);
    let monotonic_ns = monotonic_ns();
    // Beyond 36 years it is no run's clock, and differences would not fit.
    let now_ns = clock.likely_ns(monotonic_ns).filter(|now_ns| now_ns.abs() < 1 << 60);
    Ok(Told {
        now_ns: now_ns.ok_or_else(|| silent("it says nothing of its clock that can be".to_owned()))?,
        monotonic_ns,
        uncertain_ns: clock.uncertain_ns(monotonic_ns).unwrap_or_default(),
        volume_hash: header.volume_hash().to_string(),
        dims: header.dims,
        session: facts.run_id,
        run: facts.run,
        scene: facts.scene,
    })
}

/// A question for which nobody is there yet ends without a word, so that it is asked again for a while.
fn asked(session: &Opened) -> Result<Vec<u8>, String> {
    let last_ns = monotonic_ns() + bus::clock::ns(WITHIN);
    loop {
        let replies = session
            .get(FACTS)
            .timeout(WITHIN)
            .wait()
            .map_err(|why| why.to_string())?;
        match replies.recv().map(zenoh::query::Reply::into_result) {
            Ok(Ok(sample)) => return Ok(sample.payload().to_bytes().into_owned()),
            Ok(Err(why)) => return Err(words(&why.payload().to_bytes())),
            Err(_) if monotonic_ns() < last_ns => std::thread::sleep(AGAIN),
            Err(_) => return Err(format!("no answer within {} s", WITHIN.as_secs())),
        }
    }
}

/// A question may be dropped on its way, or end without a word: it is asked again for a while.
fn clock(session: &Opened) -> FarClock {
    let mut clock = FarClock::default();
    let last_ns = monotonic_ns() + bus::clock::ns(WITHIN);
    let mut answers = 0;
    while answers < ASKED && monotonic_ns() < last_ns {
        let (sender, answer) = channel();
        ask_clock(session, 0, move |asked| {
            let _ = sender.send(asked.exchange);
        });
        match answer.recv_timeout(ANSWERED_WITHIN) {
            // One that cannot be says nothing.
            Ok(exchange) => answers += usize::from(clock.take(exchange).is_ok()),
            Err(_) => std::thread::sleep(AGAIN),
        }
    }
    clock
}
