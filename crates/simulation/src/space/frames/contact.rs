//! Contact in one step: the points at the tube and at bones, out of all that may come there.

use std::sync::Arc;

use super::around::Around;
use super::factors::Factor;
use super::near::{Near, Tissue};
use super::norm;
use super::reduced::{Problem, Pushed, Reduced, Wanted};
use super::touch::Touches;
use crate::space::term::{DEEPEST_PART, depth_or_all};

/// Points nearer than this part of the least radius must take part; all up to the second one are taken when some new one comes near.
const NEAR_PART: f64 = 0.15;
const REACH_PART: f64 = 0.5;
/// Parts of steps sum to one up to so much rounding.
const WHOLE_ROUNDING: f64 = 1e-9;
/// How often points that turn out to be deep are taken in anew.
const MOST_TRIES: usize = 4;

/// All points that may touch something, and the search for their pressures.
#[derive(Debug, Clone)]
pub(super) struct Contact {
    pub(super) touches: Arc<Touches>,
    local: Reduced,
}

impl Contact {
    pub(super) fn new(touches: Arc<Touches>) -> Self {
        Self {
            touches,
            local: Reduced::default(),
        }
    }

    /// Steps made in all.
    pub(super) fn steps(&self) -> usize {
        self.local.steps
    }

    /// Whether the step found last is a whole one; else no step, or a part of one, was all that was found.
    pub(super) fn is_whole(&self) -> bool {
        self.local.part > 1.0 - WHOLE_ROUNDING
    }

    /// The farthest that a point is from where it may be, mm: in the tube or bone, or off it while it presses.
    pub(super) fn off(&self, pressures: &[f64], v: &[f64], around: &Around<'_>) -> f64 {
        let off = |(point, pressure): (usize, &f64)| match *pressure > 0.0 {
            true => self.touches.distance(point, v, around).value.abs(),
            false => self.depth(point, v, around),
        };
        pressures
            .iter()
            .enumerate()
            .map(off)
            .map(depth_or_all)
            .fold(0.0, f64::max)
    }

    /// How deep a point is in what it may touch, mm; 0 outside.
    fn depth(&self, point: usize, v: &[f64], around: &Around<'_>) -> f64 {
        let near = self.touches.within(point, v, around, 0.0);
        near.map_or(0.0, |distance| depth_or_all(-distance.value).max(0.0))
    }

    /// True where a point's way, by these changes of the unknowns, leads through what is deeper than half the radius: it might leave on
    /// the other side.
    pub(super) fn passes(&self, v: &[f64], step: &[f64], around: &Around<'_>) -> bool {
        (0..self.touches.len()).any(|point| {
            let (at, way) = (self.touches.at(point, v), self.touches.displacement(point, step));
            let with = self.touches.with(point);
            let deepest = DEEPEST_PART * around.rigid(with).radius();
            // No point comes nearer than by its way; a way that is no number passes too.
            let length = way.norm();
            let near = around.within(with, &at, length - deepest);
            let comes_near = near.is_some_and(|distance| length >= distance.value + deepest);
            !length.is_finite() || comes_near && (with > 0 || around.tube.is_crossed(&at, &way, deepest))
        })
    }

    /// The forces of pressures, with the unknowns of the touches at `v`; and of each solid the length of those of the tube, or where it does not
    /// press of all.
    pub(super) fn push(&self, pressures: &[f64], v: &[f64], around: &Around<'_>) -> (Vec<f64>, Vec<f64>) {
        let mut forces = vec![0.0; v.len()];
        let mut own = self.touches.lengths(&forces);
        let pressing = pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
        // Points at the tube come first: what bone carries may be far more than the tube presses.
        for (point, pressure) in pressing {
            if self.touches.with(point) > 0 && own.iter().all(|own| *own == 0.0) {
                own = self.touches.lengths(&forces);
            }
            let normal = self.touches.distance(point, v, around).gradient;
            let force = normal * (pressure * self.touches.area(point));
            self.touches.push(point, &force, &mut forces);
        }
        for (own, all) in own.iter_mut().zip(self.touches.lengths(&forces)) {
            *own = if *own > 0.0 { *own } else { all };
        }
        (forces, own)
    }

    /// What depths cost in a comparison of states: twice the work of the pressures, or of their mean where a point has less (an
    /// exact penalty, Nocedal and Wright 2006, 15.4).
    pub(super) fn cost(&self, pressures: &[f64], v: &[f64], around: &Around<'_>) -> f64 {
        let pressing = || {
            let each = pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
            each.map(|(k, p)| (self.touches.area(k), *p))
        };
        let area: f64 = pressing().map(|(area, _)| area).sum();
        // Where no point presses yet, all depths cost nothing: the energy alone decides, and no step can be deeper than half the radius.
        let mean = pressing().map(|(area, p)| area * p).sum::<f64>() / area.max(f64::MIN_POSITIVE);
        let cost = |(k, p): (usize, &f64)| 2.0 * p.max(mean) * self.touches.area(k) * self.depth(k, v, around);
        pressures.iter().enumerate().map(cost).sum()
    }

