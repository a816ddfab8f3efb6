//! What holds the organs: fixed nodes, ties to what is rigid, and the soft bath around the rest.

use nalgebra::Vector3;
use simulation::space::system::System;
use simulation::space::term::Springs;

use super::body::Body;
use super::labels::Labels;
use super::plan::{Attachment, Plan};
use super::way::Way;
use crate::numbers::{Checked, invalid};

/// How an organ is held by one attachment or by the bath.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Number of the organ.
    pub body: usize,
    /// In words: by what.
    pub by: String,
    /// By nodes or springs.
    pub how: How,
}

/// Held nodes, or springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum How {
    /// So many nodes keep their place.
    Nodes(usize),
    /// Springs at points of the surface.
    Springs {
        /// Their number among a model's springs.
        number: usize,
        /// How many there are.
        points: usize,
        /// What they hold, before the deformation, mm^2.
        area: f64,
        /// Stress by length, N/mm^3.
        stiffness: f64,
    },
}

/// Two attachments that hold the same points of a surface: their stiffnesses add up there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Their numbers in the plan, the smaller one first.
    pub attachments: [usize; 2],
    /// Points that both hold.
    pub points: usize,
    /// mm^2, before the deformation.
    pub area: f64,
}

/// All pairs of attachments that hold the same points.
pub(crate) fn overlaps(plan: &Plan, labels: &Labels, bodies: &[Body]) -> Vec<Overlap> {
    let of: Vec<Vec<u16>> = plan.attachments.iter().map(|one| plan.labels_of(&one.to)).collect();
    let mut all = Vec::new();
    for (j, two) in plan.attachments.iter().enumerate() {
        for (i, one) in plan.attachments[..j]
            .iter()
            .enumerate()
            .filter(|(_, one)| one.organ == two.organ)
        {
            let both =
                |x: &Vector3<f64>| labels.is_near(x, one.within, &of[i]) && labels.is_near(x, two.within, &of[j]);
            let points = bodies[one.organ].mesh.surface.iter().filter(|p| both(&p.at));
            let (points, area) = points.fold((0, 0.0), |(n, area), p| (n + 1, area + p.area));
            if points > 0 {
                all.push(Overlap {
                    attachments: [i, j],
                    points,
                    area,
                });
            }
        }
    }
    all
}

/// Holds all organs of a model, the tube having gone `free` until it touches; what is held how, and the springs.
///
/// # Errors
/// [`scene::Invalid`]: an attachment that holds nothing, an organ that nothing holds.
pub(crate) fn all(
    plan: &Plan,
    labels: &Labels,
    (way, free): (&Way, f64),
    bodies: &[Body],
    system: &mut System,
) -> Checked<(Vec<Held>, Vec<Springs>)> {
    let (mut held, mut springs) = (Vec::new(), Vec::new());
    for (k, one) in plan.attachments.iter().enumerate() {
        held.push(attached(plan, labels, (k, one), bodies, system, &mut springs)?);
    }
    if let Some(bath) = plan.bath {
        for (number, body) in bodies.iter().enumerate() {
            let ties: Vec<&Attachment> = plan.attachments.iter().filter(|a| a.organ == number).collect();
            let of: Vec<Vec<u16>> = ties.iter().map(|tie| plan.labels_of(&tie.to)).collect();
            let tied = |x: &Vector3<f64>| ties.iter().zip(&of).any(|(tie, of)| labels.is_near(x, tie.within, of));
            // What a hole holds is not what is around the organ: springs there would stiffen one that is hollow.
            let around = |x: &Vector3<f64>, normal: &Vector3<f64>| {
                way.off_axis(x, free) >= bath.corridor && !tied(x) && !body.faces_hole(x, normal)
            };
            if let Some(how) = springs_at(number, bath.stiffness, body, system, &mut springs, &around) {
                let by = format!(
                    "the bath around it, but for {} mm about the tube's way to it",
                    bath.corridor
                );
                held.push(Held { body: number, by, how });
            }
        }
    }
    match (0..bodies.len()).find(|k| held.iter().all(|h: &Held| h.body != *k)) {
        Some(k) => Err(invalid(
            format!("organs.{k}"),
            format!("{:?}, which nothing holds", bodies[k].name),
            "an organ with an attachment, or [surroundings]: else the tube pushes it away without end",
        )),
        None => Ok((held, springs)),
    }
}

fn attached(
    plan: &Plan,
    labels: &Labels,
    (k, one): (usize, &Attachment),
    bodies: &[Body],
    system: &mut System,
    springs: &mut Vec<Springs>,
) -> Checked<Held> {
    let key = format!("attachments.{k}.within");
    if !labels.can_look(one.within) {
        return Err(invalid(
            key,
            one.within,
            "less: all voxels so near to each point are looked at",
        ));
    }
    let (of, body) = (plan.labels_of(&one.to), &bodies[one.organ]);
    let near = |x: &Vector3<f64>| labels.is_near(x, one.within, &of);
    let how = match one.stiffness {
        None => nodes(one.organ, body, system, &near),
        Some(stiffness) => springs_at(one.organ, stiffness, body, system, springs, &|x, _| near(x)),
    };
    let names = plan.names_of(&one.to);
    let how = how.ok_or_else(|| {
        let found = format!(
            "no point of the surface of {:?} is within {} mm of {names}",
            body.name, one.within
        );
        invalid(
            key,
            found,
            "a distance at which something is held (fixed: and a node of its cubes too)",
        )
    })?;
    Ok(Held {
        body: one.organ,
        by: format!("{names}, within {} mm", one.within),
        how,
    })
}

/// Nodes keep their place; `None` where there is none.
fn nodes(organ: usize, body: &Body, system: &mut System, near: &dyn Fn(&Vector3<f64>) -> bool) -> Option<How> {
    // Nodes of cubes that are cut lie beside the organ too: where no point of it is near, they hold nothing.
    if !body.mesh.surface.iter().any(|point| near(&point.at)) {
        return None;
    }
    let nodes = body.mesh.nodes_where(near);
    let offset = system.bodies.offset(organ);
    for node in &nodes {
        (0..3).for_each(|k| system.fixed[offset + 3 * node + k] = true);
    }
    (!nodes.is_empty()).then_some(How::Nodes(nodes.len()))
}

/// Springs at the wanted points of a surface; `None` where there is none.
fn springs_at(
    organ: usize,
    stiffness: f64,
    body: &Body,
    system: &mut System,
    springs: &mut Vec<Springs>,
    wanted: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
) -> Option<How> {
    let each = |x: &Vector3<f64>, n: &Vector3<f64>| if wanted(x, n) { stiffness } else { 0.0 };
    let bed = Springs::new(&system.bodies, organ, each, |x| *x);
    if bed.is_empty() {
        return None;
    }
    let at = body.mesh.surface.iter().filter(|p| wanted(&p.at, &p.normal));
    let how = How::Springs {
        number: springs.len(),
        points: bed.len(),
        area: at.map(|p| p.area).sum(),
        stiffness,
    };
    springs.push(bed.clone());
    system.others.push(Box::new(bed));
    Some(how)
}
