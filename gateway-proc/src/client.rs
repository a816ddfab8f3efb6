//! One client: its thread reads what it asks, and sends what waits for it. Nothing that it does or leaves undone reaches another.

mod questions;
mod sending;

use std::collections::VecDeque;
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpStream};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bus::clock::monotonic_ns;
use bus::process::StopFlag;
use igtl::session::{Action, Event, Notice, Server, ServerRules};
use igtl::{Decoder, DeviceName, Kind, Limits};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::hall::Place;
use crate::letter::{Letter, Wire};
use crate::mailbox::Slot;
use crate::origin::Origin;
pub(crate) use sending::SMALL_BUFFER;
use sending::{Sending, Sent};

/// A client asks and commands; it has nothing long to say.
const LIMITS: Limits = Limits {
    body: 4 << 10,
    metadata_entries: 32,
    metadata_bytes: 2 << 10,
    elements: 16,
};
/// The thread looks at its limits of time at least this often, ns.
const TICK_NS: i64 = 50_000_000;
/// What is read of a client in one turn.
const A_TURN: usize = 16 << 10;
/// Answers that wait at most: who asks on and on and takes nothing loses the oldest.
const MOST_ANSWERS: usize = 64;

/// What every client's thread knows of the run.
#[derive(Debug)]
pub(crate) struct Known {
    /// The devices of the views, in the scene's order; `None` for those that have no plane and are not sent.
    pub(crate) views: Vec<Option<DeviceName>>,
    /// Where poses come from.
    pub(crate) origin: Origin,
    /// Set once the process is asked to stop.
    pub(crate) stop: StopFlag,
}

/// Why a client is gone.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Ended {
    /// It closed, or its connection broke.
    Gone,
    /// It took nothing for a second.
    Slow(String),
    /// What it sent is no OpenIGTLink, or does not end.
    Hostile(String),
    /// The run ends.
    Stopped,
}

struct Client<'a> {
    stream: &'a TcpStream,
    place: &'a Place,
    known: &'a Known,
    session: Server,
    decoder: Decoder,
    answers: VecDeque<Arc<Letter>>,
    sending: Option<Sending>,
    /// The system's buffer was full when the client was written to last.
    is_blocked: bool,
    /// Whose turn it is.
    turn: usize,
    pushed: usize,
}

/// Serves a client until it is gone.
pub(crate) fn serve(stream: &TcpStream, peer: SocketAddr, place: &Place, known: &Known) {
    let counted = &place.hall.counted;
    match Client::new(stream, place, known).work() {
        Ended::Gone | Ended::Stopped => {}
        Ended::Slow(why) => {
            counted.slow.fetch_add(1, Ordering::Relaxed);
            place.hall.tell(&format!("client {peer} is closed: {why}"));
        }
        Ended::Hostile(why) => {
            counted.hostile.fetch_add(1, Ordering::Relaxed);
            place.hall.tell(&format!("client {peer} is closed: {why}"));
        }
    }
}

impl<'a> Client<'a> {
    fn new(stream: &'a TcpStream, place: &'a Place, known: &'a Known) -> Self {
        let rules = ServerRules {
            answers: questions::ANSWERED.to_vec(),
            streams: questions::STREAMED.to_vec(),
            ..ServerRules::default()
        };
        Self {
            stream,
            place,
            known,
            session: Server::new(rules, monotonic_ns()),
            decoder: Decoder::new(LIMITS),
            answers: VecDeque::new(),
            sending: None,
            is_blocked: false,
            turn: 0,
            pushed: 0,
        }
    }

    fn work(mut self) -> Ended {
        loop {
            if let Err(ended) = self.step() {
                return ended;
            }
        }
    }

    fn step(&mut self) -> Result<(), Ended> {
        let (is_readable, is_called) = self.wait()?;
        if self.known.stop.is_set() {
            return Err(Ended::Stopped);
        }
        if is_called {
            self.place.mailbox.heard();
        }
        if is_readable {
            self.read()?;
        }
        let come = self.decoder.come();
        let actions = self.session.step(Event::Tick { come }, monotonic_ns());
        self.carry_out(actions)?;
        let streams = self.session.pace(Kind::Tdata).is_some();
        self.place.mailbox.streams_tools.store(streams, Ordering::Relaxed);
        self.send()
    }

    /// Waits for bytes of the client, room for ours, something to be said, or the time; whether there are bytes, and whether there is
    /// something to be said.
    fn wait(&mut self) -> Result<(bool, bool), Ended> {
        let wanted = if self.is_blocked {
            PollFlags::IN | PollFlags::OUT
        } else {
            PollFlags::IN
        };
        let bell = self.place.mailbox.bell();
        let mut all = [
            PollFd::from_borrowed_fd(self.stream.as_fd(), wanted),
            PollFd::from_borrowed_fd(bell, PollFlags::IN),
        ];
        let tick = Timespec {
            tv_sec: 0,
            tv_nsec: TICK_NS,
        };
        match poll(&mut all, Some(&tick)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(_) => return Err(Ended::Gone),
        }
        let [socket, bell] = all.map(|fd| fd.revents());
        if socket.contains(PollFlags::OUT) {
            self.is_blocked = false;
        }
        let is_readable = socket.intersects(PollFlags::IN | PollFlags::HUP | PollFlags::ERR);
        Ok((is_readable, bell.contains(PollFlags::IN)))
    }

