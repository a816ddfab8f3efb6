//! `pilot plan`: makes a plan of an operation, on a screen or from the command line, and says what is in it.

mod edits;
mod points;

use std::path::{Path, PathBuf};

use bus::clock::date;
use bus::volume::OwnedVolume;
use clap::Args;
use guidance::plan::file::Changed;
use guidance::plan::{Confirmed, Editor, Plan};
use guidance::safety::{LabelNames, TubeError};
use guidance::workflow::VolumeId;
use scene::raw::Source;
use scene::{Scene, VolumeSpec};

use crate::check::Depth;
use crate::cli::{VolumeArgs, display};
use crate::planning::{Findings, LabelMap, Measured, PlanStore, StoreError, planning_scene};
use crate::resolve::ResolveError;
use crate::state::Options;
use edits::{EditArgs, EditError};
use points::FileError;

pub(crate) const PLAN_HELP: &str = "\
A plan is a file of targets, ways to them and measures in one examination, which it names by its hash; it is of no use with any other. With
--window it is made on a screen (docs/plan.md); without, it is changed as the options say, written, and printed with what speaks against it.
A scene follows it with [plan] file.

Examples:
  pilot plan plan.json --volume ct --window                          makes it on a screen
  pilot plan plan.json --volume ct                                   what is in it, and what lies outside the CT
  pilot plan plan.json --volume ct --target node=33.5,4,50.5 --entry node=120,60,40
  pilot plan plan.json --volume ct --diameter node=8 --stop node=5 --rename node=left-node
  pilot plan plan.json --volume ct --measure 33.5,4,50.5:120,60,40   a distance; with three points an angle
  pilot plan plan.json --volume ct --labels organs.nii.gz --error-mm 2   how far the ways stay from each structure
  pilot plan plan.json --volume ct --import targets.mrk.json         targets and entries from 3D Slicer (docs/exchange.md)
  pilot plan plan.json --volume ct --export targets.mrk.json         and back to it
  pilot plan plan.json --volume ct --export targets.dcm              and to a planning system, as a DICOM structure set
  pilot plan plan.json --volume ct --confirm \"Dr. A\"                 read-only from now on

Exit codes: 0 all well; 1 refused or failed, nothing was written; 3 something speaks against the plan.";

type Read<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// Reads an examination, with what is doubtful about it, a sentence each.
pub type LoadTold = fn(&VolumeSpec, u64) -> Read<(OwnedVolume, Vec<String>)>;

/// A point: its name, and where it is, LPS mm.
pub type NamedPlace = (String, [f64; 3]);

/// Who reads volumes and moves organs: handed in by the binary, as this crate knows no formats of them and no model.
#[derive(Debug, Clone, Copy)]
pub struct Hands {
    /// Reads an examination, with what is doubtful about it, a sentence each; the number is the generated patient's seed.
    pub load: LoadTold,
    /// Reads a label map of an examination; the number is the generated patient's seed.
    pub load_labels: fn(&Path, &VolumeSpec, u64) -> Read<bus::volume::LabelMap>,
    /// Reads the names that a label map comes with.
    pub label_names: fn(&Path) -> Read<LabelNames>,
    /// Reads the points of a structure set of an examination; `None` of what is no such file.
    pub structure_set: fn(&Path, &VolumeSpec) -> Read<Option<StructureSet>>,
    /// These points, by name and place, LPS mm, as a structure set of an examination: a whole file.
    pub structure_set_bytes: fn(&VolumeSpec, &[NamedPlace]) -> Read<Vec<u8>>,
    /// Looks at the organs of a scene as the process does that moves them, at its start: in words, what was made of them.
    pub organs: fn(&Scene, Depth) -> Read<Option<String>>,
    /// Reads the tank that a simulated probe of a scene images, as the tracker does at its start; a file that is not there is no matter of it.
    pub tank: fn(&Scene) -> Read<()>,
}

