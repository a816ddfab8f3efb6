//! What is rigid and keeps an organ out: one smooth surface around some labels near it, along which the organ slides.
//!
//! Labels that touch share faces of voxels, and both surfaces are smoothed: as they lie in the map they overlap here and there, by a part of a voxel. An organ
//! that is at rest as it was imaged is not pressed, so the surface recedes by one level until no point of the organ's surface lies in it. By how much is told.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use simulation::space::bodies::Bodies;
use simulation::space::cells::{Bounds, Curved, Field, LabelField, LabelMap, Parts, Smoothing};
use simulation::space::level_set::{LeftOut, LevelSet, NoSurface};
use simulation::space::term::{BadStiffness, ObstacleContact};

use super::Body;
use crate::labels::Labels;
use crate::numbers::{Checked, invalid};
use crate::plan::{Contact, Plan};

/// Voxels around what is looked at, beyond what smoothing spreads: a surface is cut where the map is, and that cut must be out of reach.
const MARGIN: f64 = 4.0;
/// Standard deviations that smoothing reaches.
const SPREAD: f64 = 4.0;
/// And so many radii of the ball more, where feet and balls may lie.
const BEYOND: f64 = 2.0;
/// Both surfaces overlap at rest by smoothing alone, in voxels: more says that the labels are not what they are taken for.
const MOST_OVERLAP: f64 = 1.0;

/// What keeps an organ out.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// In words: names of what is rigid.
    pub by: String,
    /// How far its smoothed surface was taken back, where it was farthest in the organ at rest, mm.
    pub receded_mm: f64,
    /// How far round the organ at rest it was looked for, mm.
    pub reach_mm: f64,
    /// What of it within that is thinner than its ball; the place is the patient's. A state that comes to it is refused.
    pub left_out: Option<LeftOut>,
    /// Voxels of its labels near the organ that smoothing leaves outside of it, and others that it takes in.
    pub moved: [usize; 2],
    surface: LevelSet,
}

impl Obstacle {
    /// The obstacle of a contact as far as a body may come that is pushed by `stroke`.
    ///
    /// # Errors
    /// [`scene::Invalid`]: nothing rigid within reach, too thin for the smoothing, too thin for the ball at the organ itself, or an organ that lies in it.
    pub(super) fn new(
        k: usize,
        contact: &Contact,
        plan: &Plan,
        labels: &Labels,
        body: &Body,
        stroke: f64,
    ) -> Checked<Self> {
        let by = plan.names_of(&contact.with);
        let near = Near {
            contact,
            labels,
            organ: body.mesh.surface.iter().map(|point| point.at).collect(),
            key: format!("contacts.{k}"),
            name: format!("{by} near {:?}", body.name),
        };
        let reach = contact.reach(stroke);
        let field = near.field(&plan.labels_of(&contact.with), reach)?;
        let (depth, level) = near.overlap(&field)?;
        let moved = field.facts.moved;
        let surface = near.surface(Receded { field, by: level }, &near.organ, reach)?;
        for point in &body.mesh.surface {
            near.proved(&surface, &point.at, point.gap)?;
        }
        Ok(Self {
            by,
            receded_mm: depth,
            reach_mm: reach,
            moved,
            left_out: surface.left_out().map(|left| LeftOut {
                at: labels.patient(&left.at.into()).into(),
                ..left
            }),
            surface,
        })
    }

    /// The contact of a body with it.
    pub(super) fn term(&self, bodies: &Bodies, body: usize, stiffness: f64) -> Result<ObstacleContact, BadStiffness> {
        ObstacleContact::new(bodies, body, self.surface.clone(), stiffness, |_, _| true)
    }
}

/// What is rigid near an organ, as it is found.
struct Near<'a> {
    contact: &'a Contact,
    labels: &'a Labels,
    /// Points of the organ's surface at rest.
    organ: Vec<Vector3<f64>>,
    key: String,
    name: String,
}

