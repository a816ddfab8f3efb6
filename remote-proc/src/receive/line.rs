//! The line to the sender: dialled, then watched. A link that was cut is dialled again by zenoh, every tenth of a second.

use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::time::Duration;

use bus::clock::{ms, ns};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use super::inbox::{Inbox, Incoming, Promise, answer};
use crate::linger::let_go_at_once;
use crate::protocol::{Channel, FACTS};
use crate::session::{Opened, dial, look};

/// Without an answer for so long, the line counts as cut.
const SILENT: Duration = Duration::from_millis(1000);
/// Between two dials, and two looks why the sender does not answer.
const AGAIN: Duration = Duration::from_millis(500);
/// How long the sender may take to say what its run is.
const FACTS_WITHIN: Duration = Duration::from_secs(10);

/// The line to the sender.
pub(super) struct Line {
    endpoint: String,
    keys: Option<PathBuf>,
    inbox: Inbox,
    /// Left to the end of the process: see [`crate::session::ONE_THREAD`].
    session: Option<ManuallyDrop<Box<Opened>>>,
    /// A thread dials, or looks why there is no answer.
    is_busy: bool,
    next_ns: i64,
    next_let_go_ns: i64,
    /// When the sender answered last, or the session was opened; `None`: never.
    answered_ns: Option<i64>,
    /// The sender fell silent, and this was told.
    was_cut: bool,
    /// Why there is no session, or no answer.
    why: Option<String>,
}

impl Line {
    pub(super) fn new(endpoint: String, keys: Option<PathBuf>, inbox: Inbox) -> Self {
        Self {
            endpoint,
            keys,
            inbox,
            session: None,
            is_busy: false,
            next_ns: i64::MIN,
            next_let_go_ns: i64::MIN,
            answered_ns: None,
            was_cut: false,
            why: None,
        }
    }

    pub(super) fn session(&self) -> Option<&Opened> {
        self.session.as_deref().map(|session| &**session)
    }

    /// Dials where there is no session, and looks why where there is no answer.
    pub(super) fn step(&mut self, now: i64) {
        if now >= self.next_let_go_ns {
            self.next_let_go_ns = now.saturating_add(ns(AGAIN));
            // Where it cannot be done a sender that stands still is dialled later, and nothing else.
            let _ = let_go_at_once();
        }
        if !self.is_silent(now) {
            return;
        }
        if self.session.is_some() && !self.was_cut {
            self.was_cut = true;
            bus::stderr_line!("remote-proc: {} does not answer", self.endpoint);
        }
        if self.is_busy || now < self.next_ns {
            return;
        }
        self.is_busy = true;
        let (endpoint, keys, inbox) = (self.endpoint.clone(), self.keys.clone(), self.inbox.clone());
        let has_session = self.session.is_some();
        std::thread::spawn(move || {
            let keys = keys.as_deref();
            inbox.put(match has_session {
                true => Incoming::Looked(look(&endpoint, keys).err().map(|error| error.to_string())),
                false => {
                    let opened = dial(&endpoint, keys).map_err(|error| error.to_string());
                    Incoming::Opened(opened.and_then(|session| followed(session, &inbox)))
                }
            });
        });
    }

    /// What came of a dial; the session, where there is one now.
    pub(super) fn opened(&mut self, opened: Result<Box<Opened>, String>, now: i64) -> Option<&Opened> {
        match opened {
            Err(why) => {
                self.looked(Some(why), now);
                None
            }
            Ok(session) => {
                self.looked(None, now);
                bus::stderr_line!("remote-proc: connected to {}", self.endpoint);
                (self.session, self.answered_ns) = (Some(ManuallyDrop::new(session)), Some(now));
                self.session()
            }
        }
    }

    /// What a look found.
    pub(super) fn looked(&mut self, why: Option<String>, now: i64) {
        (self.is_busy, self.next_ns) = (false, now.saturating_add(ns(AGAIN)));
        if let Some(why) = why.as_ref().filter(|why| self.why.as_ref() != Some(why)) {
            bus::stderr_line!("remote-proc: {why}; dialling again");
        }
        self.why = why;
    }

    /// The sender answered; whether it did not for a while before, so that what was asked meanwhile is to be asked again.
    pub(super) fn answered(&mut self, now: i64) -> bool {
        let silent_ns = now.saturating_sub(self.answered_ns.unwrap_or(now));
        self.answered_ns = Some(now);
        let came_back = std::mem::take(&mut self.was_cut);
        if came_back {
            self.why = None;
            bus::stderr_line!(
                "remote-proc: {} answers again, after {:.1} s",
                self.endpoint,
                ms(silent_ns) / 1e3
            );
        }
        came_back
    }

    fn is_silent(&self, now: i64) -> bool {
        self.answered_ns
            .is_none_or(|at_ns| now.saturating_sub(at_ns) > ns(SILENT))
    }

    /// What is wrong with the line, in words.
    pub(super) fn trouble(&self, now: i64) -> Option<String> {
        if !self.is_silent(now) {
            return None;
        }
        let since = self.answered_ns.map_or_else(
            || "NO CONNECTION".to_owned(),
            |at_ns| format!("NO ANSWER for {:.1} s", ms(now.saturating_sub(at_ns)) / 1e3),
        );
        Some(match &self.why {
            Some(why) => format!("{since} ({why})"),
            None => since,
        })
    }
}

/// Follows every channel. Nothing is ever published.
fn followed(session: Opened, inbox: &Inbox) -> Result<Box<Opened>, String> {
    for channel in Channel::ALL {
        let to = inbox.clone();
        let subscriber = session
            .declare_subscriber(channel.key())
            .callback(move |sample| to.sample(channel, &sample))
            .background()
            .wait();
        subscriber.map_err(|why| format!("following {}: {why}", channel.key()))?;
    }
    Ok(Box::new(session))
}

/// Asks the sender what its run is.
pub(super) fn ask_facts(session: &Opened, inbox: &Inbox) {
    let none = |why: String| Incoming::Facts(Err(why));
    let promise = Promise::of(inbox, none("nobody answers".to_owned()));
    let asked = session
        .get(FACTS)
        .timeout(FACTS_WITHIN)
        // The answer goes by the question's rule: a long scene waits for room on its way.
        .congestion_control(CongestionControl::Block)
        .callback(move |reply| promise.keep(Incoming::Facts(answer(reply))))
        .wait();
    if let Err(why) = asked {
        inbox.put(none(why.to_string()));
    }
}
