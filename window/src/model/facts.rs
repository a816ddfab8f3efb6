//! What everything on the screen rests on, in words: whose examination, which registration, how good, recorded or not.

use bus::message::{IdentitySource, Tracked, Workflow};

use super::{Known, ScreenState, Tone};

/// Words of the top of the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Whose examination it is.
    pub identity: String,
    /// Whether that is to be taken as a warning.
    pub identity_tone: Tone,
    /// The examination.
    pub volume: String,
    /// The registration and the error that it leads to.
    pub registration: String,
    /// Whether the session is recorded.
    pub recording: String,
    /// Whether that is a warning.
    pub recording_tone: Tone,
}

/// What is known, in words.
pub fn facts(known: &Known<'_>, state: &ScreenState) -> Facts {
    let (identity, identity_tone) = identity(known);
    let (recording, recording_tone) = recording(known);
    Facts {
        identity,
        identity_tone,
        volume: volume(known),
        registration: registration(known, state.follows),
        recording,
        recording_tone,
    }
}

fn identity(known: &Known<'_>) -> (String, Tone) {
    let of_this = known
        .identity
        .filter(|identity| known.volume.is_none_or(|volume| volume == identity.volume()));
    let Some(identity) = of_this else {
        return ("PATIENT NOT KNOWN".to_owned(), Tone::Warning);
    };
    if known.workflow.is_some_and(|workflow| workflow.has(Workflow::REJECTED)) {
        return ("NOT THIS PATIENT'S EXAMINATION".to_owned(), Tone::Alarm);
    }
    let [name, patient_id, birth_date, ..] = identity.words();
    match identity.source() {
        IdentitySource::Phantom => ("PHANTOM".to_owned(), Tone::Quiet),
        IdentitySource::Unknown => ("PATIENT NOT KNOWN".to_owned(), Tone::Warning),
        IdentitySource::Examination | IdentitySource::Scene => {
            let labelled = |label: &str, text: &str| match text.is_empty() {
                true => String::new(),
                false => format!("  {label}{text}"),
            };
            let name = if name.is_empty() { "NO NAME" } else { &name };
            let words = format!("{name}{}{}", labelled("*", &birth_date), labelled("ID ", &patient_id));
            (words, Tone::Quiet)
        }
    }
}

fn volume(known: &Known<'_>) -> String {
    let hash = known.volume.map(|hash| hash.to_string()[..8].to_owned());
    let date = known
        .identity
        .map(|identity| identity.words()[3].clone())
        .filter(|date| !date.is_empty());
    match (hash, date) {
        (None, _) => "no examination".to_owned(),
        (Some(hash), None) => format!("CT {hash}"),
        (Some(hash), Some(date)) => format!("CT {date} {hash}"),
    }
}

/// Of the newest pose: its registration, the residual of its marker and the error predicted at the tip.
fn registration(known: &Known<'_>, follows: bool) -> String {
    let Some(pose) = known.poses.last() else {
        return "no pose yet".to_owned();
    };
    let id = format!("reg {:08x}", pose.registration_id >> 32);
    // Where nothing is to be followed, nothing is said of its error.
    if !follows || !matches!(pose.tracked(), Ok(Tracked::Valid(_))) {
        return id;
    }
    let error = match pose.tip_95_mm() {
        // `0.0 mm` would say that there is none.
        Some(mm) if mm < 0.05 => "tip 95 % < 0.1 mm".to_owned(),
        Some(mm) => format!("tip 95 % {mm:.1} mm"),
        None => "tip error not known".to_owned(),
    };
    format!("{id}  {error}")
}

fn recording(known: &Known<'_>) -> (String, Tone) {
    /// The recorder gives a sign of life ten times a second.
    const SILENT_NS: i64 = 2_000_000_000;
    match known.recorder {
        None => ("NOT RECORDED".to_owned(), Tone::Quiet),
        Some((Some(beat), age_ns)) if age_ns <= SILENT_NS && beat.counters.lost == 0 => {
            ("REC".to_owned() + &since(known), Tone::Live)
        }
        Some((Some(beat), age_ns)) if age_ns <= SILENT_NS => {
            (format!("REC HAS GAPS: {} lost", beat.counters.lost), Tone::Warning)
        }
        Some(_) => ("RECORDER SILENT".to_owned(), Tone::Warning),
    }
}

fn since(known: &Known<'_>) -> String {
    let Some(began) = known.began_ns else {
        return String::new();
    };
    let s = known.now_ns.saturating_sub(began).max(0) / 1_000_000_000;
    format!(" {:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
}
