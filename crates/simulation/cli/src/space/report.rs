//! `result.json` of solids in space.

mod state;

use nalgebra::Vector3;
use serde::Serialize;
use simulation::space::cells::Facts;

use super::body::Body;
use super::hold::How;
use super::labels::Labels;
use super::model::Model;
use super::plan::Plan;
use super::run::Run;
use super::words;
use state::{StateRecord, record};

/// Names the format.
const FORMAT: &str = "trocar-simulation-space";
const VERSION: u32 = 1;
/// What is said where an error would stand.
pub(super) const NO_ERROR: &str =
    "not known: neither how far the mesh is from a finer one, nor how far the model is from the patient";

/// The whole file. Places are the patient's, LPS, mm; forces N; moments N mm; stresses N/mm2.
#[derive(Debug, Serialize)]
pub(super) struct Report<'a> {
    format: &'static str,
    version: u32,
    title: &'a str,
    units: Units,
    labels: MapRecord<'a>,
    organs: Vec<OrganRecord<'a>>,
    held: Vec<HeldRecord<'a>>,
    tube: TubeRecord,
    not_modelled: Vec<String>,
    unknowns: usize,
    free_unknowns: usize,
    /// Of every number here: none is known.
    error: Option<f64>,
    error_words: &'static str,
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

#[derive(Debug, Serialize)]
struct MapRecord<'a> {
    path: &'a str,
    hash: &'a str,
    voxels: [usize; 3],
    spacing: [f64; 3],
}

#[derive(Debug, Serialize)]
struct OrganRecord<'a> {
    name: &'a str,
    label: u16,
    young: f64,
    poisson: f64,
    voxels: usize,
    /// mm^3: of the label, and of the mesh.
    volume: f64,
    mesh_volume: f64,
    parts: usize,
    dropped_voxels: usize,
    hole_voxels: usize,
    holes_filled: bool,
    /// It goes on beyond the label map there, which the mesh does not.
    cut_off: bool,
    elements: usize,
    nodes: usize,
    surface_points: usize,
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
            units: Units {
                length: "mm",
                stress: "N/mm2",
                force: "N",
                moment: "N mm",
                axes: "left, posterior, superior",
            },
            labels: MapRecord {
                path: whole.path,
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
            unknowns,
            free_unknowns,
            error: None,
            error_words: NO_ERROR,
            states: run.states.iter().map(|state| record(plan, model, state)).collect(),
            equilibria: run.refused.is_none() && run.saddles().is_empty(),
            refused: run.refused.as_deref(),
            pictures,
        }
    }
}

fn organ_record<'a>(body: &'a Body, organ: &super::plan::Organ) -> OrganRecord<'a> {
    let facts: &Facts = &body.facts;
    let lame = &organ.material.lame;
    OrganRecord {
        name: &body.name,
        label: body.label,
        young: lame.young(),
        poisson: 0.5 * lame.lambda / (lame.lambda + lame.mu),
        voxels: facts.voxels,
        volume: facts.volume,
        mesh_volume: body.mesh.volume(),
        parts: facts.parts,
        dropped_voxels: facts.dropped,
        hole_voxels: facts.holes,
        holes_filled: facts.filled,
        cut_off: facts.cut.iter().flatten().any(|cut| *cut),
        elements: body.mesh.elements.len(),
        nodes: body.mesh.nodes.len(),
        surface_points: body.mesh.surface.len(),
    }
}

fn held(model: &Model) -> Vec<HeldRecord<'_>> {
    let one = |held: &'_ super::hold::Held| {
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
