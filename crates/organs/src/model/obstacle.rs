//! What is rigid and keeps an organ out: one smooth surface around some labels near it, along which the organ slides.
//!
//! Labels that touch share faces of voxels, and both surfaces are smoothed: as they lie in the map they overlap here and there, by a part of a voxel. An organ
//! that is at rest as it was imaged is not pressed, so the surface recedes by one level until no point of the organ's surface lies in it. By how much is told.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use simulation::space::bodies::Bodies;
use simulation::space::cells::{Bounds, Curved, Field, LabelField, LabelMap, Parts, Smoothing};
use simulation::space::level_set::LevelSet;
use simulation::space::term::{BadStiffness, ObstacleContact};

use super::Body;
use crate::labels::Labels;
use crate::numbers::{Checked, invalid};
use crate::plan::{Contact, Plan};

/// Voxels around the box that is looked at, beyond what smoothing spreads: a surface is cut where the map is, and that cut must be out of reach.
const MARGIN: f64 = 4.0;
/// Standard deviations that smoothing reaches.
const SPREAD: f64 = 4.0;
/// Both surfaces overlap at rest by smoothing alone, in voxels: more says that the labels are not what they are taken for.
const MOST_OVERLAP: f64 = 1.0;

/// What keeps an organ out.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// In words: names of what is rigid.
    pub by: String,
    /// How far its smoothed surface was taken back, where it was farthest in the organ at rest, mm.
    pub receded_mm: f64,
    surface: LevelSet,
}

impl Obstacle {
    /// The obstacle of a contact as far as a body may come that is pushed by `stroke`.
    ///
    /// # Errors
    /// [`scene::Invalid`]: nothing rigid within reach, too thin for the smoothing or the ball, or an organ that lies in it.
    pub(super) fn new(
        k: usize,
        contact: &Contact,
        plan: &Plan,
        labels: &Labels,
        body: &Body,
        stroke: f64,
    ) -> Checked<Self> {
        let key = |last: &str| format!("contacts.{k}.{last}");
        let (by, of) = (plan.names_of(&contact.with), plan.labels_of(&contact.with));
        let reach = |corner: &Vector3<f64>, by: f64| corner.add_scalar(by);
        let [low, high] = &body.field.corners;
        let corners = [reach(low, -stroke), reach(high, stroke)];
        let far = SPREAD * contact.smoothing + 2.0 * contact.ball + MARGIN * labels.spacing.max();
        let (map, voxels) = labels.around([&reach(&corners[0], -far), &reach(&corners[1], far)], &of);
        let map = LabelMap { labels: &voxels, ..map };
        let smoothing = Smoothing {
            sigma: contact.smoothing,
            parts: Parts::All,
            fill_holes: true,
        };
        let field = LabelField::new(&map, 1, &smoothing).map_err(|why| {
            invalid(
                key("with"),
                format!("{by} near {:?}: {why}", body.name),
                "labels near the organ, and less smoothing where they are thin",
            )
        })?;
        let surface = |field: Receded| {
            LevelSet::new(Arc::new(field), corners, contact.ball).map_err(|why| {
                invalid(
                    key("ball"),
                    why,
                    "a ball that fits behind the surface; nothing thinner than it",
                )
            })
        };
        let as_it_lies = surface(Receded {
            field: field.clone(),
            by: 0.0,
        })?;
        let points = || body.mesh.surface.iter().map(|point| &point.at);
        let depth = points()
            .map(|at| -as_it_lies.signed_distance(at).value)
            .fold(0.0, f64::max);
        let most = MOST_OVERLAP * labels.spacing.max();
        if depth > most {
            let found = format!("{:?}, which lies {depth:.2} mm in {by} at rest", body.name);
            return Err(invalid(
                key("with"),
                found,
                format!(
                    "surfaces that overlap by a voxel at most, {most:.2} mm: the smoothing of one of them is too large"
                ),
            ));
        }
        let level = points().map(|at| -field.value(at)).fold(0.0, f64::max);
        Ok(Self {
            by,
            receded_mm: depth,
            surface: surface(Receded { field, by: level })?,
        })
    }

    /// The contact of a body with it.
    pub(super) fn term(&self, bodies: &Bodies, body: usize, stiffness: f64) -> Result<ObstacleContact, BadStiffness> {
        ObstacleContact::new(bodies, body, self.surface.clone(), stiffness, |_, _| true)
    }
}

/// A label's field at another level: its region is smaller.
#[derive(Debug, Clone)]
struct Receded {
    field: LabelField,
    by: f64,
}

impl Field for Receded {
    fn value(&self, at: &Vector3<f64>) -> f64 {
        self.field.value(at) + self.by
    }

    fn slope(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.field.slope(at)
    }

    fn bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> Bounds {
        self.field.bounds(low, high).map(|bound| bound + self.by)
    }

    fn slope_bounds(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [Bounds; 3] {
        self.field.slope_bounds(low, high)
    }

    fn resolution(&self) -> f64 {
        self.field.resolution()
    }
}

impl Curved for Receded {
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        self.field.curvature(at)
    }
}
