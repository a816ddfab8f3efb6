//! Contact in the space of the nodes at the tube: `min 1/2 y^T S y - b^T y` over `distance(points(v + y)) >= 0`.
//!
//! `S` is what the elimination of all other unknowns leaves on these (their stiffness against contact), `b` what is left of the
//! free forces. Pressures by the augmented Lagrangian, as in [`crate::space::term::TubeContact`]; here a round costs no sparse
//! solution, and the stiffness of contact may be far above that of tissue.

use nalgebra::{DMatrix, Vector3};

use super::norm;
use super::touch::Touches;
use crate::space::tube::Tube;
use crate::sparse::Dense;

/// Stiffness of contact by the mean stiffness of an unknown, at first.
const STIFFNESS_PART: f64 = 100.0;
/// A round that leaves more than this part of the last one's change asks for more, so much of it, and so much in all: where tissue all
/// but slips off the tube, forces of rounds grow until contact is stiff enough.
const SLOW_PART: f64 = 0.25;
const STIFFENED: f64 = 10.0;
const MOST_STIFFENED: f64 = 1e5;
/// Roundings of a place in a distance: of the sum over nodes, and of turning it into the tube's frame.
const ROUNDINGS: f64 = 8.0;
/// Rounds of pressures, and steps in each, at most.
const MOST_ROUNDS: usize = 20;
const MOST_STEPS: usize = 30;
const MOST_HALVINGS: usize = 20;

/// The quadratic problem.
#[derive(Debug, Clone, Copy)]
pub(super) struct Model<'a> {
    pub(super) stiffness: &'a DMatrix<f64>,
    pub(super) forces: &'a [f64],
}

/// How exact an answer must be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Free forces, a length.
    pub(super) force: f64,
    /// Depth, mm.
    pub(super) depth: f64,
}

/// Points with pressures.
#[derive(Debug, Clone, Default)]
pub(super) struct Reduced {
    pub(super) touches: Touches,
    /// Stress at each point.
    pub(super) pressures: Vec<f64>,
    /// Stress by length.
    stiffness: f64,
    dense: Dense,
    matrix: DMatrix<f64>,
    /// Steps made in all.
    pub(super) steps: usize,
}

impl Reduced {
    /// The energy of the pressures at `v`, and their forces added to `forces` (on the unknowns, downhill).
    fn energy(&self, v: &[f64], tube: &Tube, forces: &mut [f64]) -> f64 {
        let mut energy = 0.0;
        for (point, old) in self.pressures.iter().enumerate() {
            let distance = self.touches.distance(point, v, tube);
            let area = self.touches.area(point);
            let pressure = (old - self.stiffness * distance.value).max(0.0);
            energy += 0.5 * area / self.stiffness * (pressure * pressure - old * old);
            if pressure > 0.0 {
                self.touches
                    .push(point, &(distance.gradient * (area * pressure)), forces);
            }
        }
        energy
    }

    /// The step `y` that balances the model's forces without depth, or as far as rounds and steps led towards it; pressures are those
    /// of the last round. `None` where it is not finite.
    pub(super) fn solve(&mut self, model: &Model<'_>, v: &[f64], tube: &Tube, wanted: &Wanted) -> Option<Vec<f64>> {
        let count = model.forces.len();
        // A stiffness of contact in the scale of what it presses: as soft as rounding lets it converge, as stiff as few rounds need.
        let mean = model.stiffness.trace() / count.max(1) as f64;
        let first = STIFFNESS_PART * mean / self.touches.mean_area();
        self.stiffness = first;
        let (mut y, mut last, mut force) = (vec![0.0; count], f64::INFINITY, wanted.force);
        for _ in 0..MOST_ROUNDS {
            let (floor, steps) = (self.rounding(v), self.steps);
            // Forces that do not balance all the way still lead on: the energy of the whole decides how far.
            if self.balance(model, v, tube, force.max(floor), &mut y).is_none() {
                break;
            }
            let (change, depth) = self.update(&moved(v, &y, 1.0), tube);
            if change <= force.max(floor) && depth <= wanted.depth {
                return Some(y);
            }
            if self.steps == steps {
                // Forces balance well enough for no step, but not for the depth.
                force *= SLOW_PART;
            } else if change > SLOW_PART * last && self.stiffness < MOST_STIFFENED * first {
                self.stiffness *= STIFFENED;
            }
            last = change;
        }
        y.iter().all(|y| y.is_finite()).then_some(y)
    }

