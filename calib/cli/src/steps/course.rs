//! One task: its steps, and what came of them.

use std::path::PathBuf;

use bus::message::{Practice, Steps};
use geometry::{Ct, Point};
use scene::operating_room::PracticeRoom;
use scene::steps::StepsSpec;

use crate::commands::Outcome;

/// What a command said: what came of it, or why nothing did.
pub(super) type Said = Result<Outcome, String>;

/// What the tasks of a run have in common.
#[derive(Debug, Clone)]
pub(super) struct Around {
    /// The run's name.
    pub(super) run: String,
    /// Where touches and intermediate results go.
    pub(super) work: PathBuf,
    /// The files that the tracker reads: calibration, registration.
    pub(super) files: [Option<PathBuf>; 2],
    pub(super) spec: StepsSpec,
    /// Where the error of a registration counts, and what is there.
    pub(super) target: Option<(String, Point<Ct>)>,
    /// A check passes where no point is off by more, mm.
    pub(super) check_mm: f64,
    /// A simulated hand does what a step asks for.
    pub(super) room: Option<PracticeRoom>,
}

/// What is listened to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Listen {
    /// The command line of `calib`, its name first.
    pub(super) words: Vec<String>,
    /// What the simulated hand does meanwhile, where there is one.
    pub(super) practice: Option<Practice>,
}

/// When something was heard, and under which registration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Moment {
    /// ns on the session's clock.
    pub(super) t_ns: i64,
    /// The id of the registration that poses rested on from the beginning to the end; `None`: there was none, or it changed.
    pub(super) registration_id: Option<u64>,
}

/// What can be accepted: the content of a file that the tracker reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Proposal {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// What a check came to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Report {
    pub(super) worst_mm: f64,
    pub(super) points: u32,
    pub(super) moment: Moment,
    /// Why it fails whatever the distance allowed; empty where nothing says so.
    pub(super) fails: String,
}

/// One task.
pub(super) trait Course {
    /// What is listened to when a person begins.
    ///
    /// # Errors
    /// Why nothing can be listened to, in words.
    fn listen(&self) -> Result<Listen, String>;
    /// Takes in what the command said that listened.
    ///
    /// # Errors
    /// Why it gave nothing.
    fn heard(&mut self, said: Said, moment: Moment) -> Result<(), String>;
    /// The command line of what is to be computed of it; `None`: nothing.
    fn compute(&mut self) -> Result<Option<Vec<String>>, String>;
    /// Takes in what that said.
    ///
    /// # Errors
    /// Why it gave nothing.
    fn computed(&mut self, said: Said) -> Result<(), String>;
    /// Forgets what came last; whether there was anything.
    fn back(&mut self) -> bool;
    /// The next touch is of this point; whether there is such a point.
    fn choose(&mut self, _point: usize) -> bool {
        false
    }
    /// What can be accepted now.
    ///
    /// # Errors
    /// Why nothing can, in words.
    fn proposal(&self) -> Result<Proposal, String>;
    /// What is to be told of a check, once.
    fn report(&mut self) -> Option<Report> {
        None
    }
    /// What is shown of it.
    fn show(&self, steps: Steps) -> Steps;
}

impl Around {
    /// A command line of `calib` for this run.
    pub(super) fn command<'a>(&self, command: &str, more: impl IntoIterator<Item = &'a str>) -> Vec<String> {
        let own = ["calib", command, "--live", &self.run].map(str::to_owned);
        own.into_iter().chain(more.into_iter().map(str::to_owned)).collect()
    }

    /// A file of the work folder, as a word of a command line.
    pub(super) fn file(&self, name: &str) -> String {
        self.work.join(name).to_string_lossy().into_owned()
    }
}

/// The command that does the same in a terminal: `pilot calibrate ...`.
pub(super) fn in_a_terminal(words: &[String]) -> String {
    let mut text = "pilot calibrate".to_owned();
    for word in words.iter().skip(1) {
        match word.as_str() {
            "--json" => {}
            // `pilot calibrate` takes the same run by --run.
            "--live" => text += " --run",
            word if word.contains(' ') => text += &format!(" '{word}'"),
            word => text += &format!(" {word}"),
        }
    }
    text
}
