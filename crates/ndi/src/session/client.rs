//! The side that asks: it sets a device up, polls it, and finds its place again when a reply is late.

mod polling;
mod resync;
mod steps;

use super::rules::{ClientRules, Poll};
use super::setup::Step;
use super::{Action, Event, Notice, Reason};
use crate::answer::Answer;
use crate::bx2::Alert;
use crate::command::Command;
use crate::decode::{Decoder, Reply};
use crate::handle::Handle;
use crate::limits::MOST_LOADED;
use crate::malformed::Malformed;
use crate::status::SystemStatus;
use crate::watch::FrameWatch;

/// Where a session is.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Stage {
    /// No connection, or one that is to be closed.
    Closed,
    /// In the set-up.
    Setup(Step),
    /// Set up.
    Tracking,
    /// Waiting until the device is silent.
    Quiet { began_ns: i64, heard_ns: i64 },
    /// VER was asked to find the place in the stream again.
    Verifying,
}

/// A command without its answer.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    command: Command,
    until_ns: i64,
    limit_ns: i64,
}

/// A reply of its own.
#[derive(Debug, Clone, PartialEq)]
enum Came {
    Text(String, Answer),
    Body(Vec<u8>),
}

/// A client's session, over all its connections.
#[derive(Debug, Clone)]
pub struct Client {
    rules: ClientRules,
    decoder: Decoder,
    stage: Stage,
    asked: Option<Asked>,
    /// Of the tools of the rules, in their order, then of those that are plugged in.
    handles: Vec<Handle>,
    poll: Poll,
    /// The device has answered this way of polling.
    poll_is_known: bool,
    polled_ns: i64,
    version: Option<String>,
    /// What silence leads back to: polling, or the set-up.
    was_tracking: bool,
    /// VER was asked so often to find the place again.
    tries: u32,
    setups: u32,
    refused: u32,
    watch: FrameWatch,
    system: SystemStatus,
    alerts: Vec<Alert>,
    unplugged: Vec<Handle>,
}

impl Client {
    /// Not connected yet.
    pub fn new(rules: ClientRules) -> Self {
        Self {
            decoder: Decoder::new(rules.limits),
            stage: Stage::Closed,
            asked: None,
            handles: Vec::new(),
            poll: rules.poll.unwrap_or(Poll::Bx2),
            poll_is_known: false,
            polled_ns: 0,
            version: None,
            was_tracking: false,
            tries: 0,
            setups: 0,
            refused: 0,
            watch: FrameWatch::default(),
            system: SystemStatus::default(),
            alerts: Vec::new(),
            unplugged: Vec::new(),
            rules,
        }
    }

    /// The handles of the tools of the rules, in their order, as far as they are known; then those of tools that are
    /// plugged in.
    pub fn handles(&self) -> &[Handle] {
        &self.handles
    }

    /// The handle of the tool of this name.
    pub fn handle(&self, name: &str) -> Option<Handle> {
        let place = self.rules.tools.iter().position(|tool| tool.name == name)?;
        self.handles.get(place).copied()
    }

    /// Whether the device is set up and polled.
    pub fn is_tracking(&self) -> bool {
        self.stage == Stage::Tracking
    }

    /// What an event leads to; a [`Action::Close`] stands last.
    pub fn step(&mut self, event: Event<'_>, now_ns: i64) -> Vec<Action> {
        let mut actions = Vec::new();
        match event {
            Event::Connected => self.connected(now_ns, &mut actions),
            Event::Bytes(bytes) => self.bytes(bytes, now_ns, &mut actions),
            Event::Tick => self.tick(now_ns, &mut actions),
            Event::Closed => self.stage = Stage::Closed,
        }
        actions
    }

    fn connected(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        self.version = None;
        (self.tries, self.setups, self.refused) = (0, 0, 0);
        let (found, most) = (self.rules.tools.len(), MOST_LOADED);
        if found > most {
            self.close(Reason::TooManyTools { found, most }, actions);
        } else {
            self.set_up(Step::Init, now_ns, actions);
        }
    }