/// The points of a DICOM structure set.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureSet {
    /// Their names, and where they are: LPS, mm.
    pub points: Vec<NamedPlace>,
    /// The names of regions of interest that are no points.
    pub others: Vec<String>,
    /// Whether the file says to be in the frame of reference of the examination.
    pub is_in_its_frame: bool,
    /// What is doubtful about whose it is, a sentence each.
    pub warnings: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    /// The plan; made where there is none.
    plan: PathBuf,
    /// A scene with the examination, the tool and what ways are measured against; without one, the embedded
    /// demonstration.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    volume: VolumeArgs,
    /// Take a plan that was changed by other means as it is; it is then no plan that anybody confirmed.
    #[arg(long)]
    accept_changes: bool,
    /// A new plan begins with the targets of the scene.
    #[arg(long)]
    from_scene: bool,
    /// A label map, against which ways are measured [default: the scene's]
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// The error of navigation that distances to structures are lessened by, mm [default: the scene's; else not known]
    #[arg(long, value_name = "MM", value_parser = length)]
    error_mm: Option<f64>,
    #[command(flatten)]
    edits: EditArgs,
    /// A person says that the plan is to be followed: it is read-only from now on. What is imported is looked at before.
    #[arg(long, value_name = "NAME", conflicts_with = "import")]
    confirm: Option<String>,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
    /// Make it on a screen, on the display that DISPLAY names.
    #[arg(long, conflicts_with_all = ["confirm", "json", "export"])]
    window: bool,
    /// Names the run in which it is made on a screen.
    #[arg(long, default_value = "plan", requires = "window")]
    run: String,
}

fn length(text: &str) -> Result<f64, String> {
    let mm = text.parse().ok().filter(|mm| (0.0..=100.0).contains(mm));
    mm.ok_or_else(|| "expected 0 to 100 mm".to_owned())
}

