//! What a client and a server are told to do.

use crate::body::query::{Kind, Pace};
use crate::name::DeviceName;

const SECOND_NS: i64 = 1_000_000_000;
/// Bytes per second of a message that takes long: a poor network's, far from that of a peer that holds a connection for
/// nothing.
const LEAST_RATE: u64 = 64 << 10;

/// Which version of headers a server is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speaks {
    /// 2 from the first message on: PLUS, whose servers state no status before.
    Two,
    /// 1 for ever: servers that read nothing else.
    One,
    /// 1 until the server speaks 2.
    Follow,
    /// 2 at first, and for ever once a message of version 2 has come. Where no message comes in time, or a connection that lasted for
    /// that time ends before one of version 2 came, 1 at the next connection, and from then on if anything comes; else 2 again. Not for
    /// servers where a person confirms every connection, nor for those that end a connection at once when they are sent version 2.
    Auto,
}

/// One thing to ask for when a connection was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ask {
    /// Of which device; empty for any.
    pub device: DeviceName,
    /// What.
    pub kind: Kind,
    /// As a stream at this pace (STT_), or once (GET_).
    pub pace: Option<Pace>,
}

/// What a client does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientRules {
    /// Which version it speaks.
    pub speaks: Speaks,
    /// What it asks for when a connection was made, in this order.
    pub asks: Vec<Ask>,
    /// How long it waits for an answer (RTS_, or what GET_ asked for), ns.
    pub answer_ns: i64,
    /// It sends GET_STATUS this often, ns, so that a peer that is gone is found out; `None` for never.
    pub heartbeat_ns: Option<i64>,
    /// It closes after so long without a message, ns.
    pub silent_ns: i64,
    /// How long a message may take, whatever its length, ns.
    pub stuck_ns: i64,
    /// It closes where a message that takes longer comes at less than this rate, bytes per second.
    pub least_rate: u64,
    /// With [`Speaks::Auto`]: how long a server that was sent version 2 may be silent, and how long a connection lasts that shows its
    /// version by its end, ns.
    pub auto_ns: i64,
}

impl Default for ClientRules {
    /// Asks for nothing; a heartbeat and answers within 1 s, silence of at most 3 s, messages of 2 s or at 64 KiB/s.
    fn default() -> Self {
        Self {
            speaks: Speaks::Follow,
            asks: Vec::new(),
            answer_ns: SECOND_NS,
            heartbeat_ns: Some(SECOND_NS),
            silent_ns: 3 * SECOND_NS,
            stuck_ns: 2 * SECOND_NS,
            least_rate: LEAST_RATE,
            auto_ns: SECOND_NS,
        }
    }
}

/// What a server does for a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerRules {
    /// What it sends once where it is asked (GET_).
    pub answers: Vec<Kind>,
    /// What it sends as a stream where it is asked (STT_).
    pub streams: Vec<Kind>,
    /// The longest time between two messages of a stream that a client may ask for, ms: a stream that never comes is
    /// none.
    pub longest_ms: u32,
    /// How long a message may take, whatever its length, ns. A client that says nothing may stay.
    pub stuck_ns: i64,
    /// It closes where a message that takes longer comes at less than this rate, bytes per second.
    pub least_rate: u64,
}

impl Default for ServerRules {
    /// Tools and status; a message a minute at least; messages of 2 s or at 64 KiB/s.
    fn default() -> Self {
        Self {
            answers: vec![Kind::Status, Kind::Capability, Kind::Tdata],
            streams: vec![Kind::Tdata, Kind::Qtdata],
            longest_ms: 60_000,
            stuck_ns: 2 * SECOND_NS,
            least_rate: LEAST_RATE,
        }
    }
}
