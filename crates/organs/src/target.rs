//! Targets: places of organs, and where an organ takes them.

use nalgebra::Vector3;
use simulation::space::bodies::Bodies;
use simulation::space::cells::Field;

use super::body::{Body, displacement};
use super::labels::Labels;
use super::plan::{Plan, Wanted};
use crate::numbers::{Checked, invalid};

/// A place of an organ.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// For people.
    pub name: String,
    /// Number of the organ.
    pub body: usize,
    /// At rest, in the patient: LPS, mm.
    pub at: Vector3<f64>,
    /// Nodes of the organ that move it, with weights.
    row: Vec<(u32, f64)>,
}

/// All targets of a plan, on these meshes.
///
/// # Errors
/// [`scene::Invalid`]: a target that lies in no organ, in two, or in another than it names.
pub(crate) fn all(plan: &Plan, labels: &Labels, bodies: &[Body]) -> Checked<Vec<Target>> {
    let each = plan.targets.iter().enumerate();
    each.map(|(k, wanted)| Target::new(k, wanted, labels, bodies)).collect()
}

impl Target {
    fn new(k: usize, wanted: &Wanted, labels: &Labels, bodies: &[Body]) -> Checked<Self> {
        let own = labels.own(&wanted.at);
        let key = format!("targets.{k}.at");
        let found: Vec<usize> = (0..bodies.len())
            .filter(|b| bodies[*b].field.value(&own) < 0.0)
            .collect();
        let names = || {
            let names = found.iter().map(|b| format!("{:?}", bodies[*b].name));
            names.collect::<Vec<_>>().join(" and ")
        };
        let body = match (wanted.organ, found.as_slice()) {
            (Some(organ), all) if all.contains(&organ) => organ,
            (None, [one]) => *one,
            (_, []) => return Err(outside(&key, wanted, &own, bodies)),
            (Some(organ), _) => {
                let found = format!("a place in {}", names());
                return Err(invalid(
                    key,
                    found,
                    format!("a place in {:?}, its organ", bodies[organ].name),
                ));
            }
            (None, _) => {
                let found = format!("a place in {}, whose smoothed surfaces overlap there", names());
                return Err(invalid(key, found, "organ = one of them"));
            }
        };
        // A place in the region whose cube was all but empty.
        let row = bodies[body].mesh.row(&own);
        let row = row.ok_or_else(|| outside(&key, wanted, &own, bodies))?;
        Ok(Self {
            name: wanted.name.clone(),
            body,
            at: wanted.at,
            row,
        })
    }

    /// Its displacement in the label map's axes, mm: `a` is of all organs.
    pub fn moved(&self, bodies: &Bodies, a: &[f64]) -> Vector3<f64> {
        let part = bodies.part(self.body, a);
        displacement(&self.row, part)
    }

    /// The first of the three unknowns of each node that moves it, among those of all organs, with weights.
    pub fn unknowns(&self, bodies: &Bodies) -> Vec<(usize, f64)> {
        let offset = bodies.offset(self.body);
        let each = self
            .row
            .iter()
            .map(|(node, weight)| (offset + 3 * *node as usize, *weight));
        each.collect()
    }
}

/// A place in no organ, with the nearest one.
fn outside(key: &str, wanted: &Wanted, own: &Vector3<f64>, bodies: &[Body]) -> scene::Invalid {
    let away = |body: &Body| {
        let each = body.mesh.surface.iter().map(|p| (p.at - own).norm());
        each.fold(f64::INFINITY, f64::min)
    };
    let nearest = bodies
        .iter()
        .map(|b| (away(b), &b.name))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let [x, y, z]: [f64; 3] = wanted.at.into();
    let found = match nearest {
        Some((away, name)) => format!("[{x}, {y}, {z}], in no organ: some {away:.1} mm from {name:?}, the nearest"),
        None => format!("[{x}, {y}, {z}], in no organ"),
    };
    invalid(key, found, "a place in an organ at rest, inside its smoothed surface")
}
