//! What each connection said, held against what a receiver has to say.

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use bus::clock::ns;

/// Bytes a second that a receiver may say beside its questions for pieces: ten questions for the clock and its signs of life were 410
/// by TCP, and TLS adds 22 to each of 13.
pub(super) const RATE: f64 = 2048.0;
/// The most that it may be ahead of that: handshakes, certificate and what it follows are some 4 kB.
pub(super) const BURST: f64 = 16_384.0;
/// For so many bytes that it took, it may say one more: a question for a piece of 128 KiB has fewer than 256.
pub(super) const TAKEN_FOR_ONE: f64 = 512.0;
/// How long an address is not let in again.
pub(super) const SHUT_OUT: Duration = Duration::from_secs(60);
/// Addresses that are kept out at a time, at most.
const MOST_SHUT_OUT: usize = 1024;
/// The memory that this process has for itself, above which the connection is cut off that said most beyond [`USUAL`]; where none did,
/// all are, once in [`SHUT_OUT`]: with them goes what zenoh keeps of them, and good receivers are back at once.
pub(super) const MEMORY: u64 = 128 << 20;
/// Bytes a second of a receiver that looks on, and how far above a good one may be.
const USUAL: f64 = 1024.0;
const ABOVE_USUAL: f64 = 8192.0;

/// A connection as it is now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Looked {
    pub(super) peer: SocketAddr,
    /// Bytes that came over it in all.
    pub(super) said: u64,
    /// Bytes that its other end took in all.
    pub(super) taken: u64,
}

/// Why a connection is cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Why {
    /// It says more than a receiver has to.
    Says,
    /// The process has too much memory, and this one says most.
    Memory,
    /// The process has too much memory, and no connection says more than the others.
    Anew,
    /// It came back too early.
    ShutOut,
}

#[derive(Debug)]
struct Said {
    since_ns: i64,
    looked_ns: i64,
    last: Looked,
    ahead: f64,
}

impl Said {
    fn new(now: i64, peer: SocketAddr) -> Self {
        Self {
            since_ns: now,
            looked_ns: now,
            last: Looked {
                peer,
                said: 0,
                taken: 0,
            },
            ahead: 0.0,
        }
    }

    fn look(&mut self, now: i64, looked: Looked) {
        let (said, taken) = (
            looked.said.saturating_sub(self.last.said),
            looked.taken.saturating_sub(self.last.taken),
        );
        let may = RATE * seconds(now - self.looked_ns) + taken as f64 / TAKEN_FOR_ONE;
        self.ahead = (self.ahead + said as f64 - may).max(0.0);
        (self.looked_ns, self.last) = (now, looked);
    }

    /// Bytes beyond what a receiver that looks on says.
    fn above_usual(&self) -> f64 {
        self.last.said as f64 - self.last.taken as f64 / TAKEN_FOR_ONE - USUAL * seconds(self.looked_ns - self.since_ns)
    }
}

fn seconds(of_ns: i64) -> f64 {
    bus::clock::ms(of_ns) / 1e3
}

/// All connections.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    open: HashMap<SocketAddr, Said>,
    /// Until when each address is kept out.
    shut_out: HashMap<IpAddr, i64>,
    /// When all may be cut off again, as memory is short.
    next_anew_ns: i64,
}

impl Ledger {
    /// Whom to cut off, and why, at `now` on CLOCK_MONOTONIC, where the process has `memory` bytes for itself.
    pub(super) fn look(&mut self, now: i64, looked: &[Looked], memory: u64) -> Vec<(SocketAddr, Why)> {
        self.shut_out.retain(|_, until_ns| *until_ns > now);
        self.open.retain(|peer, _| looked.iter().any(|one| one.peer == *peer));
        let mut cut = Vec::new();
        for one in looked {
            let is_new = !self.open.contains_key(&one.peer);
            if is_new && self.shut_out.contains_key(&one.peer.ip().to_canonical()) {
                cut.push((one.peer, Why::ShutOut));
                continue;
            }
            let said = self.open.entry(one.peer).or_insert_with(|| Said::new(now, one.peer));
            said.look(now, *one);
            if said.ahead > BURST {
                cut.push((one.peer, Why::Says));
            }
        }
        if memory > MEMORY && cut.iter().all(|(_, why)| *why == Why::ShutOut) {
            cut.extend(self.short_of_memory(now));
        }
        for (peer, why) in &cut {
            self.open.remove(peer);
            if matches!(why, Why::Says | Why::Memory) {
                self.shut_out(now, peer.ip().to_canonical());
            }
        }
        cut
    }

    fn short_of_memory(&mut self, now: i64) -> Vec<(SocketAddr, Why)> {
        if let Some(loudest) = self.loudest() {
            return vec![(loudest, Why::Memory)];
        }
        if now < self.next_anew_ns {
            return Vec::new();
        }
        self.next_anew_ns = now.saturating_add(ns(SHUT_OUT));
        self.open.keys().map(|peer| (*peer, Why::Anew)).collect()
    }

    fn shut_out(&mut self, now: i64, ip: IpAddr) {
        if self.shut_out.len() < MOST_SHUT_OUT || self.shut_out.contains_key(&ip) {
            self.shut_out.insert(ip, now.saturating_add(ns(SHUT_OUT)));
        }
    }

    /// Whether somebody is kept out, so that it must be looked often who comes.
    pub(super) fn is_guarding(&self) -> bool {
        !self.shut_out.is_empty()
    }

    fn loudest(&self) -> Option<SocketAddr> {
        let loud = self.open.iter().map(|(peer, said)| (*peer, said.above_usual()));
        let loudest = loud.max_by(|one, other| one.1.total_cmp(&other.1))?;
        (loudest.1 > ABOVE_USUAL).then_some(loudest.0)
    }
}

#[cfg(test)]
mod tests;
