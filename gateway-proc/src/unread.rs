//! What a client on this machine has not read. Linux acknowledges what lies in a receiver's buffer, and lets that buffer grow to
//! megabytes: on the connection itself a program that has stopped reading looks like one that reads, for many minutes of poses. Where
//! both ends are here the system can be asked for the other end's queue too (`sock_diag(7)`).

use std::net::{IpAddr, SocketAddr, TcpStream};
use std::os::fd::OwnedFd;

use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType, netlink, recv, send, socket_with};

/// A client on this machine that reads nothing for so long is closed, ns, ...
const NOTHING_NS: i64 = 1_000_000_000;
/// ... and one that was sent something large has the time to unpack it beside: bytes per second of a slow reader.
const UNPACKED_RATE: u64 = 32 << 20;
/// So far behind something large it may read ahead before it unpacks, bytes.
const AHEAD: u64 = 1 << 20;

/// `struct nlmsghdr` and `struct inet_diag_req_v2`.
const ASKED: usize = 16 + 56;
/// Where `idiag_rqueue` and `idiag_wqueue` stand in the answer: behind the header, four bytes, the connection, and the timer.
const QUEUES: usize = 16 + 4 + 48 + 4;
/// The type of question and answer alike, `SOCK_DIAG_BY_FAMILY`.
const BY_FAMILY: u16 = 20;
/// `TCP_LISTEN`.
const LISTENS: u8 = 10;
/// `NLM_F_REQUEST`.
const REQUEST: u16 = 1;

/// Bytes that wait on a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Waiting {
    /// In the client's system, unread.
    pub(crate) there: u64,
    /// Here, not acknowledged.
    pub(crate) here: u64,
}

/// Asks for the queues of a connection whose both ends are on this machine.
#[derive(Debug)]
pub(crate) struct Queues {
    diag: OwnedFd,
    ours: SocketAddr,
    theirs: SocketAddr,
    number: u32,
}

impl Queues {
    /// `None` where the system does not tell.
    pub(crate) fn of(stream: &TcpStream) -> Option<Self> {
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let protocol = Some(netlink::SOCK_DIAG);
        let diag = socket_with(AddressFamily::NETLINK, SocketType::RAW, flags, protocol);
        Some(Self {
            diag: diag.ok()?,
            ours: plain(stream.local_addr().ok()?),
            theirs: plain(stream.peer_addr().ok()?),
            number: 0,
        })
    }

    /// What waits now; `None` where the client's end is not here, or the system does not tell.
    pub(crate) fn waiting(&mut self) -> Option<Waiting> {
        // Ours first: what is on its way meanwhile is counted twice, and never as read.
        let (_, here) = self.queues(self.ours, self.theirs)?;
        let (there, _) = self.queues(self.theirs, self.ours)?;
        Some(Waiting { there, here })
    }

    /// Of the socket at `from` that is connected to `to`: what came and was not read, and what was sent and not acknowledged.
    fn queues(&mut self, from: SocketAddr, to: SocketAddr) -> Option<(u64, u64)> {
        self.number = self.number.wrapping_add(1);
        send(&self.diag, &asked(from, to, self.number), SendFlags::DONTWAIT).ok()?;
        let mut bytes = [0; 1024];
        loop {
            // The answer lies there once the question is sent.
            let (count, _) = recv(&self.diag, &mut bytes[..], RecvFlags::DONTWAIT).ok()?;
            let answer = bytes.get(..count)?;
            if number(answer, 8)? == self.number {
                return queues_of(answer);
            }
        }
    }
}

/// The address as a client's own socket has it: a server that listens to both families sees those of the old one in the new.
fn plain(address: SocketAddr) -> SocketAddr {
    SocketAddr::new(address.ip().to_canonical(), address.port())
}

/// The question, in the order of this machine's bytes; ports and addresses in the network's.
fn asked(from: SocketAddr, to: SocketAddr, number: u32) -> Vec<u8> {
    let family = if from.is_ipv4() {
        AddressFamily::INET
    } else {
        AddressFamily::INET6
    };
    let mut bytes = Vec::with_capacity(ASKED);
    bytes.extend((ASKED as u32).to_ne_bytes());
    bytes.extend(BY_FAMILY.to_ne_bytes());
    bytes.extend(REQUEST.to_ne_bytes());
    bytes.extend(number.to_ne_bytes());
    bytes.extend([0; 4]);
    // The family, TCP (6), nothing beside, in every state.
    bytes.extend([family.as_raw() as u8, 6, 0, 0, 0xff, 0xff, 0xff, 0xff]);
    bytes.extend(from.port().to_be_bytes());
    bytes.extend(to.port().to_be_bytes());
    for address in [from, to] {
        let mut field = [0; 16];
        match address.ip() {
            IpAddr::V4(ip) => field[..4].copy_from_slice(&ip.octets()),
            IpAddr::V6(ip) => field = ip.octets(),
        }
        bytes.extend(field);
    }
    // On any interface; no cookie.
    bytes.extend([0; 4]);
    bytes.extend([0xff; 8]);
    bytes
}

