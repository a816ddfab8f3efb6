//! What a person chose and how far the run has come. The pilot keeps it: a window may be killed and must come back as it was, and
//! the pilot is the one process whose end ends the run.
//!
//! In a replay what was chosen comes out of the recording, and is only heard here. Where another machine's run is shown all of it is
//! kept there, and heard here.

mod choice;
mod identity;
mod progress;
mod told;

use bus::message::{Command, CommandKind, Guide, ToolPose, Tracked, VolumeHash, Workflow};
use bus::port::{Publisher, Subscriber};
use bus::topic::{GUIDE, WORKFLOW};
use bus::{Bus, BusError};
use guidance::workflow::{Rules, RulesError};
use scene::Scene;

use choice::Choice;
pub(crate) use progress::CheckReport;
use progress::Progress;
pub(crate) use told::GuidingStatus;

/// Who says what is aimed at and how far the run has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kept {
    /// Both are kept here.
    Here,
    /// A recording says what was aimed at.
    Recorded,
    /// Another machine, whose run is shown, says both.
    Elsewhere,
}

/// What the scene demands. A replay shows what was, and demands nothing.
pub(crate) fn rules(scene: &Scene, kept: Kept) -> Result<Rules, RulesError> {
    let demands = scene.workflow;
    Rules::new(
        demands.strict && kept != Kept::Recorded,
        demands.check_mm,
        bus::clock::ns(demands.check_age),
    )
}

/// This process's end of the guide's topic.
#[derive(Debug)]
enum Guides {
    /// It is chosen here.
    Told(Publisher<Guide>),
    /// A recording tells it.
    Heard(Subscriber<Guide>),
}

/// This process's end of the workflow's topic.
#[derive(Debug)]
enum Workflows {
    Told(Publisher<Workflow>),
    Heard(Subscriber<Workflow>),
}

/// What a person chose and how far the run has come.
#[derive(Debug)]
pub(crate) struct Guiding {
    choice: Choice,
    progress: Progress,
    guides: Guides,
    workflows: Workflows,
    /// What was said last of the workflow, here or on the other machine.
    told: Option<Workflow>,
}

impl Guiding {
    /// Opens the topics, and tells what the scene chose.
    pub(crate) fn open(bus: &Bus, scene: &Scene, rules: Rules, kept: Kept) -> Result<Self, BusError> {
        let guiding = Self {
            choice: Choice::of(scene, kept),
            progress: Progress::new(rules, bus::clock::ns(scene.limits.lost)),
            guides: match kept {
                Kept::Here => Guides::Told(Publisher::open(bus, &GUIDE, "")?),
                Kept::Recorded | Kept::Elsewhere => Guides::Heard(Subscriber::open(bus, &GUIDE, "", 1)?),
            },
            workflows: match kept {
                Kept::Here | Kept::Recorded => Workflows::Told(Publisher::open(bus, &WORKFLOW, "")?),
                Kept::Elsewhere => Workflows::Heard(Subscriber::open(bus, &WORKFLOW, "", 1)?),
            },
            told: None,
        };
        guiding.tell_guide()?;
        Ok(guiding)
    }

    /// The run's examination is in memory.
    pub(crate) fn volume(&mut self, hash: VolumeHash) {
        self.progress.volume(hash);
    }

    /// A sample came, and came to this.
    pub(crate) fn pose(&mut self, pose: &ToolPose, tracked: &Tracked) {
        self.progress.pose(pose, tracked);
    }

    /// Once a turn, at `now_ns` of the session's clock: tells what has changed, and those who joined late. Gives what is to be
    /// written into the log.
    pub(crate) fn turn(&mut self, now_ns: i64) -> Result<Vec<String>, BusError> {
        self.progress.turn(now_ns);
        match &self.guides {
            Guides::Told(guides) => guides.serve_late_joiners(),
            Guides::Heard(guides) => {
                if let Some(guide) = guides.newest()? {
                    self.choice.heard(guide);
                }
            }
        }
        let workflows = match &self.workflows {
            Workflows::Told(workflows) => workflows,
            Workflows::Heard(workflows) => {
                self.told = workflows.newest()?.or(self.told);
                return Ok(Vec::new());
            }
        };
        let mut workflow = Workflow::of(self.progress.state(), now_ns);
        if let Some(checked) = self.progress.checked() {
            workflow = workflow.checked(checked.worst_mm, checked.points, checked.t_ns);
        }
        workflow.bumps = self.progress.bumps();
        let differs = |told: Workflow| Workflow { t_ns: 0, ..told } != Workflow { t_ns: 0, ..workflow };
        match self.told.is_none_or(differs) {
            true => {
                workflows.send(workflow)?;
                self.told = Some(workflow);
            }
            false => workflows.serve_late_joiners(),
        }
        Ok(self.progress.take_said())
    }

    /// Carries out what a person asks for, at `now_ns` of the session's clock: what was done or why it was refused, in words.
    /// `None` where it is nothing of this.
    pub(crate) fn request(
        &mut self,
        command: &Command,
        now_ns: i64,
    ) -> Result<Option<Result<String, String>>, BusError> {
        let words = command.words();
        let done = match command.command_kind() {
            Some(_) if matches!(self.workflows, Workflows::Heard(_)) => Err(choice::ELSEWHERE.to_owned()),
            Some(CommandKind::Choose) => self.choice.choose(&words, now_ns),
            Some(CommandKind::Images) => match command.images_wish() {
                Ok(wish) => self.choice.images(wish, now_ns),
                Err(error) => Err(error.to_string()),
            },
            Some(CommandKind::Hold) => self.choice.hold(&command.pose, now_ns),
            Some(CommandKind::Follow) => self.choice.follow(now_ns),
            Some(CommandKind::Mark) => self.choice.mark(&words),
            Some(CommandKind::Confirm) => self.progress.confirm(&words),
            Some(CommandKind::Reject) => self.progress.reject(),
            Some(CommandKind::Navigate) => self.progress.navigate(now_ns),
            Some(CommandKind::Checked) => self.progress.check(command, now_ns),
            Some(CommandKind::Bumped) => self.progress.bumped(now_ns),
            Some(CommandKind::Rest) => self.progress.rest(),
            _ => return Ok(None),
        };
        let is_guide = matches!(
            command.command_kind(),
            Some(CommandKind::Choose | CommandKind::Images | CommandKind::Hold | CommandKind::Follow)
        );
        // Whoever is answered finds it on the bus.
        if done.is_ok() && is_guide {
            self.tell_guide()?;
        }
        Ok(Some(done))
    }

    fn tell_guide(&self) -> Result<(), BusError> {
        match &self.guides {
            Guides::Told(guides) => guides.send(*self.choice.guide()),
            Guides::Heard(_) => Ok(()),
        }
    }

    /// For the report.
    pub(crate) fn check_report(&self) -> Option<CheckReport> {
        self.progress.report().cloned()
    }

    /// For `pilot status`.
    pub(crate) fn status(&self) -> GuidingStatus {
        let workflow = match &self.workflows {
            Workflows::Told(_) => Workflow::of(self.progress.state(), 0),
            Workflows::Heard(_) => self.told.unwrap_or_default(),
        };
        GuidingStatus::of(&workflow, self.choice.guide())
    }
}
