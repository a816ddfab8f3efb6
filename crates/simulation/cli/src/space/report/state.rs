//! A state in `result.json`.

use organs::{Labels, Model, Plan};
use serde::Serialize;
use simulation::space::equilibrium::Equilibrium;

use super::super::run::{State, beside};
use super::triple;

#[derive(Debug, Serialize)]
pub(super) struct StateRecord<'a> {
    label: &'a str,
    stroke: f64,
    tip: [f64; 3],
    /// Absent where the forces do not balance.
    #[serde(skip_serializing_if = "Option::is_none")]
    on_tube: Option<OnTubeRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    equilibrium: Option<Certificate>,
    /// Of each contact of the scene, in its order; absent where the forces do not balance.
    #[serde(skip_serializing_if = "Option::is_none")]
    on_rigid: Option<Vec<OnRigidRecord<'a>>>,
    /// Area of surfaces in voxels of what is rigid, mm^2.
    area_in_rigid: f64,
    seconds: f64,
    /// Where targets are; absent where the forces do not balance.
    #[serde(skip_serializing_if = "Option::is_none")]
    targets: Option<Vec<TargetAt<'a>>>,
}

/// A target in a state.
#[derive(Debug, Serialize)]
struct TargetAt<'a> {
    name: &'a str,
    at: [f64; 3],
    moved: [f64; 3],
    moved_by: f64,
}

/// What the tissue does to the tube.
#[derive(Debug, Serialize)]
struct OnTubeRecord {
    force: [f64; 3],
    force_size: f64,
    /// Along the way: against it where it is below 0.
    force_along: f64,
    /// About the tip.
    moment: [f64; 3],
    points: usize,
    area: f64,
    depth: f64,
}

/// What an organ does to the rigid things that keep it out.
#[derive(Debug, Serialize)]
struct OnRigidRecord<'a> {
    organ: &'a str,
    with: &'a str,
    force: [f64; 3],
    force_size: f64,
    points: usize,
    area: f64,
    depth: f64,
}

#[derive(Debug, Serialize)]
struct Certificate {
    energy: f64,
    /// The largest free force beside the largest load or reaction.
    residual: f64,
    load: f64,
    /// The last change of a contact's force beside the load.
    force_change: f64,
    /// The deepest point in the tube, mm.
    depth: f64,
    /// The deepest place of a surface in the tube, between its points too, mm.
    depth_between_points: f64,
    least_determinant: f64,
    /// Directions in which the energy falls: 0 at a minimum, null where it is not known.
    falling: Option<usize>,
    /// What tube and supports leave over on the organs, beside the force on the tube.
    balance: f64,
    parts: usize,
    rounds: usize,
    iterations: usize,
}

pub(super) fn record<'a>(plan: &Plan, labels: &Labels, model: &'a Model, state: &'a State) -> StateRecord<'a> {
    let on = &state.on_tube;
    StateRecord {
        label: &state.label,
        stroke: state.stroke,
        tip: triple(&plan.way.tip(model.free + state.stroke)),
        on_tube: state.found.map(|_| OnTubeRecord {
            force: triple(&on.force),
            force_size: on.force.norm(),
            force_along: on.force.dot(&plan.way.direction) + 0.0,
            moment: triple(&on.moment),
            points: on.points,
            area: on.area,
            depth: on.depth,
        }),
        equilibrium: state.found.as_ref().map(|found| certificate(state, found)),
        on_rigid: state.found.map(|_| on_rigid(plan, model, state)),
        area_in_rigid: state.in_rigid,
        seconds: state.seconds,
        targets: state.found.map(|_| {
            let each = model.targets.iter().map(|target| {
                let moved = labels.turned(&target.moved(&model.system.bodies, &state.a));
                TargetAt {
                    name: &target.name,
                    at: triple(&(target.at + moved)),
                    moved: triple(&moved),
                    moved_by: moved.norm(),
                }
            });
            each.collect()
        }),
    }
}

fn on_rigid<'a>(plan: &Plan, model: &'a Model, state: &State) -> Vec<OnRigidRecord<'a>> {
    let each = plan.contacts.iter().zip(&model.obstacles).zip(&state.on_rigid);
    let each = each.map(|((contact, obstacle), on)| OnRigidRecord {
        organ: &model.bodies[contact.organ].name,
        with: &obstacle.by,
        force: triple(&on.force),
        force_size: on.force.norm(),
        points: on.points,
        area: on.area,
        depth: on.depth,
    });
    each.collect()
}

fn certificate(state: &State, found: &Equilibrium) -> Certificate {
    Certificate {
        energy: found.energy,
        residual: beside(found.residual, found.load),
        load: found.load,
        force_change: beside(found.change, found.load),
        depth: found.depth,
        depth_between_points: state.between.depth,
        least_determinant: found.least_determinant,
        falling: found.falling,
        balance: state.balance,
        parts: state.parts,
        rounds: found.rounds,
        iterations: found.iterations,
    }
}
