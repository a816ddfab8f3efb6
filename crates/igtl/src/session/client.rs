//! The side that dials: it asks for what it wants, and waits for answers for as long as it is told to.

use super::rules::{Ask, ClientRules, Speaks};
use super::watch::{Bounds, Watch};
use super::{Action, Event, Notice, Reason, dressed};
use crate::body::Body;
use crate::body::query::{Kind, Query, Verb};
use crate::header::Version;
use crate::message::Message;
use crate::name::DeviceName;

/// A question that is not answered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Awaited {
    verb: Verb,
    kind: Kind,
    until_ns: i64,
}

/// A client's session, over all its connections: what it found out of its server it keeps.
#[derive(Debug, Clone)]
pub struct Client {
    rules: ClientRules,
    version: Version,
    /// [`Speaks::Auto`] has found that the server does not read version 2.
    fell_back: bool,
    /// A whole message has come on this connection.
    heard: bool,
    /// One of version 2 has come, on this connection or one before: what is silent after that is silent for another reason.
    reads_two: bool,
    connected_ns: i64,
    beat_ns: i64,
    awaited: Vec<Awaited>,
    watch: Watch,
}

impl Client {
    /// Not connected yet.
    pub fn new(rules: ClientRules) -> Self {
        let bounds = Bounds {
            silent_ns: Some(rules.silent_ns),
            stuck_ns: rules.stuck_ns,
            least_rate: rules.least_rate,
        };
        Self {
            rules,
            version: Version::One,
            fell_back: false,
            heard: false,
            reads_two: false,
            connected_ns: 0,
            beat_ns: 0,
            awaited: Vec::new(),
            watch: Watch::new(bounds, 0),
        }
    }

    /// The version that the server is sent now.
    pub const fn version(&self) -> Version {
        self.version
    }

    /// What an event leads to.
    pub fn step(&mut self, event: Event<'_>, now_ns: i64) -> Vec<Action> {
        let mut actions = Vec::new();
        // A peer that does not read version 2 is silent like one that is gone: the first is found out first.
        if let (Event::Tick { .. }, Some(fallen)) = (&event, self.fallen_back(now_ns)) {
            return fallen;
        }
        match self.watch.step(&event, now_ns) {
            Some(close @ Action::Close(_)) => return vec![close],
            Some(other) => actions.push(other),
            None => {}
        }
        match event {
            Event::Connected => actions.extend(self.connected(now_ns)),
            Event::Received(message) => self.received(message, &mut actions),
            Event::Refused(_) => {}
            Event::Tick { .. } => self.tick(now_ns, &mut actions),
            Event::Closed => actions.extend(self.closed(now_ns)),
        }
        actions
    }

    fn connected(&mut self, now_ns: i64) -> Vec<Action> {
        self.version = match self.rules.speaks {
            Speaks::Two => Version::Two,
            Speaks::Auto if self.reads_two || !self.fell_back => Version::Two,
            Speaks::One | Speaks::Follow | Speaks::Auto => Version::One,
        };
        self.heard = false;
        (self.connected_ns, self.beat_ns) = (now_ns, now_ns);
        self.awaited.clear();
        let asks = self.rules.asks.clone();
        let mut actions: Vec<Action> = asks.iter().map(|ask| self.asked(ask, now_ns)).collect();
        // PLUS states a status only to who has spoken version 2, so something is said even where nothing is asked for.
        if actions.is_empty() && self.rules.heartbeat_ns.is_some() {
            actions.push(self.beat(now_ns));
        }
        actions
    }

    fn asked(&mut self, ask: &Ask, now_ns: i64) -> Action {
        let query = match ask.pace {
            Some(pace) => Query::Start(ask.kind, pace),
            None => Query::Get(ask.kind),
        };
        self.awaited.push(Awaited {
            verb: query.verb(),
            kind: ask.kind,
            until_ns: now_ns.saturating_add(self.rules.answer_ns),
        });
        dressed(ask.device, Body::Query(query), self.version)
    }

    fn beat(&mut self, now_ns: i64) -> Action {
        self.beat_ns = now_ns;
        dressed(DeviceName::EMPTY, Body::Query(Query::Get(Kind::Status)), self.version)
    }