    /// The points that press, or are nearer than this part of the least radius.
    fn near(&self, pressures: &[f64], v: &[f64], around: &Around<'_>, part: f64) -> impl Iterator<Item = usize> {
        let most = part * around.tube.least_radius();
        (0..self.touches.len()).filter(move |point| {
            let near = || self.touches.within(*point, v, around, most);
            pressures[*point] > 0.0 || near().is_some_and(|distance| distance.value < most)
        })
    }

    /// The points that a factor is to serve which is made from this state on.
    pub(super) fn around(&self, pressures: &[f64], v: &[f64], around: &Around<'_>) -> Vec<usize> {
        self.near(pressures, v, around, REACH_PART).collect()
    }

    /// The deepest point that is not among those at the tube and at bones, mm; 0 where none is.
    fn depth_of_others(&self, near: &Near, v: &[f64], around: &Around<'_>) -> f64 {
        let others = (0..self.touches.len()).filter(|point| near.index(*point).is_none());
        others.map(|point| self.depth(point, v, around)).fold(0.0, f64::max)
    }

    /// The step of all unknowns that balances the free forces `forces` without depth, as far as it was found. `None` where there is none.
    pub(super) fn solve(
        &mut self,
        factor: &mut Factor,
        forces: &[f64],
        pressures: &mut [f64],
        v: &[f64],
        around: &Around<'_>,
        wanted: &Wanted,
    ) -> Option<Vec<f64>> {
        // The step without contact, by which points at the tube begin.
        let mut free = forces.to_vec();
        factor.ldl.solve(&mut free);
        let (mut own, mut moved) = (Vec::new(), Vec::new());
        self.touches.take(forces, &mut own);
        self.touches.take(&free, &mut moved);
        let work = forces.iter().zip(&free).map(|(f, y)| f * y).sum();
        let others = (norm(forces).powi(2) - norm(&own).powi(2)).max(0.0).sqrt();
        // Points at the tube are known only once the step is: those that turn out to be in it are taken in, and the step is made anew.
        let (mut to, mut part, mut last) = (v.to_vec(), REACH_PART, None);
        for _ in 0..MOST_TRIES {
            self.gather(factor, pressures, &to, around, part);
            let near = &factor.near;
            let places: Vec<_> = near.points().iter().map(|k| self.touches.at(*k, v)).collect();
            let each = near.points().iter().zip(&places);
            let problem = Problem {
                tissue: Tissue {
                    ldl: &factor.ldl,
                    touches: &self.touches,
                },
                near,
                clearances: each
                    .map(|(k, at)| around.clearance(self.touches.with(*k), at))
                    .collect(),
                places,
                around,
                free: near
                    .points()
                    .iter()
                    .flat_map(|k| self.touches.displacement(*k, &moved).data.0[0])
                    .collect(),
                own: own.clone(),
                others,
                work,
            };
            self.local.pressures = near.points().iter().map(|k| pressures[*k]).collect();
            let pushed = self.local.solve(&problem, &mut factor.active, wanted)?;
            for (point, pressure) in near.points().iter().zip(&self.local.pressures) {
                pressures[*point] = *pressure;
            }
            let step = self.step(factor, &free, &pushed);
            self.touches.take(&step, &mut to);
            to.iter_mut().zip(v).for_each(|(to, v)| *to += v);
            last = Some(step);
            // Depths of those that took part are the solution's own; of all others none may be in the tube unseen.
            if self.depth_of_others(near, &to, around) <= wanted.depth {
                break;
            }
            part *= 2.0;
        }
        last
    }

    /// So much of the step without contact, and that of forces on the points at the tube.
    fn step(&self, factor: &Factor, free: &[f64], pushed: &Pushed) -> Vec<f64> {
        let mut step = vec![0.0; free.len()];
        let mut own = vec![0.0; self.touches.unknowns()];
        self.touches.push_all(factor.near.points(), &pushed.forces, &mut own);
        self.touches.add(&own, &mut step);
        factor.ldl.solve(&mut step);
        step.iter_mut()
            .zip(free)
            .for_each(|(step, free)| *step += pushed.part * free);
        step
    }

    /// Takes in the points at the tube where one that is near, or that presses, is not among them yet.
    fn gather(&self, factor: &mut Factor, pressures: &[f64], v: &[f64], around: &Around<'_>, part: f64) {
        // Twofold reach: who comes near must take part, and who takes part was taken from farther away, so that a compliance serves several frames.
        let missing = |point: usize| factor.near.index(point).is_none();
        if self.near(pressures, v, around, NEAR_PART).any(missing) {
            let points = self.near(pressures, v, around, part).collect();
            factor.serve(&self.touches, points, &[]);
        }
    }
}
