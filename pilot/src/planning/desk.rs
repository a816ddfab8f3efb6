//! The plan of a run in which it is made: changed on request, on disk before it is told, told to whoever listens.

use std::time::Duration;

use bus::clock::{self, date};
use bus::message::{Command, Plan as Told, PlanWish, VolumeHash};
use bus::port::Publisher;
use bus::topic::PLAN;
use bus::{Bus, BusError};
use guidance::plan::{Confirmed, Edit, Editor, Plan};
use guidance::workflow::VolumeId;

use super::store::{PlanStore, StoreError};

/// The plan that is being made.
#[derive(Debug)]
pub(crate) struct Desk {
    store: PlanStore,
    /// `None` until the examination is in memory.
    editor: Option<Editor>,
    plans: Publisher<Told>,
    /// Somebody else has changed the file.
    is_changed_elsewhere: bool,
    /// When the file is looked at next, ns on the run's clock.
    next_look_ns: i64,
}

/// Between two looks at the file.
const LOOK: Duration = Duration::from_millis(300);

impl Desk {
    pub(crate) fn open(bus: &Bus, store: PlanStore) -> Result<Self, BusError> {
        Ok(Self {
            store,
            editor: None,
            plans: Publisher::open(bus, &PLAN, "")?,
            is_changed_elsewhere: false,
            next_look_ns: i64::MIN,
        })
    }

    /// The run's examination is in memory. A plan that is there already is of it: the loader loads no other.
    pub(crate) fn volume(&mut self, hash: VolumeHash, now_ns: i64) -> Result<(), BusError> {
        if self.editor.is_some() {
            return Ok(());
        }
        let volume = VolumeId(hash.0);
        let plan = self.store.plan().cloned().unwrap_or_else(|| Plan::new(volume));
        if plan.volume != volume {
            return Ok(());
        }
        self.editor = Some(Editor::new(plan));
        self.tell(now_ns)
    }

    pub(crate) fn serve_late_joiners(&self) {
        self.plans.serve_late_joiners();
    }

    /// Looks whether somebody else has changed the file, and tells it: who plans on would find it out with her next change alone.
    pub(crate) fn look(&mut self, now_ns: i64) -> Result<(), BusError> {
        if now_ns < self.next_look_ns {
            return Ok(());
        }
        self.next_look_ns = now_ns.saturating_add(clock::ns(LOOK));
        let is_changed = self.store.is_changed_elsewhere();
        if std::mem::replace(&mut self.is_changed_elsewhere, is_changed) == is_changed {
            return Ok(());
        }
        self.tell(now_ns)
    }

    /// Makes a change that a person asks for; what was done, or why it was refused.
    pub(crate) fn request(&mut self, command: &Command, now_ns: i64) -> Result<Result<String, String>, BusError> {
        let Some(wish) = command.edit.wish(&command.words()) else {
            return Ok(Err(format!("no change of a plan has the code {}", command.edit.kind)));
        };
        let done = self.carry_out(wish);
        // Whoever is answered finds it on the bus.
        if done.is_ok() {
            self.tell(now_ns)?;
        }
        Ok(done)
    }

    /// The change is made of a copy: what could not be written has not happened.
    fn carry_out(&mut self, wish: PlanWish) -> Result<String, String> {
        let editor = self.editor.as_mut().ok_or("there is no examination yet to plan in")?;
        let mut changed = editor.clone();
        let words = words(&wish);
        let done = match wish {
            PlanWish::Edit(edit) => changed.edit(edit),
            PlanWish::Undo => changed.undo(),
            PlanWish::Redo => changed.redo(),
            PlanWish::Confirm(by) => changed.confirm(Confirmed { by, at: date::now() }),
        };
        done.map_err(|error| error.to_string())?;
        // Which plan it is stands on the screen: there the reason comes first.
        let name = format!("plan {}: ", self.store.path().display());
        let why = |error: StoreError| error.to_string().replacen(&name, "", 1);
        self.store.save(changed.plan()).map_err(why)?;
        *editor = changed;
        Ok(words)
    }

    fn tell(&self, now_ns: i64) -> Result<(), BusError> {
        let Some(editor) = &self.editor else { return Ok(()) };
        let told = Told::of(editor.plan(), self.store.id_number(), editor.depth());
        let elsewhere = if self.is_changed_elsewhere {
            Told::CHANGED_ELSEWHERE
        } else {
            0
        };
        self.plans.send(Told {
            t_ns: now_ns,
            flags: told.flags | elsewhere,
            ..told
        })
    }
}

fn words(wish: &PlanWish) -> String {
    match wish {
        PlanWish::Edit(Edit::Add(target)) => format!("plan: target {} is there", target.name),
        PlanWish::Edit(Edit::Change(name, target)) if *name != target.name => {
            format!("plan: target {name} is called {}", target.name)
        }
        PlanWish::Edit(Edit::Change(name, _)) => format!("plan: target {name} is changed"),
        PlanWish::Edit(Edit::Remove(name)) => format!("plan: target {name} is gone"),
        PlanWish::Edit(Edit::Measure(_)) => "plan: measured".to_owned(),
        PlanWish::Edit(Edit::RemoveMeasure(place)) => format!("plan: measure {} is gone", place + 1),
        PlanWish::Edit(Edit::Notes(_)) => "plan: notes".to_owned(),
        PlanWish::Undo => "plan: a change is taken back".to_owned(),
        PlanWish::Redo => "plan: a change is made again".to_owned(),
        PlanWish::Confirm(by) => format!("plan: confirmed by {by}"),
    }
}