    fn read(&mut self) -> Result<(), Ended> {
        let mut left = A_TURN;
        while left > 0 {
            let space = self.decoder.space();
            let most = space.len().min(left);
            let Some(space) = space.get_mut(..most) else { break };
            let mut stream = self.stream;
            match stream.read(space) {
                Ok(0) => return Err(Ended::Gone),
                Ok(count) => {
                    left -= count;
                    self.decoder.filled(count);
                    self.take_all()?;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err(Ended::Gone),
            }
        }
        Ok(())
    }

    /// Every whole message that has come.
    fn take_all(&mut self) -> Result<(), Ended> {
        let now_ns = monotonic_ns();
        loop {
            let (actions, wish) = match self.decoder.take() {
                None => return Ok(()),
                Some(Ok(message)) => {
                    let wish = questions::image_wish(&message);
                    (self.session.step(Event::Received(&message), now_ns), wish)
                }
                Some(Err(malformed)) => (self.session.step(Event::Refused(&malformed), now_ns), None),
            };
            if let Some((device, starts)) = wish {
                self.wish(device, starts);
            }
            self.carry_out(actions)?;
        }
    }

    fn carry_out(&mut self, actions: Vec<Action>) -> Result<(), Ended> {
        for action in actions {
            match action {
                Action::Send(message) => self.queue(Arc::new(Letter::new(message))),
                Action::Answer { kind, device } => self.answer(kind, device),
                Action::Command { device, command } => self.command(device, &command),
                // A client that spoke version 1 until now has not been told what version 2 alone can say.
                Action::Tell(Notice::SpeaksTwo) => self.tell_again(),
                Action::Tell(_) => {}
                Action::Close(reason) => return Err(Ended::Hostile(reason.to_string())),
            }
        }
        Ok(())
    }

    fn queue(&mut self, letter: Arc<Letter>) {
        if self.answers.len() == MOST_ANSWERS {
            self.answers.pop_front();
        }
        self.answers.push_back(letter);
    }

    fn tell_again(&mut self) {
        for slot in Slot::PUSHED {
            if let Some(letter) = self.place.hall.newest(slot) {
                self.place.mailbox.put(slot, &letter);
            }
        }
    }

    /// Sends as much as the system takes.
    fn send(&mut self) -> Result<(), Ended> {
        while !self.is_blocked {
            let now_ns = monotonic_ns();
            let Some(sending) = &mut self.sending else {
                match self.next(now_ns) {
                    Some(wire) => self.sending = Some(Sending::begin(self.stream, wire, now_ns)),
                    None => return Ok(()),
                }
                continue;
            };
            match sending.write(self.stream, now_ns) {
                Ok(Sent::All) => {
                    self.sending = None;
                    self.place.hall.counted.sent.fetch_add(1, Ordering::Relaxed);
                }
                Ok(Sent::Part) => self.is_blocked = true,
                Err(_) => return Err(Ended::Gone),
            }
        }
        let slow = self
            .sending
            .as_ref()
            .and_then(|sending| sending.is_slow(monotonic_ns()));
        slow.map_or(Ok(()), |why| Err(Ended::Slow(why)))
    }

    /// What is sent next: poses and statuses, answers, words and images have their turns.
    fn next(&mut self, now_ns: i64) -> Option<Arc<Wire>> {
        let version = self.session.version();
        for _ in 0..4 {
            let turn = self.turn % 4;
            self.turn += 1;
            while let Some(letter) = self.of_turn(turn, now_ns) {
                // What has grown old while it waited, and what is not for this version, is passed over.
                if let Some(wire) = letter.wire(version).filter(|_| letter.holds_at(now_ns)) {
                    return Some(wire);
                }
            }
        }
        None
    }

    fn of_turn(&mut self, turn: usize, now_ns: i64) -> Option<Arc<Letter>> {
        let mailbox = &self.place.mailbox;
        match turn {
            0 => {
                let all = Slot::PUSHED.len();
                for _ in 0..all {
                    let slot = Slot::PUSHED[self.pushed % all];
                    self.pushed += 1;
                    if let Some(letter) = mailbox.take(slot) {
                        return Some(letter);
                    }
                }
                self.tdata(now_ns)
            }
            1 => self.answers.pop_front(),
            2 => mailbox.hear(),
            _ => {
                let views = (0..self.known.views.len()).map(Slot::View);
                std::iter::once(Slot::Volume)
                    .chain(views)
                    .find_map(|slot| mailbox.take(slot))
            }
        }
    }

    /// The tools of a stream, where the client has begun one and the next is due.
    fn tdata(&mut self, now_ns: i64) -> Option<Arc<Letter>> {
        self.session.pace(Kind::Tdata)?;
        if !self.place.mailbox.has(Slot::Tdata) || !self.session.take_due(Kind::Tdata, now_ns) {
            return None;
        }
        self.place.mailbox.take(Slot::Tdata)
    }
}
