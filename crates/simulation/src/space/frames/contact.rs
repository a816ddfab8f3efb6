//! Contact on the root: the few nodes at the tube, out of all that it may reach.

use nalgebra::DMatrix;

use super::reduced::{Model, Reduced, Wanted};
use super::touch::Touches;
use crate::space::term::DEEPEST_PART;
use crate::space::tube::Tube;
use crate::sparse::Dense;

/// Points nearer than this part of the tube's least radius must take part; all up to the second one are taken when some new one comes near.
const NEAR_PART: f64 = 0.15;
const REACH_PART: f64 = 0.5;
/// How often points that turn out to be deep are taken in anew.
const MOST_TRIES: usize = 4;

/// All points that the tube may reach, and those that are at it.
#[derive(Debug, Clone)]
pub(super) struct Contact {
    pub(super) touches: Touches,
    local: Reduced,
    /// Of the local ones: their points among all.
    points: Vec<usize>,
    /// Nodes of the root in the order of their elimination; those at the tube last.
    order: Vec<usize>,
    /// The elimination of the nodes that are not at the tube, for this factor of the whole.
    others: Dense,
    factor: u64,
    rest: DMatrix<f64>,
}

impl Contact {
    pub(super) fn new(touches: Touches) -> Self {
        Self {
            touches,
            local: Reduced::default(),
            points: Vec::new(),
            order: Vec::new(),
            others: Dense::default(),
            factor: 0,
            rest: DMatrix::zeros(0, 0),
        }
    }

    /// Steps made in all.
    pub(super) fn steps(&self) -> usize {
        self.local.steps
    }

    /// The farthest that a point is from where it may be, mm: in the tube, or off it while it presses.
    pub(super) fn off(&self, pressures: &[f64], v: &[f64], tube: &Tube) -> f64 {
        let off = |(point, pressure): (usize, &f64)| {
            let distance = self.touches.distance(point, v, tube).value;
            if *pressure > 0.0 { distance.abs() } else { -distance }
        };
        pressures.iter().enumerate().map(off).fold(0.0, f64::max)
    }

    /// True where a point's way, by these changes of the root's unknowns, leads through what is deeper than half the radius in a tube: it might leave on
    /// the other side.
    pub(super) fn passes(&self, v: &[f64], step: &[f64], tube: &Tube) -> bool {
        let deepest = DEEPEST_PART * tube.least_radius();
        (0..self.touches.len()).any(|point| {
            let (at, way) = (self.touches.at(point, v), self.touches.displacement(point, step));
            // No point comes nearer than by its way; a way that is no number passes too.
            let (length, room) = (way.norm(), tube.signed_distance(&at).value + deepest);
            !length.is_finite() || length >= room && tube.is_crossed(&at, &way, deepest)
        })
    }

    /// Adds the forces of pressures, with the root's unknowns at `v`.
    pub(super) fn push(&self, pressures: &[f64], v: &[f64], tube: &Tube, forces: &mut [f64]) {
        for (point, pressure) in pressures.iter().enumerate().filter(|(_, p)| **p > 0.0) {
            let normal = self.touches.distance(point, v, tube).gradient;
            self.touches
                .push(point, &(normal * (pressure * self.touches.area(point))), forces);
        }
    }

    /// What depths cost in a comparison of states: twice the work of the pressures, or of their mean where a point has less (an
    /// exact penalty, Nocedal and Wright 2006, 15.4).
    pub(super) fn cost(&self, pressures: &[f64], v: &[f64], tube: &Tube) -> f64 {
        let pressing = || {
            self.points
                .iter()
                .map(|k| (self.touches.area(*k), pressures[*k]))
                .filter(|(_, p)| *p > 0.0)
        };
        let area: f64 = pressing().map(|(area, _)| area).sum();
        // Where no point presses yet, all depths cost nothing: the energy alone decides, and no step can be deeper than half the radius.
        let mean = pressing().map(|(area, p)| area * p).sum::<f64>() / area.max(f64::MIN_POSITIVE);
        let cost = |k: &usize| {
            let depth = (-self.touches.distance(*k, v, tube).value).max(0.0);
            2.0 * pressures[*k].max(mean) * self.touches.area(*k) * depth
        };
        self.points.iter().map(cost).sum()
    }

    /// The deepest point in a tube that is not among those at it, mm; 0 where none is.
    fn depth_of_others(&self, v: &[f64], tube: &Tube) -> f64 {
        let mut own = vec![false; self.touches.len()];
        self.points.iter().for_each(|point| own[*point] = true);
        let others = (0..own.len()).filter(|point| !own[*point]);
        let depth = |point| -self.touches.distance(point, v, tube).value;
        others.map(depth).fold(0.0, f64::max)
    }

