//! The connection: dialled in a thread of its own, as names and networks take their time; again and again until it stands.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use bus::clock::{self, Clock};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt;

/// A connection that is not made within this time is none.
const CONNECT: Duration = Duration::from_secs(2);
/// Between two tries at first, and at most; each time it is doubled.
const FIRST_WAIT_NS: i64 = 100_000_000;
const MOST_WAIT_NS: i64 = 2_000_000_000;
/// A peer that acknowledges nothing for this long is gone.
const UNACKNOWLEDGED_MS: u32 = 2000;
/// What is sent is a few hundred bytes: who does not take them within this time takes nothing.
const SEND: Duration = Duration::from_millis(500);
/// Bytes that are read at once.
const CHUNK: usize = 64 << 10;

/// What came of waiting.
#[derive(Debug)]
pub(crate) enum News<'a> {
    /// Nothing: the time is over.
    Nothing,
    /// The connection stands.
    Connected,
    /// Bytes came.
    Bytes(&'a [u8]),
    /// It is over, for this reason.
    Closed(String),
}

/// How it stands.
#[derive(Debug)]
enum Stage {
    /// The next try is due at this time; the reason why the last one came to nothing.
    Waiting { next_ns: i64, why: String },
    /// A thread is at it.
    Dialling(Receiver<Result<TcpStream, String>>),
    /// It stands.
    Up(TcpStream),
    /// It is over, and a person must want the next one.
    Over(String),
}

/// The connection to one address.
#[derive(Debug)]
pub(crate) struct Link {
    address: String,
    stage: Stage,
    /// Tries since it stood last.
    tries: u32,
    wait_ns: i64,
    room: Vec<u8>,
}

impl Link {
    /// Not dialled yet.
    pub(crate) fn new(address: &str) -> Self {
        Self {
            address: address.to_owned(),
            stage: Stage::Waiting {
                next_ns: i64::MIN,
                why: String::new(),
            },
            tries: 0,
            wait_ns: FIRST_WAIT_NS,
            room: vec![0; CHUNK],
        }
    }

    /// Waits until something happens, at most until `until_ns`.
    pub(crate) fn wait(&mut self, clock: &Clock, until_ns: i64) -> News<'_> {
        let now_ns = clock.now_ns();
        let rest = Duration::from_nanos(until_ns.saturating_sub(now_ns).max(0).unsigned_abs());
        match &mut self.stage {
            Stage::Over(_) => thread::sleep(rest),
            Stage::Waiting { next_ns, .. } if *next_ns > now_ns => {
                let next = Duration::from_nanos(next_ns.saturating_sub(now_ns).unsigned_abs());
                thread::sleep(rest.min(next));
            }
            Stage::Waiting { .. } => self.dial(),
            Stage::Dialling(answer) => match answer.recv_timeout(rest) {
                Ok(Ok(stream)) => {
                    self.stage = Stage::Up(stream);
                    (self.tries, self.wait_ns) = (0, FIRST_WAIT_NS);
                    return News::Connected;
                }
                Ok(Err(why)) => self.wait_after(why, clock.now_ns()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.wait_after("the dialling thread ended".to_owned(), now_ns),
            },
            Stage::Up(stream) => return read(stream, &mut self.room, rest),
        }
        News::Nothing
    }

    fn dial(&mut self) {
        self.tries = self.tries.saturating_add(1);
        let (say, answer) = channel();
        let address = self.address.clone();
        let started = thread::Builder::new().name("dial".to_owned()).spawn(move || {
            // Whoever asked may be gone meanwhile.
            let _ = say.send(connect(&address));
        });
        self.stage = match started {
            Ok(_) => Stage::Dialling(answer),
            Err(error) => Stage::Waiting {
                next_ns: i64::MIN,
                why: error.to_string(),
            },
        };
    }

    fn wait_after(&mut self, why: String, now_ns: i64) {
        // Each waits a little otherwise, so that many that lost one peer do not come back in step.
        let jitter_ns = self.wait_ns / 10 * (now_ns & 7) / 7;
        self.stage = Stage::Waiting {
            next_ns: now_ns.saturating_add(self.wait_ns).saturating_add(jitter_ns),
            why,
        };
        self.wait_ns = (2 * self.wait_ns).min(MOST_WAIT_NS);
    }

