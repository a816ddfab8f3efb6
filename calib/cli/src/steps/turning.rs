//! The tool by turning it in a divot: its tip, and where the scene asks for it its shaft.

use std::rc::Rc;

use bus::message::{StepFigure, Steps};

use super::course::{Around, Course, Listen, Moment, Proposal, Said};
use super::hand;
use super::made::Calibrated;
use crate::store;

const TIP: &str = "tip.json";
const SHAFT: &str = "shaft.json";

/// The tip by pivoting, and the shaft by the scene's direction or by spinning.
pub(super) struct Turning {
    around: Rc<Around>,
    spins: bool,
    tip: Option<Calibrated>,
    shaft: Option<Calibrated>,
    tool: Option<Calibrated>,
}

impl Turning {
    pub(super) fn new(around: &Rc<Around>, spins: bool) -> Self {
        Self {
            around: around.clone(),
            spins,
            tip: None,
            shaft: None,
            tool: None,
        }
    }

    /// Whether the shaft is next, or to be spun again.
    fn is_at_shaft(&self) -> bool {
        self.spins && self.tip.as_ref().is_some_and(Calibrated::is_accepted)
    }

    /// What the step made that a person stands at.
    fn newest(&self) -> Option<&Calibrated> {
        match self.is_at_shaft() {
            true => self.tool.as_ref().or(self.shaft.as_ref()),
            false => self.tip.as_ref(),
        }
    }
}

impl Course for Turning {
    fn listen(&self) -> Result<Listen, String> {
        let around = &self.around;
        let seconds = around.spec.turn_s.to_string();
        let tip = around.file(TIP);
        let words = match (self.spins, self.is_at_shaft()) {
            (false, _) => around.command("pivot", ["--seconds", &seconds, "--axis", "scene", "--json"]),
            (true, false) => around.command("pivot", ["--seconds", &seconds, "--json"]),
            (true, true) => around.command("spin", ["--seconds", &seconds, "--tip", &tip, "--json"]),
        };
        let motion = if self.is_at_shaft() { hand::spin } else { hand::pivot };
        Ok(Listen {
            words,
            practice: around.room.map(|room| motion(room.divot)),
        })
    }

    fn heard(&mut self, said: Said, _: Moment) -> Result<(), String> {
        let made = Calibrated::of(said)?;
        let is_at_shaft = self.is_at_shaft();
        (self.shaft, self.tool) = (None, None);
        let (name, place) = match is_at_shaft {
            true => (SHAFT, &mut self.shaft),
            false => (TIP, &mut self.tip),
        };
        // The next command reads it; what is not accepted nothing rests on.
        if made.is_accepted() {
            let path = self.around.work.join(name);
            store::write(&path, Ok(made.text.clone()), std::iter::empty()).map_err(|error| error.to_string())?;
        }
        *place = Some(made);
        Ok(())
    }

    fn compute(&mut self) -> Result<Option<Vec<String>>, String> {
        let is_due = self.tool.is_none() && self.shaft.as_ref().is_some_and(Calibrated::is_accepted);
        let (tip, shaft) = (self.around.file(TIP), self.around.file(SHAFT));
        let words = || {
            self.around
                .command("tool", ["--pivot", &tip, "--spin", &shaft, "--json"])
        };
        Ok(is_due.then(words))
    }

    fn computed(&mut self, said: Said) -> Result<(), String> {
        self.tool = Some(Calibrated::of(said)?);
        Ok(())
    }

    fn back(&mut self) -> bool {
        let had = self.tip.is_some();
        match self.shaft.is_some() {
            true => (self.shaft, self.tool) = (None, None),
            false => self.tip = None,
        }
        had
    }

    fn proposal(&self) -> Result<Proposal, String> {
        let made = match self.spins {
            true => self.tool.as_ref().or(self.shaft.as_ref()).or(self.tip.as_ref()),
            false => self.tip.as_ref(),
        };
        let made = made.ok_or("turn the instrument first")?;
        if let Some(why) = &made.refused {
            return Err(why.clone());
        }
        match made.file.tool_frame.is_some() {
            true => Ok(Proposal {
                path: self.around.files[0].clone().unwrap_or_default(),
                text: made.text.clone(),
            }),
            false => Err("the shaft is still to be spun".to_owned()),
        }
    }

    fn show(&self, mut steps: Steps) -> Steps {
        let is_at_shaft = self.is_at_shaft();
        (steps.step, steps.steps) = (is_at_shaft.into(), if self.spins { 2 } else { 1 });
        let (title, what) = match is_at_shaft {
            true => (
                "Shaft: spin",
                "Leave the tip in the divot and spin the instrument about its shaft, by half a turn and back.",
            ),
            false => (
                "Tip: pivot",
                "Put the tip into the divot and turn the instrument about it, to all sides. The tip must not slip.",
            ),
        };
        (steps.title, steps.what) = (Steps::field(title), Steps::field(what));
        let gates = self.newest().map(Calibrated::gates).unwrap_or_default();
        let figures = self.newest().map(Calibrated::figures).unwrap_or_default();
        let own = StepFigure::new("the direction of the shaft is the scene's own, not measured");
        let own = (!self.spins && self.tip.is_some()).then_some(own);
        steps.with(&[], &gates, &figures.into_iter().chain(own).collect::<Vec<_>>())
    }
}
