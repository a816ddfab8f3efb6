//! Pressures at points of a surface as multipliers of `gap >= 0`, by the augmented Lagrangian.
//!
//! The energy `sum of A / (2 k) (max(0, p - k gap)^2 - p^2)` is minimised and `p` becomes `max(0, p - k gap)`, in turns. Its limit
//! is exact: no depth is left that a stiffness would have to hold, and no pressure where there is a gap.

use nalgebra::Vector3;

use crate::space::solid::Solid;

/// A round that leaves more than this part of the depth asks for more stiffness: so much of it, and so much in all.
const SLOW_PART: f64 = 0.25;
const STIFFENED: f64 = 3.0;
const MOST_STIFFENED: f64 = 1e4;
/// Changes below this part of a point's largest force are not worth it.
const SMALL_CHANGE: f64 = 1e-7;

/// A stiffness of contact that is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the stiffness of contact is {found}; it must be finite and above 0")]
pub struct BadStiffness {
    /// The number found.
    pub found: f64,
}

/// A point of the surface that may touch something.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub(super) point: usize,
    pub(super) area: f64,
    /// Half of the way to the next at rest, mm.
    pub(super) gap: f64,
    pub(super) pressure: f64,
}

/// Points with their pressures.
#[derive(Debug, Clone)]
pub(super) struct Pressures {
    pub(super) touches: Vec<Touch>,
    /// Stress by length: the one asked for, and the one at work.
    stiffness: [f64; 2],
    /// What the last round left: depth, mm, and change of a force.
    left: [f64; 2],
}

impl Pressures {
    /// None yet, at the points of a solid's surface for which `wanted(reference place, normal)` holds.
    pub(super) fn new(
        solid: &dyn Solid,
        stiffness: f64,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, BadStiffness> {
        // With less than none, points would be drawn in; with none, pressures would never change.
        if !(stiffness.is_finite() && stiffness > 0.0) {
            return Err(BadStiffness { found: stiffness });
        }
        let touches = (0..solid.points()).filter_map(|point| {
            let (at, normal, area) = solid.reference(point);
            wanted(&at, &normal).then_some(Touch {
                point,
                area,
                gap: solid.gap(point),
                pressure: 0.0,
            })
        });
        Ok(Self {
            touches: touches.collect(),
            stiffness: [stiffness; 2],
            left: [f64::INFINITY; 2],
        })
    }

    /// Begins anew with the pressures at hand as a first guess.
    pub(super) fn restart(&mut self) {
        self.stiffness[1] = self.stiffness[0];
        self.left = [f64::INFINITY; 2];
    }

    /// The stiffness at work.
    pub(super) fn stiffness(&self) -> f64 {
        self.stiffness[1]
    }

    /// The energy; calls `each` with points that press, their pressure at work and what `gap` found. `gap` may leave out
    /// points without a pressure that are outside.
    pub(super) fn visit<G>(
        &self,
        gap: impl Fn(&Touch) -> Option<(f64, G)>,
        mut each: impl FnMut(&Touch, f64, &G),
    ) -> Option<f64> {
        let (stiffness, mut energy) = (self.stiffness[1], 0.0);
        for touch in &self.touches {
            let half = 0.5 * touch.area / stiffness;
            if let Some((gap, found)) = gap(touch) {
                // A distance that is no number must not pass for one that is far.
                if gap.is_nan() {
                    return None;
                }
                let pressure = touch.pressure - stiffness * gap;
                if pressure > 0.0 {
                    energy += half * pressure * pressure;
                    each(touch, pressure, &found);
                }
            }
            energy -= half * touch.pressure * touch.pressure;
        }
        Some(energy).filter(|e| e.is_finite())
    }

    /// Takes the pressures at work as those to go on from; calls `each` with those that change, by how much, and what `gap` found,
    /// and with nothing found where a pressure ends. `depth` says how deep what was found is. The deepest.
    pub(super) fn update<G>(
        &mut self,
        gap: impl Fn(&Touch) -> Option<(f64, G)>,
        depth: impl Fn(f64, &G) -> f64,
        mut each: impl FnMut(&Touch, f64, Option<&G>),
    ) -> f64 {
        let (stiffness, mut deepest) = (self.stiffness[1], 0.0_f64);
        for touch in &mut self.touches {
            let found = gap(touch);
            let new = found.as_ref().map_or(0.0, |(gap, found)| {
                deepest = deepest.max(depth_or_all(depth(*gap, found)));
                (touch.pressure - stiffness * gap).max(0.0)
            });
            let more = new - touch.pressure;
            if more != 0.0 {
                each(touch, more, found.as_ref().map(|(_, found)| found));
            }
            touch.pressure = new;
        }
        deepest
    }

    /// Raises the stiffness where a round leaves much of the depth, mm, or of the change of a force, that the last one left.
    pub(super) fn stiffen(&mut self, depth: f64, change: f64) {
        let largest = self.touches.iter().map(|touch| touch.area * touch.pressure);
        let noise = SMALL_CHANGE * largest.fold(0.0, f64::max);
        // Where points are more than their unknowns can follow, depths shrink only as pressures outgrow one another.
        let slow = depth > SLOW_PART * self.left[0] || change > noise.max(SLOW_PART * self.left[1]);
        if slow && self.stiffness[1] < MOST_STIFFENED * self.stiffness[0] {
            self.stiffness[1] *= STIFFENED;
        }
        self.left = [depth, change];
    }
}

/// A depth; one that is no number is deeper than any.
pub(in crate::space) fn depth_or_all(depth: f64) -> f64 {
    if depth.is_nan() { f64::INFINITY } else { depth }
}
