//! A network between a client and a server on this machine, which fails when it is told to.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Between two looks at whether a network that stands still goes on.
const LOOK: Duration = Duration::from_millis(5);

/// What it does with what the server says.
#[derive(Debug, Clone, Copy)]
pub enum Fault {
    /// Nothing.
    None,
    /// One byte in each packet.
    Bytes,
    /// All comes so much later.
    Delay(Duration),
    /// Nothing is read any more, nothing comes through in either direction, and nobody says so: a cable that was pulled. What was sent
    /// meanwhile comes when it is over.
    Stall,
    /// The next piece of which this holds ends after so many bytes, and the connection with it; once, and then nothing is wrong.
    Cut(usize, fn(&[u8]) -> bool),
    /// Every connection is closed in the middle of a piece.
    CutAll,
}

/// A network to one port.
pub struct Proxy {
    /// Where a client dials it.
    pub port: u16,
    shared: Arc<Shared>,
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
                for (from, to, is_answer) in [(&client, &server, false), (&server, &client, true)] {
                    let (from, to) = (from.try_clone().unwrap(), to.try_clone().unwrap());
                    let shared = Arc::clone(&shared);
                    thread::spawn(move || carry(from, to, &shared, is_answer));
                }
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

fn carry(mut from: TcpStream, mut to: TcpStream, shared: &Shared, is_answer: bool) {
    let mut room = [0; 4096];
    let _ = (from.set_nodelay(true), to.set_nodelay(true));
    loop {
        while matches!(shared.fault(), Fault::Stall) {
            thread::sleep(LOOK);
        }
        let Ok(count @ 1..) = from.read(&mut room) else {
            break;
        };
        // What was being read when it began to stand still waits too.
        while matches!(shared.fault(), Fault::Stall) {
            thread::sleep(LOOK);
        }
        if !passed(&room[..count], &mut to, shared, is_answer) {
            break;
        }
    }
    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}

/// Hands a piece on; false where the connection is over.
fn passed(piece: &[u8], to: &mut TcpStream, shared: &Shared, is_answer: bool) -> bool {
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
        // Of a client's own words peers of others lose step where they come in pieces (pyigtl): that is theirs.
        Fault::Bytes if is_answer => piece.iter().all(|byte| to.write_all(&[*byte]).is_ok()),
        Fault::Delay(time) if is_answer => {
            thread::sleep(time);
            to.write_all(piece).is_ok()
        }
        _ => to.write_all(piece).is_ok(),
    }
}
