//! Contact by the compliance of the points at the tube: forces `g` on these, and with them the step, for which no point is deep.
//!
//! The problem of a step is `min 1/2 y^T A y - b^T y` over `distance(points(v + y)) >= 0`. All that contact does to it is `B^T g`, forces on the
//! points near the tube. From `y = 0` on Newton's method goes through `y = t A^-1 b + A^-1 B^T g` only, with a part `t` that becomes 1: points are moved by
//! `t d + W g`, where `d = B A^-1 b` and `W = B A^-1 B^T`, and the energy is `1/2 g^T W g - (1 - t) g^T d + (t^2 / 2 - t) b^T A^-1 b`. Pressures by the augmented Lagrangian, as in [`crate::space::term::TubeContact`]; here a round costs no sparse solution, and a step
//! of Newton's method as many equations as directions that press (`pressed`).

use nalgebra::Vector3;

use super::around::Around;
use super::near::{Active, Near, Tissue};
use super::norm;
use super::pressed::Pressed;
use crate::space::tube::Distance;

/// Stiffness of contact times the mean compliance of a point, at first.
const STIFFNESS_PART: f64 = 1e4;
/// A round that leaves more than this part of the last one's change asks for more, so much of it, and so much in all: where tissue all
/// but slips off the tube, forces of rounds grow until contact is stiff enough.
const SLOW_PART: f64 = 0.25;
const STIFFENED: f64 = 10.0;
const MOST_STIFFENED: f64 = 1e5;
/// Roundings of a place in a distance: of the sum over nodes, and of turning it into the tube's frame.
const ROUNDINGS: f64 = 8.0;
/// Distances and ways are rounded, far less than this; a bound that fails by rounding leaves out what is at the surface to rounding.
const WAY_ROUNDING: f64 = 1e-9;
/// Rounds of pressures, and steps in each, at most.
const MOST_ROUNDS: usize = 20;
const MOST_STEPS: usize = 30;
const MOST_HALVINGS: usize = 20;

/// The quadratic problem.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    pub(super) tissue: Tissue<'a>,
    pub(super) near: &'a Near,
    /// Where the points near the tube begin.
    pub(super) places: Vec<Vector3<f64>>,
    /// Lower bounds of their distances there.
    pub(super) clearances: Vec<f64>,
    pub(super) around: &'a Around<'a>,
    /// How the step without contact moves them, three each.
    pub(super) free: Vec<f64>,
    /// `b` on the unknowns of the touches, its length on all others, and its work on the step without contact.
    pub(super) own: Vec<f64>,
    pub(super) others: f64,
    pub(super) work: f64,
}

/// How exact an answer must be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Free forces, a length.
    pub(super) force: f64,
    /// Depth, mm.
    pub(super) depth: f64,
}

/// Pressures of the points near the tube.
#[derive(Debug, Clone, Default)]
pub(super) struct Reduced {
    /// Stress at each point.
    pub(super) pressures: Vec<f64>,
    /// Stress by length.
    stiffness: f64,
    pressed: Pressed,
    /// How much of the step without contact is in the step found last: all of it, where one was found.
    pub(super) part: f64,
    /// Steps made in all.
    pub(super) steps: usize,
}

/// A step: so much of that without contact, and forces on the points, three each.
#[derive(Debug, Clone)]
pub(super) struct Pushed {
    pub(super) part: f64,
    pub(super) forces: Vec<f64>,
    /// How that moves the points.
    moved: Vec<f64>,
}

/// A step, and what it comes to.
#[derive(Debug, Clone)]
struct At {
    step: Pushed,
    /// Of model and pressures.
    energy: f64,
    /// What pressures would have them be, less what they are: zero in balance.
    free: Vec<f64>,
    /// The length of the free forces on the unknowns.
    off: f64,
}

