//! What a client and a server do, as step functions: an event and the time go in, what is to be done comes out.
//!
//! A session knows no socket. Its driver reads bytes into a [`crate::Decoder`], hands over what that says as an
//! [`Event`], carries out the [`Action`]s, and hands over [`Event::Tick`] at least as often as a time limit is to be
//! kept. Times are ns of any clock that does not go back.
//!
//! # Which version a peer is sent
//!
//! A header of version 2 ends the session of a peer that reads version 1 alone: its body stays in the stream and is
//! taken for headers. A PLUS server states the status of tools only to who has sent it a message of version 2. So
//! [`Speaks`] is told or found out, and a server sends version 1 until its client has spoken 2.

mod client;
mod rules;
mod server;
mod watch;

pub use client::Client;
pub use rules::{Ask, ClientRules, ServerRules, Speaks};
pub use server::Server;

use crate::body::query::{Kind, Pace};
use crate::body::words::Command;
use crate::header::Version;
use crate::malformed::Malformed;
use crate::message::Message;
use crate::name::{DeviceName, TypeName};

/// What happened on a connection.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// It was made.
    Connected,
    /// A message came.
    Received(&'a Message<'a>),
    /// What came was refused.
    Refused(&'a Malformed),
    /// Time went by.
    Tick {
        /// Bytes of a message that has begun and is not whole, 0 between messages: [`crate::Decoder::come`].
        come: u64,
    },
    /// The connection is gone, whoever closed it.
    Closed,
}

/// What is to be done. All of it concerns this connection alone.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Send this, in one call.
    Send(Message<'static>),
    /// A client wants this once, in the version of its session: [`Server::version`].
    Answer {
        /// What.
        kind: Kind,
        /// Of which device; empty for any.
        device: DeviceName,
    },
    /// A client wants something to be done; it is owed an RTS_COMMAND with the same number.
    Command {
        /// For which device.
        device: DeviceName,
        /// What.
        command: Command,
    },
    /// Say this, or count it.
    Tell(Notice),
    /// Close the connection. Nothing else is to be done any more.
    Close(Reason),
}

/// What a person may want to know. None of it ends the session.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Notice {
    /// The peer will not send what was asked for.
    #[error("the peer refuses to send {} (status {status})", .kind.message())]
    RefusedByPeer {
        /// What was asked for.
        kind: Kind,
        /// The peer's status; 0 would be success.
        status: u8,
    },
    /// The peer has not answered in time; it may still send what was asked for.
    #[error("no answer to the request for {} within {:.1} s", .kind.message(), seconds(*.limit_ns))]
    Unanswered {
        /// What was asked for.
        kind: Kind,
        /// The time limit.
        limit_ns: i64,
    },
    /// An answer to what was not asked, or was answered already.
    #[error("an answer for {} that nothing waits for", .0.message())]
    NotAsked(Kind),
    /// A message of a type that is not read here; it was skipped.
    #[error("a message of type {0} was skipped")]
    Skipped(TypeName),
    /// The peer has sent a message of version 2: from now on it is sent such.
    #[error("the peer speaks header version 2")]
    SpeaksTwo,
    /// The peer fell silent after a message of version 2: it is sent version 1 from the next connection on.
    #[error("the peer fell silent after a header of version 2: it is sent version 1 from now on")]
    FellBack,
    /// A connection is over on which no message of version 2 came: the peer is sent version 1 from the next connection on.
    #[error("the peer sent no message of version 2 while the connection lasted: it is sent version 1 from now on")]
    NoneOfTwo,
    /// A message was refused; the session goes on.
    #[error("{0}")]
    Malformed(Malformed),
    /// A client began or changed a stream.
    #[error("sends {} every {} ms", .kind.message(), .pace.resolution_ms)]
    Began {
        /// Of what.
        kind: Kind,
        /// How often, in which frame.
        pace: Pace,
    },
    /// A client ended a stream.
    #[error("sends {} no longer", .0.message())]
    Ended(Kind),
    /// A client asked for a stream that is not to be had, or not at this pace.
    #[error("refuses to send {} every {} ms", .kind.message(), .pace.resolution_ms)]
    Refused {
        /// Of what.
        kind: Kind,
        /// How often, in which frame.
        pace: Pace,
    },
    /// A client ended a stream that it had not begun.
    #[error("a client ends {} without having begun it", .0.message())]
    NotBegun(Kind),
}

/// Why a connection is closed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// No whole message came for this long.
    #[error("nothing was heard for {:.1} s", seconds(*.ns))]
    Silent {
        /// How long.
        ns: i64,
    },
    /// A message has begun and comes too slowly.
    #[error("{come} bytes of a message in {:.1} s", seconds(*.ns))]
    Stuck {
        /// How many bytes.
        come: u64,
        /// In how long.
        ns: i64,
    },
    /// Too many messages one after the other were refused.
    #[error("{count} messages one after the other were refused; the last: {last}")]
    TooManyRefused {
        /// How many.
        count: u32,
        /// The last of them.
        last: Malformed,
    },
    /// The stream cannot go on.
    #[error("{0}")]
    Malformed(Malformed),
    /// The peer fell silent after a header of version 2; the next connection speaks version 1.
    #[error("no whole message within {:.1} s of a header of version 2", seconds(*.ns))]
    NotVersionTwo {
        /// The time limit.
        ns: i64,
    },
}

/// A time for people.
fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// A message of a session, in the version that its peer is sent.
fn dressed(device: DeviceName, body: crate::body::Body<'static>, version: Version) -> Action {
    Action::Send(Message::new(device, body).in_version(version))
}
