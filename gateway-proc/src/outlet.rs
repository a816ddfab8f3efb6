//! The way out to one client: what is on its way, and whether its system takes more. Its own thread writes here, and so does, where the
//! way is free at that moment, who has a pose to send: a thread less has to wake.

use std::net::TcpStream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use igtl::Version;

use crate::letter::{Letter, Wire};
use crate::sending::{Sending, Sent};

/// How the way is at the moment.
#[derive(Debug)]
pub(crate) struct Way {
    /// What the client reads.
    pub(crate) version: Version,
    /// A message of which a part is still here.
    pub(crate) sending: Option<Sending>,
    /// The system's buffer was full when the client was written to last.
    pub(crate) is_blocked: bool,
    /// The connection broke; the client's thread finds that out too.
    is_broken: bool,
    /// Bytes that the system has taken.
    pub(crate) taken: u64,
    /// Behind how many bytes the last large message ended, and how long it was.
    pub(crate) large: Option<(u64, u64)>,
}

/// What became of a message that was to go at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Went {
    /// It is sent, or it is none for this client, or it has grown old.
    Done,
    /// The system took a part: the client's thread goes on with it.
    Begun,
    /// The way is not free.
    No,
}

/// A client's socket, written to by one thread at a time.
#[derive(Debug)]
pub(crate) struct Outlet {
    stream: TcpStream,
    way: Mutex<Way>,
}

impl Outlet {
    /// Of a client that was just accepted, whose socket does not block: it is sent version 1.
    pub(crate) fn new(stream: TcpStream) -> Self {
        Self {
            stream,
            way: Mutex::new(Way {
                version: Version::One,
                sending: None,
                is_blocked: false,
                is_broken: false,
                taken: 0,
                large: None,
            }),
        }
    }

    pub(crate) fn stream(&self) -> &TcpStream {
        &self.stream
    }

    /// The way, for the client's own thread. Whoever has it writes without blocking.
    pub(crate) fn way(&self) -> MutexGuard<'_, Way> {
        self.way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a message at once where nothing is on its way. Never waits, neither for the client nor for its thread. `freed` is called
    /// before anything is sent, with the way in hand: what it takes back is not sent after this.
    pub(crate) fn send_now(&self, letter: &Letter, now_ns: i64, sent: &AtomicU64, freed: impl FnOnce()) -> Went {
        let mut way = match self.way.try_lock() {
            Ok(way) => way,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Went::No,
        };
        if way.sending.is_some() || way.is_blocked || way.is_broken {
            return Went::No;
        }
        freed();
        let Some(wire) = letter.wire(way.version).filter(|_| letter.holds_at(now_ns)) else {
            return Went::Done;
        };
        match way.write(&self.stream, wire, now_ns, sent) {
            Ok(Sent::All) => Went::Done,
            // Where it broke, the client's thread is to look.
            Ok(Sent::Part) | Err(_) => Went::Begun,
        }
    }
}

impl Way {
    /// Begins a message, and sends as much of it as the system takes.
    ///
    /// # Errors
    /// Where the connection broke.
    pub(crate) fn write(
        &mut self,
        stream: &TcpStream,
        wire: Arc<Wire>,
        now_ns: i64,
        sent: &AtomicU64,
    ) -> std::io::Result<Sent> {
        self.sending = Some(Sending::begin(stream, wire, now_ns));
        self.go_on(stream, now_ns, sent)
    }

    /// Sends as much as the system takes of what is on its way.
    ///
    /// # Errors
    /// Where the connection broke.
    pub(crate) fn go_on(&mut self, stream: &TcpStream, now_ns: i64, count: &AtomicU64) -> std::io::Result<Sent> {
        let Some(sending) = &mut self.sending else {
            return Ok(Sent::All);
        };
        let before = sending.sent();
        let sent = sending.write(stream, now_ns);
        self.taken += (sending.sent() - before) as u64;
        if sending.is_large() {
            self.large = Some((self.taken, sending.sent() as u64));
        }
        match &sent {
            Ok(Sent::All) => {
                self.sending = None;
                count.fetch_add(1, Ordering::Relaxed);
            }
            Ok(Sent::Part) => self.is_blocked = true,
            Err(_) => self.is_broken = true,
        }
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mailbox::{Mailbox, Slot};
    use crate::sending::SMALL_BUFFER;
    use crate::tell::string;
    use igtl::{Body, Decoder, Limits, Stamp};
    use rustix::net::sockopt::set_socket_send_buffer_size;
    use std::io::Read;
    use std::net::TcpListener;

    /// A client's end, and its box with the way out to it.
    fn connected() -> (TcpStream, Mailbox) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (server, _) = listener.accept().unwrap();
        server.set_nonblocking(true).unwrap();
        set_socket_send_buffer_size(&server, SMALL_BUFFER).unwrap();
        let mailbox = Mailbox::new(0, false).unwrap();
        mailbox.open(Outlet::new(server));
        (client, mailbox)
    }

