//! An organ of a model: its label's region and the mesh over it.

use nalgebra::Vector3;
use simulation::space::cells::{Facts, Field, LabelField, Mesh, NoMesh, NoRegion, Smoothing};
use simulation::space::error::halved;

use super::labels::Labels;
use super::plan::{Organ, Plan};
use super::points::Points;
use super::way::Way;
use crate::numbers::{Checked, invalid};

/// An organ in the model.
#[derive(Debug, Clone)]
pub struct Body {
    /// For people.
    pub name: String,
    /// Of the label map.
    pub label: u16,
    /// Negative inside the smoothed surface; places are in the label map's own axes, mm.
    pub field: LabelField,
    /// The same that its solid has, in the label map's own axes, mm.
    pub mesh: Mesh,
    /// What was found of the label.
    pub facts: Facts,
    /// The region with its holes filled, where it has some that are open, and how far beside a surface it is asked, mm.
    filled: Option<(LabelField, f64)>,
}

impl Body {
    /// # Errors
    /// [`scene::Invalid`] where the label gives no region or its cubes no mesh.
    pub(crate) fn new(k: usize, plan: &Plan, labels: &Labels, way: &Way) -> Checked<Self> {
        let organ = &plan.organs[k];
        let key = |last: &str| format!("organs.{k}.{last}");
        let field = LabelField::new(&labels.map(), organ.label, &organ.smoothing).map_err(|why| match why {
            NoRegion::Smoothing { .. } | NoRegion::Lost { .. } => invalid(key("smoothing"), why, "less of it"),
            NoRegion::Parts { .. } => invalid(key("label"), why, "one part, or parts = \"largest\""),
            _ => invalid(key("label"), why, "a label of the map"),
        })?;
        let (settings, last) = (&organ.settings, way.last(&field));
        let refine = |low: &Vector3<f64>, high: &Vector3<f64>| {
            let level = (settings.side / (high.x - low.x)).log2().round().max(0.0) as usize;
            // The distance of its middle less half of its diagonal: no cube near the way is left out.
            let near = way.off_axis(&(0.5 * (low + high)), last) - 0.5 * (high - low).norm();
            organ.within.get(level).is_some_and(|reach| near < *reach)
        };
        let mesh = Mesh::new(&field, field.corners, settings, &refine);
        let mut mesh = mesh.map_err(|why| invalid(key("cubes"), why, "cubes that fit the organ"))?;
        let points = Points::new(k, plan, labels, way, last);
        mesh.lay_points_by(&field, |low, high| points.spacing([low, high]));
        Ok(Self {
            filled: filled(organ, labels, &field),
            name: organ.name.clone(),
            label: organ.label,
            facts: field.facts,
            field,
            mesh,
        })
    }

    /// Whether a point of the surface, with its normal, is of the wall of a hole that the organ encloses.
    pub fn faces_hole(&self, at: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
        let filled = self.filled.as_ref();
        filled.is_some_and(|(filled, beside)| filled.value(&(at + normal * *beside)) < 0.0)
    }

    /// The same organ in cubes half as large.
    ///
    /// # Errors
    /// [`NoMesh`], as of too many cubes.
    pub(crate) fn halved(&self, k: usize, plan: &Plan, labels: &Labels, way: &Way) -> Result<Self, NoMesh> {
        let (field, settings) = (&self.field, &plan.organs[k].settings);
        let mut mesh = halved(&self.mesh, field, field.corners, settings, None)?;
        let points = Points::new(k, plan, labels, way, way.last(field));
        // Where cubes set how near points are, these are nearer too: what points leave out shows as an error of the mesh.
        mesh.lay_points_by(field, |low, high| points.spacing([low, high]));
        Ok(Self { mesh, ..self.clone() })
    }
}

/// The region of an organ with holes that are left open, as if they were filled; `None` without any, or where it cannot be smoothed so.
fn filled(organ: &Organ, labels: &Labels, field: &LabelField) -> Option<(LabelField, f64)> {
    if field.facts.holes == 0 || field.facts.filled {
        return None;
    }
    let smoothing = Smoothing {
        fill_holes: true,
        ..organ.smoothing
    };
    let filled = LabelField::new(&labels.map(), organ.label, &smoothing).ok()?;
    Some((filled, labels.spacing.min()))
}

/// The displacement that nodes give a place, mm: `row` is of their numbers, with weights, and `part` the unknowns of their organ,
/// three of each node.
pub fn displacement(row: &[(u32, f64)], part: &[f64]) -> Vector3<f64> {
    let each = row.iter().map(|(node, weight)| {
        let first = 3 * *node as usize;
        Vector3::new(part[first], part[first + 1], part[first + 2]) * *weight
    });
    each.sum()
}
