//! A peer that speaks OpenIGTLink: its poses of tools as frames of markers.
//!
//! Names are those of the scene ([`names`]), never guessed. A pose counts where its peer says that it is good ([`stated`], [`status`]), says
//! nothing else under the same stamp ([`instants`], [`twins`]), and its numbers are a rotation and a place ([`pose`]): [`tools`]. One kind of
//! message of each marker makes frames ([`sources`]). TRANSFORMs are gathered by their stamps ([`gather`]); a TDATA is of one instant.
//! IMAGEs of an ultrasound scanner are passed on where the scene asks for them ([`images`]).

mod gather;
mod images;
mod instants;
mod names;
mod pose;
mod reason;
mod sources;
mod stated;
mod status;
#[cfg(test)]
mod tests;
mod together;
mod tools;
mod twins;
mod words;

use bus::clock;
use igtl::session::{self, Action, Ask, Client, ClientRules, Event, Speaks};
use igtl::{Body, Decoder, DeviceName, Kind, Limits, Message, Pace, Recovery, Stamp};
use scene::localizer::{OpenIgtLinkSpec, Peer, Reconnect};
use scene::tracking::PosedMarkers;

use crate::driver::{Act, Driver, Known};
use crate::state::Once;
use gather::Gather;
use images::Images;
use instants::Instants;
use names::Names;
use reason::Reason;
use sources::Sources;
use together::Together;
use twins::Twins;

pub(crate) use images::Picture;
pub(crate) use names::NamesError;

/// What is read of a peer: as much as an image has only where the scene asks for images.
const fn limits(has_images: bool) -> Limits {
    Limits {
        body: if has_images {
            images::MOST_BYTES
        } else {
            Limits::POSES.body
        },
        ..Limits::POSES
    }
}

/// Characters of a peer's own words that are told: the field of them may have some thousand.
const MOST_WORDS: usize = 200;

/// The client's side.
pub(crate) struct OpenIgtLink {
    spec: OpenIgtLinkSpec,
    names: Names,
    session: Client,
    decoder: Decoder,
    gather: Gather,
    twins: Twins,
    instants: Instants,
    sources: Sources,
    together: Together,
    /// The images that the scene asks for; `None`: none.
    images: Option<Images>,
    /// Markers of which the peer has stated a status, on this connection or one before.
    stated: Vec<u32>,
    /// Why a pose was refused last.
    reason: Reason,
    /// The peer reads version 1 alone, as this connection has shown: the next one is part of the first.
    falls_back: bool,
    /// What was told on this connection.
    told: Once,
    /// How many messages were refused.
    refused: u64,
    now_ns: i64,
}

impl OpenIgtLink {
    /// Not connected yet.
    ///
    /// # Errors
    /// [`NamesError`].
    pub(crate) fn new(spec: &OpenIgtLinkSpec, markers: &PosedMarkers) -> Result<Self, NamesError> {
        let names = Names::new(markers)?;
        let pace = |every: std::time::Duration| Pace {
            // At most 1000 ms by the scene.
            resolution_ms: every.as_millis() as u32,
            frame: igtl::Name::EMPTY,
        };
        let asks = spec.stream.map(|every| Ask {
            device: DeviceName::EMPTY,
            kind: Kind::Tdata,
            pace: Some(pace(every)),
        });
        let rules = ClientRules {
            speaks: match spec.peer {
                Peer::Auto => Speaks::Auto,
                Peer::Plus => Speaks::Two,
                Peer::V1 => Speaks::One,
            },
            asks: asks.into_iter().collect(),
            silent_ns: clock::ns(spec.silent),
            ..ClientRules::default()
        };
        Ok(Self {
            spec: spec.clone(),
            gather: Gather::new(names.markers()),
            instants: Instants::new(spec.max_rotation_error),
            sources: Sources::new(names.markers()),
            together: Together::new(&names.markers()),
            names,
            session: Client::new(rules),
            decoder: Decoder::new(limits(spec.images.is_some())),
            images: spec.images.as_ref().map(Images::new),
            twins: Twins::default(),
            stated: Vec::new(),
            reason: Reason::default(),
            falls_back: false,
            told: Once::default(),
            refused: 0,
            now_ns: 0,
        })
    }

    /// What the session wants done.
    fn carry_out(&mut self, actions: Vec<Action>, acts: &mut Vec<Act>) {
        for action in actions {
            match action {
                Action::Send(message) => acts.extend(message.to_vec().ok().map(Act::Send)),
                Action::Tell(notice) => acts.extend(self.told.say(notice.to_string())),
                Action::Close(reason) => {
                    self.falls_back = matches!(reason, session::Reason::NotVersionTwo { .. });
                    acts.push(Act::Close(reason.to_string()));
                }
                // A client is asked for nothing that it would answer.
                Action::Answer { .. } | Action::Command { .. } => {}
            }
        }
    }

    fn received(&mut self, message: &Message<'_>, acts: &mut Vec<Act>) {
        let allowed = self.spec.max_rotation_error;
        match &message.body {
            Body::Transform(matrix) => self.one(message, pose::of_matrix(matrix, allowed), acts),
            Body::Position(position) | Body::Qtrans(position) => {
                self.one(message, pose::of_position(position, allowed), acts);
            }
            Body::Tdata(tools) => {
                let pose = |tool: &igtl::Tool<igtl::Matrix>| pose::of_matrix(&tool.pose, allowed);
                let tools: Vec<_> = tools.iter().map(|tool| (tool.name, tool.kind, pose(tool))).collect();
                self.several(message, tools, acts);
            }
            Body::Qtdata(tools) => {
                let pose = |tool: &igtl::Tool<igtl::Placed>| pose::of_placed(&tool.pose, allowed);
                let tools: Vec<_> = tools.iter().map(|tool| (tool.name, tool.kind, pose(tool))).collect();
                self.several(message, tools, acts);
            }
            Body::Image(image) => self.image(message, image, acts),
            Body::Status(status) if status.code != igtl::Status::OK => {
                // Words of a peer go to a terminal: nothing in them may steer it.
                let words = String::from_utf8_lossy(&status.words);
                let words: String = words.escape_debug().take(MOST_WORDS).collect();
                let (code, name) = (status.code, &status.name);
                acts.extend(self.told.say(format!("the peer's STATUS is {code} {name}: {words}")));
            }
            _ => {}
        }
    }

