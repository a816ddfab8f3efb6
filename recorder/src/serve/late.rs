//! Closes connections that read more slowly than messages come. The system takes megabytes on for them, and what they show is then tens of
//! seconds old and looks like the present: who is closed shows that it is disconnected, once it has read what was taken on for it.
//!
//! The server has no way to close one client, so its socket is found among those of this process.

use std::collections::BTreeMap;
use std::net::{Shutdown, SocketAddr, TcpStream};

use rustix::process::{PidfdFlags, PidfdGetfdFlags, getpid, pidfd_getfd, pidfd_open};

/// Between two looks, ns.
const EVERY_NS: i64 = 500_000_000;
/// Bytes that wait for a connection: more than all messages of a moment.
const QUEUED: u64 = 128 << 10;
/// In so many looks in a row more waits for it: it does not catch up.
const LOOKS: u32 = 4;

/// Follows what waits for each connection to a port of this process.
#[derive(Debug)]
pub(super) struct Late {
    port: u16,
    next_ns: i64,
    /// By the other end's port: in how many looks in a row too much waited.
    looks: BTreeMap<u16, u32>,
}

impl Late {
    /// Of the server on `port`.
    pub(super) fn new(port: u16) -> Self {
        let (next_ns, looks) = (i64::MIN, BTreeMap::new());
        Self { port, next_ns, looks }
    }

    /// Looks, if it is time, and closes those that are too late; `steady_ns` is of a clock that never stands still.
    pub(super) fn step(&mut self, steady_ns: i64) {
        if steady_ns < self.next_ns {
            return;
        }
        self.next_ns = steady_ns.saturating_add(EVERY_NS);
        // Where the system has no such table there is nothing to go by; docs/foxglove.md says what that means.
        let tables = ["tcp", "tcp6"].map(|name| std::fs::read_to_string(format!("/proc/self/net/{name}")));
        let found = tables.iter().flatten().flat_map(|table| queued(table, self.port));
        let late = self.late(found.collect());
        if !late.is_empty() {
            close(self.port, &late);
            // Until it is gone it is not closed in every look.
            self.looks.retain(|peer, _| !late.contains(peer));
        }
    }

    /// Takes what waits for each; those for whom too much waited for long.
    fn late(&mut self, queued: Vec<(u16, u64)>) -> Vec<u16> {
        let before = std::mem::take(&mut self.looks);
        let too_much = queued.into_iter().filter(|(_, bytes)| *bytes > QUEUED);
        self.looks = too_much
            .map(|(peer, _)| (peer, before.get(&peer).map_or(1, |n| n + 1)))
            .collect();
        self.looks
            .iter()
            .filter(|(_, looks)| **looks >= LOOKS)
            .map(|(peer, _)| *peer)
            .collect()
    }
}

/// The other end's port and the bytes that wait, of each connection of a table of `/proc/net/tcp` whose own port is `port`.
fn queued(table: &str, port: u16) -> impl Iterator<Item = (u16, u64)> {
    table.lines().filter_map(move |line| {
        let mut words = line.split_whitespace().skip(1);
        let mut end = || u16::from_str_radix(words.next()?.rsplit_once(':')?.1, 16).ok();
        let (own, peer) = (end()?, end()?);
        let (waiting, _) = words.nth(1)?.split_once(':')?;
        (own == port).then_some((peer, u64::from_str_radix(waiting, 16).ok()?))
    })
}

/// Closes the connections of this process from `port` to the `peers`.
fn close(port: u16, peers: &[u16]) {
    let Ok(own) = pidfd_open(getpid(), PidfdFlags::empty()) else {
        return;
    };
    let Ok(numbers) = std::fs::read_dir("/proc/self/fd") else {
        return;
    };
    let numbers = numbers
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    for number in numbers.collect::<Vec<i32>>() {
        // A file that is no socket has no addresses.
        let Ok(file) = pidfd_getfd(&own, number, PidfdGetfdFlags::empty()) else {
            continue;
        };
        let socket = TcpStream::from(file);
        let ends = [socket.local_addr(), socket.peer_addr()].map(|end| end.as_ref().map_or(0, SocketAddr::port));
        if ends[0] == port && peers.contains(&ends[1]) && socket.shutdown(Shutdown::Both).is_ok() {
            bus::stderr_line!(
                "recorder: a client (port {}) reads too slowly and is closed: it showed what was old",
                ends[1]
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str =
        "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
   0: 0100007F:223D 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 1 1 0 100 0 0 10 0
   1: 0100007F:223D 0100007F:D431 01 00030D40:00000007 01:00000014 00000000     0        0 2 1 0 20 4 30 10 -1
   2: 0100007F:D431 0100007F:223D 01 00000000:0002FAF0 00:00000000 00000000     0        0 3 1 0 20 4 30 10 -1
rubbish
   3: 0100007F";

    #[test]
    fn what_waits_for_a_connection_is_read_of_the_systems_table() {
        let found: Vec<_> = queued(TABLE, 8765).collect();
        assert_eq!(found, [(0, 0), (0xd431, 200_000)]);
    }

    #[test]
    fn a_connection_is_late_where_too_much_waits_for_it_in_every_look_of_two_seconds() {
        let mut late = Late::new(8765);
        let (slow, quick) = ((1, QUEUED + 1), (2, QUEUED));
        for _ in 1..LOOKS {
            assert!(late.late(vec![slow, quick]).is_empty());
        }
        assert_eq!(late.late(vec![slow, quick]), [1]);
        // It caught up once.
        assert!(late.late(vec![(1, 0), quick]).is_empty());
        assert!(late.late(vec![slow, quick]).is_empty());
    }
}
