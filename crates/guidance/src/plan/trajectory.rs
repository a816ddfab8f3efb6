//! The numbers of a planned way.

use geometry::{Ct, Direction, Point};

use super::Target;

/// The way of the tube from its entry to where it stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trajectory {
    /// Where the tube enters.
    pub entry: Point<Ct>,
    /// Where its tip stops.
    pub stop: Point<Ct>,
    /// From the entry towards the target's centre.
    pub axis: Direction<Ct>,
    /// From the entry to where the tip stops, mm: how deep the tube goes.
    pub depth_mm: f64,
}

impl Trajectory {
    /// That of a target of a plan; `None` where it has no entry.
    pub fn of(target: &Target) -> Option<Self> {
        let entry = target.entry?;
        let axis = (target.centre - entry).direction()?;
        Some(Self {
            entry,
            stop: target.centre - axis * target.stop_mm,
            axis,
            depth_mm: entry.distance(target.centre) - target.stop_mm,
        })
    }

    /// The angle between the tube and the axial plane, -pi/2 to pi/2, rad: positive where the tube goes towards the head.
    pub fn to_head_rad(&self) -> f64 {
        let [x, y, z] = self.axis.components();
        z.atan2(x.hypot(y))
    }

    /// On the axial plane, the angle between the tube and the straight way from front to back, -pi to pi, rad: positive where the tube goes
    /// towards the patient's left. `None` within a thousandth of a degree of the body's long axis, where there is no such angle.
    pub fn to_left_rad(&self) -> Option<f64> {
        let [x, y, _] = self.axis.components();
        (x.hypot(y) > 1.75e-5).then(|| x.atan2(y))
    }

    /// The point so far from the entry, mm.
    pub fn at(&self, depth_mm: f64) -> Point<Ct> {
        self.entry + self.axis * depth_mm
    }
}
