//! The field of a plate in the file of a camera.

use nalgebra::Vector2;
use optics::camera::{Plate, REACH};
use serde::{Deserialize, Serialize};

use super::read::Seen;

/// A smooth field by which the discs lie off their places, the same in all views.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FieldRecord {
    /// The deviation of the random field, in height and of each axis in the plane, mm, before what pose, bend and focal lengths
    /// say is taken out of it.
    pub sizes_mm: [f64; 2],
    /// Over such a distance it changes, mm.
    pub reach_mm: f64,
    /// How many of its numbers the views fix.
    pub fixed: f64,
    /// Place on the grid (2), where the disc lies from there, the height with the bend (3), the deviations of that (3): mm.
    pub discs: Vec<[f64; 8]>,
}

impl FieldRecord {
    /// None without a field.
    pub(super) fn of(plate: &Plate, seen: &Seen) -> Option<Self> {
        let field = plate.field.as_ref()?;
        let sightings = seen.images.iter().flat_map(|image| &image.view.sightings);
        let mut places: Vec<Vector2<f64>> = sightings.map(|s| s.at_mm).collect();
        places.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
        places.dedup();
        let disc = |at: &Vector2<f64>| {
            let (off, sigma) = (plate.offset_mm(*at), plate.deviation_mm(*at));
            [at.x, at.y, off.x, off.y, off.z, sigma.x, sigma.y, sigma.z]
        };
        Some(Self {
            sizes_mm: field.sizes_mm,
            reach_mm: REACH * plate.ruler_mm().1,
            fixed: field.fixed,
            discs: places.iter().map(disc).collect(),
        })
    }
}
