//! Polls and their frames.

use super::super::rules::Poll;
use super::super::setup::Step;
use super::super::{Action, Notice, Reason};
use super::{Came, Client, not_an_answer, shortened};
use crate::answer::{Answer, ErrorCode};
use crate::bx2::{Alert, parse_bx2};
use crate::command::Command;
use crate::frame::Frame;
use crate::handle::Handle;
use crate::malformed::Malformed;
use crate::polled::bx::parse_bx;
use crate::polled::tx::parse_tx;
use crate::status::SystemStatus;
use crate::watch::FrameStep;
use crate::why::Why;

/// Polls one after the other that are refused.
const MOST_REFUSED: u32 = 5;
/// What the device says of itself in one reply, as far as it is told.
const MOST_ALERTS: usize = 64;
/// What a device says that does not know a way of polling, or not with these options.
const NOT_KNOWN: [ErrorCode; 4] = [
    ErrorCode::INVALID_COMMAND,
    ErrorCode::PARAMETERS,
    ErrorCode::RANGE,
    ErrorCode(0x33),
];
/// What a device says that is not set up.
const NOT_SET_UP: [ErrorCode; 2] = [ErrorCode::BAD_MODE, ErrorCode::SYSTEM_NOT_INITIALIZED];

/// What a poll gave.
struct Given {
    frames: Vec<Frame>,
    alerts: Vec<Alert>,
    system: Option<SystemStatus>,
}

impl Client {
    /// A poll, if it is time for one.
    pub(super) fn poll(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        if self.is_tracking() && now_ns.saturating_sub(self.polled_ns) >= self.rules.poll_ns {
            self.poll_now(now_ns, actions);
        }
    }

    pub(super) fn poll_now(&mut self, now_ns: i64, actions: &mut Vec<Action>) {
        self.polled_ns = now_ns;
        let command = match self.poll {
            Poll::Bx2 => Command::Bx2(self.rules.bx2()),
            Poll::Bx => Command::Bx(self.rules.bx()),
            Poll::Tx => Command::Tx(self.rules.tx()),
        };
        self.ask(command, now_ns, actions);
    }

    pub(super) fn polled(&mut self, command: &Command, came: Came, now_ns: i64, actions: &mut Vec<Action>) {
        let given = match came {
            Came::Text(_, Answer::Error(error)) => return self.poll_refused(command, error, now_ns, actions),
            came => given(command, &came, self.rules.tolerance),
        };
        match given {
            None => self.lose_step(not_an_answer(command), now_ns, actions),
            Some(Err(malformed)) => self.one_refused(Notice::Malformed(malformed), actions),
            Some(Ok(given)) => {
                (self.refused, self.setups, self.tries) = (0, 0, 0);
                if !self.poll_is_known {
                    self.poll_is_known = true;
                    actions.push(Action::Tell(Notice::Tracking(self.poll)));
                }
                self.of_itself(&given, actions);
                self.frames(given.frames, now_ns, actions);
                self.poll(now_ns, actions);
            }
        }
    }

    fn poll_refused(&mut self, command: &Command, error: ErrorCode, now_ns: i64, actions: &mut Vec<Action>) {
        let simpler = self.poll.simpler().filter(|_| self.rules.poll.is_none());
        if let (false, true, Some(simpler)) = (self.poll_is_known, NOT_KNOWN.contains(&error), simpler) {
            let poll = self.poll;
            actions.push(Action::Tell(Notice::NotKnown { poll, error }));
            self.poll = simpler;
            return self.poll_now(now_ns, actions);
        }
        let command = shortened(command);
        let notice = Notice::Refused { command, error };
        if NOT_SET_UP.contains(&error) {
            actions.push(Action::Tell(notice));
            return self.set_up(Step::Stop, now_ns, actions);
        }
        self.one_refused(notice, actions);
    }

