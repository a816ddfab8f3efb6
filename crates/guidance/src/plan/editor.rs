//! Changing a plan, and taking changes back.

use super::{Confirmed, Measure, Plan, PlanError, Target};

/// So many changes can be taken back; the earliest are forgotten first.
const MOST_UNDONE: usize = 256;

/// A change.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// One more target.
    Add(Target),
    /// The target of this name becomes this one, also under another name.
    Change(String, Target),
    /// The target of this name is no more.
    Remove(String),
    /// One more distance or angle.
    Measure(Measure),
    /// The distance or angle at this place, from 0, is no more.
    RemoveMeasure(usize),
    /// These are the notes.
    Notes(String),
}

/// A plan that is being made: each change is made whole or not at all, and can be taken back.
#[derive(Debug, Clone, PartialEq)]
pub struct Editor {
    plan: Plan,
    undone: Vec<Plan>,
    before: Vec<Plan>,
}

impl Editor {
    /// Goes on with a plan.
    pub fn new(plan: Plan) -> Self {
        Self {
            plan,
            undone: Vec::new(),
            before: Vec::new(),
        }
    }

    /// The plan as it is now.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// How many changes can be taken back, and how many of these made again.
    pub fn depth(&self) -> [usize; 2] {
        [self.before.len(), self.undone.len()]
    }

    /// Makes a change.
    ///
    /// # Errors
    /// [`PlanError`]: nothing has changed then.
    pub fn edit(&mut self, edit: Edit) -> Result<(), PlanError> {
        self.is_open()?;
        let changed = changed(&self.plan, edit)?.checked()?;
        if changed != self.plan {
            self.keep();
            self.undone.clear();
            self.plan = changed;
        }
        Ok(())
    }

    /// Takes the last change back.
    ///
    /// # Errors
    /// [`PlanError::NothingToUndo`], [`PlanError::Confirmed`].
    pub fn undo(&mut self) -> Result<(), PlanError> {
        self.is_open()?;
        let before = self.before.pop().ok_or(PlanError::NothingToUndo)?;
        self.undone.push(std::mem::replace(&mut self.plan, before));
        Ok(())
    }

    /// Makes the change again that was taken back last.
    ///
    /// # Errors
    /// [`PlanError::NothingToRedo`], [`PlanError::Confirmed`].
    pub fn redo(&mut self) -> Result<(), PlanError> {
        self.is_open()?;
        let after = self.undone.pop().ok_or(PlanError::NothingToRedo)?;
        self.keep();
        self.plan = after;
        Ok(())
    }

    /// A person says that the plan is to be followed: nothing changes any more.
    ///
    /// # Errors
    /// [`PlanError::NothingToConfirm`] without a target, [`PlanError::Confirmed`] where that was said before,
    /// [`PlanError::Words`] for no name.
    pub fn confirm(&mut self, confirmed: Confirmed) -> Result<(), PlanError> {
        self.is_open()?;
        if self.plan.targets.is_empty() {
            return Err(PlanError::NothingToConfirm);
        }
        let plan = Plan {
            confirmed: Some(confirmed),
            ..self.plan.clone()
        };
        self.plan = plan.checked()?;
        Ok(())
    }

    fn is_open(&self) -> Result<(), PlanError> {
        match &self.plan.confirmed {
            None => Ok(()),
            Some(Confirmed { by, at }) => Err(PlanError::Confirmed {
                by: by.clone(),
                at: at.clone(),
            }),
        }
    }

    fn keep(&mut self) {
        if self.before.len() == MOST_UNDONE {
            self.before.remove(0);
        }
        self.before.push(self.plan.clone());
    }
}

fn changed(plan: &Plan, edit: Edit) -> Result<Plan, PlanError> {
    let mut plan = plan.clone();
    match edit {
        Edit::Add(target) => plan.targets.push(target),
        Edit::Change(name, target) => {
            let place = place_of(&plan, &name)?;
            plan.targets[place] = target;
        }
        Edit::Remove(name) => {
            let place = place_of(&plan, &name)?;
            plan.targets.remove(place);
        }
        Edit::Measure(measure) => plan.measures.push(measure),
        Edit::RemoveMeasure(place) => {
            let count = plan.measures.len();
            if place >= count {
                return Err(PlanError::NoMeasure {
                    place: place.saturating_add(1),
                    count,
                });
            }
            plan.measures.remove(place);
        }
        Edit::Notes(notes) => plan.notes = notes,
    }
    Ok(plan)
}

fn place_of(plan: &Plan, name: &str) -> Result<usize, PlanError> {
    let place = plan.targets.iter().position(|target| target.name == name);
    place.ok_or_else(|| PlanError::NoTarget {
        name: name.to_owned(),
        names: plan.targets.iter().map(|target| target.name.clone()).collect(),
    })
}
