//! What everything on the screen rests on, in words: whose examination, which registration, how good, recorded or not.

use bus::message::{
    Heartbeat, Identity, IdentitySource, NOT_RECORDING, ProcessState, RECORDED_ANEW, Tracked, Workflow,
};

use super::{Known, ScreenState, Tone};

/// Words of the top of the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Whose examination it is.
    pub identity: String,
    /// Whether that is to be taken as a warning.
    pub identity_tone: Tone,
    /// The patient's birth date and number, and the examination.
    pub volume: String,
    /// The registration and the error that it leads to.
    pub registration: String,
    /// Whether the session is recorded.
    pub recording: String,
    /// Whether that is a warning.
    pub recording_tone: Tone,
    /// Whether nobody reads this screen back: a window that froze would not be covered.
    pub is_unwatched: bool,
}

/// What is known, in words.
pub fn facts(known: &Known<'_>, state: &ScreenState) -> Facts {
    let (identity, identity_tone) = identity(known);
    let (recording, recording_tone) = recording(known);
    Facts {
        identity,
        identity_tone,
        volume: patient(known) + &volume(known),
        registration: registration(known, state.follows),
        recording,
        recording_tone,
        is_unwatched: known.watched_ns.is_none_or(|age_ns| age_ns > UNWATCHED_NS),
    }
}

fn identity(known: &Known<'_>) -> (String, Tone) {
    let Some(identity) = of_this_volume(known) else {
        return ("PATIENT NOT KNOWN".to_owned(), Tone::Warning);
    };
    if known.workflow.is_some_and(|workflow| workflow.has(Workflow::REJECTED)) {
        return ("NOT THIS PATIENT'S EXAMINATION".to_owned(), Tone::Alarm);
    }
    let [name, ..] = identity.words();
    match identity.source() {
        IdentitySource::Phantom => ("PHANTOM".to_owned(), Tone::Quiet),
        IdentitySource::Unknown => ("PATIENT NOT KNOWN".to_owned(), Tone::Warning),
        IdentitySource::Examination | IdentitySource::Scene => {
            // Spaces, or the signs between the parts of a name that has none, would be the same for every patient.
            match name.chars().any(char::is_alphanumeric) {
                true => (name, Tone::Quiet),
                false => ("NO NAME".to_owned(), Tone::Warning),
            }
        }
    }
}

/// Birth date and number: apart from the name, which may be so long that it ends in an ellipsis.
fn patient(known: &Known<'_>) -> String {
    let Some(identity) = of_this_volume(known) else {
        return String::new();
    };
    let [_, patient_id, birth_date, ..] = identity.words();
    let labelled = [("*", birth_date), ("ID ", patient_id)];
    let said = labelled.into_iter().filter(|(_, text)| !text.is_empty());
    said.map(|(label, text)| format!("{label}{text}  ")).collect()
}

/// The identity of the run's examination; that of another is none.
fn of_this_volume(known: &Known<'_>) -> Option<Identity> {
    known
        .identity
        .filter(|identity| known.volume == Some(identity.volume()))
}

fn volume(known: &Known<'_>) -> String {
    let hash = known.volume.map(|hash| hash.to_string()[..8].to_owned());
    let date = of_this_volume(known).map(|identity| identity.words()[3].clone());
    let date = date.filter(|date| !date.is_empty());
    match (hash, date) {
        (None, _) => "no examination".to_owned(),
        (Some(hash), None) => format!("CT {hash}"),
        (Some(hash), Some(date)) => format!("CT {date} {hash}"),
    }
}

/// Of the pose that the sight is of: its registration, the residual of its marker and the error predicted at the tip.
fn registration(known: &Known<'_>, follows: bool) -> String {
    let Some(pose) = known.sighted().and_then(|header| known.pose_of(&header)) else {
        return "no pose".to_owned();
    };
    let id = format!("reg {:08x}", pose.registration_id >> 32);
    let checked = checked(known);
    // Where nothing is to be followed, nothing is said of its error.
    if !follows || !matches!(pose.tracked(), Ok(Tracked::Valid(_))) {
        return id + &checked;
    }
    let error = match pose.tip_95_mm() {
        // `0.0 mm` would say that there is none.
        Some(mm) if mm < 0.05 => "tip 95 % < 0.1 mm".to_owned(),
        Some(mm) => format!("tip 95 % {mm:.1} mm"),
        None => "tip error not known".to_owned(),
    };
    format!("{id}  {error}{checked}")
}

/// The worst distance of the last check of the registration in use, and its age; and whether it holds.
fn checked(known: &Known<'_>) -> String {
    let Some(workflow) = known.workflow.filter(|workflow| workflow.check_points > 0) else {
        return String::new();
    };
    let age_min = known.now_ns.saturating_sub(workflow.check_t_ns) / 60_000_000_000;
    let word = match (
        workflow.has(Workflow::CHECK_FAILED),
        workflow.has(Workflow::NOT_CHECKED),
    ) {
        (true, _) => "CHECK FAILED",
        (false, true) => "old check",
        (false, false) => "check",
    };
    format!("  {word} {:.1} mm {age_min} min", workflow.check_worst_mm)
}

/// The watcher says ten times a second what it read. This is three times what its successor takes to start.
const UNWATCHED_NS: i64 = 1_500_000_000;

/// The recorder gives a sign of life ten times a second.
const SILENT_NS: i64 = 2_000_000_000;

/// REC says that everything so far is on its way to a file: a recorder that starts, cannot write, has lost something, came after one
/// that died, or is silent never has it.
fn recording(known: &Known<'_>) -> (String, Tone) {
    let Some((beat, age_ns)) = known.recorder else {
        return ("NOT RECORDED".to_owned(), Tone::Quiet);
    };
    let Some(beat) = beat.filter(|_| age_ns <= SILENT_NS) else {
        return ("RECORDER SILENT".to_owned(), Tone::Warning);
    };
    if is_refused(&beat) {
        return (NOT_RECORDING.to_owned(), Tone::Alarm);
    }
    if beat.counters.lost > 0 {
        return (format!("REC HAS GAPS: {} lost", beat.counters.lost), Tone::Warning);
    }
    if beat.note_text().contains(RECORDED_ANEW) {
        return ("REC HAS GAPS".to_owned(), Tone::Warning);
    }
    match beat.process_state() {
        ProcessState::Ready => ("REC".to_owned() + &since(known), Tone::Live),
        ProcessState::Starting => ("NOT RECORDING YET".to_owned(), Tone::Warning),
        ProcessState::Stopping => ("RECORDING ENDS".to_owned(), Tone::Warning),
    }
}

fn is_refused(beat: &Heartbeat) -> bool {
    beat.note_text().starts_with(NOT_RECORDING)
}

fn since(known: &Known<'_>) -> String {
    let Some(began) = known.began_ns else {
        return String::new();
    };
    let s = known.now_ns.saturating_sub(began).max(0) / 1_000_000_000;
    format!(" {:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
}
