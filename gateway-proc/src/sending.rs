//! A message on its way to one client.

use std::io::{self, ErrorKind, Write};
use std::net::TcpStream;
use std::sync::Arc;

use rustix::net::sockopt::set_socket_send_buffer_size;

use crate::letter::Wire;

/// A client that takes nothing for so long is closed, ns.
const NOTHING_NS: i64 = 1_000_000_000;
/// One that takes little is closed where a message takes longer than this, ns, ...
const LONG_NS: i64 = 10_000_000_000;
/// ... at less than this, bytes per second.
const LEAST_RATE: i128 = 64 << 10;
/// What the system keeps for a client beside its own buffer, bytes: old poses that it has not taken yet are of no use.
pub(crate) const SMALL_BUFFER: usize = 32 << 10;
/// The same while something large is on its way.
const LARGE_BUFFER: usize = 1 << 20;
/// From here on a message is large, bytes.
const LARGE: usize = 256 << 10;

/// How far a write got.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sent {
    /// To the end.
    All,
    /// The system takes no more at the moment.
    Part,
}

#[derive(Debug)]
pub(crate) struct Sending {
    wire: Arc<Wire>,
    sent: usize,
    begun_ns: i64,
    moved_ns: i64,
}

impl Sending {
    pub(crate) fn begin(stream: &TcpStream, wire: Arc<Wire>, now_ns: i64) -> Self {
        if wire.len() >= LARGE {
            // Where the system refuses, it takes longer.
            let _ = set_socket_send_buffer_size(stream, LARGE_BUFFER);
        }
        Self {
            wire,
            sent: 0,
            begun_ns: now_ns,
            moved_ns: now_ns,
        }
    }

    /// Hands all that is left to the system in one call, and what it does not take in another.
    pub(crate) fn write(&mut self, mut stream: &TcpStream, now_ns: i64) -> io::Result<Sent> {
        while self.sent < self.wire.len() {
            match stream.write_vectored(&self.wire.rest(self.sent)) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.sent += count;
                    self.moved_ns = now_ns;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(Sent::Part),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        if self.is_large() {
            let _ = set_socket_send_buffer_size(stream, SMALL_BUFFER);
        }
        Ok(Sent::All)
    }

    /// How many bytes the system has taken of it.
    pub(crate) const fn sent(&self) -> usize {
        self.sent
    }

    /// Whether it is one that a client takes a while to unpack.
    pub(crate) fn is_large(&self) -> bool {
        self.wire.len() >= LARGE
    }

    /// Why the client is too slow, where it is.
    pub(crate) fn is_slow(&self, now_ns: i64) -> Option<String> {
        let still_ns = now_ns.saturating_sub(self.moved_ns);
        if still_ns > NOTHING_NS {
            return Some(format!(
                "it took nothing for 1 s, with {} of {} bytes of a message sent",
                self.sent,
                self.wire.len()
            ));
        }
        let ns = now_ns.saturating_sub(self.begun_ns);
        let needed = LEAST_RATE * i128::from(ns) / 1_000_000_000;
        let is_slow = ns > LONG_NS && (self.sent as i128) < needed;
        is_slow.then(|| format!("it took {} bytes of a message in {} s", self.sent, ns / 1_000_000_000))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tell::string;
    use igtl::{Stamp, Version};
    use std::net::TcpListener;

    #[test]
    fn a_client_that_takes_nothing_or_a_trickle_is_too_slow() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let wire = string("State", "LIVE", Stamp::NONE).wire(Version::One).unwrap();
        let mut sending = Sending::begin(&stream, wire, 0);
        assert_eq!(
            (sending.is_slow(NOTHING_NS), sending.is_slow(NOTHING_NS + 1).is_some()),
            (None, true)
        );
        sending.moved_ns = LONG_NS;
        assert_eq!(sending.is_slow(LONG_NS), None);
        assert!(sending.is_slow(LONG_NS + 1).unwrap().contains("in 10 s"));
        sending.sent = 2 << 20;
        assert_eq!(sending.is_slow(LONG_NS + 1), None);
    }
}