    /// What rounding leaves of the forces: of places, times the stiffness of contact.
    fn rounding(&self, v: &[f64]) -> f64 {
        // Points that do not press have no forces to round.
        let pressing = (0..self.touches.len()).filter(|point| self.pressures[*point] > 0.0);
        let places = pressing.map(|point| (self.touches.area(point), self.touches.at(point, v).amax()));
        let (area, far) = places.fold((0.0, 0.0_f64), |(area, far), (a, x)| (area + a * a, far.max(x)));
        ROUNDINGS * f64::EPSILON * self.stiffness * far * area.sqrt()
    }

    /// Newton's method with these pressures.
    fn balance(&mut self, model: &Model<'_>, v: &[f64], tube: &Tube, force: f64, y: &mut Vec<f64>) -> Option<()> {
        let mut at = self.evaluate(model, v, tube, y);
        for _ in 0..MOST_STEPS {
            if norm(&at.1) <= force {
                return Some(());
            }
            // Forces that are small enough cost no step: rounds near the end are updates of pressures alone.
            self.steps += 1;
            let step = self.newton(model, v, tube, y, &at.1)?;
            let slope: f64 = -step.iter().zip(&at.1).map(|(s, f)| s * f).sum::<f64>();
            let next = (0..MOST_HALVINGS as i32).find_map(|k| {
                let t = 0.5_f64.powi(k);
                let moved = moved(y, &step, t);
                let there = self.evaluate(model, v, tube, &moved);
                // Near the end energies differ by rounding only: less force is enough there.
                let lower = there.0 <= at.0 + 1e-4 * t * slope || norm(&there.1) <= 0.5 * norm(&at.1);
                lower.then_some((moved, there))
            });
            (*y, at) = next?;
        }
        None
    }

    /// Energy and downhill forces of model and pressures.
    fn evaluate(&self, model: &Model<'_>, v: &[f64], tube: &Tube, y: &[f64]) -> (f64, Vec<f64>) {
        let mut forces = model.forces.to_vec();
        let mut energy = 0.0;
        // Column by column: the matrix is symmetric, and a column is one sum.
        for (k, column) in model.stiffness.column_iter().enumerate() {
            let held: f64 = column.iter().zip(y).map(|(s, y)| s * y).sum();
            energy += y[k] * (0.5 * held - model.forces[k]);
            forces[k] -= held;
        }
        energy += self.energy(&moved(v, y, 1.0), tube, &mut forces);
        (energy, forces)
    }

    /// Newton's step: with the bend of the tube, or where that leaves no definite matrix without it.
    fn newton(&mut self, model: &Model<'_>, v: &[f64], tube: &Tube, y: &[f64], forces: &[f64]) -> Option<Vec<f64>> {
        let at = moved(v, y, 1.0);
        for bent in [true, false] {
            self.matrix.clone_from(model.stiffness);
            for (point, old) in self.pressures.iter().enumerate() {
                let distance = self.touches.distance(point, &at, tube);
                let pressure = old - self.stiffness * distance.value;
                if pressure > 0.0 {
                    let normal: Vector3<f64> = distance.gradient;
                    let mut own = normal * normal.transpose() * self.stiffness;
                    if bent {
                        own -= distance.hessian * pressure;
                    }
                    let own = own * self.touches.area(point);
                    self.touches.stiffen(point, &own, &mut self.matrix);
                }
            }
            if self.dense.factor(&self.matrix) {
                let mut step = forces.to_vec();
                self.dense.solve(&mut step);
                return Some(step);
            }
        }
        None
    }

    /// Pressures become what the depths made of them: the length of the change of the forces, and the depth.
    fn update(&mut self, v: &[f64], tube: &Tube) -> (f64, f64) {
        let (mut forces, mut depth) = (vec![0.0; v.len()], 0.0_f64);
        for (point, pressure) in self.pressures.iter_mut().enumerate() {
            let distance = self.touches.distance(point, v, tube);
            let new = (*pressure - self.stiffness * distance.value).max(0.0);
            let more = distance.gradient * ((new - *pressure) * self.touches.area(point));
            self.touches.push(point, &more, &mut forces);
            *pressure = new;
            depth = depth.max(-distance.value);
        }
        (norm(&forces), depth)
    }
}

/// `v + t y`.
fn moved(v: &[f64], y: &[f64], t: f64) -> Vec<f64> {
    v.iter().zip(y).map(|(v, y)| v + t * y).collect()
}
