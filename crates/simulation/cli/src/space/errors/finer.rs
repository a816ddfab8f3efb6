//! The same state in cubes half as large.

use nalgebra::Vector3;
use organs::{Labels, Model};
use simulation::space::cells::Mesh;
use simulation::space::error::{Jumps, SAFETY, Stated, Touching, corrected, taken_over};

use super::{At, Base, displacements};

/// Places nearer than this to the tip's are stated by themselves, mm.
pub(in super::super) const REACH: f64 = 20.0;

/// The error of the mesh, estimated.
#[derive(Debug)]
pub(in super::super) struct Finer {
    /// Unknowns of the finer mesh.
    pub(in super::super) unknowns: usize,
    /// What going to it changes, without a factor.
    pub(in super::super) by: At,
    /// With the factor: of the organ that the tube presses, near its tip and elsewhere.
    pub(in super::super) stated: Option<Stated>,
    /// What the last pass still moved, by the largest move.
    pub(in super::super) left: f64,
    /// By organ: where the tractions jump most.
    pub(in super::super) worst: Vec<Option<Worst>>,
}

/// Jumps of an organ's tractions between its cubes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct Worst {
    /// Cubes that have half of them.
    pub(in super::super) cubes: usize,
    pub(in super::super) of: usize,
    /// The middle of the worst, in the patient at rest.
    pub(in super::super) at: Vector3<f64>,
}

impl Finer {
    /// What is stated: [`SAFETY`] times the change.
    pub(in super::super) fn stated(change: &Vector3<f64>) -> f64 {
        SAFETY * change.norm()
    }
}

pub(super) fn of(base: &Base<'_>) -> Result<Finer, String> {
    let (model, labels) = (base.model, base.labels);
    let pressed = pressed(model, &base.state.a)?;
    let finer = model.halved(base.plan, labels)?;
    let mut start = Vec::with_capacity(finer.system.bodies.size());
    for (k, (from, to)) in model.bodies.iter().zip(&finer.bodies).enumerate() {
        start.extend(taken_over(
            &from.mesh,
            model.system.bodies.part(k, &base.state.a),
            &to.mesh,
        ));
    }
    // What keeps its place on the finer mesh has not moved, wherever it is taken over to.
    start
        .iter_mut()
        .zip(&finer.system.fixed)
        .filter(|(_, fixed)| **fixed)
        .for_each(|(a, _)| *a = 0.0);
    let touching = pressed.and_then(|body| {
        let tube = model.system.tubes.get(body)?.tube();
        let wanted: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool = &|_, _| true;
        Some(Touching { body, tube, wanted })
    });
    let next = corrected(&finer.system, &start, touching.as_ref()).map_err(|why| why.to_string())?;
    untouched(&finer, model, pressed, &next.a)?;
    let at = At {
        targets: displacements(&finer, labels, &next.a),
        force: labels.turned(&next.force),
    };
    let part = |model: &Model, body: usize, a: &[f64]| model.system.bodies.part(body, a).to_vec();
    let stated = pressed.map(|body| {
        let meshes: [&Mesh; 2] = [&model.bodies[body].mesh, &finer.bodies[body].mesh];
        let parts = [part(model, body, &base.state.a), part(&finer, body, &next.a)];
        let coarse = (meshes[0], parts[0].as_slice(), base.at.force);
        let tip = model.way.tip(model.free + base.state.stroke);
        Stated::new(coarse, (meshes[1], &parts[1], at.force), &tip, REACH)
    });
    Ok(Finer {
        unknowns: next.a.len(),
        by: at.minus(&base.at),
        stated,
        left: next.left,
        worst: (0..model.bodies.len()).map(|k| worst(base, labels, k)).collect(),
    })
}

/// Refuses a finer state in which the tube is in an organ that it does not press: there is no contact with that one.
fn untouched(finer: &Model, model: &Model, pressed: Option<usize>, a: &[f64]) -> Result<(), String> {
    let Some(tube) = model.system.tubes.first().map(|contact| contact.tube()) else {
        return Ok(());
    };
    let bodies = &finer.system.bodies;
    let others = (0..bodies.len()).filter(|k| pressed != Some(*k));
    let mut points = others.flat_map(|k| (0..bodies.solid(k).points()).map(move |point| (k, point)));
    let within = |(k, point)| {
        tube.signed_distance(&bodies.solid(k).point(bodies.part(k, a), point))
            .value
            < 0.0
    };
    match points.find(|(k, point)| within((*k, *point))) {
        Some((k, _)) => Err(format!(
            "in cubes half as large the tube presses {:?} too, which is not looked at there",
            finer.bodies[k].name
        )),
        None => Ok(()),
    }
}

/// The organ that the tube presses; `None` where it presses none.
fn pressed(model: &Model, a: &[f64]) -> Result<Option<usize>, String> {
    let each = model.system.tubes.iter().enumerate();
    let pressed: Vec<usize> = each
        .filter(|(_, tube)| tube.force(&model.system.bodies, a).points > 0)
        .map(|(k, _)| k)
        .collect();
    match pressed.as_slice() {
        [] => Ok(None),
        [one] => Ok(Some(*one)),
        _ => Err("the tube presses several organs at once, which is not looked at in finer cubes".to_owned()),
    }
}

fn worst(base: &Base<'_>, labels: &Labels, k: usize) -> Option<Worst> {
    let mesh = &base.model.bodies[k].mesh;
    let part = base.model.system.bodies.part(k, &base.state.a);
    let jumps = Jumps::new(mesh, &base.plan.organs[k].material, part)?;
    let first = jumps.cubes.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [low, high] = mesh.grid().corners(&first.0);
    Some(Worst {
        cubes: jumps.worst(0.5).len(),
        of: jumps.cubes.len(),
        at: labels.patient(&((low + high) * 0.5)),
    })
}
