//! The side that is dialled: one session for each client. It knows what the client reads and what it has asked for;
//! what it is sent, and when, the driver knows.

use std::collections::BTreeMap;

use super::rules::ServerRules;
use super::watch::{Bounds, Watch};
use super::{Action, Event, Notice, dressed};
use crate::body::Body;
use crate::body::query::{Kind, Pace, Query};
use crate::header::Version;
use crate::message::Message;
use crate::name::{DeviceName, TypeName};

/// RTS_: it is done.
const SUCCESS: u8 = 0;
/// RTS_: it is not.
const ERROR: u8 = 1;
/// Skipped types that are counted each by its name; those beyond are counted together.
const MOST_TYPES: usize = 64;
const NS_PER_MS: i64 = 1_000_000;

/// A stream that a client has begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stream {
    pace: Pace,
    sent_ns: Option<i64>,
}

/// A server's session with one client.
#[derive(Debug, Clone)]
pub struct Server {
    rules: ServerRules,
    version: Version,
    streams: BTreeMap<Kind, Stream>,
    skipped: BTreeMap<TypeName, u64>,
    watch: Watch,
}

impl Server {
    /// With a client that was just accepted.
    pub fn new(rules: ServerRules, now_ns: i64) -> Self {
        let bounds = Bounds {
            silent_ns: None,
            stuck_ns: rules.stuck_ns,
            least_rate: rules.least_rate,
        };
        Self {
            rules,
            version: Version::One,
            streams: BTreeMap::new(),
            skipped: BTreeMap::new(),
            watch: Watch::new(bounds, now_ns),
        }
    }

    /// The version that this client is sent: 1 until it has spoken 2.
    pub const fn version(&self) -> Version {
        self.version
    }

    /// How many messages of which types were skipped; beyond 64 types, under no name.
    pub const fn skipped(&self) -> &BTreeMap<TypeName, u64> {
        &self.skipped
    }

    /// The pace of a stream that the client has begun.
    pub fn pace(&self, kind: Kind) -> Option<Pace> {
        self.streams.get(&kind).map(|stream| stream.pace)
    }

    /// Whether a message of this stream is to be sent now: the client has begun it, and the last one is as long ago as
    /// it asked for. Saying yes, it takes it for sent.
    pub fn take_due(&mut self, kind: Kind, now_ns: i64) -> bool {
        let Some(stream) = self.streams.get_mut(&kind) else {
            return false;
        };
        let every_ns = i64::from(stream.pace.resolution_ms) * NS_PER_MS;
        let is_due = stream
            .sent_ns
            .is_none_or(|sent| now_ns.saturating_sub(sent) >= every_ns);
        if is_due {
            stream.sent_ns = Some(now_ns);
        }
        is_due
    }

    /// What an event leads to.
    pub fn step(&mut self, event: Event<'_>, now_ns: i64) -> Vec<Action> {
        match (self.watch.step(&event, now_ns), event) {
            (Some(action), _) => vec![action],
            (None, Event::Received(message)) => self.received(message),
            (None, Event::Connected | Event::Closed) => {
                (self.version, self.streams) = (Version::One, BTreeMap::new());
                Vec::new()
            }
            _ => Vec::new(),
        }
    }

    fn received(&mut self, message: &Message<'_>) -> Vec<Action> {
        let mut actions = Vec::new();
        if message.version > self.version {
            self.version = message.version;
            actions.push(Action::Tell(Notice::SpeaksTwo));
        }
        let device = message.device;
        match &message.body {
            Body::Query(Query::Get(kind)) if self.rules.answers.contains(kind) => {
                actions.push(Action::Answer { kind: *kind, device });
            }
            Body::Query(Query::Start(kind, pace)) => self.begin(device, *kind, *pace, &mut actions),
            Body::Query(Query::Stop(kind)) => self.end(device, *kind, &mut actions),
            Body::Query(Query::Answer(kind, _)) => actions.push(Action::Tell(Notice::NotAsked(*kind))),
            Body::Command(command) => actions.push(Action::Command {
                device,
                command: command.clone(),
            }),
            body => actions.push(self.skip(body.kind())),
        }
        actions
    }

    /// A second STT_ takes the place of the first.
    fn begin(&mut self, device: DeviceName, kind: Kind, pace: Pace, actions: &mut Vec<Action>) {
        let is_had = self.rules.streams.contains(&kind) && pace.resolution_ms <= self.rules.longest_ms;
        if is_had {
            self.streams.insert(kind, Stream { pace, sent_ns: None });
        }
        let (notice, status) = if is_had {
            (Notice::Began { kind, pace }, SUCCESS)
        } else {
            (Notice::Refused { kind, pace }, ERROR)
        };
        actions.push(Action::Tell(notice));
        actions.push(self.answer(device, kind, status));
    }

    fn end(&mut self, device: DeviceName, kind: Kind, actions: &mut Vec<Action>) {
        let (notice, status) = match self.streams.remove(&kind) {
            Some(_) => (Notice::Ended(kind), SUCCESS),
            None => (Notice::NotBegun(kind), ERROR),
        };
        actions.push(Action::Tell(notice));
        actions.push(self.answer(device, kind, status));
    }

    fn answer(&self, device: DeviceName, kind: Kind, status: u8) -> Action {
        dressed(device, Body::Query(Query::Answer(kind, status)), self.version)
    }

    fn skip(&mut self, kind: TypeName) -> Action {
        let has_room = self.skipped.len() < MOST_TYPES || self.skipped.contains_key(&kind);
        let name = if has_room { kind } else { TypeName::EMPTY };
        let count = self.skipped.entry(name).or_default();
        *count = count.saturating_add(1);
        Action::Tell(Notice::Skipped(kind))
    }
}
