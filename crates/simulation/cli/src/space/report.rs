//! `result.json` of solids in space.

pub(super) mod errors;
mod state;

use nalgebra::Vector3;
use organs::body::Body;
use organs::hold::How;
use organs::{Labels, Model, Plan};
use serde::Serialize;
use simulation::space::cells::Facts;

use super::errors::Said;
use super::run::Run;
use super::words;
use errors::ErrorsRecord;
use state::{StateRecord, record};

/// Names the format.
const FORMAT: &str = "trocar-simulation-space";
const VERSION: u32 = 2;

/// The whole file. Places are the patient's, LPS, mm; forces N; moments N mm; stresses N/mm2.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    format: &'static str,
    version: u32,
    title: &'a str,
    /// False while the run goes on: an interrupted one keeps what it found.
    complete: bool,
    scene: SceneRecord<'a>,
    units: Units,
    labels: MapRecord<'a>,
    organs: Vec<OrganRecord<'a>>,
    held: Vec<HeldRecord<'a>>,
    tube: TubeRecord,
    not_modelled: Vec<String>,
    warnings: Vec<String>,
    targets: Vec<TargetRecord<'a>>,
    unknowns: usize,
    free_unknowns: usize,
    errors: ErrorsRecord<'a>,
    states: Vec<StateRecord<'a>>,
    /// True where forces balance in every state at a minimum, and the run came to its end.
    equilibria: bool,
    /// Why the run ended early; absent after a whole run.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<&'a str>,
    pictures: &'a [String],
}

#[derive(Debug, Serialize)]
struct Units {
    length: &'static str,
    stress: &'static str,
    force: &'static str,
    moment: &'static str,
    axes: &'static str,
}

/// The file that all this came from.
#[derive(Debug, Serialize)]
struct SceneRecord<'a> {
    path: &'a str,
    sha256: &'a str,
    text: &'a str,
}

/// A target at rest.
#[derive(Debug, Serialize)]
struct TargetRecord<'a> {
    name: &'a str,
    organ: &'a str,
    at: [f64; 3],
}

#[derive(Debug, Serialize)]
struct MapRecord<'a> {
    path: &'a str,
    /// Of the file; null where it is none.
    sha256: Option<&'a str>,
    /// BLAKE3 of geometry and voxels.
    hash: &'a str,
    voxels: [usize; 3],
    spacing: [f64; 3],
}

#[derive(Debug, Serialize)]
struct OrganRecord<'a> {
    name: &'a str,
    label: u16,
    law: &'static str,
    /// `[weight, exponent]` of each term where that is Ogden's.
    ogden: Option<&'a [[f64; 2]]>,
    young: f64,
    young_spread: Option<f64>,
    poisson: f64,
    poisson_spread: Option<f64>,
    /// Standard deviation of the surface's smoothing, mm.
    smoothing: f64,
    cubes: CubesRecord<'a>,
    /// Of the label's part that is meshed, without holes.
    voxels: usize,
    /// Of these the ones that smoothing left outside, and others that it took in.
    voxels_smoothed_away: usize,
    voxels_smoothed_in: usize,
    /// mm^3: of the label with the holes that are filled, and of the mesh.
    volume: f64,
    mesh_volume: f64,
    parts: usize,
    dropped_voxels: usize,
    /// Voxels of holes that were filled, and that were left open.
    filled_voxels: usize,
    open_hole_voxels: usize,
    /// It goes on beyond the label map there, which the mesh does not.
    cut_off: bool,
    elements: usize,
    nodes: usize,
    surface_points: usize,
}

#[derive(Debug, Serialize)]
struct CubesRecord<'a> {
    side: f64,
    levels: u32,
    within: &'a [f64],
}

#[derive(Debug, Serialize)]
struct HeldRecord<'a> {
    organ: &'a str,
    by: &'a str,
    how: &'static str,
    count: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness: Option<f64>,
}

#[derive(Debug, Serialize)]
struct TubeRecord {
    diameter: f64,
    length: f64,
    entry: [f64; 3],
    direction: [f64; 3],
    /// Where the tip is when the tube first touches.
    first_touch: [f64; 3],
    stroke: f64,
    step: f64,
}

fn triple(v: &Vector3<f64>) -> [f64; 3] {
    // Adding zero makes -0 a plain 0.
    [v.x + 0.0, v.y + 0.0, v.z + 0.0]
}

/// What a report is of.
pub(super) struct Whole<'a> {
    pub(super) title: &'a str,
    pub(super) path: &'a str,
    pub(super) plan: &'a Plan,
    pub(super) labels: &'a Labels,
    pub(super) model: &'a Model,
    pub(super) run: &'a Run,
    pub(super) origin: &'a Origin,
    pub(super) errors: &'a Said,
    /// False while the run goes on.
    pub(super) complete: bool,
}

