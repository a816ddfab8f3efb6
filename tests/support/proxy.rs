//! A network between a client and a server on this machine, which fails when it is told to: the same for every peer.
//!
//! A piece is what one read from the server gives. What comes is handed on in its order, by a thread of its own, so that a delay costs no pace.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use bus::clock::monotonic_ns;

/// Between two looks at whether a network that stands still goes on.
const LOOK: Duration = Duration::from_millis(5);
/// Pieces on their way, at most: a sender is held up by a receiver that does not read.
const ON_THE_WAY: usize = 256;

/// What it does with what the server says.
#[derive(Debug, Clone, Copy)]
pub enum Fault {
    /// Nothing.
    None,
    /// One byte in each packet.
    Bytes,
    /// Those of the client too. Peers of others lose step where a question of theirs comes in pieces (pyigtl): that is theirs.
    BytesOfBoth,
    /// All comes so much later.
    Delay(Duration),
    /// Nothing is read any more, nothing comes through in either direction, and nobody says so: a cable that was pulled. What was sent
    /// meanwhile comes when it is over.
    Stall,
    /// The next piece of which this holds ends after so many bytes, and the connection with it; once, and then nothing is wrong.
    Cut(usize, fn(&[u8]) -> bool),
    /// Every connection is closed in the middle of a piece.
    CutAll,
    /// Every connection ends behind so many bytes of the server.
    CutBehind(usize),
    /// Behind so many bytes of the server none comes for this long.
    StallBehind(usize, Duration),
    /// Behind so many bytes of the server none is read any more, and nothing ends.
    SilentBehind(usize),
}

impl Fault {
    /// Behind which byte of a connection it happens.
    fn place(self) -> Option<usize> {
        match self {
            Self::CutBehind(at) | Self::StallBehind(at, _) | Self::SilentBehind(at) => Some(at),
            _ => None,
        }
    }
}

/// Every which byte is cut at: `usual`, or each of them where TROCAR_EVERY_BYTE is set, which takes minutes.
pub fn cut_step(usual: usize) -> usize {
    std::env::var_os("TROCAR_EVERY_BYTE").map_or(usual, |_| 1)
}

/// A network to one port.
pub struct Proxy {
    /// Where a client dials it.
    pub port: u16,
    shared: Arc<Shared>,
}

/// The address of a network to this server that fails so for as long as the test runs.
pub fn through(fault: Fault, server: SocketAddr) -> SocketAddr {
    let network = Proxy::to(server.port());
    network.set(fault);
    SocketAddr::new(server.ip(), network.port)
}

struct Shared {
    /// The first is what is wrong now; a cut makes room for the next.
    faults: Mutex<Vec<Fault>>,
    /// Bytes of the piece that was cut last.
    length: AtomicUsize,
    /// Connections that have reached the server.
    made: AtomicUsize,
}

impl Shared {
    fn fault(&self) -> Fault {
        self.faults.lock().unwrap().first().copied().unwrap_or(Fault::None)
    }

    fn wait_while(&self, stands_still: impl Fn(Fault) -> bool) {
        while stands_still(self.fault()) {
            thread::sleep(LOOK);
        }
    }
}

impl Proxy {
    /// One with which nothing is wrong yet.
    pub fn to(port: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let shared = Arc::new(Shared {
            faults: Mutex::default(),
            length: AtomicUsize::new(0),
            made: AtomicUsize::new(0),
        });
        let proxy = Self {
            port: listener.local_addr().unwrap().port(),
            shared: Arc::clone(&shared),
        };
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let Ok(server) = TcpStream::connect(("127.0.0.1", port)) else {
                    continue;
                };
                shared.made.fetch_add(1, Ordering::SeqCst);
                carry(&client, &server, &shared, false);
                carry(&server, &client, &shared, true);
            }
        });
        proxy
    }

    /// From now on.
    pub fn set(&self, fault: Fault) {
        self.set_all(&[fault]);
    }

    /// These cuts, one after the other.
    pub fn set_all(&self, faults: &[Fault]) {
        *self.shared.faults.lock().unwrap() = faults.to_vec();
    }

    /// Whether every [`Fault::Cut`] that was set has happened.
    pub fn is_through(&self) -> bool {
        self.shared.faults.lock().unwrap().is_empty()
    }

    /// How many connections have reached the server.
    pub fn made(&self) -> usize {
        self.shared.made.load(Ordering::SeqCst)
    }

    /// How many bytes the piece had that was cut last.
    pub fn length(&self) -> usize {
        self.shared.length.load(Ordering::SeqCst)
    }
}

