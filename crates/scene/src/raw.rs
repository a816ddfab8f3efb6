//! The scene file as it is written: every key known, every type right, nothing else checked.

mod rigid;
mod view;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::{Invalid, SceneError};
use super::gateway::RawGateway;
use super::guide::RawGuide;
use super::identity::{self, RawIdentity};
use super::localizer::RawLocalizer;
use super::locate;
use super::operating_room::RawRoom;
use super::pacs::RawPacs;
use super::plan::RawPlan;
use super::priorities::Priorities;
use super::recording::RawRecording;
use super::sampling::Render;
use super::steps::RawSteps;
use super::tissue::RawTissue;
use super::tracking::raw::{
    RawCalibrationFile, RawEmitterSource, RawMarkerSource, RawRegistrationFile, RawSequence, RawSmoothing,
};
use super::volume::{GENERATED, RawVolume};
use super::workflow::RawWorkflow;
use crate::file::{self, OpenError};

pub use rigid::RawRigid;
pub use view::{Drawn, Extent, Plane, RawAngles, RawFrom, RawLevels, RawSurface, RawView, RawWindow, Up};

/// Scene files are short; a longer one is not a scene.
const MAX_BYTES: u64 = 1 << 20;

/// A raw scene with the text it came from, for errors that point at a line.
#[derive(Debug, Clone)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Its content.
    pub scene: RawScene,
}

/// The whole file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawScene {
    /// Seeds everything that is drawn by chance.
    pub seed: u64,
    /// `[volume]`
    pub volume: RawVolume,
    /// `[identity]`; absent: what the examination says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identity: Option<RawIdentity>,
    /// `[tool]`
    pub tool: RawTool,
    /// `[tracker]`
    pub tracker: RawTracker,
    /// `[localizer]`; absent: none is dialled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localizer: Option<RawLocalizer>,
    /// `[render]`
    pub render: Render,
    /// `[recording]`; absent: nothing is recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<RawRecording>,
    /// `[gateway]`; absent: no other program is served.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gateway: Option<RawGateway>,
    /// `[tissue]`; absent: organs are shown where the examination has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<RawTissue>,
    /// `[pacs]`; absent: nobody is named who sends examinations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pacs: Option<RawPacs>,
    /// `[limits]`
    pub limits: RawLimits,
    /// `[priorities]`
    pub priorities: Priorities,
    /// `[guide]`
    pub guide: RawGuide,
    /// `[workflow]`
    pub workflow: RawWorkflow,
    /// `[steps]`; absent: nothing is calibrated, registered and checked while the run goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<RawSteps>,
    /// `[plan]`; absent: the run follows none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<RawPlan>,
    /// `[[targets]]`; absent: those of the generated patient, or none for a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub targets: Option<Vec<RawTarget>>,
    /// `[[views]]`; absent: the seven images of the thesis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<Vec<RawView>>,
}

/// `[tool]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawTool {
    /// For people.
    pub name: String,
    /// From the handle to the tip, mm.
    pub length_mm: f64,
    /// Outer diameter, mm.
    pub diameter_mm: f64,
}

impl Default for RawTool {
    fn default() -> Self {
        Self {
            name: "mediastinoscope".to_owned(),
            length_mm: 180.0,
            diameter_mm: 12.0,
        }
    }
}

/// `[tracker]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawTracker {
    /// Who publishes poses.
    pub source: RawTrackerSource,
    /// Samples a second.
    pub rate_hz: f64,
    /// Standard deviation of the measured tip along each axis, mm.
    pub noise_mm: f64,
    /// Standard deviation of the measured rotation about each axis, degrees.
    pub noise_deg: f64,
    /// Chance that a sample starts a dropout.
    pub dropout: f64,
    /// Samples a dropout lasts.
    pub dropout_samples: u32,
    /// `[tracker.approach]`
    pub approach: RawApproach,
    /// `[tracker.ct_from_tracker]`
    pub ct_from_tracker: RawRigid,
    /// `[tracker.room]`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub room: Option<RawRoom>,
    /// `[tracker.emitters]`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emitters: Option<RawEmitterSource>,
    /// `[tracker.markers]`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub markers: Option<RawMarkerSource>,
    /// `[tracker.sequence]`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<RawSequence>,
    /// `[tracker.calibration]`; absent: the scene's own numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<RawCalibrationFile>,
    /// `[tracker.registration]`; absent: the scene's own numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration: Option<RawRegistrationFile>,
    /// `[tracker.smoothing]`; absent: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<RawSmoothing>,
}

