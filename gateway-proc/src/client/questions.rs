//! What a client asks, and what it is told.

use std::sync::Arc;

use bus::clock::monotonic_ns;
use igtl::{Body, Command, DeviceName, Kind, Message, Query, TypeName};

use super::Client;
use crate::commands;
use crate::hall::Kept;
use crate::letter::Letter;
use crate::mailbox::Slot;
use crate::tell::{NOT_FOUND, NOT_READY, named, reference_marker, refusal, tool_marker};
use crate::volume::VOLUME;

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
    /// The images of a view, or of all, as a stream.
    pub(super) fn wish(&mut self, device: DeviceName, starts: bool) {
        let mailbox = &self.place.mailbox;
        if device.is_empty() {
            mailbox.wish(None, |wish| wish.stream = starts);
        } else if let Some(view) = self.view(device) {
            mailbox.wish(Some(view), |wish| wish.stream = starts);
        } else {
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
        let hall = &self.place.hall;
        let newest = match kind {
            Kind::Status => hall.newest(Slot::Status),
            Kind::Capability => Some(Arc::new(capability())),
            Kind::Transform => match self.slot(device) {
                Some(slot) => self.placed(slot),
                None => {
                    let words = format!("there is no transform {device:?}; GET_TRANS of no name asks for the tool's");
                    Some(Arc::new(refusal(NOT_FOUND, &words)))
                }
            },
            Kind::Tdata => self.placed(Slot::Tdata),
            Kind::Point => hall.kept(Kept::Points),
            Kind::String => hall.kept(Kept::State),
            Kind::Image => return self.image(device),
            _ => None,
        };
        let none = || Arc::new(refusal(NOT_READY, "there is nothing of this to be sent yet"));
        self.queue(newest.unwrap_or_else(none));
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

    /// A pose that may be sent to this client now, or else how the tool is, in words.
    fn placed(&self, slot: Slot) -> Option<Arc<Letter>> {
        let hall = &self.place.hall;
        let letter = hall.newest(slot);
        let letter = letter.filter(|letter| letter.holds_at(monotonic_ns()));
        let letter = letter.filter(|letter| letter.wire(self.session.version()).is_some());
        letter.or_else(|| match slot {
            Slot::Tool | Slot::Tdata => hall.newest(Slot::Status),
            _ => Some(Arc::new(refusal(NOT_FOUND, "there is no pose of this marker now"))),
        })
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

    pub(super) fn command(&mut self, device: DeviceName, asked: &Command) {
        let answer = commands::answer(device, asked, |name| self.said_of(name));
        self.queue(Arc::new(answer));
    }

    fn said_of(&self, name: &str) -> Option<String> {
        match name {
            "Version" => Some(format!("Trocar {}", env!("CARGO_PKG_VERSION"))),
            "State" => Some(self.place.hall.state()),
            "Devices" => {
                let views = self.known.views.iter().flatten();
                let fixed = [
                    self.known.origin.tool(),
                    tool_marker(),
                    reference_marker(),
                    named(VOLUME),
                ];
                let all: Vec<String> = fixed.iter().chain(views).map(ToString::to_string).collect();
                Some(all.join(" "))
            }
            _ => None,
        }
    }
}

fn capability() -> Letter {
    let types = TYPES.iter().filter_map(|name| TypeName::new(name).ok()).collect();
    Letter::new(Message::new(DeviceName::EMPTY, Body::Capability(types)))
}
