//! An organ of a model: its label's region and the mesh over it.

use nalgebra::Vector3;
use simulation::space::cells::{Facts, LabelField, Mesh, NoMesh, NoRegion};
use simulation::space::error::halved;

use super::labels::Labels;
use super::plan::Organ;
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
}

impl Body {
    /// # Errors
    /// [`scene::Invalid`] where the label gives no region or its cubes no mesh.
    pub(crate) fn new(k: usize, organ: &Organ, labels: &Labels, way: &Way) -> Checked<Self> {
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
        mesh.lay_points(&field, settings.depth, |low, high| way.spacing([low, high], last));
        Ok(Self {
            name: organ.name.clone(),
            label: organ.label,
            facts: field.facts,
            field,
            mesh,
        })
    }

    /// The same organ in cubes half as large.
    ///
    /// # Errors
    /// [`NoMesh`], as of too many cubes.
    pub(crate) fn halved(&self, organ: &Organ, way: &Way) -> Result<Self, NoMesh> {
        let (field, settings) = (&self.field, &organ.settings);
        let mut mesh = halved(&self.mesh, field, field.corners, settings, None)?;
        // As near to one another as on the mesh that it is held against: what changes is the cubes alone.
        let last = way.last(field);
        mesh.lay_points(field, settings.depth, |low, high| way.spacing([low, high], last));
        Ok(Self { mesh, ..self.clone() })
    }
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
