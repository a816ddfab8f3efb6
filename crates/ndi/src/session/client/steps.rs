//! The set-up: each step is asked, and its answer leads to the next.

use super::super::setup::Step;
use super::super::{Action, Notice, Reason};
use super::{Client, Stage, not_an_answer, shortened};
use crate::answer::{Answer, ErrorCode};
use crate::command::Command;
use crate::handle::Handle;
use crate::limits::MOST_LOADED;
use crate::ports::{parse_phrq, parse_phsr};

/// Set-ups one after the other without a frame.
const MOST_SETUPS: u32 = 3;

impl Client {
    /// Begins the set-up anew, at this step.
    pub(super) fn set_up(&mut self, from: Step, now_ns: i64, actions: &mut Vec<Action>) {
        self.decoder.restart();
        self.handles.clear();
        self.unplugged.clear();
        self.watch.set_up();
        self.was_tracking = false;
        self.poll = self.rules.poll.unwrap_or(super::Poll::Bx2);
        self.poll_is_known = false;
        self.setups += 1;
        if self.setups > MOST_SETUPS {
            let count = MOST_SETUPS;
            return self.close(Reason::TooManySetups { count }, actions);
        }
        self.begin(from, now_ns, actions);
    }

    /// This step, or the first one behind it that has something to ask.
    pub(super) fn begin(&mut self, mut step: Step, now_ns: i64, actions: &mut Vec<Action>) {
        while step != Step::Track {
            if let Some(command) = step.command(&self.rules, &self.handles) {
                self.stage = Stage::Setup(step);
                return self.ask(command, now_ns, actions);
            }
            step = step.after(&self.rules);
        }
        self.stage = Stage::Tracking;
        self.was_tracking = true;
        self.asked = None;
        self.poll_now(now_ns, actions);
    }

    pub(super) fn answered(
        &mut self,
        step: Step,
        command: &Command,
        text: &str,
        answer: Answer,
        now_ns: i64,
        actions: &mut Vec<Action>,
    ) {
        match answer {
            // Nothing was tracked, or nothing can be stopped: as good.
            Answer::Error(_) if step == Step::Stop => self.begin(Step::Init, now_ns, actions),
            Answer::Error(ErrorCode::BAD_MODE) if step == Step::Init && self.setups <= 1 => {
                self.set_up(Step::Stop, now_ns, actions);
            }
            Answer::Error(error) => {
                let command = shortened(command);
                self.close(Reason::Refused { command, error }, actions);
            }
            Answer::Warning(code) => {
                let command = shortened(command);
                actions.push(Action::Tell(Notice::Warning { command, code }));
                let next = step.after(&self.rules);
                self.begin(next, now_ns, actions);
            }
            Answer::Okay => match self.after_okay(step, actions) {
                Some(next) => self.begin(next, now_ns, actions),
                None => self.lose_step(not_an_answer(command), now_ns, actions),
            },
            Answer::Words(_) => self.told(step, command, text, now_ns, actions),
            Answer::Reset => {}
        }
    }

    /// `OKAY` answers all steps but those that ask for something.
    fn after_okay(&self, step: Step, actions: &mut Vec<Action>) -> Option<Step> {
        match step {
            Step::Version | Step::Stale | Step::Request(_) | Step::FindUninitialized | Step::FindUnenabled => None,
            Step::Comm => {
                actions.extend(self.rules.comm.clone().map(Action::Speed));
                Some(step.after(&self.rules))
            }
            _ => Some(step.after(&self.rules)),
        }
    }

    /// What was asked for.
    fn told(&mut self, step: Step, command: &Command, text: &str, now_ns: i64, actions: &mut Vec<Action>) {
        let next = match step {
            Step::Version => {
                self.version = Some(text.to_owned());
                actions.push(Action::Tell(Notice::Version(text.to_owned())));
                Ok(step.after(&self.rules))
            }
            Step::Request(tool) => self.loaded(tool, text, actions).map(|()| step.after(&self.rules)),
            Step::Stale => self.listed(text, Step::Free, step),
            Step::FindUninitialized => self.wired(text, Step::InitializeWired, step),
            Step::FindUnenabled => self.wired(text, Step::EnableWired, step),
            _ => Err(not_an_answer(command)),
        };
        match next {
            Ok(next) => self.begin(next, now_ns, actions),
            Err(notice) => self.lose_step(notice, now_ns, actions),
        }
    }

    fn loaded(&mut self, tool: usize, text: &str, actions: &mut Vec<Action>) -> Result<(), Notice> {
        let handle = parse_phrq(text).map_err(Notice::Malformed)?;
        self.handles.truncate(tool);
        if self.handles.contains(&handle) {
            return Err(Notice::HandleTwice(handle));
        }
        self.handles.push(handle);
        let name = self
            .rules
            .tools
            .get(tool)
            .map(|tool| tool.name.clone())
            .unwrap_or_default();
        actions.push(Action::Tell(Notice::Loaded { name, handle }));
        Ok(())
    }

    /// The step for each of a list of handles.
    fn listed(&self, text: &str, each: impl Fn(Vec<Handle>) -> Step, step: Step) -> Result<Step, Notice> {
        let ports = parse_phsr(text).map_err(Notice::Malformed)?;
        let mut handles: Vec<Handle> = ports.iter().map(|port| port.handle).collect();
        handles.reverse();
        Ok(if handles.is_empty() {
            step.after(&self.rules)
        } else {
            each(handles)
        })
    }

    /// The same for tools that are plugged in, which are tracked from now on; no more than a device has.
    fn wired(&mut self, text: &str, each: impl Fn(Vec<Handle>) -> Step, step: Step) -> Result<Step, Notice> {
        for port in parse_phsr(text).map_err(Notice::Malformed)? {
            if !self.handles.contains(&port.handle) && self.handles.len() < MOST_LOADED {
                self.handles.push(port.handle);
            }
        }
        self.listed(text, each, step)
    }
}