/// The files of a run.
#[derive(Debug)]
pub(super) struct Origin {
    /// Of the scene.
    pub(super) path: String,
    pub(super) text: String,
    pub(super) sha256: String,
    /// Of the label map, where it is a file.
    pub(super) labels_sha256: Option<String>,
}

impl<'a> Report<'a> {
    pub(super) fn new(whole: &'a Whole<'a>, pictures: &'a [String]) -> Self {
        let Whole {
            plan,
            labels,
            model,
            run,
            ..
        } = whole;
        let [unknowns, free_unknowns] = model.unknowns();
        Self {
            format: FORMAT,
            version: VERSION,
            title: whole.title,
            complete: whole.complete,
            scene: SceneRecord {
                path: &whole.origin.path,
                sha256: &whole.origin.sha256,
                text: &whole.origin.text,
            },
            units: Units {
                length: "mm",
                stress: "N/mm2",
                force: "N",
                moment: "N mm",
                axes: "left, posterior, superior",
            },
            labels: MapRecord {
                path: whole.path,
                sha256: whole.origin.labels_sha256.as_deref(),
                hash: &labels.hash,
                voxels: labels.size,
                spacing: labels.spacing.into(),
            },
            organs: model
                .bodies
                .iter()
                .zip(&plan.organs)
                .map(|(body, organ)| organ_record(body, organ))
                .collect(),
            held: held(model),
            tube: TubeRecord {
                diameter: 2.0 * plan.way.radius,
                length: plan.way.length,
                entry: triple(&plan.way.entry),
                direction: triple(&plan.way.direction),
                first_touch: triple(&plan.way.tip(model.free)),
                stroke: plan.way.stroke,
                step: plan.way.step,
            },
            not_modelled: words::not_modelled(plan, labels, model),
            warnings: words::warnings(plan, model),
            targets: model
                .targets
                .iter()
                .map(|target| target_record(model, target))
                .collect(),
            unknowns,
            free_unknowns,
            errors: errors::record(whole.errors, model),
            states: run
                .states
                .iter()
                .map(|state| record(plan, labels, model, state))
                .collect(),
            equilibria: whole.complete && run.refused.is_none() && run.saddles().is_empty(),
            refused: run.refused.as_deref(),
            pictures,
        }
    }
}

fn target_record<'a>(model: &'a Model, target: &'a organs::Target) -> TargetRecord<'a> {
    TargetRecord {
        name: &target.name,
        organ: &model.bodies[target.body].name,
        at: triple(&target.at),
    }
}

fn organ_record<'a>(body: &'a Body, organ: &'a organs::plan::Organ) -> OrganRecord<'a> {
    let facts: &Facts = &body.facts;
    let (filled, open) = if facts.filled {
        (facts.holes, 0)
    } else {
        (0, facts.holes)
    };
    OrganRecord {
        name: &body.name,
        label: body.label,
        law: organ.law,
        ogden: organ.ogden.as_deref(),
        young: organ.young.value,
        young_spread: organ.young.spread,
        poisson: organ.poisson.value,
        poisson_spread: organ.poisson.spread,
        smoothing: organ.smoothing.sigma,
        cubes: CubesRecord {
            side: organ.settings.side,
            levels: organ.settings.levels,
            within: &organ.within,
        },
        voxels: facts.voxels - filled,
        voxels_smoothed_away: facts.moved[0],
        voxels_smoothed_in: facts.moved[1],
        volume: facts.volume,
        mesh_volume: body.mesh.volume(),
        parts: facts.parts,
        dropped_voxels: facts.dropped,
        filled_voxels: filled,
        open_hole_voxels: open,
        cut_off: facts.cut.iter().flatten().any(|cut| *cut),
        elements: body.mesh.elements.len(),
        nodes: body.mesh.nodes.len(),
        surface_points: body.mesh.surface.len(),
    }
}

fn held(model: &Model) -> Vec<HeldRecord<'_>> {
    let one = |held: &'_ organs::hold::Held| {
        let (how, count, area, stiffness) = match held.how {
            How::Nodes(count) => ("fixed nodes", count, None, None),
            How::Springs {
                points,
                area,
                stiffness,
                ..
            } => ("springs", points, Some(area), Some(stiffness)),
        };
        (how, count, area, stiffness)
    };
    let records = model.held.iter().map(|held| {
        let (how, count, area, stiffness) = one(held);
        HeldRecord {
            organ: &model.bodies[held.body].name,
            by: &held.by,
            how,
            count,
            area,
            stiffness,
        }
    });
    records.collect()
}
