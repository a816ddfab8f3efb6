//! Changes of the plan that were asked of the pilot and are not in what it told.

use bus::message::{Command, PlanWish};
use bus::port::{CommandClient, Pending};
use bus::{Bus, BusError};
use guidance::plan::{Editor, Plan};

/// A change that was not answered for so long is said to have no answer.
const PATIENCE_NS: i64 = 2_000_000_000;
/// Changes that wait for their answer, at most.
const MOST: usize = 8;

/// What was asked of the pilot, one after another, in the order in which it was wished.
#[derive(Debug)]
pub(crate) struct Asked {
    pilot: CommandClient,
    /// Not answered yet.
    open: Option<(PlanWish, Pending)>,
    waiting: Vec<PlanWish>,
}

impl Asked {
    /// # Errors
    /// [`BusError::Open`].
    pub(crate) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            pilot: CommandClient::open(bus, "pilot")?,
            open: None,
            waiting: Vec::new(),
        })
    }

    /// Whether something is not answered.
    pub(crate) fn is_some(&self) -> bool {
        self.open.is_some() || !self.waiting.is_empty()
    }

    /// Takes a change in.
    ///
    /// # Errors
    /// In words, where too many wait.
    pub(crate) fn ask(&mut self, wish: PlanWish) -> Result<(), String> {
        if self.waiting.len() >= MOST {
            return Err(format!("{MOST} changes are without an answer already"));
        }
        self.waiting.push(wish);
        Ok(())
    }

    /// Takes the answer that has come, and asks for the next change.
    ///
    /// # Errors
    /// In words, why a change was refused or has no answer.
    pub(crate) fn turn(&mut self) -> Result<(), String> {
        if let Some((_, pending)) = &self.open {
            let answer = match pending.reply() {
                Ok(None) if pending.waited_ns() <= PATIENCE_NS => return Ok(()),
                Ok(Some(reply)) if !reply.refused => Ok(()),
                Ok(Some(reply)) => Err(reply.text),
                Ok(None) => Err(pending.no_answer().to_string()),
                Err(error) => Err(error.to_string()),
            };
            self.open = None;
            if answer.is_err() {
                // What was wished after it was wished of a plan that there is not.
                self.waiting.clear();
                return answer;
            }
        }
        if self.waiting.is_empty() {
            return Ok(());
        }
        let wish = self.waiting.remove(0);
        let command = Command::plan(&wish).ok_or("these words are too long")?;
        let pending = self.pilot.send(command).map_err(|error| error.to_string())?;
        self.open = Some((wish, pending));
        Ok(())
    }

    /// The plan as it was told, with what has been asked for since: two presses of a key are two steps.
    pub(crate) fn made_of(&self, told: &Plan) -> Plan {
        let mut editor = Editor::new(told.clone());
        for wish in self.open.iter().map(|(wish, _)| wish).chain(&self.waiting) {
            if let PlanWish::Edit(edit) = wish {
                // Whoever keeps the plan says what is wrong with it.
                let _ = editor.edit(edit.clone());
            }
        }
        editor.plan().clone()
    }
}
