//! From the scene of organs and its label map to meshes that lie in the examination.

use std::path::{Path, PathBuf};

use bus::message::{MOST_DEPTH_MM, TissueMesh};
use bus::volume::LabelMap;
use geometry::rotation::RotationMatrix;
use geometry::{Ct, DoorError, Model as ModelFrame, Point, Rigid, VolumeGrid, Voxel, checked};
use nalgebra::Vector3;
use organs::{Body, Labels, Meeting, Meetings, Model, NoLabels, Obstacle, Parsed, Plan, RawSpaceScene, Varied, sha};
use scene::{Scene, SceneError, TissueSpec, VolumeSpec};
use simulation::space::cells::Lattice;
use simulation::space::frames::{Frames, NoFrames, Settings, Together};
use simulation::space::system::System;
use simulation::space::tube::TubeError;

use crate::errors::Errors;
use crate::live::{Live, Met, pose_at, tube};
use crate::message;

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Reads the label map at a path, of an examination; the generated patient's of a seed. Handed in by the binary, as this crate knows no
/// file formats.
pub type LoadLabels = fn(&Path, &VolumeSpec, u64) -> Result<LabelMap, Cause>;

/// Rounding of the axes of a label map that are orthogonal.
const ROUNDING: f64 = 1e-4;
/// Two diameters are one to this, mm.
const SAME: f64 = 1e-6;

