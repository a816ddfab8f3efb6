//! What a session rests on: the attached scene, calibrations and registrations, and the records beside the messages.

use std::collections::BTreeMap;
use std::path::Path;

use bus::message::Ages;
use calib::file::{RegistrationFile, ToolFile};
use mcap::Attachment;
use mcap::records::Metadata;
use scene::{Scene, TrackerSource};
use serde::Serialize;

use super::run_report::{self, RunReport, Tissue, last_name};
use super::short::{List, short};
use crate::edit::cut::CUT;
use crate::edit::import::IMPORTED;
use crate::edit::recovered::{self, RECOVERED};
use crate::read::organs::MOST_TOLERANCE;
use crate::wire::schema::{RUN, SCENE};
use crate::write::beside::MAX_BYTES;
use crate::write::record::Progress;
use crate::write::series::part::{BEFORE, PART};

/// What lies beside the messages.
#[derive(Debug, Default, Serialize)]
pub(super) struct Basis {
    /// The scene; `None`: none is attached.
    pub(super) scene: Option<Result<SceneFacts, String>>,
    /// The run's own report; `None`: none is attached.
    pub(super) report: Option<Result<RunReport, String>>,
    /// The other attached files.
    pub(super) files: List<Attached>,
    /// The newest record of the run's facts.
    pub(super) run: BTreeMap<String, String>,
    /// What the recorder says at the end of its work; empty: it never came to its end.
    pub(super) recorder: BTreeMap<String, String>,
    /// What a file says at its end that is not the last of its session.
    pub(super) part: BTreeMap<String, String>,
    /// Where the file is a stretch of another.
    pub(super) cut: BTreeMap<String, String>,
    /// What was lost when the file was made of a damaged one, in words.
    pub(super) recovered: Vec<String>,
    /// Where its poses were imported.
    pub(super) imported: BTreeMap<String, String>,
    /// When the run wrote down its scene, ns since 1970 by the wall clock; 0: nobody says.
    pub(super) begun_wall_ns: u64,
    /// When it wrote its report.
    pub(super) reported_wall_ns: u64,
}

/// More records of losses are not told: one was made for each time that the file was made whole.
const MOST_RECOVERED: usize = 8;

/// By what samples are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    pub(crate) ages: Ages,
    /// The same measurement for longer is none, ns; `None`: it may stand still.
    pub(crate) frozen_ns: Option<i64>,
}

impl Limits {
    /// Those of a scene.
    pub(crate) fn of(scene: &Scene) -> Self {
        Self {
            ages: Ages::of(&scene.limits),
            frozen_ns: scene.frozen().map(bus::clock::ns),
        }
    }
}

/// What a person wants to know of a scene; nothing of whose examination it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct SceneFacts {
    pub(super) tool: String,
    pub(super) tool_length_mm: f64,
    pub(super) tool_diameter_mm: f64,
    /// Where poses came from, in words.
    pub(super) source: &'static str,
    /// Whether the localizer, or the tool, was made up.
    pub(super) is_simulated: bool,
    pub(super) rate_hz: f64,
    pub(super) targets: usize,
    pub(super) views: usize,
    /// Whether a model moves organs in its images.
    pub(super) moves_organs: bool,
    pub(super) stale_ms: f64,
    pub(super) lost_ms: f64,
    #[serde(skip)]
    pub(super) limits: Limits,
    /// Of settled states ([`bus::message::TissueHeader::certified`]).
    #[serde(skip)]
    tissue_tolerance: Option<f64>,
}

/// An attached file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Attached {
    pub(super) name: String,
    pub(super) bytes: u64,
    /// What it is, in words.
    pub(super) kind: &'static str,
    /// Its id, where it has one.
    pub(super) id: Option<String>,
    /// How good it is, or why it cannot be used, in words.
    pub(super) stated: String,
}

impl Basis {
    /// Takes an attached file.
    pub(super) fn attachment(&mut self, file: &Attachment<'_>) {
        match file.name.as_str() {
            SCENE => {
                self.begun_wall_ns = file.create_time;
                self.scene = Some(SceneFacts::read(&file.data));
            }
            run_report::NAME => {
                self.reported_wall_ns = file.create_time;
                self.report = Some(match self.report {
                    None => RunReport::parse(&file.data),
                    Some(_) => Err("two files of that name are attached, and one is not the run's".to_owned()),
                });
            }
            name => self.files.push(attached(name, &file.data)),
        }
    }

    /// Takes a record beside the messages; the last one of a name counts.
    pub(super) fn metadata(&mut self, record: Metadata) {
        let of = match record.name.as_str() {
            RUN => &mut self.run,
            Progress::RECORD => &mut self.recorder,
            PART => &mut self.part,
            CUT => &mut self.cut,
            IMPORTED => &mut self.imported,
            _ => return,
        };
        if record.name == RECOVERED && self.recovered.len() < MOST_RECOVERED {
            self.recovered.push(short(&recovered::words(&record.metadata)));
        }
        // Names of recordings come with their folders, which are called after patients.
        let told = |(key, value): (String, String)| match key.as_str() {
            "remade_from" | "file" => (key, last_name(&value)),
            _ => (short(&key), short(&value)),
        };
        *of = record.metadata.into_iter().take(64).map(told).collect();
    }

    /// Takes nothing from a report of another run, once all of the recording is read.
    pub(super) fn hold_report(&mut self) {
        let of_another = self.run_report().and_then(|report| report.of_another(&self.run));
        self.report = of_another.map(Err).or(self.report.take());
    }