/// Why a plan was not made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PlanCliError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    #[error(transparent)]
    Edit(#[from] EditError),
    #[error(transparent)]
    Points(#[from] FileError),
    #[error(transparent)]
    Tube(#[from] TubeError),
    #[error("label map {path}: {source}")]
    Labels {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    #[error("reading the examination: {0}")]
    Volume(Box<dyn std::error::Error + Send + Sync>),
    #[error(
        "plan {path}: it was made for the examination {expected}, and this one is {found}. Give the examination that it was made for, all of \
         it and read in the same way"
    )]
    OtherExamination {
        path: PathBuf,
        found: String,
        expected: String,
    },
    #[error("plan {path}: there is one already, and --from-scene begins a new one; give another name")]
    NotNew { path: PathBuf },
}

/// What `pilot plan` is to do.
pub(crate) enum Planned {
    /// It was done: what is to be said, and whether something speaks against the plan.
    Said(String, bool),
    /// It is made on a screen.
    Window(Box<(Options, Source, Scene)>),
}

impl PlanArgs {
    /// Changes and prints the plan, or prepares the run in which it is made on a screen.
    pub(crate) fn carry_out(&self, hands: Hands) -> Result<Planned, PlanCliError> {
        let changed = match self.accept_changes {
            true => Changed::Taken,
            false => Changed::Refused,
        };
        let mut store = PlanStore::open(&self.plan, changed)?;
        self.edits.points.check(&self.plan)?;
        let (mut source, scene) = self.volume.load(self.scene.as_deref(), true)?;
        if self.from_scene && store.plan().is_some() {
            let path = store.path().to_owned();
            return Err(PlanCliError::NotNew { path });
        }
        if self.window && !self.edits.is_some() && !self.from_scene {
            return self.on_screen(store, &mut source);
        }
        bus::stderr_line!("pilot: reading the examination");
        let (volume, doubts) = (hands.load)(&scene.volume, scene.seed).map_err(PlanCliError::Volume)?;
        let plan = self.changed(&store, &scene, &volume, hands)?;
        // Everything that can be refused is looked at before anything is written.
        let measured = self.measured(&scene, &volume, hands)?;
        let safety = measured.as_ref().map(|measured| measured.safety(&plan)).transpose()?;
        let export = self
            .edits
            .points
            .prepare(&plan, &|points| (hands.structure_set_bytes)(&scene.volume, points))?;
        // A plan with nothing in it is written by nobody's wish.
        if store.plan().is_some() || plan != Plan::new(plan.volume) {
            store.save(&plan)?;
        }
        if let Some(export) = export {
            export.finish()?;
        }
        if self.window {
            return self.on_screen(store, &mut source);
        }
        let found = Findings::of(&store, &plan, (&volume.view(), doubts), safety);
        let words = match self.json {
            true => serde_json::to_string_pretty(&found).unwrap_or_default(),
            false => found.table(),
        };
        Ok(Planned::Said(words, found.is_doubtful()))
    }

    /// What ways are measured against, where there is a label map.
    fn measured(&self, scene: &Scene, volume: &OwnedVolume, hands: Hands) -> Result<Option<Measured>, PlanCliError> {
        let Some(path) = self.labels.clone().or_else(|| scene.plan.labels.clone()) else {
            return Ok(None);
        };
        let fail = |source| PlanCliError::Labels {
            path: path.clone(),
            source,
        };
        let labels = (hands.load_labels)(&path, &scene.volume, scene.seed).map_err(fail)?;
        let names = (hands.label_names)(&path).map_err(fail)?;
        let map = LabelMap {
            file: path.display().to_string(),
            grid: labels.lies_on(&volume.grid),
            doubts: labels.doubts.clone(),
            names,
        };
        let error_mm = self.error_mm.or(scene.plan.error_mm);
        let measured = Measured::of(&labels.volume, map, (scene.tool.diameter_mm, error_mm));
        Ok(Some(measured.map_err(|error| fail(error.into()))?))
    }

    /// The plan with all changes made.
    fn changed(
        &self,
        store: &PlanStore,
        scene: &Scene,
        volume: &OwnedVolume,
        hands: Hands,
    ) -> Result<Plan, PlanCliError> {
        let hash = VolumeId(volume.hash.0);
        let plan = match store.plan() {
            Some(plan) if plan.volume != hash => {
                return Err(PlanCliError::OtherExamination {
                    path: store.path().to_owned(),
                    found: volume.hash.to_string(),
                    expected: bus::message::VolumeHash(plan.volume.0).to_string(),
                });
            }
            Some(plan) => plan.clone(),
            None => Plan::new(hash),
        };
        let mut editor = Editor::new(plan);
        let given = if self.from_scene { &scene.targets[..] } else { &[] };
        for edit in edits::of_scene(given) {
            editor.edit(edit).map_err(EditError::from)?;
        }
        self.edits
            .make(&mut editor, &|path| (hands.structure_set)(path, &scene.volume))?;
        if let Some(by) = &self.confirm {
            let (by, at) = (by.clone(), date::now());
            editor.confirm(Confirmed { by, at }).map_err(EditError::from)?;
        }
        Ok(editor.plan().clone())
    }

    fn on_screen(&self, store: PlanStore, source: &mut Source) -> Result<Planned, PlanCliError> {
        planning_scene(source, &store);
        if let Some(path) = self.labels.as_ref().filter(|path| scene::is_generated(path)) {
            return Err(PlanCliError::Labels {
                path: path.clone(),
                source: "--window takes a file: `volume-loader labels phantom --out FILE.seg.nrrd` writes one".into(),
            });
        }
        if self.labels.is_some() || self.error_mm.is_some() {
            let plan = source.scene.plan.get_or_insert_default();
            let labels = self.labels.as_ref().map(|path| display(path));
            (plan.labels, plan.error_mm) = (labels.or(plan.labels.take()), self.error_mm.or(plan.error_mm));
        }
        let scene = Scene::from_raw(source).map_err(ResolveError::from)?;
        let folder = store.path().parent().unwrap_or(store.path()).to_owned();
        let options = Options {
            run: self.run.clone(),
            out: folder,
            overwrite: false,
            duration: None,
            simulated_time: false,
            has_window: true,
            replay: None,
            remote: None,
            planning: Some(store),
        };
        Ok(Planned::Window(Box::new((options, source.clone(), scene))))
    }
}