    fn close(&mut self, reason: Reason, actions: &mut Vec<Action>) {
        self.stage = Stage::Closed;
        self.asked = None;
        self.decoder.restart();
        actions.push(Action::Close(reason));
    }

    fn bytes(&mut self, mut bytes: &[u8], now_ns: i64, actions: &mut Vec<Action>) {
        while !bytes.is_empty() {
            match &mut self.stage {
                Stage::Closed => return,
                Stage::Quiet { heard_ns, .. } => {
                    *heard_ns = now_ns;
                    return;
                }
                _ => {}
            }
            let Some(came) = self.decoder.feed(&mut bytes).map(owned) else {
                return;
            };
            match came {
                Err(malformed) => self.lose_step(Notice::Malformed(malformed), now_ns, actions),
                Ok(Came::Text(_, Answer::Reset)) => self.reset(now_ns, actions),
                Ok(came) => self.came(came, now_ns, actions),
            }
        }
    }

    fn reset(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        actions.push(Action::Tell(Notice::Reset));
        self.watch.forget();
        self.set_up(Step::Init, now_ns, actions);
    }

    fn came(&mut self, came: Came, now_ns: i64, actions: &mut Vec<Action>) {
        let Some(asked) = self.asked.take() else {
            let command = String::new();
            return self.lose_step(Notice::NotAnAnswer { command }, now_ns, actions);
        };
        match (self.stage.clone(), came) {
            (Stage::Setup(step), Came::Text(text, answer)) => {
                self.answered(step, &asked.command, &text, answer, now_ns, actions);
            }
            (Stage::Tracking, came) => self.polled(&asked.command, came, now_ns, actions),
            (Stage::Verifying, came) => self.verified(came, now_ns, actions),
            _ => self.lose_step(not_an_answer(&asked.command), now_ns, actions),
        }
    }

    fn tick(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        match self.stage {
            Stage::Closed => return,
            Stage::Quiet { began_ns, heard_ns } => return self.quiet(began_ns, heard_ns, now_ns, actions),
            _ => {}
        }
        match &self.asked {
            Some(asked) if now_ns > asked.until_ns => {
                let (command, limit_ns) = (shortened(&asked.command), asked.limit_ns);
                let broken = self
                    .decoder
                    .end()
                    .map(|malformed| Action::Tell(Notice::Malformed(malformed)));
                actions.extend(broken);
                self.lose_step(Notice::Unanswered { command, limit_ns }, now_ns, actions);
            }
            Some(_) => {}
            None => self.poll(now_ns, actions),
        }
    }

    fn ask(&mut self, command: Command, now_ns: i64, actions: &mut Vec<Action>) {
        let limit_ns = match command {
            Command::Init | Command::Pinit(_) | Command::Tstart => self.rules.slow_ns,
            _ => self.rules.answer_ns,
        };
        actions.push(Action::Send(command.to_bytes(self.rules.crc)));
        self.asked = Some(Asked {
            command,
            until_ns: now_ns.saturating_add(limit_ns),
            limit_ns,
        });
    }
}

fn owned(reply: Result<Reply<'_>, Malformed>) -> Result<Came, Malformed> {
    reply.map(|reply| match reply {
        Reply::Text(text) => Came::Text(text.to_owned(), Answer::of(text)),
        Reply::Binary(body) => Came::Body(body.to_vec()),
    })
}

fn not_an_answer(command: &Command) -> Notice {
    Notice::NotAnAnswer {
        command: shortened(command),
    }
}

/// A command for a message: of a piece of a definition its place alone.
fn shortened(command: &Command) -> String {
    match command {
        Command::Pvwr(handle, address, _) => format!("PVWR {handle}{address:04X}"),
        command => format!("{} {}", command.name(), command.arguments())
            .trim_end()
            .to_owned(),
    }
}
