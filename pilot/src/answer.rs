//! What the pilot answers: to `pilot status`, `stop` and `restart`, and to whoever chooses, holds, notes, confirms and starts.

use bus::BusError;
use bus::message::{Command, CommandKind, Level};
use bus::port::Request;

use crate::plan::LOCALIZER;
use crate::state::Run;
use crate::status::Status;
use crate::supervise::Event;

/// Images of poses show the plan that the run began with, and a replay shows them again.
const NOT_PLANNING: &str =
    "the plan of a run that navigates does not change: change it with `pilot plan`, and start again";

impl Run {
    /// Answers a request; returns what it means for the supervisor.
    pub(crate) fn answer(&mut self, request: Request) -> Result<Option<Event>, BusError> {
        let command: Command = *request.command();
        match command.command_kind() {
            Some(CommandKind::Status) => {
                let json = serde_json::to_string(&Status::of(self)).unwrap_or_default();
                request.reply(Ok(&json))?;
                Ok(None)
            }
            Some(CommandKind::Stop) => {
                self.tell(Level::Info, "command: stop");
                request.reply(Ok("stopping"))?;
                self.asked_to_stop = true;
                Ok(None)
            }
            Some(CommandKind::Restart) => match self.bring_back(&command.words()) {
                Ok((i, words)) => {
                    self.tell(Level::Info, &format!("command: restart; {words}"));
                    request.reply(Ok(&words))?;
                    Ok(Some(Event::Restart(i)))
                }
                Err(why) => {
                    request.reply(Err(&why))?;
                    Ok(None)
                }
            },
            _ => {
                self.guided(request)?;
                Ok(None)
            }
        }
    }

    /// Answers what a person chooses or says.
    fn guided(&mut self, request: Request) -> Result<(), BusError> {
        let now_ns = self.session.clock().now_ns();
        let done = match (request.command().command_kind(), &mut self.desk) {
            (Some(CommandKind::Plan), Some(desk)) => Some(desk.request(request.command(), now_ns)?),
            (Some(CommandKind::Plan), None) => Some(Err(NOT_PLANNING.to_owned())),
            _ => self.guiding.request(request.command(), now_ns)?,
        };
        match done {
            Some(Ok(words)) => {
                self.tell(Level::Info, &words);
                request.reply(Ok(&words))
            }
            Some(Err(why)) => request.reply(Err(&why)),
            None => request.reply(Err(
                "the pilot answers status, stop, restart, choose, images, hold, follow, mark, confirm, reject, navigate, rest, checked, bumped and plan",
            )),
        }
    }

    /// The held process of this name, no longer held, or the localizer; or why there is nothing to bring back.
    fn bring_back(&mut self, name: &str) -> Result<(usize, String), String> {
        let found = self.children.iter().position(|child| child.name() == name);
        let Some(i) = found else {
            return Err(format!("this run has no process {name:?}"));
        };
        match self.supervisor.stage_word(i) {
            "held" => {
                self.children[i].is_held = false;
                self.localizer_anew |= name == LOCALIZER;
                Ok((i, format!("starting {name} again")))
            }
            // Its peer may want a person to confirm each connection: nobody else may say when.
            "ready" if name == LOCALIZER => Ok((i, "the localizer is started anew and dials".to_owned())),
            stage => Err(format!(
                "{name} is {stage}: only a process that ended too often and is held can be brought back"
            )),
        }
    }
}
