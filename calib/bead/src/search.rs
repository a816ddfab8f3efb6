//! What is looked for.

use super::Ground;

/// The beads looked for, and the thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Least and greatest radius, mm.
    pub radius_mm: [f64; 2],
    /// Least HU of the beads' metal over their surroundings, before the scanner's blur and clipping.
    pub metal_hu: f64,
    /// The HU at which the scanner clips; `None`: found from the volume.
    pub clip_hu: Option<i16>,
    /// Least value of chi (5.3).
    pub least_chi: f64,
    /// What lies around a bead, for its centre.
    pub ground: Ground,
}

impl Search {
    /// The largest radius, mm: beyond it a thing is no bead.
    pub const MAX_RADIUS_MM: f64 = 10.0;
    /// The least HU of metal that is accepted.
    pub const LEAST_METAL_HU: f64 = 1000.0;
    /// How far radii may lie from the nominal one where only that is given.
    pub const RADIUS_RANGE: f64 = 1.25;

    /// Beads of about this radius, mm, and the defaults: 6000 HU (titanium; steel and tantalum have more), chi of 1.5:
    /// with bone around, a bead's is as low as 2, and what is no bead is refused by the model.
    pub fn of_radius(radius_mm: f64) -> Self {
        Self {
            radius_mm: [radius_mm / Self::RADIUS_RANGE, radius_mm * Self::RADIUS_RANGE],
            metal_hu: 6000.0,
            clip_hu: None,
            least_chi: 1.5,
            ground: Ground::default(),
        }
    }

    /// The nominal radius: the middle of the range, mm.
    pub(super) fn radius(&self) -> f64 {
        (self.radius_mm[0] * self.radius_mm[1]).sqrt()
    }
}