/// Why organs are not moved.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoAnatomy {
    /// The scene of organs, or what it says of the label map.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Another file than the run began with, or than was recorded.
    #[error("{path}: its hash is {found}, and {expected} is expected ({key}): other organs would be moved")]
    Other {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The hash of the one that is to be moved.
        expected: String,
        /// Which key of the scene says so.
        key: &'static str,
    },
    /// The label map.
    #[error("{path}: {source}")]
    Labels {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: Cause,
    },
    /// No label map for solids.
    #[error("{path}: {source}")]
    NoLabels {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: NoLabels,
    },
    /// Of another patient, or of another scan of the same.
    #[error(
        "{path}: its voxels, {found}, are not those of the run's examination, {expected}: organs of another grid, or of another patient, would be moved. Give a label map of these \
         voxels{}", .is_part.then_some(", or load the whole examination: [volume.region] and volume.downsample make others").unwrap_or_default()
    )]
    OtherGrid {
        /// The label map.
        path: PathBuf,
        /// Its voxels, in words.
        found: String,
        /// Those of the examination.
        expected: String,
        /// Whether a part of the examination is loaded, or several voxels are made one.
        is_part: bool,
    },
    /// Organs that the model, which has no contact between them, could not tell apart.
    #[error(
        "{path}: {}: the model has no contact between organs, so they must lie apart where nothing pushes them: leave one out, or give another label map",
        .met.at_rest()
    )]
    Meet {
        /// The scene of organs.
        path: PathBuf,
        /// Which, and how deep.
        met: Met,
    },
    /// A tube that is not the run's.
    #[error(
        "{path}: key tube.diameter: found {found} mm; the run's tool has {expected} mm (tool.diameter_mm): the model must be pushed by the tube that is tracked"
    )]
    Tool {
        /// The scene of organs.
        path: PathBuf,
        /// Its tube's diameter.
        found: f64,
        /// The tool's.
        expected: f64,
    },
    /// Axes that make no rigid transform.
    #[error("the axes of the label map: {0}")]
    Axes(#[from] DoorError),
    /// The tool is no tube.
    #[error("the tool as a tube: {0}")]
    Tube(#[from] TubeError),
    /// No state to begin with.
    #[error("{path}: {source}")]
    Frames {
        /// The scene of organs.
        path: PathBuf,
        /// Why.
        source: NoFrames,
    },
    /// Cubes so small that images would take too many nodes.
    #[error("the cubes of the mesh are so small that images would take more than a million nodes")]
    Cubes,
}

/// Organs ready for poses.
pub(crate) struct Anatomy {
    pub(crate) live: Live,
    pub(crate) errors: Errors,
    /// In the order of the organs.
    pub(crate) lattices: Vec<Lattice>,
    pub(crate) mesh: TissueMesh,
    /// In words.
    pub(crate) said: String,
}

/// Makes what the scene's table asks for, in the examination of `grid` and `hash`.
///
/// # Errors
/// [`NoAnatomy`].
pub(crate) fn make(
    (scene, spec): (&Scene, &TissueSpec),
    (grid, hash): (&VolumeGrid, [u8; 32]),
    load: LoadLabels,
) -> Result<Anatomy, NoAnatomy> {
    let (source, plan) = read((scene, spec))?;
    let labels = labels((&source, &plan), (scene, grid), load)?;
    let model = Model::without_tube(&plan, &labels).map_err(|why| source.error_at(why))?;
    let ct_from_model = placed(&labels)?;
    let meetings = apart(&model.bodies, spec)?;
    let (lattices, mesh) = meshes(&model.bodies, (ct_from_model, hash))?;
    let said = in_all(&model, &plan, &lattices, &meetings);
    let varied = Varied::all(&model, &plan, &labels).map_err(|why| source.error_at(why))?;
    let bodies = model.bodies.clone();
    let names = bodies.iter().map(|body| body.name.clone()).collect();
    let systems = model.apart(&plan, &labels).map_err(|why| source.error_at(why))?;
    let live = Live::new(frames(model, systems, (scene, spec))?, ct_from_model, (meetings, names));
    let targets = scene.targets.iter().map(|target| target.centre);
    Ok(Anatomy {
        errors: Errors::new(targets, (&bodies, &mesh, &live), varied, spec.error_every),
        live,
        lattices,
        mesh,
        said,
    })
}

/// What images draw, and the mesh as a message.
pub(crate) fn meshes(
    bodies: &[Body],
    placed: (Rigid<Ct, ModelFrame>, [u8; 32]),
) -> Result<(Vec<Lattice>, TissueMesh), NoAnatomy> {
    let lattices = bodies.iter().map(|body| body.mesh.lattice(&body.field));
    let lattices: Vec<Lattice> = lattices.collect::<Option<_>>().ok_or(NoAnatomy::Cubes)?;
    let mesh = message::mesh(bodies, &lattices, placed);
    Ok((lattices, mesh))
}

/// What tells whether organs have come into one another; refused where they are so, or touch, before anything moves them.
pub(crate) fn apart(bodies: &[Body], spec: &TissueSpec) -> Result<Meetings, NoAnatomy> {
    let meetings = Meetings::new(bodies);
    match meetings.at_rest() {
        None => Ok(meetings),
        Some(Meeting { organs, depth }) => Err(NoAnatomy::Meet {
            path: spec.organs.clone(),
            met: Met::new(organs.map(|k| bodies[k].name.as_str()), depth),
        }),
    }
}

/// What was made, in words: organ by organ, and how they are told apart.
fn in_all(model: &Model, plan: &Plan, lattices: &[Lattice], meetings: &Meetings) -> String {
    let each = model
        .bodies
        .iter()
        .zip(lattices)
        .enumerate()
        .map(|(k, (body, lattice))| {
            let own = model.obstacles.iter().zip(&plan.contacts);
            let kept: String = own
                .filter(|(_, contact)| contact.organ == k)
                .map(|(o, _)| kept_out(o))
                .collect();
            format!(
                "{}: {} cubes, {} unknowns{kept}{}",
                body.name,
                lattice.cubes.len(),
                body.mesh.unknowns(),
                cut_off(body)
            )
        });
    let each: Vec<String> = each.collect();
    match each.len() {
        1 => each.concat(),
        count => format!(
            "{count} organs of {} unknowns, looked at in {} places up to {:.1} mm apart for whether they lie in one another; {}",
            model.unknowns()[0],
            meetings.places(),
            meetings.step(),
            each.join("; ")
        ),
    }
}

/// What it slides along, and what of that a state may not come to.
fn kept_out(obstacle: &Obstacle) -> String {
    let left = obstacle.left_out.map(|left| {
        format!(
            " ({:.0} mm2 thinner than its ball, from {:.1} mm on, are left out)",
            left.area, left.apart
        )
    });
    format!(", kept out of {}{}", obstacle.by, left.unwrap_or_default())
}

/// Whether the label map ends within the organ: no surface is there, so that neither the tube nor anything that holds it acts on it there.
fn cut_off(body: &Body) -> &'static str {
    match body.facts.cut.iter().flatten().any(|cut| *cut) {
        true => ", CUT OFF by the border of the label map: what lies beyond is not in the model",
        false => "",
    }
}

/// The scene of organs that a table names, checked but for what the label map says.
///
/// # Errors
/// [`NoAnatomy`].
pub(crate) fn read((scene, spec): (&Scene, &TissueSpec)) -> Result<(Parsed<RawSpaceScene>, Plan), NoAnatomy> {
    let path = &spec.organs;
    let text = organs::read(path)?;
    same(path, "tissue.organs_hash", spec.organs_hash.as_deref(), || {
        blake3::hash(text.as_bytes()).to_string()
    })?;
    let source = Parsed::<RawSpaceScene>::parse(text, path)?;
    let plan = Plan::new(&source.scene).map_err(|why| source.error_at(why))?;
    by_the_tool(path, &plan, scene)?;
    Ok((source, plan))
}

/// Refuses another file than the run's scene says.
fn same(path: &Path, key: &'static str, expected: Option<&str>, found: impl Fn() -> String) -> Result<(), NoAnatomy> {
    match expected.map(|expected| (found(), expected)) {
        Some((found, expected)) if found != expected => Err(NoAnatomy::Other {
            path: path.to_owned(),
            found,
            expected: expected.to_owned(),
            key,
        }),
        _ => Ok(()),
    }
}

