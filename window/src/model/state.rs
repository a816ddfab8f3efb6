//! The state of the whole screen: one word, in one colour, with one shape.

use bus::clock;
use bus::gather::{PoseId, Set};
use bus::message::{FrameState, Workflow};
use guidance::workflow::Stage;

use super::{Known, Recorded};

/// No image shows a pose that is captured so much later than now, ns: its age would never be noticed.
const AHEAD_NS: i64 = 100_000_000;

/// How a state is to be taken: each has a colour and a shape of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// The images are now, and may be followed.
    Live,
    /// The images are now, and something is not done yet.
    Quiet,
    /// What is shown is old, or parts of it differ.
    Warning,
    /// There is nothing to be followed.
    Alarm,
    /// A replay, or simulated time: not the present.
    Replay,
}

/// What stands at the top of the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenState {
    /// One or two words, to be read from two metres.
    pub word: String,
    /// What else is to be known of it.
    pub detail: String,
    /// Its colour and shape.
    pub tone: Tone,
    /// Whether images may be followed: sight and digits are shown only then.
    pub follows: bool,
    /// From the capture of the oldest pose shown until now, ms; of images that may be followed only.
    pub age_ms: Option<f64>,
    /// When the oldest pose shown was captured, ns on the session's clock.
    pub oldest_ns: Option<i64>,
    /// Whether all views show one pose, in words; empty where there is nothing to say.
    pub set: String,
    /// Whether the views show different poses.
    pub is_mixed: bool,
    /// A pose is held: what is shown stands still until somebody follows again.
    pub is_held: bool,
    /// A recording is shown: it can be steered.
    pub is_replay: bool,
    /// What has to stand on the screen besides: RESEARCH, NOT CHECKED, HELD.
    pub marks: Vec<&'static str>,
}

/// The state of what is known.
pub fn state(known: &Known<'_>) -> ScreenState {
    let (set, is_mixed) = set_words(known.set);
    let oldest_ns = known
        .headers
        .iter()
        .flatten()
        .map(|header| header.stamp.t_capture_ns)
        .min();
    let (tone, word, detail) = judged(known);
    let follows = matches!(tone, Tone::Live | Tone::Quiet | Tone::Replay);
    let age = oldest_ns.map(|oldest| clock::ms(known.now_ns.saturating_sub(oldest)));
    ScreenState {
        word,
        detail,
        tone,
        follows,
        age_ms: age.filter(|_| follows),
        oldest_ns,
        set,
        is_mixed,
        is_held: held(known).is_some(),
        is_replay: known.is_replay,
        marks: marks(known),
    }
}

/// The worst that can be said: what comes first outweighs what follows.
fn judged(known: &Known<'_>) -> (Tone, String, String) {
    let says = |tone, word: &str, detail: &str| (tone, word.to_owned(), detail.to_owned());
    let missing = known.headers.iter().filter(|header| header.is_none()).count();
    if missing == known.headers.len() {
        let why = match held(known) {
            Some(_) => "no view has sent an image of the pose that is held",
            None => "no view has sent an image yet",
        };
        return says(Tone::Alarm, "NO IMAGES", why);
    }
    if known.volume.is_none() {
        return says(Tone::Alarm, "NO EXAMINATION", "what the images are of cannot be told");
    }
    if let Some(why) = foreign(known) {
        return says(Tone::Alarm, "WRONG IMAGES", why);
    }
    let states = || {
        known
            .headers
            .iter()
            .flatten()
            .map(|h| h.stamp.state_at(known.now_ns, known.ages()))
    };
    if known
        .headers
        .iter()
        .flatten()
        .any(|header| header.stamp.t_capture_ns.saturating_sub(known.now_ns) > AHEAD_NS)
    {
        return says(
            Tone::Alarm,
            "WRONG IMAGES",
            "captured in the future: a clock stands still or went back",
        );
    }
    if states().any(|state| state.is_none()) {
        return says(
            Tone::Alarm,
            "WRONG IMAGES",
            "an image of a kind that this window does not know",
        );
    }
    if let Some(FrameState::Lost(reason)) = states().flatten().find(|state| matches!(state, FrameState::Lost(_))) {
        let still = known.standing_still();
        if still > 0 {
            let views = known.headers.len();
            return says(
                Tone::Alarm,
                "NO IMAGES",
                &format!("{still} of {views} views stand still"),
            );
        }
        return says(Tone::Alarm, "NO POSE", reason.words());
    }
    if missing > 0 {
        return (
            Tone::Alarm,
            "NO IMAGES".to_owned(),
            format!("of {missing} of {} views", known.headers.len()),
        );
    }
    let of_the_workflow = of_the_workflow(known.workflow);
    // A marker that was pushed outweighs whatever is old or held.
    if of_the_workflow.0 == Tone::Alarm && !is_not_now(known) {
        return of_the_workflow;
    }
    if states().flatten().any(|state| state == FrameState::Stale) {
        let oldest = known.headers.iter().flatten().map(|h| h.stamp.t_capture_ns).min();
        let age = known.now_ns.saturating_sub(oldest.unwrap_or(known.now_ns));
        return (Tone::Warning, "OLD".to_owned(), format!("pose {} old", age_words(age)));
    }
    // Anything else than live has no place among images that follow the tool, whoever sent it.
    let is_other = |state: FrameState| state != FrameState::Live;
    if held(known).is_none() && states().flatten().any(is_other) {
        return says(
            Tone::Alarm,
            "WRONG IMAGES",
            "images that were asked for among those that follow the tool",
        );
    }
    if let Some(held) = held(known) {
        let age = age_words(known.now_ns.saturating_sub(held.t_capture_ns));
        let when = if is_not_now(known) { ", not the present" } else { "" };
        return (Tone::Warning, "HELD".to_owned(), format!("pose {age} old{when}"));
    }
    if is_not_now(known) {
        let word = if known.is_simulated { "SIMULATED TIME" } else { "REPLAY" };
        return says(Tone::Replay, word, other_recording(known).unwrap_or("not the present"));
    }
    of_the_workflow
}