    /// The run's own report, where it can be read.
    pub(super) fn run_report(&self) -> Option<&RunReport> {
        self.report.as_ref()?.as_ref().ok()
    }

    /// The scene, where it can be read.
    pub(super) fn scene_facts(&self) -> Option<&SceneFacts> {
        self.scene.as_ref()?.as_ref().ok()
    }

    /// Whether images of the run could show organs where a model had them, by the scene or by the run's report.
    pub(super) fn moves_organs(&self) -> bool {
        self.scene_facts().is_some_and(|scene| scene.moves_organs) || self.images_of_organs().is_some()
    }

    /// What images showed of organs, by the run's report. Counts that are not there, or of words that this version does not know, are no
    /// counts of 0.
    pub(super) fn images_of_organs(&self) -> Option<&Tissue> {
        let tissue = self.run_report()?.tissue.as_ref()?;
        (!tissue.images.is_empty()).then_some(tissue)
    }

    /// What settled states are held against: the scene's, or the most that any scene allows.
    pub(super) fn tissue_tolerance(&self) -> f64 {
        self.scene_facts()
            .and_then(|scene| scene.tissue_tolerance)
            .unwrap_or(MOST_TOLERANCE)
    }

    /// A number that the recorder said at its end.
    pub(super) fn recorder_says(&self, key: &str) -> Option<u64> {
        self.recorder.get(key)?.parse().ok()
    }

    /// How many files of the session came before this one.
    pub(super) fn files_before(&self) -> u64 {
        let of_last = self.recorder_says(BEFORE);
        let of_part = || self.part.get(BEFORE)?.parse().ok();
        of_last.or_else(of_part).unwrap_or(0)
    }
}

impl SceneFacts {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
        if text.len() as u64 > MAX_BYTES {
            return Err(format!("it has {} bytes, at most {MAX_BYTES} are read", text.len()));
        }
        let scene = Scene::parse(text, Path::new(SCENE)).map_err(|error| short(&error.to_string()))?;
        Ok(Self::of(&scene))
    }

    fn of(scene: &Scene) -> Self {
        let (source, is_simulated) = match &scene.tracker.source {
            TrackerSource::Simulated(_) => ("a simulated tool", true),
            TrackerSource::OperatingRoom(_) => ("a simulated operating room", true),
            TrackerSource::Emitters(_) => ("emitters that another program published", false),
            TrackerSource::Markers(_) => ("markers that a localizer followed", false),
            TrackerSource::Sequence(_) => ("a sequence from a file", false),
            TrackerSource::External => ("another program", false),
        };
        let ages = Ages::of(&scene.limits);
        Self {
            tool: short(&scene.tool.name),
            tool_length_mm: scene.tool.length_mm,
            tool_diameter_mm: scene.tool.diameter_mm,
            source,
            is_simulated,
            rate_hz: scene.tracker.rate_hz,
            targets: scene.targets.len(),
            views: scene.views.len(),
            moves_organs: scene.tissue.is_some(),
            stale_ms: bus::clock::ms(ages.stale_ns),
            lost_ms: bus::clock::ms(ages.lost_ns),
            limits: Limits::of(scene),
            tissue_tolerance: scene.tissue.as_ref().map(|tissue| tissue.tolerance),
        }
    }
}

/// An attached file of which nothing is known but its name: what it is, is told by what it says.
fn attached(name: &str, bytes: &[u8]) -> Attached {
    let text = std::str::from_utf8(bytes).unwrap_or_default();
    let (kind, id, stated) = if bytes.len() as u64 > MAX_BYTES {
        ("file", None, "too long to be looked at".to_owned())
    } else if text.contains("\"trocar-registration\"") {
        registration(text)
    } else if text.contains("\"trocar_calibration\"") {
        calibration(text)
    } else {
        ("file", None, "not looked at".to_owned())
    };
    Attached {
        name: short(name),
        bytes: bytes.len() as u64,
        kind,
        id: id.map(|id| short(&id)),
        stated,
    }
}

fn registration(text: &str) -> (&'static str, Option<String>, String) {
    match RegistrationFile::parse(text) {
        Ok(file) => {
            let reached = file.reached(geometry::Point::new(0.0, 0.0, 0.0));
            let fre = reached.rms_mm.map_or("unknown".to_owned(), |mm| format!("{mm:.2} mm"));
            (
                "registration",
                Some(file.id),
                format!("fiducial registration error (rms) {fre}"),
            )
        }
        Err(error) => (
            "registration",
            None,
            format!("cannot be used: {}", short(&error.to_string())),
        ),
    }
}

fn calibration(text: &str) -> (&'static str, Option<String>, String) {
    match ToolFile::parse(text) {
        Ok(file) => {
            let mm = |found: Option<f64>| found.map_or("unknown".to_owned(), |mm| format!("{mm:.2} mm"));
            let (tip, rms) = (mm(file.reached.tip_error_mm), mm(file.reached.rms_mm));
            let (date, tool) = (short(&file.date_utc), short(&file.tool));
            let words = format!("error of the tip (rms) {tip}, residuals (rms) {rms}; tool {tool:?}, made {date}");
            ("calibration of the tool", Some(file.id), words)
        }
        Err(error) => (
            "calibration",
            None,
            format!("not a tool's in use: {}", short(&error.to_string())),
        ),
    }
}
