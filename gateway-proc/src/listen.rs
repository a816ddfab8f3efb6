//! Takes connections: each has a thread of its own; beyond the sixteenth they are told so and closed.

use std::io::{self, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use bus::clock::monotonic_ns;
use igtl::Version;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt::{
    set_socket_keepalive, set_socket_send_buffer_size, set_tcp_keepidle, set_tcp_keepintvl, set_tcp_user_timeout,
};

use crate::client::{Known, serve};
use crate::hall::{Hall, MOST_CLIENTS};
use crate::sending::SMALL_BUFFER;
use crate::tell::{BUSY, refusal};

/// Between two tries to listen where another program has the port, ns.
const RETRY_NS: i64 = 1_000_000_000;
/// Between two looks at whether the process is to stop.
const TICK: Duration = Duration::from_millis(50);
/// Connections taken in one go; then the others have their turn.
const AT_ONCE: u32 = 32;
/// How long who dials on and on waits between two such goes.
const PAUSE: Duration = Duration::from_millis(2);
/// A peer that acknowledges nothing for so long is gone, ms: its cable is.
const UNACKNOWLEDGED_MS: u32 = 2000;

/// Where the server listens, or why it does not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Door {
    /// It has not tried yet.
    Closed,
    /// It listens here.
    Open(SocketAddr),
    /// Another try follows.
    Refused(String),
}

/// The server's door, seen from other threads.
pub(crate) type SharedDoor = Arc<Mutex<Door>>;

fn set(door: &SharedDoor, now: Door) {
    *door.lock().unwrap_or_else(PoisonError::into_inner) = now;
}

/// Listens at `address` until the process is to stop. A port that another program has is asked for again and again: a navigation
/// does not end for want of it.
pub(crate) fn listen(address: SocketAddr, hall: &Arc<Hall>, known: &Arc<Known>, door: &SharedDoor) {
    let mut next_ns = i64::MIN;
    while !known.stop.is_set() {
        if monotonic_ns() < next_ns {
            thread::sleep(TICK);
            continue;
        }
        next_ns = monotonic_ns() + RETRY_NS;
        let opened = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let here = listener.local_addr()?;
            Ok((listener, here))
        });
        match opened {
            Ok((listener, here)) => {
                set(door, Door::Open(here));
                accept_all(&listener, hall, known);
            }
            Err(error) => set(door, Door::Refused(format!("{address}: {error}"))),
        }
    }
}

fn accept_all(listener: &TcpListener, hall: &Arc<Hall>, known: &Arc<Known>) {
    let tick = Timespec {
        tv_sec: 0,
        tv_nsec: TICK.subsec_nanos().into(),
    };
    while !known.stop.is_set() {
        let mut door = [PollFd::from_borrowed_fd(listener.as_fd(), PollFlags::IN)];
        // A wait that fails is a wait that is over.
        let _ = poll(&mut door, Some(&tick));
        for count in 0..AT_ONCE {
            match listener.accept() {
                Ok((stream, peer)) => admit(stream, peer, hall, known),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                // A connection that was gone before it was taken, or no descriptor left: others go on.
                Err(_) => {
                    thread::sleep(PAUSE);
                    break;
                }
            }
            if count + 1 == AT_ONCE {
                thread::sleep(PAUSE);
            }
        }
    }
}

fn admit(stream: TcpStream, peer: SocketAddr, hall: &Arc<Hall>, known: &Arc<Known>) {
    if prepare(&stream).is_err() {
        return;
    }
    let place = match hall.enter() {
        None => return turn_away(&stream, hall),
        Some(Err(error)) => return hall.tell(&format!("client {peer} is not served: {error}")),
        Some(Ok(place)) => place,
    };
    let known = Arc::clone(known);
    let started = thread::Builder::new()
        .name("client".to_owned())
        .spawn(move || serve(stream, peer, &place, &known));
    if let Err(error) = started {
        hall.tell(&format!("client {peer} is not served: {error}"));
    }
}

fn prepare(stream: &TcpStream) -> io::Result<()> {
    stream.set_nonblocking(true)?;
    stream.set_nodelay(true)?;
    // What is refused below makes a client that has gone noticed later, and no more.
    let _ = set_socket_send_buffer_size(stream, SMALL_BUFFER);
    let _ = set_tcp_user_timeout(stream, UNACKNOWLEDGED_MS);
    let _ = set_tcp_keepidle(stream, Duration::from_secs(1));
    let _ = set_tcp_keepintvl(stream, Duration::from_secs(1));
    let _ = set_socket_keepalive(stream, true);
    Ok(())
}

/// Says why, as far as the system takes it at once.
fn turn_away(mut stream: &TcpStream, hall: &Hall) {
    hall.counted.crowded.fetch_add(1, Ordering::Relaxed);
    let words = format!("{MOST_CLIENTS} clients are connected, and no more are served");
    if let Some(wire) = refusal(BUSY, &words).wire(Version::One) {
        let _ = stream.write_vectored(&wire.rest(0));
        let _ = stream.shutdown(std::net::Shutdown::Write);
    }
}
