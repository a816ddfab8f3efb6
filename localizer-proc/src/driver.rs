//! What a protocol does with the bytes of a connection, as a step function: no socket, no clock of its own.

use bus::message::{EmitterSight, Lost};
use geometry::{Marker, Rigid, Tracker};
use scene::tracking::{EmitterSource, PosedMarkers};
use serde::{Deserialize, Serialize};

use crate::openigtlink::Picture;

/// What is made of what a localizer sees.
#[derive(Debug, Clone, Copy)]
pub enum Follows<'a> {
    /// Poses of markers, made by the localizer.
    Markers(&'a PosedMarkers),
    /// Single markers, of which the tracker makes poses.
    Emitters(&'a EmitterSource),
}

/// What is to be done. Times are ns on the run's clock, which is the only one here.
#[derive(Debug, Clone, PartialEq)]
pub enum Act {
    /// Send this, in one call.
    Send(Vec<u8>),
    /// Publish this.
    Frame(Frame),
    /// Publish single markers of a frame, in which no marker has a pose.
    Emitters(Frame, Places),
    /// Publish this image of an ultrasound scanner.
    Image(Box<Picture>),
    /// A person should know, once.
    Tell(String),
    /// Something that is only counted was left out.
    Refused,
    /// Close the connection, for this reason. Nothing else is to be done any more.
    Close(String),
}

/// What a localizer saw at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its own stamp, ns of its clock; 0 where it states none.
    pub device_ns: i64,
    /// When the first byte that holds some of it had arrived: what the law of its clock is made of.
    pub first_ns: i64,
    /// When the last had.
    pub arrival_ns: i64,
    /// When it was asked for; the same as `first_ns` where nobody asks.
    pub asked_ns: i64,
    /// Its markers, each once.
    pub seen: Vec<Seen>,
}

impl Frame {
    /// One that came in one reply at `now_ns`, to a question of `asked_ns`.
    pub(crate) fn of_device(device_ns: Option<i64>, (asked_ns, now_ns): (i64, i64), seen: Vec<Seen>) -> Self {
        Self {
            device_ns: device_ns.unwrap_or(0),
            first_ns: now_ns,
            arrival_ns: now_ns,
            asked_ns,
            seen,
        }
    }

    /// From the question to the first byte of the answer, ns.
    pub(crate) fn in_question_ns(&self) -> i64 {
        self.first_ns.saturating_sub(self.asked_ns).max(0)
    }
}

/// Single markers at one instant, by their numbers, with their places in the localizer's frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places {
    /// Those on the surgeon's tool.
    pub tool: Vec<EmitterSight>,
    /// Those on the patient.
    pub patient: Vec<EmitterSight>,
}

/// One marker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Its number in a frame of the bus.
    pub marker: u32,
    /// `tracker_from_marker` with the error of fit that the localizer states, mm (0 for none), or why there is none.
    pub outcome: Result<(Rigid<Tracker, Marker>, f64), Lost>,
}

/// What is known of a peer over all its connections, for a process that follows.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Where the scene names no tool: the names that came, as bytes of the wire.
    pub tools: Vec<Vec<u8>>,
    /// Numbers of the markers of which it has stated a status.
    pub stated: Vec<u32>,
}

/// A protocol with one peer, over all its connections.
pub trait Driver {
    /// What a process that follows is to know.
    fn known(&self) -> Known {
        Known::default()
    }

    /// Goes on from what the process before knew; before the first connection.
    fn go_on(&mut self, _known: Known) {}

    /// A connection was made.
    fn connected(&mut self, now_ns: i64) -> Vec<Act>;

    /// Bytes came, the last of them at `now_ns`.
    fn bytes(&mut self, bytes: &[u8], now_ns: i64) -> Vec<Act>;

    /// Time went by.
    fn tick(&mut self, now_ns: i64) -> Vec<Act>;

    /// The connection is gone, whoever closed it.
    fn closed(&mut self, now_ns: i64) -> Vec<Act>;

    /// When [`Driver::tick`] has something to do next, if before the next look.
    fn due_ns(&self) -> Option<i64>;

    /// What is wrong with a connection that is made, for people, in few words; empty for nothing.
    fn wrong(&self) -> String {
        String::new()
    }

    /// How a connection stands that is made, for people; empty for nothing to say.
    fn words(&self) -> String;

    /// The markers that it looks for.
    fn markers(&self) -> Vec<u32>;

    /// Whether another connection is to be made without a person.
    fn reconnects(&self) -> bool;
}
