//! What the run's own report (`report.json`, attached at its end) says, against what the recording holds.

use std::collections::BTreeMap;

use bus::message::TissueState;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::organs::Organs;

/// The name of the attached file.
pub(super) const REPORT: &str = "report.json";

/// The keys that are held against the recording; a report of another version may lack some.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Report {
    trocar_version: Option<String>,
    simulated_time: bool,
    seed: Option<u64>,
    volume: Option<Volume>,
    replay: Option<IgnoredAny>,
    poses: Option<Poses>,
    views: Vec<IgnoredAny>,
    tissue: Option<Tissue>,
    restarts: Vec<IgnoredAny>,
    recording: Vec<IgnoredAny>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Volume {
    hash: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Poses {
    published: u64,
}

/// First images of poses by what they showed, and of those refused by the model's words.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Tissue {
    images: BTreeMap<String, u64>,
    refused_because: BTreeMap<String, u64>,
}

/// What a recording holds that a report speaks of.
#[derive(Debug, Default)]
pub(super) struct Held<'a> {
    /// The examination, by the record of the run.
    pub(super) volume_hash: Option<&'a str>,
    /// The scene's seed.
    pub(super) seed: Option<u64>,
    /// Messages of `/tool_pose`.
    pub(super) poses: u64,
    /// Whether it holds all that was recorded: nothing is damaged, and it was cut out of no other.
    pub(super) is_whole: bool,
}

/// What the report in these bytes says and the recording denies, in words; nothing of what is no report of a run.
pub(super) fn denied(report: &[u8], held: &Held<'_>, organs: &Organs) -> Vec<String> {
    let Ok(report) = serde_json::from_slice::<Report>(report) else {
        return Vec::new();
    };
    // A replay's report is of another run than the one recorded.
    if report.trocar_version.is_none() || report.replay.is_some() {
        return Vec::new();
    }
    let mut words = ids(&report, held);
    // What several recordings hold together, or was lost with a process, is not counted here.
    if held.is_whole && report.recording.len() == 1 && report.restarts.is_empty() {
        words.extend(counts(&report, held, organs));
    }
    words
}

fn ids(report: &Report, held: &Held<'_>) -> Vec<String> {
    let mut words = Vec::new();
    let stated = report.volume.as_ref().map(|volume| volume.hash.as_str());
    if let (Some(stated), Some(found)) = (stated, held.volume_hash)
        && stated != found
    {
        let stated: String = stated.chars().take(64).collect();
        words.push(format!(
            "{REPORT} is of examination {stated}, and the recording of {found}"
        ));
    }
    if let (Some(stated), Some(found)) = (report.seed, held.seed)
        && stated != found
    {
        words.push(format!("{REPORT} says seed {stated}, and the recorded scene {found}"));
    }
    words
}

fn counts(report: &Report, held: &Held<'_>, organs: &Organs) -> Vec<String> {
    let mut words = Vec::new();
    // In simulated time the run waits for whoever records.
    if let Some(poses) = report.poses.as_ref().filter(|_| report.simulated_time)
        && poses.published != held.poses
    {
        words.push(format!(
            "{REPORT} counts {} poses, and the recording holds {}",
            poses.published, held.poses
        ));
    }
    let Some(tissue) = &report.tissue else { return words };
    // Each view has one first image of a pose, by the one state of that pose.
    // What cannot be drawn of a good state is shown as refused, so that those are not held against states.
    for state in [TissueState::Settled, TissueState::Approximate, TissueState::CatchingUp] {
        let images = tissue.images.get(state.word()).copied().unwrap_or(0);
        let Some(states) = organs.count(state) else { continue };
        if images > states.saturating_mul(report.views.len() as u64) {
            words.push(format!(
                "{REPORT} counts {images} first images of organs that are {}, and the recording holds {states} such states for {} views",
                state.word(),
                report.views.len()
            ));
        }
    }
    let refused = tissue.images.get(TissueState::Refused.word()).copied().unwrap_or(0);
    let because = tissue
        .refused_because
        .values()
        .fold(0_u64, |sum, n| sum.saturating_add(*n));
    if refused != because {
        words.push(format!(
            "{REPORT} counts {refused} first images of organs that are refused, and reasons for {because}"
        ));
    }
    words
}
