//! A peer that speaks OpenIGTLink: its poses of tools as frames of markers.
//!
//! Names are those of the scene ([`names`]), never guessed. A pose counts where its peer says that it is good ([`status`]) and its
//! numbers are a rotation and a place ([`pose`]). TRANSFORMs are gathered by their stamps ([`gather`]); a TDATA is of one instant. IMAGEs of
//! an ultrasound scanner are passed on where the scene asks for them ([`images`]).

mod gather;
mod images;
mod names;
mod pose;
mod status;
#[cfg(test)]
mod tests;
mod twins;

use bus::clock;
use bus::message::Lost;
use igtl::session::{Action, Ask, Client, ClientRules, Event, Reason, Speaks};
use igtl::{Body, Decoder, DeviceName, Kind, Limits, Message, Pace, Recovery, Stamp, ToolKind, ToolStatus};
use scene::localizer::{OpenIgtLinkSpec, Peer, Reconnect, StatusRule};
use scene::tracking::PosedMarkers;

use crate::driver::{Act, Driver, Frame, Seen};
use crate::state::Once;
use gather::Gather;
use images::Images;
use names::{Named, Names};
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
    /// The images that the scene asks for; `None`: none.
    images: Option<Images>,
    /// Markers of which this connection's peer has stated a status.
    stated: Vec<u32>,
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
            names,
            session: Client::new(rules),
            decoder: Decoder::new(limits(spec.images.is_some())),
            images: spec.images.as_ref().map(Images::new),
            twins: Twins::default(),
            stated: Vec::new(),
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
                    self.falls_back = matches!(reason, Reason::NotVersionTwo { .. });
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

    /// A message of one tool.
    fn one(&mut self, message: &Message<'_>, pose: Result<pose::Tool, pose::PoseError>, acts: &mut Vec<Act>) {
        let status = ToolStatus::of_transform(&message.metadata);
        let Some(mut seen) = self.seen(&message.device, &status, pose, acts) else {
            return;
        };
        if self.twins.are_two(message.stamp, &seen, self.now_ns) {
            let name = &message.device;
            let words =
                format!("the peer sends {name} twice at one time, at two places: two tools with one name have no pose");
            acts.extend(self.told.say(words));
            self.gather.refuse(seen.marker);
            seen.outcome = Err(Lost::Refused);
        }
        let frames = self.gather.add(message.stamp, seen, self.now_ns);
        if self.gather.is_alone() && self.names.markers().len() > 1 {
            let words = "the peer's stamps do not say which poses are of one instant: those of tool and patient are not combined";
            acts.extend(self.told.say(words.to_owned()));
        }
        acts.extend(frames.into_iter().map(Act::Frame));
    }

    /// A message of all tools of one instant. One that is not in it was not seen.
    fn several(
        &mut self,
        message: &Message<'_>,
        tools: Vec<(DeviceName, ToolKind, Result<pose::Tool, pose::PoseError>)>,
        acts: &mut Vec<Act>,
    ) {
        acts.extend(self.gather.close().map(Act::Frame));
        let mut all: Vec<Seen> = Vec::with_capacity(tools.len());
        for (name, kind, pose) in tools {
            let (status, pose) = match self.names.status(&message.metadata, &name) {
                Ok(status) => (status, pose),
                Err(words) => (ToolStatus::Ok, Err(pose::PoseError::Whose(words))),
            };
            let pose = match kind {
                ToolKind::Six => pose,
                // The turn of a 3D or 5D tool means nothing, and the tracker itself is no tool.
                other => Err(pose::PoseError::Kind(other.word())),
            };
            let Some(seen) = self.seen(&name, &status, pose, acts) else {
                continue;
            };
            match all.iter_mut().find(|other| other.marker == seen.marker) {
                // Two tools that may be the surgeon's, where the scene names none: neither is.
                Some(other) => other.outcome = Err(Lost::Refused),
                None => all.push(seen),
            }
        }
        acts.push(Act::Frame(Frame {
            device_ns: stamp_ns(message.stamp),
            first_ns: self.now_ns,
            arrival_ns: self.now_ns,
            asked_ns: self.now_ns,
            seen: all,
        }));
    }

    /// A tool of a message as a marker of the scene; none where the scene does not name it.
    fn seen(
        &mut self,
        name: &DeviceName,
        status: &ToolStatus,
        pose: Result<pose::Tool, pose::PoseError>,
        acts: &mut Vec<Act>,
    ) -> Option<Seen> {
        let marker = match self.names.find(name) {
            Named::Marker(marker) => marker,
            Named::Unknown(words) => {
                acts.extend(self.told.say(words));
                return None;
            }
            Named::Known => return None,
        };
        // A peer that names two tools where the scene names none may mean either.
        if let Some(ambiguous) = self.names.ambiguous() {
            acts.extend(self.told.say(ambiguous));
            let outcome = Err(Lost::Refused);
            return Some(Seen { marker, outcome });
        }
        if *status != ToolStatus::Absent && !self.stated.contains(&marker) {
            self.stated.push(marker);
        }
        // Who states it now and then leaves it out of what it does not know.
        let rule = match self.stated.contains(&marker) {
            true => StatusRule::Required,
            false => self.spec.status,
        };
        let outcome = match status::judge(status, rule) {
            Err((lost, words)) => {
                acts.extend(words.and_then(|words| self.told.say(format!("{name}: {words}"))));
                Err(lost)
            }
            Ok(()) => pose
                .and_then(|tool| pose::not_near(tool, self.spec.least_distance_mm))
                .map(|tool| (tool, 0.0))
                .map_err(|error| {
                    acts.push(Act::Refused);
                    acts.extend(self.told.say(format!("{name}: {error}")));
                    Lost::Refused
                }),
        };
        Some(Seen { marker, outcome })
    }
}

/// A stamp as ns; 0 where there is none.
fn stamp_ns(stamp: Stamp) -> i64 {
    // 32 bits of seconds are 4.3e18 ns at most, which 64 bits with a sign hold.
    i64::try_from(stamp.ns()).unwrap_or(0)
}

impl Driver for OpenIgtLink {
    fn connected(&mut self, now_ns: i64) -> Vec<Act> {
        self.now_ns = now_ns;
        self.decoder = Decoder::new(limits(self.images.is_some()));
        self.images.iter_mut().for_each(Images::forget);
        self.gather = Gather::new(self.names.markers());
        self.twins = Twins::default();
        self.stated.clear();
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
        let mut acts: Vec<Act> = self.gather.expired(now_ns).into_iter().map(Act::Frame).collect();
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

    fn words(&self) -> String {
        let version = match self.session.version() {
            igtl::Version::One => 1,
            igtl::Version::Two => 2,
        };
        let refused = match self.refused {
            0 => String::new(),
            n => format!(", {n} messages refused"),
        };
        let unmapped = self.names.unmapped();
        format!("version {version}{refused}{unmapped}")
    }

    fn markers(&self) -> Vec<u32> {
        self.names.markers()
    }

    fn reconnects(&self) -> bool {
        self.falls_back || self.spec.reconnect == Reconnect::Always
    }
}
