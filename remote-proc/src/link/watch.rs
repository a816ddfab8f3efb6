//! Receivers that say more than a receiver has to are cut off.
//!
//! Access control denies what is none of a receiver's business. But zenoh lets numbers of keys and interests pass it, keeps each, any
//! number of them, and compares each with all others: a receiver that goes on declaring takes memory and the time of the one thread
//! that poses go through. There is no setting for it (1.10.2). So the kernel is asked how many bytes came over each connection, and
//! `ledger` judges them. Whoever is cut off is not let in again for a while. Last, the process has a bound of memory: beyond
//! it it ends, and the run beside it goes on.

use std::collections::HashMap;
use std::io;
use std::net::SocketAddr;
use std::os::fd::{AsRawFd, OwnedFd};
use std::time::Duration;

use bus::clock::monotonic_ns;
use rustix::net::sockopt::socket_acceptconn;
use rustix::net::{Shutdown, getpeername, getsockname, shutdown};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::sockets;
use ledger::{Ledger, Looked, SHUT_OUT, Why};

mod ledger;

/// Between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// The same while somebody is kept out: little is said before.
const LOOK_WHILE_GUARDING: Duration = Duration::from_millis(20);
/// The most memory that this process may have for itself, in bytes; a sender of one receiver has 10 MiB.
pub const MOST_MEMORY: u64 = 512 << 20;

/// Bounds the memory of this process, and watches all connections that it accepts from now on. Said on stderr is whom it cuts off, and
/// that it cannot watch where the system forbids it.
pub fn start() {
    let was = getrlimit(Resource::Data);
    let least = was.current.map_or(MOST_MEMORY, |was| was.min(MOST_MEMORY));
    let bound = Rlimit {
        current: Some(least),
        maximum: was.maximum,
    };
    if let Err(error) = setrlimit(Resource::Data, bound) {
        bus::stderr_line!("remote-proc: warning: memory is not bounded: {error}");
    }
    std::thread::spawn(|| {
        let mut ledger = Ledger::default();
        loop {
            if let Err(error) = look(&mut ledger) {
                bus::stderr_line!("remote-proc: warning: connections are not watched: {error}");
                return;
            }
            std::thread::sleep(if ledger.is_guarding() {
                LOOK_WHILE_GUARDING
            } else {
                LOOK
            });
        }
    });
}

fn look(ledger: &mut Ledger) -> io::Result<()> {
    let accepted = accepted()?;
    let looked: Vec<_> = accepted.values().map(|(_, looked)| *looked).collect();
    for (peer, why) in ledger.look(monotonic_ns(), &looked, anonymous_bytes()?) {
        let Some((socket, looked)) = accepted.get(&peer) else {
            continue;
        };
        // One that is closed by now needs no more.
        let _ = shutdown(socket, Shutdown::Both);
        let kib = looked.said >> 10;
        let what = match why {
            Why::ShutOut => continue,
            Why::Says => format!("said {kib} KiB, more than a receiver has to"),
            Why::Anew => format!("said {kib} KiB, as others, and this process has too much memory"),
            Why::Memory => format!("said {kib} KiB, the most of all while this process has too much memory"),
        };
        let seconds = SHUT_OUT.as_secs();
        let then = match why {
            Why::Anew => "may come again".to_owned(),
            _ => format!("not let in again for {seconds} s"),
        };
        bus::stderr_line!("remote-proc: warning: {peer} {what}: cut off, and {then}");
    }
    Ok(())
}

/// The connections that came to a port of this process, by their other ends.
fn accepted() -> io::Result<HashMap<SocketAddr, (OwnedFd, Looked)>> {
    let sockets = sockets::own()?;
    let port = |socket: &OwnedFd| Some(SocketAddr::try_from(getsockname(socket).ok()?).ok()?.port());
    let is_listening = |socket: &&OwnedFd| socket_acceptconn(socket).unwrap_or(false);
    let ports: Vec<u16> = sockets.iter().filter(is_listening).filter_map(port).collect();
    let came = sockets.into_iter().filter_map(|socket| {
        let peer = SocketAddr::try_from(getpeername(&socket).ok()??).ok()?;
        let (said, taken) = counted(&socket).ok()?;
        let is_ours = port(&socket).is_some_and(|port| ports.contains(&port));
        is_ours.then_some((peer, (socket, Looked { peer, said, taken })))
    });
    Ok(came.collect())
}

/// Bytes that came over a TCP connection, and bytes that its other end took: `tcpi_bytes_received` and `tcpi_bytes_acked` of `struct
/// tcp_info` in Linux's `include/uapi/linux/tcp.h` (since 4.1).
fn counted(socket: &OwnedFd) -> io::Result<(u64, u64)> {
    const ACKED: usize = 120;
    const RECEIVED: usize = 128;
    let mut info = [0u8; RECEIVED + 8];
    let mut length = info.len() as libc::socklen_t;
    #[allow(unsafe_code, reason = "rustix has no TCP_INFO")]
    // SAFETY: the kernel writes at most `length` bytes to `info`, which has as many, and the descriptor is open.
    let done = unsafe {
        libc::getsockopt(
            socket.as_raw_fd(),
            libc::IPPROTO_TCP,
            libc::TCP_INFO,
            info.as_mut_ptr().cast(),
            &raw mut length,
        )
    };
    match done {
        0 if length as usize == info.len() => Ok((number(&info, RECEIVED), number(&info, ACKED))),
        0 => Err(io::ErrorKind::Unsupported.into()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn number(info: &[u8], at: usize) -> u64 {
    let bytes = info.get(at..at + 8).and_then(|bytes| bytes.try_into().ok());
    u64::from_ne_bytes(bytes.unwrap_or_default())
}

/// What this process has in memory of its own, without what it shares with the run.
fn anonymous_bytes() -> io::Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"));
    let kib = line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    kib.map(|kib| kib << 10)
        .ok_or_else(|| io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};

    #[test]
    fn what_a_connection_said_and_took_is_counted_on_the_accepted_end_alone() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut dialled = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (mut taken, peer) = listener.accept().unwrap();
        dialled.write_all(&[7; 1000]).unwrap();
        taken.read_exact(&mut [0; 1000]).unwrap();
        taken.write_all(&[7; 30]).unwrap();
        dialled.read_exact(&mut [0; 30]).unwrap();
        // What was taken is told to the other end by its next packet.
        dialled.write_all(&[7]).unwrap();
        taken.read_exact(&mut [0]).unwrap();
        let accepted = accepted().unwrap();
        let looked = accepted.get(&peer).unwrap().1;
        assert_eq!((looked.said, looked.taken), (1001, 30));
        assert!(!accepted.contains_key(&listener.local_addr().unwrap()));
        assert!((1 << 16..1 << 40).contains(&anonymous_bytes().unwrap()));
    }
}
