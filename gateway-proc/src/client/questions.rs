//! What a client asks, and what it is told.

use std::sync::Arc;

use bus::clock::monotonic_ns;
use igtl::session::Action;
use igtl::{Body, DeviceName, Kind, Message, Query, TypeName};

use super::{Answer, Client};
use crate::commands;
use crate::hall::Kept;
use crate::letter::Letter;
use crate::mailbox::Slot;
use crate::tell::{NOT_FOUND, NOT_READY, named, reference_marker, refusal, tool_marker};
use crate::volume::VOLUME;

/// RTS_: it is done.
const SUCCESS: u8 = 0;
/// RTS_: it is not.
const ERROR: u8 = 1;
/// What was said last was that there is a pose; it has grown old since, and nothing else was said.
const NOT_KNOWN: &str = "NOT KNOWN: how the tool is was not said in time";
/// What is answered once.
pub(super) const ANSWERED: [Kind; 7] = [
    Kind::Status,
    Kind::Capability,
    Kind::Transform,
    Kind::Tdata,
    Kind::Point,
    Kind::String,
    Kind::Image,
];
/// What is sent as a stream.
pub(super) const STREAMED: [Kind; 2] = [Kind::Tdata, Kind::Image];
/// What stands in CAPABILITY: what is sent, and what is read.
const TYPES: [&str; 21] = [
    "TRANSFORM",
    "TDATA",
    "STATUS",
    "STRING",
    "POINT",
    "IMAGE",
    "CAPABILITY",
    "GET_TRANS",
    "GET_TDATA",
    "GET_STATUS",
    "GET_STRING",
    "GET_POINT",
    "GET_IMAGE",
    "GET_CAPABIL",
    "STT_TDATA",
    "STP_TDATA",
    "RTS_TDATA",
    "STT_IMAGE",
    "STP_IMAGE",
    "RTS_IMAGE",
    "RTS_COMMAND",
];

/// Of which device a stream of images is to begin (or to end: `false`).
pub(super) fn image_wish(message: &Message<'_>) -> Option<(DeviceName, bool)> {
    match message.body {
        Body::Query(Query::Start(Kind::Image, _)) => Some((message.device, true)),
        Body::Query(Query::Stop(Kind::Image)) => Some((message.device, false)),
        _ => None,
    }
}