fn number(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_ne_bytes(four.try_into().ok()?))
}

/// `None` where it is an error: there is no such socket here. In place of a connection the system may give who listens at its port; the
/// numbers of that one are of something else.
fn queues_of(answer: &[u8]) -> Option<(u64, u64)> {
    let (kind, state) = (answer.get(4..6)?, answer.get(17)?);
    if kind != BY_FAMILY.to_ne_bytes() || *state == LISTENS {
        return None;
    }
    Some((number(answer, QUEUES)?.into(), number(answer, QUEUES + 4)?.into()))
}

/// For how long a client has read nothing. Pure.
#[derive(Debug)]
pub(crate) struct Patience {
    read: u64,
    since_ns: i64,
}

impl Patience {
    pub(crate) const fn new(now_ns: i64) -> Self {
        Self {
            read: 0,
            since_ns: now_ns,
        }
    }

    /// Why the client is to be closed, if it is: of `sent` bytes so many wait. `large`: where the last large message ended, and its length.
    pub(crate) fn step(
        &mut self,
        (sent, large): (u64, Option<(u64, u64)>),
        waiting: Waiting,
        now_ns: i64,
    ) -> Option<String> {
        let read = sent.saturating_sub(waiting.here).saturating_sub(waiting.there);
        if read > self.read || waiting.there == 0 {
            *self = Self {
                read: read.max(self.read),
                since_ns: now_ns,
            };
            return None;
        }
        let large = large.filter(|(end, _)| read < end.saturating_add(AHEAD));
        let unpacks_ms = large.map_or(0, |(_, length)| length * 1000 / UNPACKED_RATE);
        let limit_ns = i64::try_from(unpacks_ms)
            .unwrap_or(i64::MAX)
            .saturating_mul(1_000_000)
            .saturating_add(NOTHING_NS);
        (now_ns.saturating_sub(self.since_ns) > limit_ns).then(|| {
            format!(
                "it read nothing for {:.1} s, and {} bytes wait in its system",
                limit_ns as f64 / 1e9,
                waiting.there
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpListener;

    const SECOND: i64 = 1_000_000_000;

    #[test]
    #[allow(clippy::print_stdout, reason = "why a test was skipped")]
    fn what_a_client_has_not_read_is_seen_from_here() {
        for address in ["127.0.0.1:0", "[::1]:0"] {
            let Ok(listener) = TcpListener::bind(address) else {
                continue;
            };
            let mut client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (mut server, _) = listener.accept().unwrap();
            let Some(mut queues) = Queues::of(&server) else { return };
            server.write_all(&[7; 1000]).unwrap();
            let Some(waiting) = queues.waiting() else {
                // Clients are then judged by what our own socket takes.
                println!("skipped: this kernel does not tell of sockets (sock_diag)");
                return;
            };
            assert_eq!(waiting, Waiting { there: 1000, here: 0 });
            client.read_exact(&mut [0; 300]).unwrap();
            assert_eq!(queues.waiting().unwrap().there, 700);
            // A client elsewhere may have the number of a port that is listened at here.
            queues.theirs = listener.local_addr().unwrap();
            queues.ours.set_port(9);
            assert_eq!(queues.queues(queues.theirs, queues.ours), None);
        }
    }

    #[test]
    fn who_reads_nothing_for_a_second_is_closed_and_who_reads_a_byte_or_is_sent_nothing_is_not() {
        let waits = |there| Waiting { there, here: 0 };
        let mut patience = Patience::new(0);
        assert_eq!(patience.step((500, None), waits(0), 10 * SECOND), None);
        assert_eq!(patience.step((600, None), waits(100), 11 * SECOND), None);
        let why = patience.step((700, None), waits(200), 11 * SECOND + 1).unwrap();
        assert_eq!(why, "it read nothing for 1.0 s, and 200 bytes wait in its system");
        assert_eq!(patience.step((800, None), waits(299), 12 * SECOND), None);
        // What waits here was read by nobody.
        let both = Waiting { there: 299, here: 5000 };
        assert!(patience.step((5800, None), both, 13 * SECOND + 1).is_some());
    }

    #[test]
    fn who_unpacks_something_large_has_the_time_for_it() {
        let waits = |there| Waiting { there, here: 0 };
        let (large, end) = (200 << 20, (200 << 20) + 50);
        let mut patience = Patience::new(0);
        patience.step((end, Some((end, large))), waits(0), 0);
        assert_eq!(
            patience.step((end + 500, Some((end, large))), waits(500), 7 * SECOND),
            None
        );
        let closed = patience.step((end + 500, Some((end, large))), waits(500), 8 * SECOND);
        assert!(closed.unwrap().starts_with("it read nothing for 7.2 s"));
        // Farther on it has been unpacked long ago.
        let on = end + AHEAD;
        patience.step((on, Some((end, large))), waits(0), 9 * SECOND);
        assert!(
            patience
                .step((on + 9, Some((end, large))), waits(9), 10 * SECOND + 1)
                .is_some()
        );
    }
}