/// The pose that is held.
fn held(known: &Known<'_>) -> Option<PoseId> {
    known.guide.and_then(|guide| guide.held())
}

/// Why a replay's tube and anatomy do not belong together: poses of one examination over images of another, or of one that is not known.
pub(super) fn other_recording(known: &Known<'_>) -> Option<&'static str> {
    match (known.recorded_in?, known.volume) {
        (Recorded::In(recorded), Some(shown)) if recorded == shown.to_string() => None,
        (Recorded::In(_), None) => None,
        (Recorded::In(_), Some(_)) => Some("not the examination of the recording"),
        (Recorded::Unknown, _) => Some("the recording does not say in which examination it was made"),
    }
}

/// Whether what moves is not the present. Whoever replays or simulates may have been started after this window: images say it too.
fn is_not_now(known: &Known<'_>) -> bool {
    known.is_replay || known.is_simulated || known.headers.iter().flatten().any(|header| header.stamp.replay != 0)
}

/// Why the images do not belong to this run, or to one another.
fn foreign(known: &Known<'_>) -> Option<&'static str> {
    let mut hashes = known.headers.iter().flatten().map(|header| header.stamp.volume_hash);
    let first = hashes.next()?;
    if hashes.any(|hash| hash != first) {
        return Some("views show different examinations");
    }
    let is_other = known.volume.is_some_and(|volume| volume.0 != first);
    if is_other {
        return Some("images of another examination than the run's");
    }
    let mut registrations = known
        .headers
        .iter()
        .flatten()
        .map(|header| header.stamp.registration_id);
    let first = registrations.next()?;
    // A new registration comes to one view after another: as long as they show different poses, that is the mark's to say.
    let differ = registrations.any(|id| id != first) && matches!(known.set, Some(Set::One(_)));
    differ.then_some("views rest on different registrations")
}

fn of_the_workflow(workflow: Option<Workflow>) -> (Tone, String, String) {
    let Some((workflow, stage)) = workflow.and_then(|workflow| Some((workflow, workflow.stage()?))) else {
        return (
            Tone::Quiet,
            "LIVE".to_owned(),
            "how far the run has come is not known".to_owned(),
        );
    };
    if workflow.has(Workflow::BUMPED) {
        return (
            Tone::Alarm,
            "REFERENCE MOVED".to_owned(),
            "check the registration, or register again".to_owned(),
        );
    }
    if workflow.has(Workflow::CHECK_FAILED) {
        return (Tone::Alarm, "CHECK FAILED".to_owned(), "register again".to_owned());
    }
    if !workflow.has(Workflow::IMAGES) {
        let detail = "images may not be followed yet".to_owned();
        return (Tone::Warning, stage.word().to_owned(), detail);
    }
    match stage {
        Stage::Navigating => (Tone::Live, "NAVIGATING".to_owned(), String::new()),
        stage => (
            Tone::Quiet,
            stage.word().to_owned(),
            "the navigation has not started".to_owned(),
        ),
    }
}

fn set_words(set: Option<Set>) -> (String, bool) {
    match set {
        None => (String::new(), false),
        Some(Set::One(_)) => ("one pose".to_owned(), false),
        Some(Set::Mixed { poses, missing: 0 }) => {
            let plural = if poses == 1 { "" } else { "S" };
            (format!("VIEWS DIFFER {poses} POSE{plural}"), true)
        }
        Some(Set::Mixed { missing, .. }) => (format!("{missing} VIEWS MISSING"), true),
    }
}

fn marks(known: &Known<'_>) -> Vec<&'static str> {
    let mut marks = Vec::new();
    let Some(workflow) = known.workflow else { return marks };
    if workflow.has(Workflow::RESEARCH) {
        marks.push("RESEARCH");
    }
    marks.extend(workflow.marks().iter().map(|mark| mark.word()));
    marks
}

/// An age as it stands on images.
pub(super) fn age_words(age_ns: i64) -> String {
    match clock::ms(age_ns) {
        ms if ms < 1000.0 => format!("{ms:.0} ms"),
        ms => format!("{:.1} s", ms / 1000.0),
    }
}