    /// The points at the tube, by those of all.
    pub(super) fn points(&self) -> &[usize] {
        &self.points
    }

    /// The points at the tube alone, and the stiffness of the nodes that move them.
    pub(super) fn local(&self) -> (&Touches, &DMatrix<f64>) {
        (&self.local.touches, &self.rest)
    }

    /// The nodes at the tube.
    fn nodes(&self) -> &[usize] {
        &self.order[self.order.len() - self.local.touches.nodes()..]
    }

    /// The step of the root that balances the forces of factor number `factor` without depth, as far as it was found. `None` where there is none.
    pub(super) fn solve(
        &mut self,
        model: &Model<'_>,
        factor: u64,
        pressures: &mut [f64],
        v: &[f64],
        tube: &Tube,
        wanted: &Wanted,
    ) -> Option<Vec<f64>> {
        // Points at the tube are known only once the step is: those that turn out to be in it are taken in, and the step is made anew.
        let (mut around, mut part, mut last) = (v.to_vec(), REACH_PART, None);
        for _ in 0..MOST_TRIES {
            self.gather(model, factor, pressures, &around, tube, part)?;
            let mut x: Vec<f64> = self
                .order
                .iter()
                .flat_map(|n| &model.forces[3 * n..3 * n + 3])
                .copied()
                .collect();
            // Nodes that are not at the tube are eliminated by the same factor for all rounds of contact.
            self.others.forward(&mut x);
            let first = x.len() - 3 * self.local.touches.nodes();
            let own: Vec<f64> = self
                .nodes()
                .iter()
                .flat_map(|n| &v[3 * n..3 * n + 3])
                .copied()
                .collect();
            let local = Model {
                stiffness: &self.rest,
                forces: &x[first..],
            };
            // Off the tube there is nothing to solve for: the others' forces alone make the step.
            let y = match own.is_empty() {
                true => Vec::new(),
                false => self.local.solve(&local, &own, tube, wanted)?,
            };
            x[first..].copy_from_slice(&y);
            self.others.back(&mut x);
            let mut step = vec![0.0; x.len()];
            for (n, x) in self.order.iter().zip(x.chunks_exact(3)) {
                step[3 * n..3 * n + 3].copy_from_slice(x);
            }
            for (point, pressure) in self.points.iter().zip(&self.local.pressures) {
                pressures[*point] = *pressure;
            }
            around = v.iter().zip(&step).map(|(v, y)| v + y).collect();
            last = Some(step);
            // Depths of those that took part are the solution's own; of all others none may be in the tube unseen.
            if self.depth_of_others(&around, tube) <= wanted.depth {
                break;
            }
            part *= 2.0;
        }
        last
    }

    /// Takes in the points at the tube where one that is near, or that presses, is not among them yet.
    fn gather(
        &mut self,
        model: &Model<'_>,
        factor: u64,
        pressures: &[f64],
        v: &[f64],
        tube: &Tube,
        part: f64,
    ) -> Option<()> {
        let radius = tube.least_radius();
        let distances: Vec<f64> = (0..self.touches.len())
            .map(|point| self.touches.distance(point, v, tube).value)
            .collect();
        let mut known = vec![false; distances.len()];
        self.points.iter().for_each(|point| known[*point] = true);
        // Twofold reach: who comes near must take part, and who takes part was taken from farther away, so that the elimination serves several frames.
        let missing = |k: usize| !known[k] && (distances[k] < NEAR_PART * radius || pressures[k] > 0.0);
        let renewed = self.factor == 0 || (0..distances.len()).any(missing);
        if renewed {
            let wanted = |k: &usize| distances[*k] < part * radius || pressures[*k] > 0.0;
            self.points = (0..distances.len()).filter(wanted).collect();
            let (touches, nodes) = self.touches.only(&self.points);
            self.local.touches = touches;
            let mut at_tube = vec![false; self.touches.nodes()];
            nodes.iter().for_each(|n| at_tube[*n] = true);
            self.order = (0..at_tube.len()).filter(|n| !at_tube[*n]).chain(nodes).collect();
        }
        self.local.pressures = self.points.iter().map(|k| pressures[*k]).collect();
        if renewed || self.factor != factor {
            let unknowns: Vec<usize> = self.order.iter().flat_map(|n| 3 * n..3 * n + 3).collect();
            let size = unknowns.len();
            let ordered = DMatrix::from_fn(size, size, |i, j| model.stiffness[(unknowns[i], unknowns[j])]);
            // None until it is whole: what fails half way must not be taken for one.
            self.factor = 0;
            if !self.others.eliminate(&ordered, size - 3 * self.local.touches.nodes()) {
                return None;
            }
            self.others.rest(&mut self.rest);
            self.factor = factor;
        }
        Some(())
    }
}