impl Near<'_> {
    fn key(&self, last: &str) -> String {
        format!("{}.{last}", self.key)
    }

    /// The smoothed field of labels, good within reach.
    fn field(&self, of: &[u16], reach: f64) -> Checked<LabelField> {
        let (contact, labels) = (self.contact, self.labels);
        let far = reach + BEYOND * contact.ball + SPREAD * contact.smoothing + MARGIN * labels.spacing.max();
        let bound = |one: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| {
            self.organ
                .iter()
                .copied()
                .reduce(|a, b| one(&a, &b))
                .unwrap_or_default()
        };
        let (low, high) = (bound(Vector3::inf), bound(Vector3::sup));
        let (map, voxels) = labels.around([&low.add_scalar(-far), &high.add_scalar(far)], of);
        let map = LabelMap { labels: &voxels, ..map };
        let smoothing = Smoothing {
            sigma: contact.smoothing,
            parts: Parts::All,
            fill_holes: true,
        };
        LabelField::new(&map, 1, &smoothing).map_err(|why| {
            invalid(
                self.key("with"),
                format!("{}: {why}", self.name),
                "labels near the organ, and less smoothing where they are thin",
            )
        })
    }

    fn surface(&self, field: Receded, organ: &[Vector3<f64>], reach: f64) -> Checked<LevelSet> {
        let surface = LevelSet::about(Arc::new(field), organ, reach, self.contact.ball);
        surface.map_err(|why| self.no_surface(&why, reach))
    }

    fn no_surface(&self, why: &NoSurface, reach: f64) -> scene::Invalid {
        match why {
            NoSurface::Empty => invalid(
                self.key("with"),
                format!("{}: none within {reach:.1} mm of it", self.name),
                "what the organ can come to",
            ),
            _ => invalid(self.key("ball"), why, "a larger ball, or a shorter stroke"),
        }
    }

    /// How deep the organ at rest is in it as it lies, mm, and the level of the field that is as far back.
    fn overlap(&self, field: &LabelField) -> Checked<(f64, f64)> {
        let inside: Vec<Vector3<f64>> = self.organ.iter().filter(|at| field.value(at) < 0.0).copied().collect();
        if inside.is_empty() {
            return Ok((0.0, 0.0));
        }
        let most = MOST_OVERLAP * self.labels.spacing.max();
        let as_it_lies = Receded {
            field: field.clone(),
            by: 0.0,
        };
        // What is deeper than the most has no foot so near, or one that is not its nearest: it is no less deep than told.
        let depth = match LevelSet::about(Arc::new(as_it_lies), &inside, most, self.contact.ball) {
            Ok(surface) => inside
                .iter()
                .map(|at| -surface.signed_distance(at).value)
                .fold(0.0, f64::max),
            Err(NoSurface::Empty) => f64::INFINITY,
            Err(why) => return Err(self.no_surface(&why, most)),
        };
        if depth > most {
            return Err(invalid(
                self.key("with"),
                format!("{}, in which it lies {} at rest", self.name, deep(depth)),
                format!(
                    "surfaces that overlap by a voxel at most, {most:.2} mm: the smoothing of one of them is too large"
                ),
            ));
        }
        Ok((depth, inside.iter().map(|at| -field.value(at)).fold(0.0, f64::max)))
    }

    /// # Errors
    /// An edge that is too thin at the organ itself: no state would be proved.
    fn proved(&self, surface: &LevelSet, at: &Vector3<f64>, gap: f64) -> Checked<()> {
        match surface.unproved_at_rest(at, gap) {
            None => Ok(()),
            Some(why) => {
                let place = self.labels.patient(at);
                Err(invalid(
                    self.key("ball"),
                    format!(
                        "{}, at ({:.1}, {:.1}, {:.1}) mm: {why}",
                        self.name, place.x, place.y, place.z
                    ),
                    "a ball that fits behind what the organ lies at: a smaller one, or more smoothing",
                ))
            }
        }
    }
}

/// A depth in words; infinite where no surface is near at all.
fn deep(depth: f64) -> String {
    match depth.is_finite() {
        true => format!("{depth:.2} mm deep"),
        false => "wholly".to_owned(),
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
