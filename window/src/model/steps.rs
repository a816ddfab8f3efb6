//! The way from an examination to a navigation: what has been done of it, and the step that a person stands at.

use bus::clock;
use bus::message::{Identity, StepTask, Steps, Workflow};
use guidance::workflow::Stage;

use super::{Known, Tone};

/// What the screen of steps shows.
#[derive(Debug, Clone, PartialEq)]
pub struct StepsModel {
    /// What has been done, and what is still to be done, one line each.
    pub ladder: Vec<Rung>,
    /// Where the person stands, as the calibrator told it last; `None`: nothing came from it.
    pub steps: Option<Box<Steps>>,
    /// The radius of the target that the proposed registration's error is shown at, mm.
    pub target_radius_mm: Option<f64>,
    /// A person has still to say whose the examination is.
    pub asks_whose: bool,
    /// There is a registration, which a marker that moves puts in doubt.
    pub is_registered: bool,
    /// What starts the navigation, or ends it; `None`: it cannot be started yet.
    pub navigates: Option<&'static str>,
}

/// A line of the ladder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rung {
    /// What is done or to be done.
    pub words: String,
    /// Live: done; quiet: to be done; a warning or an alarm: done, and does not hold.
    pub tone: Tone,
    /// Whether it is done.
    pub is_done: bool,
}

/// What is known of the steps; `None` where the run has none and demands none.
pub fn steps(known: &Known<'_>) -> Option<StepsModel> {
    let is_strict = known.workflow.is_some_and(|workflow| !workflow.has(Workflow::RESEARCH));
    if known.is_replay || (known.scene.steps.is_none() && !is_strict) {
        return None;
    }
    let target = known.steps.map(|steps| Steps::text(&steps.target));
    let target = target.and_then(|name| known.scene.targets.iter().find(|target| target.name == name));
    let workflow = known.workflow.unwrap_or_default();
    let stage = workflow.stage().unwrap_or(Stage::Empty);
    Some(StepsModel {
        asks_whose: stage > Stage::Empty && is_strict && !workflow.has(Workflow::CONFIRMED),
        is_registered: stage >= Stage::Registered,
        navigates: match stage {
            Stage::Navigating => Some("Rest"),
            Stage::Checked => Some("Navigate"),
            Stage::Registered if !is_strict => Some("Navigate"),
            _ => None,
        },
        ladder: ladder(known),
        steps: known.steps.map(Box::new),
        target_radius_mm: target.map(|target| target.diameter_mm / 2.0),
    })
}

fn ladder(known: &Known<'_>) -> Vec<Rung> {
    let stage = known
        .workflow
        .and_then(|workflow| workflow.stage())
        .unwrap_or(Stage::Empty);
    let workflow = known.workflow.unwrap_or_default();
    let is_research = workflow.has(Workflow::RESEARCH);
    let done = |words: &str, is_done: bool| Rung {
        words: words.to_owned(),
        tone: if is_done { Tone::Live } else { Tone::Quiet },
        is_done,
    };
    vec![
        done("examination loaded", stage > Stage::Empty),
        confirmed(known, workflow, is_research),
        done("tool calibrated", stage >= Stage::Calibrated),
        done("patient registered", stage >= Stage::Registered),
        checked(known, workflow, stage, is_research),
        done("navigating", stage == Stage::Navigating),
    ]
}

fn confirmed(known: &Known<'_>, workflow: Workflow, is_research: bool) -> Rung {
    let whose = known.identity.as_ref().map(Identity::words).map(|[name, ..]| name);
    let whose = whose
        .filter(|name| !name.is_empty())
        .unwrap_or("a patient not known".to_owned());
    if workflow.has(Workflow::REJECTED) {
        return Rung {
            words: format!("NOT THIS PATIENT'S EXAMINATION: {whose}"),
            tone: Tone::Alarm,
            is_done: false,
        };
    }
    let is_done = workflow.has(Workflow::CONFIRMED);
    let words = match (is_done, is_research) {
        (true, _) => format!("confirmed: the examination of {whose}"),
        (false, true) => format!("examination of {whose}: not confirmed, RESEARCH"),
        (false, false) => format!("examination of {whose}: to be confirmed"),
    };
    Rung {
        words,
        tone: if is_done { Tone::Live } else { Tone::Quiet },
        is_done,
    }
}

/// The check: its age and worst distance, or why it does not hold.
fn checked(known: &Known<'_>, workflow: Workflow, stage: Stage, is_research: bool) -> Rung {
    let alarm = |words: String| Rung {
        words,
        tone: Tone::Alarm,
        is_done: false,
    };
    if workflow.has(Workflow::BUMPED) {
        return alarm("MARKER ON THE PATIENT MOVED: check the registration".to_owned());
    }
    let said = check_words(known);
    if workflow.has(Workflow::CHECK_FAILED) {
        let said = said.map_or(String::new(), |said| format!(": {said}"));
        return alarm(format!("CHECK FAILED{said}"));
    }
    match said.filter(|_| !workflow.has(Workflow::NOT_CHECKED) && stage >= Stage::Registered) {
        Some(said) => Rung {
            words: format!("checked: {said}"),
            tone: Tone::Live,
            is_done: true,
        },
        None if is_research => Rung {
            words: "registration not checked, RESEARCH".to_owned(),
            tone: Tone::Quiet,
            is_done: false,
        },
        None => Rung {
            words: "registration to be checked".to_owned(),
            tone: Tone::Quiet,
            is_done: false,
        },
    }
}

/// The last check of the registration in use: how many points, the worst, and how long ago; `None`: none was made.
pub(super) fn check_words(known: &Known<'_>) -> Option<String> {
    let workflow = known.workflow.filter(|workflow| workflow.check_points > 0)?;
    let age_s = clock::ms(known.now_ns.saturating_sub(workflow.check_t_ns)).max(0.0) / 1e3;
    let ago = match age_s {
        s if s < 60.0 => format!("{s:.0} s ago"),
        s => format!("{:.0} min ago", (s / 60.0).floor()),
    };
    let plural = if workflow.check_points == 1 { "" } else { "s" };
    Some(format!(
        "{} point{plural}, the worst {:.1} mm, {ago}",
        workflow.check_points, workflow.check_worst_mm
    ))
}

impl StepsModel {
    /// Whether the scene has a task.
    pub fn has(&self, task: StepTask) -> bool {
        self.steps.as_ref().is_some_and(|steps| steps.has(task))
    }

    /// The task that was begun.
    pub fn task(&self) -> Option<StepTask> {
        self.steps.as_ref().and_then(|steps| steps.task())
    }
}
