//! One client: its thread reads what it asks, and sends what waits for it. Nothing that it does or leaves undone reaches another.

mod questions;

use std::collections::VecDeque;
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpStream};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use bus::clock::monotonic_ns;
use bus::process::StopFlag;
use igtl::session::{Action, Event, Notice, Server, ServerRules};
use igtl::{Command, Decoder, DeviceName, Kind, Limits, Status};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::hall::{Kept, Place};
use crate::letter::{Letter, Wire};
use crate::mailbox::Slot;
use crate::origin::Origin;
use crate::outlet::{Outlet, Way};
use crate::tell::refusal;
use crate::unread::{Patience, Queues};

/// A client asks and commands; it has nothing long to say.
const LIMITS: Limits = Limits {
    body: 4 << 10,
    metadata_entries: 32,
    metadata_bytes: 2 << 10,
    elements: 16,
};
/// The thread looks at its limits of time at least this often, ns.
const TICK_NS: i64 = 50_000_000;
/// The client's own queue is looked at so often, ns.
const LOOK_NS: i64 = 200_000_000;
/// What is read of a client in one turn.
const A_TURN: usize = 16 << 10;
/// Messages of a client that are read in a tick; the rest waits in its own system. Who asks without end would take the time of others.
const MOST_ASKED: u32 = 200;
/// Answers that wait at most: before some of them are sent nothing more is read of who asks.
const MOST_ANSWERS: usize = 64;

/// What every client's thread knows of the run.
#[derive(Debug)]
pub(crate) struct Known {
    /// The devices of the views, in the scene's order; `None` for those that have no plane and are not sent.
    pub(crate) views: Vec<Option<DeviceName>>,
    /// Where poses come from.
    pub(crate) origin: Origin,
    /// There are markers of a localizer. Those of a replay come out of a recording, and have no device of another name.
    pub(crate) has_markers: bool,
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

/// What a client is owed. What may change is looked up when its turn has come: an older one must not follow what was sent meanwhile.
#[derive(Debug, Clone)]
enum Answer {
    /// This.
    Said(Arc<Letter>),
    /// What there is of a device.
    Newest(Slot),
    /// What was said last.
    Kept(Kept),
    /// To a command.
    Asked(DeviceName, Command),
}

struct Client<'a> {
    outlet: &'a Outlet,
    place: &'a Place,
    known: &'a Known,
    session: Server,
    decoder: Decoder,
    answers: VecDeque<Answer>,
    /// Messages wait in the decoder until the answers to others are sent, or the tick is over.
    is_behind: bool,
    /// Messages that came since the tick that began then, ns.
    asked: u32,
    asked_since_ns: i64,
    /// What it has not read; `None` where nobody here can tell.
    queues: Option<Queues>,
    patience: Patience,
    /// `None` before the first step: many a connection is gone before anything has to be opened for it.
    next_look_ns: Option<i64>,
    /// Whose turn it is.
    turn: usize,
    pushed: usize,
}