/// Pushed by the tube of the run.
fn by_the_tool(path: &Path, plan: &Plan, scene: &Scene) -> Result<(), NoAnatomy> {
    let (found, expected) = (2.0 * plan.way.radius, scene.tool.diameter_mm);
    match (found - expected).abs() <= SAME {
        true => Ok(()),
        false => Err(NoAnatomy::Tool {
            path: path.to_owned(),
            found,
            expected,
        }),
    }
}

/// The label map of a scene of organs, on the voxels of the examination.
///
/// # Errors
/// [`NoAnatomy`].
pub(crate) fn labels(
    (source, plan): (&Parsed<RawSpaceScene>, &Plan),
    (scene, grid): (&Scene, &VolumeGrid),
    load: LoadLabels,
) -> Result<Labels, NoAnatomy> {
    let path = scene::labels_beside(&source.path, &source.scene.space.labels);
    let named = |source: Cause| NoAnatomy::Labels {
        path: path.clone(),
        source,
    };
    let map = load(&path, &scene.volume, scene.seed).map_err(named)?;
    let wanted = plan.labels_sha256.as_deref();
    if wanted.is_some() {
        let found = sha::of_labels(&path).map_err(|error| named(error.into()))?;
        sha::pinned(wanted, &path, found.as_deref()).map_err(|why| source.error_at(why))?;
    }
    same(
        &path,
        "tissue.labels_hash",
        scene.tissue.as_ref().and_then(|spec| spec.labels_hash.as_deref()),
        || map.volume.hash.to_string(),
    )?;
    // Of other voxels it may be of another patient.
    if map.lies_on(grid).is_doubtful() {
        return Err(NoAnatomy::OtherGrid {
            path,
            found: in_words(&map.volume.grid),
            expected: in_words(grid),
            is_part: scene.volume.region.is_some() || scene.volume.downsample != [1; 3],
        });
    }
    let (volume, view) = (&map.volume, map.volume.view());
    let slice = |z: u32, out: &mut [i16]| view.slice(z, out);
    Labels::new(&volume.grid, volume.hash.to_string(), slice).map_err(|source| NoAnatomy::NoLabels { path, source })
}

/// How many voxels of which size, and where the first lies in the patient.
fn in_words(grid: &VolumeGrid) -> String {
    let ([i, j, k], [x, y, z]) = (grid.dims(), grid.spacing_mm());
    let first = grid.ct_from_voxel() * Point::<Voxel>::new(0.0, 0.0, 0.0);
    format!(
        "{i} x {j} x {k} of {x:.3} x {y:.3} x {z:.3} mm from {} on",
        first.in_words(1)
    )
}

/// Where the label map's axes are in the patient.
pub(crate) fn placed(labels: &Labels) -> Result<Rigid<Ct, ModelFrame>, DoorError> {
    let columns = [0, 1, 2].map(|axis| labels.turned(&Vector3::ith(axis, 1.0)));
    let rows = [0, 1, 2].map(|row| columns.map(|column| column[row]));
    let turn = RotationMatrix::new(rows, ROUNDING).map(|matrix| matrix.rotation().quaternion());
    // Axes that are no rotation have been refused: numbers that are none are refused by the door.
    let quaternion = turn.unwrap_or([f64::NAN; 4]);
    checked::rigid(quaternion, labels.patient(&Vector3::zeros()).into(), 1e-9)
}

/// The organs with the run's tube at the entry of its way.
///
/// # Errors
/// [`NoAnatomy`].
pub(crate) fn frames(
    model: Model,
    systems: Vec<System>,
    (scene, spec): (&Scene, &TissueSpec),
) -> Result<Together, NoAnatomy> {
    let way = model.way;
    let begin = pose_at(&way.entry, &way.direction, way.radius);
    let tube = tube(scene.tool.diameter_mm, scene.tool.length_mm, begin)?;
    let settings = Settings {
        tolerance: spec.tolerance,
        // Who shows a state holds it against that.
        depth: MOST_DEPTH_MM,
        most_steps: spec.most_steps,
        refresh: spec.refresh_mm,
        delay: spec.delay,
        ..Settings::default()
    };
    let each = model.bodies.iter().zip(systems).map(|(body, system)| {
        // Where points of the surface were laid for it.
        let last = way.last(&body.field);
        let wanted = |at: &Vector3<f64>, _: &Vector3<f64>| way.spacing([at, at], last).is_some();
        let a = system.initial();
        Frames::new(system, a, 0, tube.clone(), settings, wanted)
    });
    let refused = |source| NoAnatomy::Frames {
        path: spec.organs.clone(),
        source,
    };
    let each = each.collect::<Result<Vec<_>, _>>().map_err(refused)?;
    let bodies = model.system.bodies.len();
    Together::new(model.system, each).ok_or(refused(NoFrames::NoBody {
        body: bodies,
        solids: bodies,
    }))
}
