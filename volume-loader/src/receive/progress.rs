//! What is told of an association while it goes on.

use std::io;
use std::net::SocketAddr;

use bus::clock::monotonic_ns;

use super::association::Count;

/// Says something of a peer to a person.
pub(super) fn tell(peer: SocketAddr, words: &str) {
    bus::stderr_line!("volume-loader: {peer}: {words}");
}

/// How far an association is: a line that is written over on a terminal, a line now and then elsewhere.
pub(super) struct Progress {
    peer: SocketAddr,
    began_ns: i64,
    next_ns: i64,
    every_ns: i64,
    is_terminal: bool,
    is_shown: bool,
}

impl Progress {
    pub(super) fn new(peer: SocketAddr) -> Self {
        let is_terminal = io::IsTerminal::is_terminal(&io::stderr());
        let every_ns = if is_terminal { 100_000_000 } else { 2_000_000_000 };
        let began_ns = monotonic_ns();
        Self {
            peer,
            began_ns,
            next_ns: began_ns + every_ns,
            every_ns,
            is_terminal,
            is_shown: false,
        }
    }

    pub(super) fn at(&mut self, count: Count) {
        let now_ns = monotonic_ns();
        if now_ns < self.next_ns {
            return;
        }
        self.next_ns = now_ns + self.every_ns;
        let mib = count.bytes as f64 / f64::from(1 << 20);
        let rate = mib / ((now_ns - self.began_ns) as f64 / 1e9);
        let text = format!("receiving: {} instances, {mib:.1} MiB, {rate:.1} MiB/s", count.kept);
        if self.is_terminal {
            let _ = io::Write::write_all(&mut io::stderr(), format!("\r{text}   ").as_bytes());
            self.is_shown = true;
        } else {
            tell(self.peer, &text);
        }
    }

    pub(super) fn finish(&self) {
        if self.is_shown {
            bus::stderr_line!("");
        }
    }
}