impl Client<'_> {
    /// The images of a view, or of all, as a stream from now on, or no longer. The session knows streams by their type alone: what it
    /// answers is corrected by what becomes of each view's.
    pub(super) fn wish(&mut self, device: DeviceName, starts: bool, actions: &mut [Action]) {
        let view = self.view(device);
        let answer = actions.iter_mut().find_map(|action| match action {
            Action::Send(message) => match &mut message.body {
                Body::Query(Query::Answer(Kind::Image, status)) => Some(status),
                _ => None,
            },
            _ => None,
        });
        let Some(status) = answer else { return };
        // One that would come too seldom is not begun.
        let is_granted = !starts || *status == SUCCESS;
        let is_known = device.is_empty() || view.is_some();
        let mailbox = &self.place.mailbox;
        let had = mailbox.streams(view);
        if is_granted && is_known {
            mailbox.wish(view, |wish| {
                wish.stream = starts;
                wish.owed = starts;
            });
        }
        let is_done = is_granted && is_known && (starts || had);
        *status = if is_done { SUCCESS } else { ERROR };
        if !is_known {
            self.no_such(device);
        }
    }

    fn view(&self, device: DeviceName) -> Option<usize> {
        self.known.views.iter().position(|view| *view == Some(device))
    }

    fn no_such(&mut self, device: DeviceName) {
        let there = self.known.views.iter().flatten().map(ToString::to_string);
        let there: Vec<String> = std::iter::once(VOLUME.to_owned()).chain(there).collect();
        let words = format!("there is no image {device:?}; there are {}", there.join(", "));
        self.queue(Arc::new(refusal(NOT_FOUND, &words)));
    }

    pub(super) fn answer(&mut self, kind: Kind, device: DeviceName) {
        let answer = match kind {
            Kind::Status => Answer::Newest(Slot::Status),
            Kind::Transform => match self.slot(device) {
                Some(slot) => Answer::Newest(slot),
                None => {
                    let words = format!("there is no transform {device:?}; GET_TRANS of no name asks for the tool's");
                    Answer::Said(Arc::new(refusal(NOT_FOUND, &words)))
                }
            },
            Kind::Tdata => Answer::Newest(Slot::Tdata),
            Kind::Capability => Answer::Said(Arc::new(capability())),
            Kind::Point => Answer::Kept(Kept::Points),
            Kind::String => Answer::Kept(Kept::State),
            Kind::Image => return self.image(device),
            _ => Answer::Said(nothing()),
        };
        self.owe(answer);
    }

    /// An answer whose turn has come: what holds now, in this client's version.
    pub(super) fn said(&self, answer: &Answer) -> Arc<Letter> {
        let hall = &self.place.hall;
        let holds =
            |letter: &Arc<Letter>| letter.holds_at(monotonic_ns()) && letter.wire(self.session.version()).is_some();
        match answer {
            Answer::Said(letter) => Arc::clone(letter),
            Answer::Newest(slot @ (Slot::ToolMarker | Slot::ReferenceMarker)) => hall
                .newest(*slot)
                .filter(holds)
                .unwrap_or_else(|| Arc::new(refusal(NOT_FOUND, "there is no pose of this marker now"))),
            Answer::Newest(slot) => {
                let own = hall.newest(*slot).filter(holds);
                // Or else how the tool is, in words.
                let words = || hall.newest(Slot::Status).map(|letter| Some(letter).filter(holds));
                own.unwrap_or_else(|| words().map_or_else(nothing, |words| words.unwrap_or_else(not_known)))
            }
            Answer::Kept(kept) => {
                let letter = hall.kept(*kept);
                letter.map_or_else(nothing, |letter| Some(letter).filter(holds).unwrap_or_else(not_known))
            }
            Answer::Asked(device, command) => Arc::new(commands::answer(*device, command, |name| self.said_of(name))),
        }
    }

    fn slot(&self, device: DeviceName) -> Option<Slot> {
        if device.is_empty() || device == self.known.origin.tool() {
            return Some(Slot::Tool);
        }
        let markers = [
            (tool_marker(), Slot::ToolMarker),
            (reference_marker(), Slot::ReferenceMarker),
        ];
        markers
            .into_iter()
            .find(|(name, _)| *name == device)
            .map(|(_, slot)| slot)
    }

    fn image(&mut self, device: DeviceName) {
        if device.is_empty() || device == VOLUME {
            self.place.mailbox.wish_volume(self.session.version());
        } else if let Some(view) = self.view(device) {
            self.place.mailbox.wish(Some(view), |wish| wish.once = true);
        } else {
            self.no_such(device);
        }
    }

    fn said_of(&self, name: &str) -> Option<String> {
        match name {
            "Version" => Some(format!("Trocar {}", env!("CARGO_PKG_VERSION"))),
            "State" => {
                let hall = &self.place.hall;
                let said = hall.kept(Kept::State);
                let holds = said.is_none_or(|letter| letter.holds_at(monotonic_ns()));
                Some(if holds { hall.state() } else { NOT_KNOWN.to_owned() })
            }
            "Devices" => {
                let markers = [tool_marker(), reference_marker()];
                let markers = markers.into_iter().filter(|_| self.known.has_markers);
                let fixed = [self.known.origin.tool()]
                    .into_iter()
                    .chain(markers)
                    .chain([named(VOLUME)]);
                let views = self.known.views.iter().flatten().copied();
                let all: Vec<String> = fixed.chain(views).map(|device| device.to_string()).collect();
                Some(all.join(" "))
            }
            _ => None,
        }
    }
}

fn nothing() -> Arc<Letter> {
    Arc::new(refusal(NOT_READY, "there is nothing of this to be sent yet"))
}

fn not_known() -> Arc<Letter> {
    Arc::new(refusal(NOT_READY, NOT_KNOWN))
}

fn capability() -> Letter {
    let types = TYPES.iter().filter_map(|name| TypeName::new(name).ok()).collect();
    Letter::new(Message::new(DeviceName::EMPTY, Body::Capability(types)))
}
