//! What a person chose and how far the run has come. The pilot keeps it: a window may be killed and must come back as it was, and
//! the pilot is the one process whose end ends the run.
//!
//! In a replay what was chosen comes out of the recording, and is only heard here.

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
use progress::Progress;
pub(crate) use told::GuidingStatus;

/// What the scene demands. A replay shows what was, and demands nothing.
pub(crate) fn rules(scene: &Scene, is_replay: bool) -> Result<Rules, RulesError> {
    let demands = scene.workflow;
    Rules::new(
        demands.strict && !is_replay,
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

/// What a person chose and how far the run has come.
#[derive(Debug)]
pub(crate) struct Guiding {
    choice: Choice,
    progress: Progress,
    guides: Guides,
    workflows: Publisher<Workflow>,
    /// What was said last of the workflow.
    told: Option<Workflow>,
}

impl Guiding {
    /// Opens the topics, and tells what the scene chose.
    pub(crate) fn open(bus: &Bus, scene: &Scene, rules: Rules, is_replay: bool) -> Result<Self, BusError> {
        let guiding = Self {
            choice: Choice::of(scene, is_replay),
            progress: Progress::new(rules, bus::clock::ns(scene.limits.lost)),
            guides: match is_replay {
                true => Guides::Heard(Subscriber::open(bus, &GUIDE, "", 1)?),
                false => Guides::Told(Publisher::open(bus, &GUIDE, "")?),
            },
            workflows: Publisher::open(bus, &WORKFLOW, "")?,
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
        let mut workflow = Workflow::of(self.progress.state(), now_ns);
        if let Some(checked) = self.progress.checked() {
            workflow = workflow.checked(checked.worst_mm, checked.points, checked.t_ns);
        }
        workflow.bumps = self.progress.bumps();
        let differs = |told: Workflow| Workflow { t_ns: 0, ..told } != Workflow { t_ns: 0, ..workflow };
        match self.told.is_none_or(differs) {
            true => {
                self.workflows.send(workflow)?;
                self.told = Some(workflow);
            }
            false => self.workflows.serve_late_joiners(),
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

    /// For `pilot status`.
    pub(crate) fn status(&self) -> GuidingStatus {
        GuidingStatus::of(self.progress.state(), self.choice.guide())
    }
}