    /// What a connection that is over says of the version that its server reads. One that sends version 1 unasked may
    /// have spoken before it fell silent at our version 2; with version 1 nothing is lost of what it says. One that was
    /// over at once says nothing: a server that is starting ends it too, and states no status to who speaks version 1.
    fn closed(&mut self, now_ns: i64) -> Option<Action> {
        self.awaited.clear();
        if self.rules.speaks != Speaks::Auto || self.reads_two {
            return None;
        }
        let is_long = now_ns.saturating_sub(self.connected_ns) >= self.rules.auto_ns;
        match self.version {
            Version::Two if is_long && !self.fell_back => {
                self.fell_back = true;
                Some(Action::Tell(Notice::NoneOfTwo))
            }
            // Neither version was answered: the server was not there at all, and may read version 2 when it is.
            Version::One if !self.heard => {
                self.fell_back = false;
                None
            }
            _ => None,
        }
    }

    fn fallen_back(&mut self, now_ns: i64) -> Option<Vec<Action>> {
        let may_read_one = self.rules.speaks == Speaks::Auto && !self.reads_two;
        let waits = may_read_one && self.version == Version::Two && !self.heard;
        let ns = self.rules.auto_ns;
        if !waits || now_ns.saturating_sub(self.connected_ns) <= ns {
            return None;
        }
        self.fell_back = true;
        Some(vec![
            Action::Tell(Notice::FellBack),
            Action::Close(Reason::NotVersionTwo { ns }),
        ])
    }

    fn received(&mut self, message: &Message<'_>, actions: &mut Vec<Action>) {
        self.heard = true;
        self.reads_two |= message.version == Version::Two;
        let rises = self.rules.speaks == Speaks::Follow && self.version == Version::One;
        if rises && message.version == Version::Two {
            self.version = Version::Two;
            actions.push(Action::Tell(Notice::SpeaksTwo));
        }
        match &message.body {
            Body::Query(Query::Answer(kind, status)) => actions.extend(self.answered(*kind, *status)),
            Body::Query(query) => {
                let skipped = Notice::Skipped(Body::Query(*query).kind());
                actions.push(Action::Tell(skipped));
            }
            Body::Other { kind, .. } => actions.push(Action::Tell(Notice::Skipped(*kind))),
            body => self.got(body),
        }
    }

    /// An RTS_; those to a STP_ are waited for by nobody.
    fn answered(&mut self, kind: Kind, status: u8) -> Option<Action> {
        let place = self.place(Verb::Start, kind);
        match place {
            None => Some(Action::Tell(Notice::NotAsked(kind))),
            Some(place) => {
                self.awaited.remove(place);
                (status != 0).then_some(Action::Tell(Notice::RefusedByPeer { kind, status }))
            }
        }
    }

    fn place(&self, verb: Verb, kind: Kind) -> Option<usize> {
        self.awaited.iter().position(|one| one.verb == verb && one.kind == kind)
    }

    /// A message answers a GET_ of its type.
    fn got(&mut self, body: &Body<'_>) {
        let name = body.kind();
        let kind = Kind::all().find(|kind| name == *kind.message());
        if let Some(place) = kind.and_then(|kind| self.place(Verb::Get, kind)) {
            self.awaited.remove(place);
        }
    }

    fn tick(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        let limit_ns = self.rules.answer_ns;
        let late: Vec<Awaited> = self.awaited.extract_if(.., |one| now_ns > one.until_ns).collect();
        actions.extend(late.into_iter().map(|one| {
            Action::Tell(Notice::Unanswered {
                kind: one.kind,
                limit_ns,
            })
        }));
        let due = self
            .rules
            .heartbeat_ns
            .is_some_and(|every| now_ns.saturating_sub(self.beat_ns) >= every);
        if due {
            actions.push(self.beat(now_ns));
        }
    }

    /// What ends the streams that were asked for, before a connection is closed by its user.
    pub fn farewell(&self) -> Vec<Message<'static>> {
        let streams = self.rules.asks.iter().filter(|ask| ask.pace.is_some());
        streams
            .map(|ask| Message::new(ask.device, Body::Query(Query::Stop(ask.kind))).in_version(self.version))
            .collect()
    }
}
