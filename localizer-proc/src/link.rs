//! The connection: dialled in a thread of its own, as names and networks take their time; again and again until it stands.

use std::net::{TcpStream, ToSocketAddrs};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use bus::clock::{self, Clock};

use crate::stream::{self, prepared, words, write};

/// A connection that is not made within this time is none.
const CONNECT: Duration = Duration::from_secs(2);
/// Between two tries at first, and at most; each time it is doubled.
const FIRST_WAIT_NS: i64 = 100_000_000;
const MOST_WAIT_NS: i64 = 2_000_000_000;
/// Bytes that are read at once.
pub(crate) const CHUNK: usize = 64 << 10;

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
    /// Tries since one was of use last.
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
            Stage::Waiting { .. } => self.dial(now_ns),
            Stage::Dialling(answer) => match answer.recv_timeout(rest) {
                Ok(Ok(stream)) => {
                    self.stage = Stage::Up(stream);
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

    fn dial(&mut self, now_ns: i64) {
        self.tries = self.tries.saturating_add(1);
        let (say, answer) = channel();
        let address = self.address.clone();
        let started = thread::Builder::new().name("dial".to_owned()).spawn(move || {
            // Whoever asked may be gone meanwhile.
            let _ = say.send(connect(&address));
        });
        match started {
            Ok(_) => self.stage = Stage::Dialling(answer),
            Err(error) => self.wait_after(words(&error), now_ns),
        }
    }

    /// The connection is of use: the next one, after it, is dialled soon. A peer that takes connections and ends them at once is no
    /// better than none, and is not dialled ten times a second.
    pub(crate) fn is_of_use(&mut self) {
        (self.tries, self.wait_ns) = (0, FIRST_WAIT_NS);
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
            // In front, as what is too long for a note is cut at its end.
            Stage::Over(why) => format!("`pilot restart localizer` dials again: {address}: {why}"),
        }
    }
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

fn read<'a>(stream: &mut TcpStream, room: &'a mut [u8], rest: Duration) -> News<'a> {
    match stream::read(stream, room, rest) {
        Ok(0) => News::Nothing,
        Ok(count) => News::Bytes(&room[..count]),
        Err(why) => News::Closed(why),
    }
}