/// Carries one direction of a connection until either end closes.
fn carry(from: &TcpStream, to: &TcpStream, shared: &Arc<Shared>, is_answer: bool) {
    from.set_nodelay(true).unwrap();
    let (pieces, due) = sync_channel(ON_THE_WAY);
    let [reader, closed] = [(); 2].map(|()| from.try_clone().unwrap());
    let writer = to.try_clone().unwrap();
    let [reads, writes] = [(); 2].map(|()| Arc::clone(shared));
    thread::spawn(move || read(reader, &pieces, &reads, is_answer));
    thread::spawn(move || {
        write(&writer, &due, &writes, is_answer);
        let _ = (closed.shutdown(Shutdown::Both), writer.shutdown(Shutdown::Both));
    });
}

/// What comes, each piece with when it is due.
fn read(mut from: TcpStream, pieces: &SyncSender<(i64, Vec<u8>)>, shared: &Shared, is_answer: bool) {
    let (mut room, mut come, mut has_stalled) = ([0; 4096], 0, false);
    loop {
        shared.wait_while(|fault| matches!(fault, Fault::Stall));
        let fault = if is_answer { shared.fault() } else { Fault::None };
        let place = fault.place().filter(|_| !has_stalled);
        let most = place.map_or(room.len(), |at| at.saturating_sub(come).min(room.len()));
        if most == 0 {
            match fault {
                Fault::StallBehind(_, long) => thread::sleep(long),
                Fault::SilentBehind(_) => shared.wait_while(|fault| matches!(fault, Fault::SilentBehind(_))),
                _ => break,
            }
            has_stalled = true;
            continue;
        }
        let Ok(count @ 1..) = from.read(&mut room[..most]) else {
            break;
        };
        come += count;
        let late_ns = match fault {
            Fault::Delay(delay) => bus::clock::ns(delay),
            _ => 0,
        };
        if pieces.send((monotonic_ns() + late_ns, room[..count].to_vec())).is_err() {
            break;
        }
    }
}

/// Hands pieces on when they are due.
fn write(to: &TcpStream, due: &Receiver<(i64, Vec<u8>)>, shared: &Shared, is_answer: bool) {
    for (due_ns, piece) in due {
        let left_ns = due_ns.saturating_sub(monotonic_ns());
        thread::sleep(Duration::from_nanos(left_ns.max(0).unsigned_abs()));
        // What was on its way when it began to stand still waits too.
        shared.wait_while(|fault| matches!(fault, Fault::Stall));
        if !passed(&piece, to, shared, is_answer) {
            break;
        }
    }
}

/// Hands a piece on; false where the connection is over.
fn passed(piece: &[u8], mut to: &TcpStream, shared: &Shared, is_answer: bool) -> bool {
    match shared.fault() {
        Fault::Cut(at, of) if is_answer && of(piece) => {
            let _ = to.write_all(&piece[..at.min(piece.len())]);
            shared.length.store(piece.len(), Ordering::SeqCst);
            shared.faults.lock().unwrap().remove(0);
            false
        }
        Fault::CutAll => {
            if is_answer {
                let _ = to.write_all(&piece[..piece.len() / 2]);
            }
            false
        }
        Fault::BytesOfBoth => one_by_one(piece, to),
        Fault::Bytes if is_answer => one_by_one(piece, to),
        _ => to.write_all(piece).is_ok(),
    }
}

fn one_by_one(piece: &[u8], mut to: &TcpStream) -> bool {
    piece.iter().all(|byte| to.write_all(&[*byte]).is_ok())
}
