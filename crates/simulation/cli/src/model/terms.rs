//! The constraints of a model as terms of its energy, made anew for each place of the walls.

use simulation::constraint::{Constraint, HalfPlane, HalfPlaneBarrier, SolidBarrier};

use super::{Model, Wall};
use crate::scene::raw::RawWalls;

/// Stiffness of the terms of exact walls, in stiffnesses of the solids: it decides how fast their forces settle.
const HOLD: f64 = 100.0;
/// Widths of a wall's barrier in sizes of the largest solid, where the scene has no contact with widths of its own.
const WIDTHS: [f64; 2] = [1e-2, 1e-3];

/// Who makes a force of contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Maker {
    /// A wall, by its index.
    Wall(usize),
    /// A link, by its index.
    Link(usize),
    /// A solid against a solid.
    Touch,
    /// A force that is given.
    Given,
}

impl Model {
    /// Widths of barriers, at first and at last.
    pub(crate) fn widths(&self) -> [f64; 2] {
        let extent = self.system.bodies.extent();
        self.touch.map_or(WIDTHS.map(|w| w * extent), |touch| touch.widths)
    }

    /// Puts the terms of all constraints into the system. `first`: from a start that may be far from contact.
    pub(crate) fn constrain(&mut self, first: bool) -> Vec<Maker> {
        let mut terms: Vec<Box<dyn Constraint>> = Vec::new();
        let mut makers = Vec::new();
        for (k, wall) in self.walls.iter().enumerate() {
            terms.extend(self.wall(wall, first));
            makers.push(Maker::Wall(k));
        }
        for (k, link) in self.links.iter().enumerate() {
            terms.push(Box::new(*link));
            makers.push(Maker::Link(k));
        }
        for lever in &self.levers {
            terms.push(Box::new(*lever));
            makers.push(Maker::Given);
        }
        if let Some(touch) = self.touch.filter(|_| self.solids.len() > 1 || self.pairs.is_some()) {
            let [wide, narrow] = touch.widths;
            let wide = if first { wide } else { narrow };
            let pairs = SolidBarrier::new(wide, narrow, touch.stiffness);
            terms.push(Box::new(match &self.pairs {
                Some(named) => pairs.among(named),
                None => pairs,
            }));
            makers.push(Maker::Touch);
        }
        self.system.terms = terms;
        makers
    }

    fn wall(&self, wall: &Wall, first: bool) -> Option<Box<dyn Constraint>> {
        let (bodies, hold) = (&self.system.bodies, HOLD * self.stiffness);
        if self.how == RawWalls::Exact || (self.how == RawWalls::BarrierThenExact && !first) {
            let plane = HalfPlane::new(bodies, &wall.keeps, wall.normal, wall.offset, hold)?;
            return Some(Box::new(plane));
        }
        let guard = self.guard(wall, first)?;
        Some(match self.how {
            RawWalls::BarrierThenExact => Box::new(guard.then_exact()),
            _ => Box::new(guard),
        })
    }

    fn guard(&self, wall: &Wall, first: bool) -> Option<HalfPlaneBarrier> {
        let [wide, narrow] = self.widths();
        let widths = [if first { wide } else { narrow }, narrow];
        let stiffness = self.touch.map_or(0.1 * self.stiffness, |touch| touch.stiffness);
        HalfPlaneBarrier::new(
            &self.system.bodies,
            &wall.keeps,
            wall.normal,
            wall.offset,
            widths,
            stiffness,
        )
    }

    /// How far a wall may advance: to half its distance from the nearest solid behind a barrier, else anywhere.
    pub(crate) fn room(&self, wall: usize, a: &[f64]) -> f64 {
        if self.how != RawWalls::Barrier {
            return f64::INFINITY;
        }
        let guard = self.guard(&self.walls[wall], false);
        guard.map_or(f64::INFINITY, |guard| {
            0.5 * guard.least_gap(&self.system.bodies, a).max(0.0)
        })
    }
}
