//! Floor 1: the scene file, one TOML file that describes a whole run.
//!
//! Read in two steps: the raw shape ([`raw`]: every key known, every type right), then the checked [`Scene`], in which
//! every value is usable. Errors say file, line, column, key, what was found and what is allowed.

mod check;
mod error;
pub mod file;
mod gateway;
mod guide;
pub mod identity;
mod limits;
pub mod localizer;
pub mod locate;
pub mod operating_room;
mod pacs;
pub mod plan;
mod priorities;
pub mod raw;
mod recording;
mod sampling;
pub mod shipped;
pub mod steps;
mod tissue;
pub mod tracking;
mod values;
mod view;
mod volume;
mod workflow;

use std::path::Path;
use std::time::Duration;

use geometry::{Ct, Point, Rigid, Tracker};

pub use error::{Invalid, SceneError};
pub use gateway::{GatewaySpec, RawGateway};
pub use guide::{RawGuide, plan_id};
pub use identity::RawIdentity;
pub use limits::Limits;
pub use pacs::{PacsSpec, RawPacs};
pub use priorities::Priorities;
pub use raw::{Drawn, Extent, Plane, Up};
pub use recording::{Compression, RawRecording, RecordingSpec};
pub use sampling::{BackEnd, Filter, GpuWeights, Minify, Render, Sampling, Slab, SlabMode, THICKNESS_MM};
pub use tissue::{RawTissue, TissueSpec};
pub use view::{Surface, View, WindowLevel};
pub use volume::{
    FileSpec, GENERATED, RawRegion, RawVolume, Region, VolumeSource, VolumeSpec, is_generated, labels_beside,
};
pub use workflow::{Demands, RawWorkflow};

/// A run's scene, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Seeds everything that is drawn by chance.
    pub seed: u64,
    /// Where the examination comes from, and how much of it is loaded.
    pub volume: VolumeSpec,
    /// The instrument.
    pub tool: ToolSpec,
    /// Where poses come from.
    pub tracker: TrackerSpec,
    /// The connection to a real localizer; `None`: another program publishes, or nothing real is followed.
    pub localizer: Option<localizer::LocalizerSpec>,
    /// What the surgeon aims at.
    pub targets: Vec<Target>,
    /// The name of the target that is chosen at the start; `None`: none is.
    pub guide: Option<String>,
    /// What the run demands of a person on its way to navigation.
    pub workflow: Demands,
    /// What is calibrated, registered and checked while the run goes on; `None`: nothing.
    pub steps: Option<steps::StepsSpec>,
    /// The images, in the order of the file.
    pub views: Vec<View>,
    /// The plan that the run follows, and what its ways are measured against.
    pub plan: plan::PlanSpec,
    /// Whose examination it is, as far as the scene says so.
    pub identity: Option<RawIdentity>,
    /// Organs that the tube moves; `None`: nothing moves.
    pub tissue: Option<TissueSpec>,
    /// Who samples the volume.
    pub render: Render,
    /// What is recorded; `None` starts no recorder.
    pub recording: Option<RecordingSpec>,
    /// The server for other programs; `None` opens no port.
    pub gateway: Option<GatewaySpec>,
    /// From whom examinations are received before a run; `None`: nobody is named.
    pub pacs: Option<PacsSpec>,
    /// When to warn, restart and give up.
    pub limits: Limits,
    /// Who gives way where the machine has too much to do.
    pub priorities: Priorities,
}

/// The rigid tube. Its frame: origin at the inner tip, +z from the handle to the tip.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolSpec {
    /// For people.
    pub name: String,
    /// From the handle to the tip, mm.
    pub length_mm: f64,
    /// Outer diameter, mm.
    pub diameter_mm: f64,
}

/// Where poses come from.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSpec {
    /// Simulated by the tracker process, or published by a program of the user's.
    pub source: TrackerSource,
    /// Samples a second.
    pub rate_hz: f64,
    /// The patient's registration, unless a file says or it rests on a marker on the patient.
    pub ct_from_tracker: Rigid<Ct, Tracker>,
    /// The files that calibration and registration come from.
    pub links: tracking::LinkFiles,
    /// Time constant of the smoothing of poses; `None`: they are not smoothed.
    pub smoothing: Option<Duration>,
}

/// Who publishes poses.
#[derive(Debug, Clone, PartialEq)]
pub enum TrackerSource {
    /// The tracker process plays a scripted approach.
    Simulated(Simulation),
    /// The tracker process simulates an operating room: emitters seen by a localizer.
    OperatingRoom(Box<operating_room::Room>),
    /// Another program publishes what a localizer sees; the tracker process makes poses of it.
    Emitters(Box<tracking::EmitterSource>),
    /// A localizer makes the poses of its markers; the tracker process takes them on to the patient.
    Markers(Box<tracking::MarkerSource>),
    /// The tracker process plays poses from a file.
    Sequence(Box<tracking::SequenceSource>),
    /// Another program publishes on the pose topic; no tracker process is started.
    External,
}

impl TrackerSource {
    /// Whether a marker on the patient is seen, from which the patient is registered.
    pub fn has_reference(&self) -> bool {
        match self {
            Self::OperatingRoom(room) => room.reference.is_some(),
            Self::Emitters(spec) => spec.reference.is_some(),
            Self::Markers(spec) => spec.markers.reference.is_some(),
            Self::Sequence(spec) => spec.markers.reference.is_some(),
            Self::Simulated(_) | Self::External => false,
        }
    }