impl Default for RawTracker {
    fn default() -> Self {
        Self {
            source: RawTrackerSource::Simulated,
            rate_hz: 60.0,
            noise_mm: 0.1,
            noise_deg: 0.02,
            dropout: 0.0,
            dropout_samples: 6,
            approach: RawApproach::default(),
            ct_from_tracker: RawRigid::default(),
            room: None,
            emitters: None,
            markers: None,
            sequence: None,
            calibration: None,
            registration: None,
            smoothing: None,
        }
    }
}

/// Who publishes poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RawTrackerSource {
    /// The tracker process, which makes up poses.
    Simulated,
    /// The tracker process, which simulates an operating room.
    OperatingRoom,
    /// The tracker process, of what another program's localizer sees.
    Emitters,
    /// The tracker process, of the poses of markers that a localizer delivers.
    Markers,
    /// The tracker process, of poses from a file.
    Sequence,
    /// Another program.
    External,
}

/// `[tracker.approach]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawApproach {
    /// Name of a target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// Where the tube goes through the skin, LPS mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entry_ct_mm: Option<[f64; 3]>,
    /// How far short of the target the tip stops, mm.
    pub stop_short_mm: f64,
    /// Duration of the insertion and of the withdrawal, s.
    pub insert_s: f64,
    /// Rest at the target, s.
    pub pause_s: f64,
    /// Duration of the sweep, s.
    pub sweep_s: f64,
    /// Half opening of the sweep's cone, degrees.
    pub sweep_deg: f64,
}

impl Default for RawApproach {
    fn default() -> Self {
        Self {
            target: None,
            entry_ct_mm: None,
            stop_short_mm: 5.0,
            insert_s: 4.0,
            pause_s: 2.0,
            sweep_s: 4.0,
            sweep_deg: 6.0,
        }
    }
}

/// `[[targets]]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTarget {
    /// For people.
    pub name: String,
    /// Its centre, LPS mm.
    pub ct_mm: [f64; 3],
    /// Its diameter, mm.
    #[serde(default = "default_target_diameter")]
    pub diameter_mm: f64,
    /// Where the tube is to enter on its way there, LPS mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry_ct_mm: Option<[f64; 3]>,
    /// How far before its centre the tip is to stop, mm.
    #[serde(default)]
    pub stop_mm: f64,
}

fn default_target_diameter() -> f64 {
    5.0
}

/// `[limits]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawLimits {
    /// An image whose pose is older than this says so.
    pub stale_ms: f64,
    /// A pose that is older than this is none: nothing is shown of it but the dimmed slice. Absent: 1000, or twice
    /// `stale_ms` where that is more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_ms: Option<f64>,
    /// The same numbers under fresh stamps for longer than this are no measurement.
    pub frozen_ms: f64,
    /// A process without a sign of life for this long is restarted.
    pub silent_s: f64,
    /// A process that is not ready after this long is restarted.
    pub start_s: f64,
    /// Restarts of one process within `restart_window_s` before it is held.
    pub restarts: u32,
    /// See `restarts`.
    pub restart_window_s: f64,
    /// How long processes may take to end when asked.
    pub stop_s: f64,
    /// More of a run's samples missing than this share is a problem.
    pub max_missing_share: f64,
    /// Images later than this behind the capture of their pose, at the 99th percentile, are a problem; 0: they are not. Absent:
    /// as `stale_ms`, as one image in a hundred was then old before it was ever seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_p99_ms: Option<f64>,
}

impl Default for RawLimits {
    fn default() -> Self {
        Self {
            stale_ms: 100.0,
            lost_ms: None,
            frozen_ms: 500.0,
            silent_s: 2.0,
            start_s: 120.0,
            restarts: 5,
            restart_window_s: 30.0,
            stop_s: 3.0,
            max_missing_share: 0.01,
            latency_p99_ms: None,
        }
    }
}