impl Problem<'_> {
    fn len(&self) -> usize {
        self.places.len()
    }

    fn area(&self, k: usize) -> f64 {
        self.tissue.touches.area(self.near.points()[k])
    }

    fn with(&self, k: usize) -> usize {
        self.tissue.touches.with(self.near.points()[k])
    }

    /// The distance of a point, left out where it presses neither by `pressure` nor by depth.
    fn distance(&self, k: usize, moved: &[f64], pressure: f64) -> Option<Distance> {
        let way = Vector3::from_column_slice(&moved[3 * k..3 * k + 3]);
        // A distance changes by no more than the way: most points are out of reach whatever a round does.
        if pressure <= 0.0 && self.clearances[k] > (1.0 + WAY_ROUNDING) * way.norm() {
            return None;
        }
        let most = if pressure > 0.0 { f64::INFINITY } else { 0.0 };
        self.around.within(self.with(k), &(self.places[k] + way), most)
    }

    /// The work of `b` on a step.
    fn work_of(&self, step: &Pushed) -> f64 {
        step.part * self.work + dot(&step.forces, &self.free)
    }

    /// The length of forces on points, and of this part of `b`, as forces on the unknowns: patterns that push nothing have none.
    fn length(&self, forces: &[f64], part: f64) -> f64 {
        let mut own: Vec<f64> = self.own.iter().map(|b| part * b).collect();
        self.tissue.touches.push_all(self.near.points(), forces, &mut own);
        norm(&own).hypot(part * self.others)
    }
}

impl Pushed {
    /// No force, and this part of the step without contact: of that either nothing, or nothing is moved.
    fn none(size: usize, part: f64) -> Self {
        Self {
            part,
            forces: vec![0.0; size],
            moved: vec![0.0; size],
        }
    }

    /// `self + t step`.
    fn plus(&self, step: &Self, t: f64) -> Self {
        Self {
            part: self.part + t * step.part,
            forces: plus(&self.forces, &step.forces, t),
            moved: plus(&self.moved, &step.moved, t),
        }
    }
}

impl Reduced {
    /// The step that balances the model without depth, or as far as rounds and steps led towards it; pressures are those
    /// of the last round. `None` where it is not finite.
    pub(super) fn solve(&mut self, problem: &Problem<'_>, active: &mut Active, wanted: &Wanted) -> Option<Pushed> {
        let (count, mean) = (problem.len(), problem.near.mean());
        // Points that nothing moves have nothing to solve for.
        if !(mean > 0.0 && mean.is_finite()) {
            self.part = 1.0;
            return (mean == 0.0).then(|| Pushed::none(3 * count, 1.0));
        }
        // A stiffness of contact in the scale of what it presses: as soft as rounding lets it converge, as stiff as few rounds need.
        let mean_area = (0..count).map(|k| problem.area(k)).sum::<f64>() / count as f64;
        let first = STIFFNESS_PART / (mean * mean_area);
        self.stiffness = first;
        let mut at = self.evaluate(problem, Pushed::none(3 * count, 0.0));
        let (mut last, mut force) = (f64::INFINITY, wanted.force);
        for _ in 0..MOST_ROUNDS {
            let (floor, steps) = (self.rounding(problem), self.steps);
            // Forces that do not balance all the way still lead on: the energy of the whole decides how far.
            if self.balance(problem, active, force.max(floor), &mut at).is_none() {
                break;
            }
            let (change, depth) = self.update(problem, &at.step.moved);
            if change <= force.max(floor) && depth <= wanted.depth {
                break;
            }
            if self.steps == steps {
                // Forces balance well enough for no step, but not for the depth.
                force *= SLOW_PART;
            } else if change > SLOW_PART * last && self.stiffness < MOST_STIFFENED * first {
                self.stiffness *= STIFFENED;
            }
            last = change;
            at = self.evaluate(problem, at.step);
        }
        // Whoever is told of the step's length must know whether it is the whole one.
        self.part = at.step.part;
        at.step.forces.iter().all(|g| g.is_finite()).then_some(at.step)
    }

    /// What rounding leaves of the forces: of places, times the stiffness of contact.
    fn rounding(&self, problem: &Problem<'_>) -> f64 {
        // Points that do not press have no forces to round.
        let pressing = (0..problem.len()).filter(|k| self.pressures[*k] > 0.0);
        let places = pressing.map(|k| (problem.area(k), problem.places[k].amax()));
        let (area, far) = places.fold((0.0, 0.0_f64), |(area, far), (a, x)| (area + a * a, far.max(x)));
        ROUNDINGS * f64::EPSILON * self.stiffness * far * area.sqrt()
    }