    /// Whether a tool at rest has the same numbers again and again, by what the scene says of the noise: a simulator without any, or
    /// a simulated localizer whose steps are so coarse that its noise drowns in them.
    pub fn is_noiseless(&self) -> bool {
        match self {
            Self::Simulated(simulation) => simulation.noise_mm == 0.0 && simulation.noise_rad == 0.0,
            Self::OperatingRoom(room) => {
                let noise_mm = room.sensor.across_mm.max(room.sensor.depth_mm);
                noise_mm == 0.0 || room.sensor.quantisation_mm > 3.0 * noise_mm
            }
            Self::Emitters(_) | Self::Markers(_) | Self::Sequence(_) | Self::External => false,
        }
    }
}

/// The simulated gesture and its imperfections.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Standard deviation of the measured tip along each axis, mm.
    pub noise_mm: f64,
    /// Standard deviation of the measured rotation about each axis, radians.
    pub noise_rad: f64,
    /// Chance that a sample starts a dropout.
    pub dropout: f64,
    /// Samples a dropout lasts.
    pub dropout_samples: u32,
    /// The gesture.
    pub approach: Approach,
}

/// Insert along a line towards the target, pause, sweep about the entry, withdraw; again and again.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// Name of a target, or `None`: the first target, and the volume's middle where there is none.
    pub target: Option<String>,
    /// Where the tube goes through the skin; `None`: from the patient's left and back.
    pub entry: Option<Point<Ct>>,
    /// How far short of the target the tip stops, mm.
    pub stop_short_mm: f64,
    /// Duration of the insertion and of the withdrawal, s.
    pub insert_s: f64,
    /// Rest at the target, s.
    pub pause_s: f64,
    /// Duration of the sweep, s.
    pub sweep_s: f64,
    /// Half opening of the sweep's cone, radians.
    pub sweep_rad: f64,
}

/// What the surgeon aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// For people.
    pub name: String,
    /// Its centre.
    pub centre: Point<Ct>,
    /// Its diameter, mm.
    pub diameter_mm: f64,
    /// Where the tube is to enter on its way there.
    pub entry: Option<Point<Ct>>,
    /// How far before its centre the tip is to stop, mm; 0 or more.
    pub stop_mm: f64,
}

impl Scene {
    /// Reads and checks a scene file. Paths in it are relative to the file's folder.
    ///
    /// # Errors
    /// Each variant of [`SceneError`].
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::from_raw(&raw::load(path)?)
    }

    /// Reads and checks the text of a scene; `path` stands in errors and anchors relative paths.
    ///
    /// # Errors
    /// Each variant of [`SceneError`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        Self::from_raw(&raw::parse(text, path)?)
    }

    /// Checks a raw scene.
    ///
    /// # Errors
    /// [`SceneError::Value`].
    pub fn from_raw(source: &raw::Source) -> Result<Self, SceneError> {
        check::scene(&source.scene).map_err(|invalid| source.error_at(invalid))
    }

    /// For how long the same measurement may come again before it is none: [`Limits::frozen`]; `None` where the scene's own source has
    /// no noise. Poses say that of themselves too, but those of recordings from before they did say nothing.
    pub fn frozen(&self) -> Option<std::time::Duration> {
        (!self.tracker.source.is_noiseless()).then_some(self.limits.frozen)
    }

    /// Identifies the registration that poses rest on where the scene itself says it: [`registration_id`] of its numbers, with
    /// those of the marker on the patient where there is one.
    pub fn registration_id(&self) -> u64 {
        let ct_from_reference = match &self.tracker.source {
            TrackerSource::OperatingRoom(room) => room.reference.as_ref().map(|on| on.ct_from_reference),
            TrackerSource::Emitters(source) => source.reference.as_ref().map(|on| on.ct_from_reference),
            TrackerSource::Markers(source) => source.markers.reference.as_ref().map(|(_, rigid)| *rigid),
            TrackerSource::Sequence(source) => source.markers.reference.as_ref().map(|(_, rigid)| *rigid),
            TrackerSource::Simulated(_) | TrackerSource::External => None,
        };
        let rigid = &self.tracker.ct_from_tracker;
        let mut numbers = [rigid.quaternion().to_vec(), rigid.translation_mm().to_vec()].concat();
        if let Some(rigid) = ct_from_reference {
            numbers.extend(rigid.quaternion().into_iter().chain(rigid.translation_mm()));
        }
        registration_id(&numbers)
    }

    /// The renderers that this scene needs: one per plane direction, each with the indices of its views.
    pub fn renderers(&self) -> Vec<(Plane, Vec<usize>)> {
        let mut renderers: Vec<(Plane, Vec<usize>)> = Vec::new();
        for (index, view) in self.views.iter().enumerate() {
            match renderers.iter_mut().find(|(plane, _)| *plane == view.plane) {
                Some((_, views)) => views.push(index),
                None => renderers.push((view.plane, vec![index])),
            }
        }
        renderers
    }
}

/// Identifies a registration, with the calibrations that go with it, by its numbers: 64 bits of BLAKE3.
pub fn registration_id(numbers: &[f64]) -> u64 {
    let mut hasher = blake3::Hasher::new_derive_key("trocar registration 1");
    for number in numbers {
        hasher.update(&number.to_bits().to_le_bytes());
    }
    let bytes = hasher.finalize();
    u64::from_be_bytes(std::array::from_fn(|i| bytes.as_bytes()[i]))
}