/// Serves a client until it is gone.
pub(crate) fn serve(stream: TcpStream, peer: SocketAddr, place: &Place, known: &Known) {
    let counted = &place.hall.counted;
    let outlet = place.mailbox.open(Outlet::new(stream));
    match Client::new(outlet, place, known).work() {
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
    fn new(outlet: &'a Outlet, place: &'a Place, known: &'a Known) -> Self {
        let rules = ServerRules {
            answers: questions::ANSWERED.to_vec(),
            streams: questions::STREAMED.to_vec(),
            ..ServerRules::default()
        };
        Self {
            outlet,
            place,
            known,
            session: Server::new(rules, monotonic_ns()),
            decoder: Decoder::new(LIMITS),
            answers: VecDeque::new(),
            is_behind: false,
            asked: 0,
            asked_since_ns: monotonic_ns(),
            queues: None,
            patience: Patience::new(monotonic_ns()),
            next_look_ns: None,
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
        if self.known.stop.is_set() && self.place.hall.is_over() {
            // What waits still, that the run has ended first of all, as far as the system takes it.
            self.send()?;
            return Err(Ended::Stopped);
        }
        if is_called {
            self.place.mailbox.heard();
        }
        if self.is_behind {
            self.take_all()?;
        } else if is_readable {
            self.read()?;
        }
        // What lies in the decoder came long ago, and is kept waiting here.
        let come = if self.is_behind { 0 } else { self.decoder.come() };
        let actions = self.session.step(Event::Tick { come }, monotonic_ns());
        self.carry_out(actions)?;
        let streams = self.session.pace(Kind::Tdata).is_some();
        self.place.mailbox.streams_tools.store(streams, Ordering::Relaxed);
        self.send()?;
        self.look(monotonic_ns())
    }

    /// Whether a client on this machine still reads what its system takes for it.
    fn look(&mut self, now_ns: i64) -> Result<(), Ended> {
        let next_ns = self.next_look_ns.get_or_insert(now_ns.saturating_add(LOOK_NS));
        if now_ns < *next_ns {
            return Ok(());
        }
        *next_ns = now_ns.saturating_add(LOOK_NS);
        if self.queues.is_none() {
            self.queues = Queues::of(self.outlet.stream());
        }
        let way = self.outlet.way();
        let waiting = self.queues.as_mut().and_then(Queues::waiting);
        let slow = waiting.and_then(|waiting| self.patience.step((way.taken, way.large), waiting, now_ns));
        slow.map_or(Ok(()), |why| Err(Ended::Slow(why)))
    }

    /// Waits for bytes of the client, room for ours, something to be said, or the time; whether there are bytes, and whether there is
    /// something to be said.
    fn wait(&mut self) -> Result<(bool, bool), Ended> {
        let mut wanted = PollFlags::empty();
        let may_ask = self.may_ask(monotonic_ns());
        wanted.set(PollFlags::IN, may_ask && !self.is_behind);
        wanted.set(PollFlags::OUT, self.outlet.way().is_blocked);
        let bell = self.place.mailbox.bell();
        let mut all = [
            PollFd::from_borrowed_fd(self.outlet.stream().as_fd(), wanted),
            PollFd::from_borrowed_fd(bell, PollFlags::IN),
        ];
        let tick = Timespec {
            tv_sec: 0,
            tv_nsec: if may_ask && self.is_behind { 0 } else { TICK_NS },
        };
        match poll(&mut all, Some(&tick)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(_) => return Err(Ended::Gone),
        }
        let [socket, bell] = all.map(|fd| fd.revents());
        if socket.contains(PollFlags::OUT) {
            self.outlet.way().is_blocked = false;
        }
        let is_readable = socket.intersects(PollFlags::IN | PollFlags::HUP | PollFlags::ERR);
        Ok((is_readable, bell.contains(PollFlags::IN)))
    }

    /// Whether it may be answered more: in this tick, and before what waits is sent.
    fn may_ask(&mut self, now_ns: i64) -> bool {
        if now_ns.saturating_sub(self.asked_since_ns) >= TICK_NS {
            (self.asked, self.asked_since_ns) = (0, now_ns);
        }
        self.asked < MOST_ASKED && self.answers.len() < MOST_ANSWERS
    }

    fn read(&mut self) -> Result<(), Ended> {
        let mut left = A_TURN;
        while left > 0 && !self.is_behind {
            let space = self.decoder.space();
            let most = space.len().min(left);
            let Some(space) = space.get_mut(..most) else { break };
            let mut stream = self.outlet.stream();
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

    /// Every whole message that has come, as long as it may ask.
    fn take_all(&mut self) -> Result<(), Ended> {
        let now_ns = monotonic_ns();
        loop {
            self.is_behind = !self.may_ask(now_ns);
            if self.is_behind {
                return Ok(());
            }
            let (mut actions, wish) = match self.decoder.take() {
                None => return Ok(()),
                Some(Ok(message)) => {
                    let wish = questions::image_wish(&message);
                    (self.session.step(Event::Received(&message), now_ns), wish)
                }
                Some(Err(malformed)) => (self.session.step(Event::Refused(&malformed), now_ns), None),
            };
            self.asked += 1;
            if let Some((device, starts)) = wish {
                self.wish(device, starts, &mut actions);
            }
            self.carry_out(actions)?;
        }
    }

    fn carry_out(&mut self, actions: Vec<Action>) -> Result<(), Ended> {
        for action in actions {
            match action {
                Action::Send(message) => self.queue(Arc::new(Letter::new(message))),
                Action::Answer { kind, device } => self.answer(kind, device),
                Action::Command { device, command } => self.owe(Answer::Asked(device, command)),
                // A client that spoke version 1 until now has not been told what version 2 alone can say.
                Action::Tell(Notice::SpeaksTwo) => {
                    self.outlet.way().version = self.session.version();
                    self.place.hall.tell_again(&self.place.mailbox);
                }
                // Who asks waits for an answer.
                Action::Tell(Notice::Skipped(kind)) if kind.to_string().starts_with("GET_") => {
                    let words = format!("{kind} is not answered here; CAPABILITY says what is");
                    self.queue(Arc::new(refusal(Status::ILLEGAL_INSTRUCTION, &words)));
                }
                Action::Tell(_) => {}
                Action::Close(reason) => return Err(Ended::Hostile(reason.to_string())),
            }
        }
        Ok(())
    }

    fn queue(&mut self, letter: Arc<Letter>) {
        self.owe(Answer::Said(letter));
    }

    fn owe(&mut self, answer: Answer) {
        // One message leads to two answers at most, and none is taken where there is no room: this is bounded.
        self.answers.push_back(answer);
    }

    /// Sends as much as the system takes.
    fn send(&mut self) -> Result<(), Ended> {
        let (outlet, counted) = (self.outlet, &self.place.hall.counted);
        let mut way = outlet.way();
        while !way.is_blocked {
            let now_ns = monotonic_ns();
            let written = match &way.sending {
                Some(_) => way.go_on(outlet.stream(), now_ns, &counted.sent),
                None => match self.next(&way, now_ns) {
                    Some(wire) => way.write(outlet.stream(), wire, now_ns, &counted.sent),
                    None => return Ok(()),
                },
            };
            written.map_err(|_| Ended::Gone)?;
        }
        let slow = way.sending.as_ref().and_then(|sending| sending.is_slow(monotonic_ns()));
        slow.map_or(Ok(()), |why| Err(Ended::Slow(why)))
    }

    /// What is sent next: poses and statuses, answers, words and images have their turns. What is taken of the box here, with the way in
    /// hand, is sent before whatever is told from now on.
    fn next(&mut self, way: &Way, now_ns: i64) -> Option<Arc<Wire>> {
        for _ in 0..4 {
            let turn = self.turn % 4;
            self.turn += 1;
            while let Some(letter) = self.of_turn(turn, now_ns) {
                // What has grown old while it waited, and what is not for this version, is passed over.
                if let Some(wire) = letter.wire(way.version).filter(|_| letter.holds_at(now_ns)) {
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
            1 => self.answers.pop_front().map(|answer| self.said(&answer)),
            2 => mailbox.hear(),
            _ => mailbox
                .take(Slot::Volume)
                .or_else(|| (0..self.known.views.len()).find_map(|view| self.waiting_image(view, now_ns))),
        }
    }

    /// The image of a view that waits. One that has grown old on its way is not sent, and what follows it is owed: who asked once asks no more.
    fn waiting_image(&self, view: usize, now_ns: i64) -> Option<Arc<Letter>> {
        let mailbox = &self.place.mailbox;
        let letter = mailbox.take(Slot::View(view))?;
        if letter.holds_at(now_ns) {
            return Some(letter);
        }
        mailbox.wish(Some(view), |wish| wish.owed = true);
        None
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