    /// Sends all of it, or gives the reason why the connection is of no use.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Result<(), String> {
        match &mut self.stage {
            Stage::Up(stream) => write(stream, bytes),
            _ => Ok(()),
        }
    }

    /// Ends a connection that stands: the next one is dialled, or not before a person wants it.
    pub(crate) fn close(&mut self, why: String, reconnects: bool, now_ns: i64) {
        match reconnects {
            true => self.wait_after(why, now_ns),
            false => self.stage = Stage::Over(why),
        }
    }

    /// Whether it stands.
    pub(crate) fn is_up(&self) -> bool {
        matches!(self.stage, Stage::Up(_))
    }

    /// How it stands, in words; empty where it does.
    pub(crate) fn words(&self, now_ns: i64) -> String {
        let address = &self.address;
        match &self.stage {
            Stage::Up(_) => String::new(),
            Stage::Dialling(_) => format!("dialling {address} (try {})", self.tries),
            Stage::Waiting { why, .. } if why.is_empty() => format!("dialling {address}"),
            Stage::Waiting { next_ns, why } => {
                let next_s = clock::ms(next_ns.saturating_sub(now_ns).max(0)) / 1e3;
                format!(
                    "waiting for {address}: {why} (try {}, next in {next_s:.1} s)",
                    self.tries
                )
            }
            Stage::Over(why) => format!("{address}: {why}; `pilot restart localizer` dials again"),
        }
    }
}

/// In the words of the system, without its number.
fn words(error: &std::io::Error) -> String {
    let text = error.to_string();
    let end = text.find(" (os error").unwrap_or(text.len());
    text[..end].to_lowercase()
}

fn connect(address: &str) -> Result<TcpStream, String> {
    let found = address.to_socket_addrs().map_err(|error| words(&error))?;
    let mut why = "no address of that name".to_owned();
    for each in found {
        match TcpStream::connect_timeout(&each, CONNECT) {
            Ok(stream) => return prepared(stream).map_err(|error| words(&error)),
            Err(error) => why = words(&error),
        }
    }
    Err(why)
}

/// A peer whose cable is pulled is found out, and what is sent goes out at once.
fn prepared(stream: TcpStream) -> std::io::Result<TcpStream> {
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)?;
    sockopt::set_tcp_user_timeout(&stream, UNACKNOWLEDGED_MS)?;
    sockopt::set_socket_keepalive(&stream, true)?;
    sockopt::set_tcp_keepidle(&stream, Duration::from_secs(1))?;
    sockopt::set_tcp_keepintvl(&stream, Duration::from_secs(1))?;
    sockopt::set_tcp_keepcnt(&stream, 2)?;
    Ok(stream)
}

fn ready(stream: &TcpStream, for_what: PollFlags, rest: Duration) -> std::io::Result<bool> {
    let rest = Timespec::try_from(rest).unwrap_or(Timespec { tv_sec: 1, tv_nsec: 0 });
    match poll(&mut [PollFd::new(stream, for_what)], Some(&rest)) {
        Ok(count) => Ok(count > 0),
        Err(rustix::io::Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn read<'a>(stream: &mut TcpStream, room: &'a mut [u8], rest: Duration) -> News<'a> {
    match ready(stream, PollFlags::IN, rest) {
        Ok(false) => return News::Nothing,
        Ok(true) => {}
        Err(error) => return News::Closed(words(&error)),
    }
    match stream.read(room) {
        Ok(0) => News::Closed("the peer closed the connection".to_owned()),
        Ok(count) => News::Bytes(&room[..count]),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => News::Nothing,
        Err(error) => News::Closed(words(&error)),
    }
}

fn write(stream: &mut TcpStream, mut bytes: &[u8]) -> Result<(), String> {
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(0) => return Err("the peer takes nothing".to_owned()),
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => match ready(stream, PollFlags::OUT, SEND) {
                Ok(true) => {}
                Ok(false) => return Err("the peer takes nothing".to_owned()),
                Err(error) => return Err(words(&error)),
            },
            Err(error) => return Err(words(&error)),
        }
    }
    Ok(())
}
