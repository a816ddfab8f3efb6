//! A network that misbehaves, between the gateway and one client: it delays, gives one byte at a time, cuts, stalls, or falls silent with
//! the connection open.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// What happens to the bytes that go to the client.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Fault {
    /// They come so much later.
    Delay(Duration),
    /// Each is written by itself; those of the client too.
    Bytes,
    /// The connection ends behind so many.
    Cut(usize),
    /// Behind so many nothing is read or written for this long.
    Stall(usize, Duration),
    /// Behind so many nothing is read or written any more, and nothing ends.
    HalfOpen(usize),
}

/// Where a client finds the gateway through this fault. Serves connections one after the other, for as long as the test runs.
pub(crate) fn through(fault: Fault, gateway: SocketAddr) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let here = listener.local_addr().unwrap();
    thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let Ok(server) = TcpStream::connect(gateway) else {
                return;
            };
            join(fault, client, server);
        }
    });
    here
}

fn join(fault: Fault, client: TcpStream, server: TcpStream) {
    for stream in [&client, &server] {
        stream.set_nodelay(true).unwrap();
    }
    let (asks, asked) = (client.try_clone().unwrap(), server.try_clone().unwrap());
    let back = match fault {
        Fault::Bytes => Fault::Bytes,
        _ => Fault::Delay(Duration::ZERO),
    };
    thread::spawn(move || carry(back, asks, asked));
    thread::spawn(move || carry(fault, server, client));
}

/// Carries bytes until one end closes; then both are closed.
fn carry(fault: Fault, mut from: TcpStream, to: TcpStream) {
    if let Fault::Delay(delay) = fault {
        return carry_later(delay, from, to);
    }
    let (mut space, mut come) = ([0; 4096], 0);
    loop {
        let left = match fault {
            Fault::Cut(at) | Fault::Stall(at, _) | Fault::HalfOpen(at) if come <= at => (at - come).min(space.len()),
            _ => space.len(),
        };
        if left == 0 {
            match fault {
                Fault::Stall(_, long) => thread::sleep(long),
                // Both ends stay open, and nobody reads.
                Fault::HalfOpen(_) => loop {
                    thread::park();
                },
                _ => break,
            }
            // Beyond the place.
            come += 1;
            continue;
        }
        let Ok(count @ 1..) = from.read(&mut space[..left]) else {
            break;
        };
        come += count;
        if write(fault, &to, &space[..count]).is_err() {
            break;
        }
    }
    close(&from, &to);
}

fn write(fault: Fault, mut to: &TcpStream, bytes: &[u8]) -> std::io::Result<()> {
    match fault {
        Fault::Bytes => bytes.iter().try_for_each(|byte| to.write_all(&[*byte])),
        _ => to.write_all(bytes),
    }
}

/// In their order and at their pace, each a little later.
fn carry_later(delay: Duration, mut from: TcpStream, to: TcpStream) {
    let (later, due) = mpsc::channel::<(i64, Vec<u8>)>();
    let (ended, sink) = (from.try_clone().unwrap(), to.try_clone().unwrap());
    thread::spawn(move || {
        for (due_ns, bytes) in due {
            let left_ns = due_ns.saturating_sub(bus::clock::monotonic_ns());
            thread::sleep(Duration::from_nanos(left_ns.max(0).unsigned_abs()));
            if write(Fault::Delay(delay), &sink, &bytes).is_err() {
                break;
            }
        }
        close(&ended, &sink);
    });
    let mut space = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut space) {
        let due_ns = bus::clock::monotonic_ns() + bus::clock::ns(delay);
        if later.send((due_ns, space[..count].to_vec())).is_err() {
            break;
        }
    }
}

fn close(from: &TcpStream, to: &TcpStream) {
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}
