//! What `pilot status` says of it.

use bus::message::{Guide, Workflow};
use guidance::workflow::Stage;
use serde::{Deserialize, Serialize};

/// How far the run has come and what a person chose.
#[derive(Debug, Default, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct GuidingStatus {
    /// EMPTY, LOADED, CONFIRMED, CALIBRATED, REGISTERED, CHECKED or NAVIGATING.
    pub(crate) stage: String,
    /// Confirmations may be skipped: every screen says RESEARCH.
    pub(crate) research: bool,
    /// What stands on what is shown, such as NOT CHECKED.
    pub(crate) marks: Vec<String>,
    /// The chosen target; `null`: none is.
    pub(crate) target: Option<String>,
    /// The number of the pose that is held; `null`: the tool is followed.
    pub(crate) held_seq: Option<u64>,
    /// What images show in the place of the scene's field and window; empty where all is the scene's.
    #[serde(default)]
    pub(crate) images: String,
}

impl GuidingStatus {
    pub(super) fn of(workflow: &Workflow, guide: &Guide) -> Self {
        Self {
            stage: workflow.stage().map_or("UNKNOWN", Stage::word).to_owned(),
            research: workflow.has(Workflow::RESEARCH),
            marks: workflow.marks().iter().map(|mark| mark.word().to_owned()).collect(),
            // A recording may hold what is no plan: nothing is aimed at then.
            target: guide.chosen().ok().flatten().map(|chosen| chosen.name),
            held_seq: guide.held().map(|held| held.seq),
            images: guide.images().unwrap_or_default().words(),
        }
    }

    /// One line for people.
    pub(crate) fn line(&self) -> String {
        let mut words = vec![self.stage.clone()];
        words.extend(self.research.then(|| "RESEARCH".to_owned()));
        words.extend(self.marks.iter().cloned());
        words.push(match &self.target {
            Some(name) => format!("target {name}"),
            None => "no target chosen".to_owned(),
        });
        words.extend((!self.images.is_empty()).then(|| format!("images {}", self.images)));
        words.extend(self.held_seq.map(|seq| format!("pose {seq} is held")));
        words.join(", ")
    }
}
