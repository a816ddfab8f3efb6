//! The band at the top of the planning screen: whose examination, whether it can be planned in, who reads the screen back.

use bus::message::{Heartbeat, Identity, Plan as Told, VolumeHash, Workflow};
use guidance::plan::{Concern, Plan};
use scene::Scene;

use crate::model::{Facts, Known, Model, ScreenState, Tone, facts};

/// What has come over the bus.
#[derive(Default)]
pub(crate) struct Heard {
    /// The plan, as it was told and as it is.
    pub(crate) plan: Option<(Told, Plan)>,
    pub(crate) identity: Option<Identity>,
    pub(crate) workflow: Option<Workflow>,
    pub(crate) watcher: Option<Heartbeat>,
    /// What speaks against the plan.
    pub(crate) concerns: Vec<Concern>,
}

/// The band, in a run with the examination `volume`, at `now_ns` on the run's clock.
pub(crate) fn model(scene: &Scene, now_ns: i64, volume: Option<VolumeHash>, heard: &Heard) -> Model {
    let known = Known {
        steps: None,
        scene,
        now_ns,
        headers: &[],
        set: None,
        poses: &[],
        guide: None,
        workflow: heard.workflow,
        identity: heard.identity,
        volume,
        recorder: None,
        may_restart_localizer: false,
        watched_ns: heard.watcher.map(|beat| now_ns.saturating_sub(beat.t_painted_ns)),
        is_replay: false,
        law: None,
        timeline: None,
        recorded_in: None,
        is_simulated: false,
        began_ns: None,
    };
    let told = heard.plan.as_ref();
    let is_changed = told.is_some_and(|(told, _)| told.flags & Told::CHANGED_ELSEWHERE != 0);
    let state = state(volume, told.map(|(_, plan)| plan), is_changed);
    Model {
        replay: None,
        steps: None,
        cells: Vec::new(),
        organs: None,
        sight: Err(String::new()),
        facts: Facts {
            registration: String::new(),
            recording: String::new(),
            recording_tone: Tone::Quiet,
            ..facts(&known, &state)
        },
        are_images_changed: false,
        may_restart_localizer: false,
        state,
    }
}

fn state(volume: Option<VolumeHash>, plan: Option<&Plan>, is_changed: bool) -> ScreenState {
    let (tone, word, detail) = match (volume, plan) {
        (None, _) => (Tone::Warning, "NO EXAMINATION", "it is being read".to_owned()),
        (_, None) => (Tone::Warning, "NO PLAN", "it has not been told yet".to_owned()),
        (Some(hash), Some(plan)) if plan.volume.0 != hash.0 => {
            (Tone::Alarm, "WRONG PLAN", "it is of another examination".to_owned())
        }
        // Nothing that is changed here is written any more.
        (_, Some(_)) if is_changed => (
            Tone::Alarm,
            "PLAN CHANGED ELSEWHERE",
            "somebody else changed its file: close this and open the plan again".to_owned(),
        ),
        (_, Some(plan)) => match &plan.confirmed {
            Some(confirmed) => (Tone::Quiet, "CONFIRMED PLAN", format!("by {}", confirmed.by)),
            None => (Tone::Quiet, "PLANNING", "images follow no tool".to_owned()),
        },
    };
    ScreenState {
        word: word.to_owned(),
        detail,
        tone,
        follows: false,
        age_ms: None,
        oldest_ns: None,
        set: String::new(),
        is_mixed: false,
        is_held: false,
        is_replay: false,
        marks: Vec::new(),
    }
}