    /// Newton's method with these pressures.
    fn balance(&mut self, problem: &Problem<'_>, active: &mut Active, force: f64, at: &mut At) -> Option<()> {
        for _ in 0..MOST_STEPS {
            // No step at all would leave what contact has no part in, however little that is.
            if at.off <= force && at.step.part > 0.0 {
                return Some(());
            }
            // Forces that are small enough cost no step: rounds near the end are updates of pressures alone.
            self.steps += 1;
            let step = self.newton(problem, active, at)?;
            let slope = -problem.work_of(&step) * (1.0 - at.step.part) - dot(&at.free, &step.moved);
            *at = (0..MOST_HALVINGS as i32).find_map(|k| {
                let t = 0.5_f64.powi(k);
                let there = self.evaluate(problem, at.step.plus(&step, t));
                // Near the end energies differ by rounding only: less force is enough there.
                let lower = there.energy <= at.energy + 1e-4 * t * slope || there.off <= 0.5 * at.off;
                lower.then_some(there)
            })?;
        }
        None
    }

    /// Energy and free forces of model and pressures.
    fn evaluate(&self, problem: &Problem<'_>, step: Pushed) -> At {
        let Pushed { part, forces, moved } = &step;
        let mut energy =
            0.5 * dot(forces, moved) + (0.5 * part - 1.0) * (dot(forces, &problem.free) + part * problem.work);
        let mut free: Vec<f64> = forces.iter().map(|g| -g).collect();
        for (k, old) in self.pressures.iter().enumerate() {
            let half = 0.5 * problem.area(k) / self.stiffness;
            energy -= half * old * old;
            let Some(distance) = problem.distance(k, moved, *old) else {
                continue;
            };
            let pressure = (old - self.stiffness * distance.value).max(0.0);
            energy += half * pressure * pressure;
            let pushed = distance.gradient * (problem.area(k) * pressure);
            (0..3).for_each(|c| free[3 * k + c] += pushed[c]);
        }
        At {
            off: problem.length(&free, 1.0 - part),
            step,
            energy,
            free,
        }
    }

    /// Newton's step: with the bend of the tube, or where that leaves no definite matrix without it.
    fn newton(&mut self, problem: &Problem<'_>, active: &mut Active, at: &At) -> Option<Pushed> {
        let (near, part) = (problem.near, 1.0 - at.step.part);
        let mut pressing = Vec::new();
        for (k, old) in self.pressures.iter().enumerate() {
            if let Some(distance) = problem.distance(k, &at.step.moved, *old) {
                let (pressure, area) = (old - self.stiffness * distance.value, problem.area(k));
                if pressure > 0.0 {
                    let number = active.take(&problem.tissue, near, k);
                    pressing.push((number, distance, area * self.stiffness, area * pressure));
                }
            }
        }
        // Points that a force was on before and is on no more.
        for (k, free) in at.free.chunks_exact(3).enumerate() {
            if free.iter().any(|f| *f != 0.0) {
                active.take(&problem.tissue, near, k);
            }
        }
        let pressed = &mut self.pressed;
        let mut definite = |bent: &bool| pressed.take(pressing.iter().copied(), *bent, active);
        if ![true, false].iter().any(&mut definite) {
            return None;
        }
        let mut forces = at.free.clone();
        let mut held = active.of_all(&forces);
        let mut moved = active.moved(&held);
        for (moved, k) in moved.iter_mut().zip(active.points()) {
            *moved += Vector3::from_column_slice(&problem.free[3 * k..3 * k + 3]) * part;
        }
        for (number, spring) in self.pressed.holding(&moved) {
            held[number] -= spring;
        }
        for (force, k) in held.iter().zip(active.points()) {
            forces[3 * k..3 * k + 3].copy_from_slice(force.as_slice());
        }
        let mut moved = active.moved_all(problem.tissue.touches, near, &held);
        moved.iter_mut().zip(&problem.free).for_each(|(m, d)| *m += part * d);
        Some(Pushed { part, forces, moved })
    }

    /// Pressures become what the depths made of them: the length of the change of the forces, and the depth.
    fn update(&mut self, problem: &Problem<'_>, moved: &[f64]) -> (f64, f64) {
        let (mut changes, mut depth) = (vec![0.0; moved.len()], 0.0_f64);
        for (k, pressure) in self.pressures.iter_mut().enumerate() {
            let Some(distance) = problem.distance(k, moved, *pressure) else {
                continue;
            };
            let new = (*pressure - self.stiffness * distance.value).max(0.0);
            let more = distance.gradient * ((new - *pressure) * problem.area(k));
            changes[3 * k..3 * k + 3].copy_from_slice(more.as_slice());
            *pressure = new;
            depth = depth.max(-distance.value);
        }
        (problem.length(&changes, 0.0), depth)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a + t b`.
fn plus(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + t * b).collect()
}