    /// A message of an image.
    fn image(&mut self, message: &Message<'_>, image: &igtl::Image<'_>, acts: &mut Vec<Act>) {
        let name = &message.device;
        let taken = self
            .images
            .as_mut()
            .and_then(|images| images.take(message, image, self.now_ns));
        match taken {
            None => {
                let words = format!(
                    "the peer sends images {name}, which localizer.images does not name: they are not passed on"
                );
                acts.extend(self.told.say(words));
            }
            Some(Ok(picture)) => acts.push(Act::Image(Box::new(picture))),
            Some(Err(error)) => {
                acts.push(Act::Refused);
                acts.extend(self.told.say(format!("image {name} refused: {error}")));
            }
        }
    }
}

/// A stamp as ns; 0 where there is none.
fn stamp_ns(stamp: Stamp) -> i64 {
    // 32 bits of seconds are 4.3e18 ns at most, which 64 bits with a sign hold.
    i64::try_from(stamp.ns()).unwrap_or(0)
}

impl Driver for OpenIgtLink {
    fn known(&self) -> Known {
        Known {
            tools: self.names.came(),
            stated: self.stated.clone(),
        }
    }

    fn go_on(&mut self, known: Known) {
        self.names.go_on(&known.tools);
        self.stated = known.stated;
    }

    fn connected(&mut self, now_ns: i64) -> Vec<Act> {
        self.now_ns = now_ns;
        self.decoder = Decoder::new(limits(self.images.is_some()));
        self.images.iter_mut().for_each(Images::forget);
        self.gather = Gather::new(self.names.markers());
        self.twins = Twins::default();
        self.instants = Instants::new(self.spec.max_rotation_error);
        self.sources = Sources::new(self.names.markers());
        self.together = Together::new(&self.names.markers());
        self.reason = Reason::default();
        self.falls_back = false;
        self.told = Once::default();
        self.names.forget();
        let mut acts = Vec::new();
        let actions = self.session.step(Event::Connected, now_ns);
        self.carry_out(actions, &mut acts);
        acts
    }

    fn bytes(&mut self, mut bytes: &[u8], now_ns: i64) -> Vec<Act> {
        self.now_ns = now_ns;
        let mut acts = Vec::new();
        while !acts.iter().any(|act| matches!(act, Act::Close(_))) {
            let Some(taken) = self.decoder.feed(&mut bytes) else {
                break;
            };
            match taken.map(Message::into_owned) {
                Ok(message) => {
                    let actions = self.session.step(Event::Received(&message), now_ns);
                    self.carry_out(actions, &mut acts);
                    self.received(&message, &mut acts);
                }
                Err(malformed) => {
                    self.refused += 1;
                    acts.push(Act::Refused);
                    let ended = self.gather.damage();
                    self.go_out(ended, &mut acts);
                    let actions = self.session.step(Event::Refused(&malformed), now_ns);
                    self.carry_out(actions, &mut acts);
                    if malformed.recovery == Recovery::Close {
                        let at = self.decoder.began().saturating_add(malformed.at);
                        acts.push(Act::Close(format!("{malformed} (byte {at} of the connection)")));
                    }
                }
            }
        }
        acts
    }

    fn tick(&mut self, now_ns: i64) -> Vec<Act> {
        self.now_ns = now_ns;
        let mut acts = Vec::new();
        let expired = self.gather.expired(now_ns);
        self.go_out(expired, &mut acts);
        let come = self.decoder.come();
        let actions = self.session.step(Event::Tick { come }, now_ns);
        self.carry_out(actions, &mut acts);
        acts
    }

    fn closed(&mut self, now_ns: i64) -> Vec<Act> {
        let mut acts = Vec::new();
        let actions = self.session.step(Event::Closed, now_ns);
        self.carry_out(actions, &mut acts);
        acts
    }

    fn due_ns(&self) -> Option<i64> {
        self.gather.due_ns()
    }

    fn wrong(&self) -> String {
        let is_missing = |marker: &u32| !self.instants.know(*marker);
        let unmapped = match self.names.markers().iter().any(is_missing) {
            true => self.names.unmapped(),
            false => String::new(),
        };
        let parts = [self.reason.words(self.now_ns), &unmapped];
        let parts: Vec<&str> = parts.into_iter().filter(|words| !words.is_empty()).collect();
        parts.join("; ")
    }

    fn words(&self) -> String {
        let version = match self.session.version() {
            igtl::Version::One => 1,
            igtl::Version::Two => 2,
        };
        let refused = match self.refused {
            0 => String::new(),
            n => format!(", {n} messages refused"),
        };
        let used = self.names.used();
        // Where a marker of the scene has not come, they are what is wrong.
        let unmapped = match self.names.unmapped() {
            words if words.is_empty() || self.wrong().contains(&words) => String::new(),
            words => format!(", {words}"),
        };
        format!("version {version}{used}{refused}{unmapped}")
    }

    fn markers(&self) -> Vec<u32> {
        self.names.markers()
    }

    fn reconnects(&self) -> bool {
        self.falls_back || self.spec.reconnect == Reconnect::Always
    }
}
