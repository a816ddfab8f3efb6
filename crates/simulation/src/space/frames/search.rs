//! Steps to the state that a pose of the tube asks for.

use super::reduced::{Model, Wanted};
use super::report::Refused;
use super::{Evaluated, Frames, norm};
use crate::space::tube::Tube;

/// The problem of contact is solved to this part of what is asked of the whole.
const OF_THE_WHOLE: f64 = 0.05;
/// While free forces are far above the tolerance, to this part of theirs.
const FAR_PART: f64 = 0.2;
/// Part of the first-order decrease that a step must bring (Armijo).
const ARMIJO_PART: f64 = 1e-4;
/// Energies are compared to this relative rounding.
const ENERGY_ROUNDING: f64 = 1e-13;
/// Halvings of a step before there is none.
const MOST_HALVINGS: i32 = 10;

/// What a search came to.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    pub(super) residual: f64,
    pub(super) depth: f64,
    pub(super) steps: usize,
    pub(super) contact_steps: usize,
    /// The largest displacement of the last step, mm, and what it left of the residual.
    pub(super) last: f64,
    pub(super) rate: f64,
}

impl Found {
    /// This, and what came after it.
    pub(super) fn and(&self, next: &Self) -> Self {
        Self {
            steps: self.steps + next.steps,
            contact_steps: self.contact_steps + next.contact_steps,
            ..*next
        }
    }

    /// What all steps that were not made would move: a geometric series by the last one.
    pub(super) fn unsettled(&self) -> f64 {
        self.last * self.rate / (1.0 - self.rate).max(0.1)
    }
}

/// A state that a step leads to.
struct Next {
    a: Vec<f64>,
    at: Evaluated,
    v: Vec<f64>,
    /// Free forces with those of contact, and those of contact alone, as lengths.
    free: f64,
    pushed: f64,
}

impl Frames {
    /// Goes to the state for a tube; the tube's place and the state are those reached.
    pub(super) fn search(&mut self, tube: &Tube, most: usize) -> Result<Found, Refused> {
        self.mix.clear();
        let mut v = Vec::new();
        self.contact.touches.take(&self.a, &mut v);
        self.watch(tube, &self.a, &v)?;
        let (mut found, before) = (Found::default(), self.contact.steps());
        let mut free = f64::INFINITY;
        for _ in 0..most {
            let next = match self.step(tube, &v, free) {
                // Steps of an old factor may fail where those of a new one do not.
                Err(_) if self.ways[0] > 0.0 && self.renew() => {
                    self.mix.clear();
                    self.step(tube, &v, free)?
                }
                other => other?,
            };
            found.steps += 1;
            found.last = next.a.iter().zip(&self.a).map(|(n, a)| (n - a).abs()).fold(0.0, f64::max);
            found.rate = if free.is_finite() { (next.free / free).min(1.0) } else { 1.0 };
            (free, self.scale) = (next.free, next.pushed.max(self.least_force));
            (self.a, self.at, v) = (next.a, next.at, next.v);
            found.residual = free / self.scale;
            found.depth = self.contact.depth(&v, tube);
            if found.residual <= self.settings.tolerance && found.depth <= self.settings.depth {
                break;
            }
        }
        self.tube = tube.clone();
        found.contact_steps = self.contact.steps() - before;
        self.watch(tube, &self.a, &v)?;
        Ok(found)
    }

    /// One step: down to the root, contact there, and back.
    fn step(&mut self, tube: &Tube, v: &[f64], last: f64) -> Result<Next, Refused> {
        let (ldl, settings) = (&self.factors.now.ldl, &self.settings);
        let reduced = ldl.reduce(&self.at.forces);
        let model = Model {
            stiffness: ldl.root().1,
            forces: reduced.on_root(),
        };
        let wanted = Wanted {
            // What is still far from its end needs no exact forces of contact.
            force: OF_THE_WHOLE * settings.tolerance.max(FAR_PART * last.min(self.scale) / self.scale) * self.scale,
            depth: OF_THE_WHOLE * settings.depth,
        };
        let y = self.contact.solve(&model, self.factors.number, v, tube, &wanted).ok_or(Refused::NoContact)?;
        let step = ldl.back(&reduced, &y);
        let mixed = self.mix.next(&self.a, &step);
        self.line(tube, v, &step, mixed, last).ok_or(Refused::NoStep)
    }

    /// The first of the mixed step, the whole one and its halves that lowers the energy with the new pressures, or the free forces by half.
    fn line(&self, tube: &Tube, v: &[f64], step: &[f64], mixed: Option<Vec<f64>>, last: f64) -> Option<Next> {
        let mut pushed = vec![0.0; v.len()];
        let start = self.at.energy + self.contact.energy(v, tube, &mut pushed);
        let downhill: f64 = step.iter().zip(&self.at.forces).map(|(s, f)| s * f).sum();
        let mut own = Vec::new();
        self.contact.touches.take(step, &mut own);
        let slope = -(downhill + own.iter().zip(&pushed).map(|(s, f)| s * f).sum::<f64>());
        let rounding = ENERGY_ROUNDING * start.abs();
        let halves = (0..MOST_HALVINGS).map(|k| (0.5_f64.powi(k), step));
        let tries = mixed.iter().map(|mixed| (1.0, mixed.as_slice())).chain(halves);
        tries.into_iter().find_map(|(t, step)| {
            let a: Vec<f64> = self.a.iter().zip(step).map(|(a, s)| a + t * s).collect();
            let (next, energy) = self.look_at(a, tube)?;
            let lower = energy <= start + ARMIJO_PART * t * slope.min(0.0) + rounding;
            (lower || last.is_finite() && next.free <= 0.5 * last).then_some(next)
        })
    }

    /// A state with its forces and its energy with the pressures.
    fn look_at(&self, a: Vec<f64>, tube: &Tube) -> Option<(Next, f64)> {
        let at = Evaluated::of(&self.system, &a)?;
        let mut v = Vec::new();
        self.contact.touches.take(&a, &mut v);
        let mut pushed = vec![0.0; v.len()];
        let energy = at.energy + self.contact.energy(&v, tube, &mut pushed);
        let mut free = at.forces.clone();
        self.contact.touches.add(&pushed, &mut free);
        let next = Next {
            free: norm(&free),
            pushed: norm(&pushed),
            a,
            at,
            v,
        };
        Some((next, energy))
    }
}