    fn letter(number: usize) -> Arc<Letter> {
        Arc::new(string("x", &number.to_string(), Stamp::NONE))
    }

    /// The numbers of the next messages that come.
    fn read(client: &mut TcpStream, count: usize) -> Vec<usize> {
        let mut decoder = Decoder::new(Limits::POSES);
        let mut numbers = Vec::new();
        while numbers.len() < count {
            if let Some(message) = decoder.take() {
                let Body::String(text) = message.unwrap().body else {
                    panic!()
                };
                numbers.push(text.to_string().parse().unwrap());
                continue;
            }
            let count = client.read(decoder.space()).unwrap();
            assert!(count > 0);
            decoder.filled(count);
        }
        numbers
    }

    #[test]
    fn a_pose_goes_at_once_where_the_way_is_free_and_what_waited_before_it_never_follows() {
        let (mut client, mailbox) = connected();
        let sent = AtomicU64::new(0);
        mailbox.put(Slot::Tool, &letter(1));
        mailbox.post(Slot::Tool, &letter(2), 0, &sent);
        assert!(!mailbox.has(Slot::Tool) && sent.load(Ordering::Relaxed) == 1 && mailbox.overtaken() == 1);
        // Its own thread has the way: nobody waits for that.
        let outlet = mailbox.outlet().unwrap();
        let way = outlet.way();
        mailbox.post(Slot::Tool, &letter(3), 0, &sent);
        assert!(mailbox.has(Slot::Tool) && sent.load(Ordering::Relaxed) == 1);
        drop(way);
        mailbox.post(Slot::Tool, &letter(4), 0, &sent);
        assert!(!mailbox.has(Slot::Tool));
        assert_eq!(read(&mut client, 2), [2, 4]);
    }

    #[test]
    fn what_is_old_or_not_for_this_version_is_not_sent_and_takes_back_what_waited() {
        let (mut client, mailbox) = connected();
        let sent = AtomicU64::new(0);
        let none = Arc::new(string("x", "7", Stamp::NONE).not_to_one());
        let old = Arc::new(string("x", "8", Stamp::NONE).until(Some(100)));
        for letter_of in [none, old] {
            mailbox.put(Slot::Tool, &letter(1));
            mailbox.post(Slot::Tool, &letter_of, 101, &sent);
            assert!(!mailbox.has(Slot::Tool) && sent.load(Ordering::Relaxed) == 0);
        }
        mailbox.post(Slot::Tool, &letter(9), 0, &sent);
        assert_eq!(read(&mut client, 1), [9]);
    }

    /// What the system took in part goes on before anything else is begun: a message in another would be the end of the stream.
    #[test]
    fn a_message_that_was_taken_in_part_ends_before_the_next_begins() {
        let (mut client, mailbox) = connected();
        let (sent, outlet) = (AtomicU64::new(0), mailbox.outlet().unwrap());
        let mut last = 0;
        while !outlet.way().is_blocked {
            last += 1;
            mailbox.post(Slot::Tool, &letter(last), 0, &sent);
            assert!(last < 1_000_000);
        }
        mailbox.post(Slot::Tool, &letter(last + 1), 0, &sent);
        assert!(mailbox.has(Slot::Tool) && outlet.way().sending.is_some());
        let reader = std::thread::spawn(move || read(&mut client, last));
        while outlet.way().sending.is_some() {
            let _ = outlet.way().go_on(outlet.stream(), 0, &sent);
        }
        assert_eq!(reader.join().unwrap(), (1..=last).collect::<Vec<_>>());
        assert_eq!(sent.load(Ordering::Relaxed), last as u64);
    }
}