    fn one_refused(&mut self, notice: Notice, actions: &mut Vec<Action>) {
        self.refused += 1;
        if self.refused >= MOST_REFUSED {
            let (count, last) = (self.refused, Box::new(notice));
            return self.close(Reason::TooManyRefused { count, last }, actions);
        }
        actions.push(Action::Tell(notice));
    }

    /// What has changed of what the device says of itself.
    fn of_itself(&mut self, given: &Given, actions: &mut Vec<Action>) {
        if let Some(system) = given.system.filter(|system| *system != self.system) {
            self.system = system;
            actions.push(Action::Tell(Notice::System(system)));
        }
        let alerts = given.alerts.get(..MOST_ALERTS).unwrap_or(&given.alerts);
        let new = alerts.iter().filter(|alert| !self.alerts.contains(alert));
        actions.extend(new.map(|alert| Action::Tell(Notice::Alert(*alert))));
        self.alerts = alerts.to_vec();
    }

    fn frames(&mut self, frames: Vec<Frame>, now_ns: i64, actions: &mut Vec<Action>) {
        if frames.is_empty() {
            actions.push(Action::Tell(Notice::NoFrame));
        }
        for mut frame in frames {
            let step = self.watch.judge(&frame, now_ns);
            let number = frame.number.unwrap_or_default();
            let notice = match step {
                FrameStep::First | FrameStep::Next { .. } => None,
                FrameStep::Same => Some(Notice::SameFrame { number }),
                FrameStep::Stands { number } => Some(Notice::Stands { number }),
                FrameStep::Jump { from, to } => Some(Notice::Jump { from, to }),
                FrameStep::Restarted { from, to } => Some(Notice::Restarted { from, to }),
                FrameStep::Back { from, to, .. } => Some(Notice::Back { from, to }),
                FrameStep::Anew { frames } => Some(Notice::CountsAnew { frames }),
            };
            actions.extend(notice.map(Action::Tell));
            match step {
                FrameStep::Same | FrameStep::Back { .. } => continue,
                FrameStep::Anew { .. } => {
                    self.watch.forget();
                    return self.set_up(Step::Stop, now_ns, actions);
                }
                FrameStep::Stands { number } => frame.doubt(("a frame's number that stands still,", number)),
                _ => {}
            }
            frame.expect(self.handles.iter().copied());
            self.unplugged_in(&frame, actions);
            actions.push(Action::Publish(frame, step));
        }
    }

    /// Tells once of each tool that is there no longer.
    fn unplugged_in(&mut self, frame: &Frame, actions: &mut Vec<Action>) {
        let of_session = |handle: &Handle| self.handles.contains(handle);
        for sight in frame.tools.iter().filter(|sight| of_session(&sight.handle())) {
            let was = self.unplugged.contains(&sight.handle());
            match (sight.why(), was) {
                (Why::Unplugged, false) => {
                    self.unplugged.push(sight.handle());
                    actions.push(Action::Tell(Notice::Unplugged(sight.handle())));
                }
                (Why::Unplugged | Why::NotInFrame, _) | (_, false) => {}
                (_, true) => self.unplugged.retain(|handle| *handle != sight.handle()),
            }
        }
    }
}

/// What a reply to this command says; `None` where it is none to it.
fn given(command: &Command, came: &Came, tolerance: f64) -> Option<Result<Given, Malformed>> {
    let of_polled = |polled: crate::polled::Polled| Given {
        frames: Frame::of_polled(&polled, tolerance),
        alerts: Vec::new(),
        system: Some(polled.system),
    };
    let given = match (command, came) {
        (Command::Tx(options), Came::Text(text, Answer::Words(_))) => parse_tx(text, *options).map(of_polled),
        (Command::Bx(options), Came::Body(body)) => parse_bx(body, *options).map(of_polled),
        (Command::Bx2(_), Came::Body(body)) => parse_bx2(body).map(|reply| Given {
            frames: Frame::of_bx2(&reply, tolerance),
            alerts: reply.alerts,
            system: None,
        }),
        _ => return None,
    };
    Some(given)
}