/// Reads a scene file.
///
/// # Errors
/// [`SceneError::Io`], also where it is a pipe or a device; [`SceneError::TooLong`], [`SceneError::Syntax`].
pub fn load(path: &Path) -> Result<Source, SceneError> {
    let text = file::read_text(path, MAX_BYTES).map_err(|error| match error {
        OpenError::TooLong { found, most } => SceneError::TooLong {
            path: path.to_owned(),
            bytes: found,
            allowed: most,
        },
        error => SceneError::Io {
            path: path.to_owned(),
            source: error.into(),
        },
    })?;
    parse(&text, path)
}

/// Reads the text of a scene.
///
/// # Errors
/// [`SceneError::Syntax`].
pub fn parse(text: &str, path: &Path) -> Result<Source, SceneError> {
    parse_beside(text, path, path)
}

/// Reads the text of the scene that is attached to a recording. Errors name the file within the file; relative paths in it mean relative to
/// the recording.
///
/// # Errors
/// [`SceneError::Syntax`].
pub fn parse_attached(text: &str, recording: &Path) -> Result<Source, SceneError> {
    parse_beside(text, &recording.join("scene.toml"), recording)
}

/// Reads the text of the scene `path`, whose relative paths mean relative to `file`.
fn parse_beside(text: &str, path: &Path, file: &Path) -> Result<Source, SceneError> {
    let mut scene: RawScene = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let (line, column) = locate::line_and_column(text, at);
        let key = locate::key_at(text, at);
        SceneError::Syntax {
            path: path.to_owned(),
            line,
            column,
            why: told(key.as_deref(), error.message()),
            key,
        }
    })?;
    if scene.volume.source != GENERATED {
        anchor(&mut scene.volume.source, file);
    }
    let tracker = &mut scene.tracker;
    let plan = scene
        .plan
        .as_mut()
        .map(|plan| [plan.file.as_mut(), plan.labels.as_mut()]);
    let room = tracker.room.as_mut();
    let (gesture, probe) = room.map(|room| (room.gesture.as_mut(), room.probe.as_mut())).unzip();
    let tank = probe.flatten().and_then(|probe| probe.tank.as_mut());
    let files = [
        gesture.flatten().map(|gesture| &mut gesture.file),
        tank.map(|tank| &mut tank.file),
        tracker.sequence.as_mut().map(|sequence| &mut sequence.file),
        tracker.calibration.as_mut().map(|link| &mut link.file),
        tracker.registration.as_mut().map(|link| &mut link.file),
    ];
    let steps = scene
        .steps
        .as_mut()
        .map(|steps| [steps.drawing.as_mut(), steps.beads.as_mut()]);
    let files = files
        .into_iter()
        .chain(plan.into_iter().flatten())
        .chain([scene.tissue.as_mut().and_then(|tissue| tissue.organs.as_mut())])
        .chain(steps.into_iter().flatten());
    let roms = scene
        .localizer
        .iter_mut()
        .flat_map(|localizer| localizer.tools.iter_mut());
    let roms = roms.map(|tool| &mut tool.rom);
    files.flatten().chain(roms).for_each(|named| anchor(named, file));
    Ok(Source {
        path: path.to_owned(),
        text: text.to_owned(),
        scene,
    })
}

/// What is wrong in the words of the reader, which quote the file; but for whose examination it is.
fn told(key: Option<&str>, why: &str) -> String {
    let is_of = |key: &str| key.split('.').next() == Some(identity::TABLE);
    match key.is_some_and(is_of) {
        true => "allowed: text in quotes for name, patient_id, birth_date, study_date and description".to_owned(),
        false => why.to_owned(),
    }
}

/// A relative path in a scene file means relative to that file.
fn anchor(source: &mut String, scene: &Path) {
    if Path::new(source.as_str()).is_absolute() {
        return;
    }
    if let Some(folder) = scene.parent() {
        *source = folder.join(source.as_str()).to_string_lossy().into_owned();
    }
}

impl Source {
    /// The scene as TOML, with every default written out.
    pub fn to_toml(&self) -> String {
        toml::to_string(&self.scene).unwrap_or_default()
    }

    pub(super) fn error_at(&self, invalid: Invalid) -> SceneError {
        let at = locate::position_of(&self.text, &invalid.key).unwrap_or(0);
        let (line, column) = locate::line_and_column(&self.text, at);
        SceneError::Value {
            path: self.path.clone(),
            line,
            column,
            invalid,
        }
    }
}
