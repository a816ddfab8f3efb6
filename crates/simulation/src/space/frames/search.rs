//! Steps to the state that a pose of the tube asks for.

use std::sync::Arc;

use super::around::Around;
use super::reduced::Wanted;
use super::report::Refused;
use super::{Evaluated, Frames, norm};
use crate::control::Potential;
use crate::space::tube::Tube;

/// The problem of contact is solved to this part of what is asked of the whole.
const OF_THE_WHOLE: f64 = 0.05;
/// While free forces are far above the tolerance, to this part of theirs.
const FAR_PART: f64 = 0.2;
/// Steps that leave more than this part of the free forces, so many of them, ask for new factors at once.
const HALTING_RATE: f64 = 0.5;
const MOST_SLOW: usize = 3;
/// Energies are compared to this relative rounding.
const ENERGY_ROUNDING: f64 = 1e-13;
/// Up to this relative difference two energies are alike, and less free force counts.
const ALIKE: f64 = 1e-5;
/// The step that tells what is left is solved to this part of the tolerance and the depth, so that what it says is not that solution's own error.
const LAST_PART: f64 = 1e-3;
/// It is told times this: factors are a little old, and contact bends. On the shipped kidney the way to the converged state was up to 2.5 steps.
const MARGIN: f64 = 3.0;
/// Halvings of a step before there is none.
const MOST_HALVINGS: i32 = 10;

/// What a search came to.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    pub(super) residual: f64,
    pub(super) depth: f64,
    /// The deepest point inside, and the widest gap of the surface, mm.
    pub(super) inside: f64,
    pub(super) gap: f64,
    /// The least determinant of the deformation gradient at the points of the elements.
    pub(super) determinant: f64,
    pub(super) steps: usize,
    pub(super) contact_steps: usize,
    /// What the last step left of the residual.
    pub(super) rate: f64,
    /// What all steps that were not made would move, mm.
    pub(super) unsettled: f64,
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
}

/// A step and the pressures after it.
type Step = (Vec<f64>, Vec<f64>);

/// A state that a step leads to.
struct Next {
    a: Vec<f64>,
    at: Evaluated,
    v: Vec<f64>,
    pressures: Vec<f64>,
    /// Free forces with those of contact, and what these are measured by.
    free: f64,
    scale: f64,
}

impl Frames {
    /// Goes to the state for a tube; the tube's place and the state are those reached.
    pub(super) fn search(&mut self, tube: &Tube, most: usize) -> Result<Found, Refused> {
        self.mix.clear();
        let mut v = Vec::new();
        self.contact.touches.take(&self.now.a, &mut v);
        // Before any step: what begins too deep would be led out on the other side.
        self.watch(tube, &self.now.a, &v, false)?;
        let (mut found, before) = (self.balance(tube, &v), self.contact.steps());
        let (mut free, mut slow) = (f64::INFINITY, 0);
        // What a first step, or one after new factors, is held against where energies differ by rounding only.
        let mut at_start = found.residual * self.scale;
        // What is in balance already has no step: there may be none that leads lower.
        let most = if self.is_balanced(&found) { 0 } else { most };
        for _ in 0..most {
            // Steps of an old factor may fail, or lead nowhere, where those of a new one do not.
            let next = match self.step(tube, &v, [free, at_start]) {
                Err(_) if self.renew_old() => self.step(tube, &v, [free, at_start]),
                other => other,
            };
            // What the steps before came to stands: how far from balance it is, is told.
            let next = match next {
                Err(_) if found.steps > 0 => break,
                other => other?,
            };
            self.stale = true;
            found.steps += 1;
            found.rate = if free.is_finite() {
                (next.free / free).min(1.0)
            } else {
                1.0
            };
            (free, at_start, self.scale) = (next.free, next.free, next.scale);
            (self.now.a, self.now.at, v) = (next.a, next.at, next.v);
            self.now.pressures = next.pressures;
            found.residual = free / self.scale;
            found.depth = self.contact.off(&self.now.pressures, &v, &self.around(tube));
            if self.is_balanced(&found) {
                break;
            }
            // A stale factor shows by steps that leave most of the free forces; the first step has nothing to be held against.
            slow += usize::from(found.steps > 1 && found.rate > HALTING_RATE);
            if slow == MOST_SLOW && self.renew_old() {
                free = f64::INFINITY;
            }
        }
        self.now.tube = tube.clone();
        found.contact_steps = self.contact.steps() - before;
        found.gap = self.watch(tube, &self.now.a, &v, true)?;
        found.inside = self.look_inside(tube, &self.now.a)?;
        found.determinant = self.system.least_determinant(&self.now.a);
        Ok(found)
    }

    /// How far the state as it is is from balance with the tube there.
    pub(super) fn balance(&mut self, tube: &Tube, v: &[f64]) -> Found {
        let (now, around) = (&self.now, self.around(tube));
        let (free, scale) = self.left(&now.at, &now.pressures, v, &around);
        let found = Found {
            residual: norm(&free) / scale,
            depth: self.contact.off(&now.pressures, v, &around),
            ..Found::default()
        };
        self.scale = scale;
        found
    }

    /// Whether forces and depths are within what is asked for.
    pub(super) fn is_balanced(&self, found: &Found) -> bool {
        found.residual <= self.settings.tolerance && found.depth <= self.settings.depth
    }

    /// Free forces with those of contact, and what their length is measured by.
    fn left(&self, at: &Evaluated, pressures: &[f64], v: &[f64], around: &Around<'_>) -> (Vec<f64>, f64) {
        let (pushed, lengths) = self.contact.push(pressures, v, around);
        let mut free = at.forces.clone();
        self.contact.touches.add(&pushed, &mut free);
        let scale = self.scale(&free, &lengths);
        (free, scale)
    }

    /// What the length of free forces is measured by, from the forces of contact on each solid. Each is measured by its own, and that of the worst
    /// counts for all: a small one that hardly resists would else be far from its balance while a large one is pressed.
    fn scale(&self, free: &[f64], pushed: &[f64]) -> f64 {
        let scales = pushed
            .iter()
            .zip(&self.least_forces)
            .map(|(pushed, least)| pushed.max(*least));
        // Where nothing is left, the most delicate of them: what it is pushed by first must not be lost in what others bear.
        let least = scales.clone().fold(f64::INFINITY, f64::min);
        if pushed.len() == 1 {
            return least;
        }
        let own = |body: usize| norm(self.system.bodies.part(body, free));
        let worst = scales
            .enumerate()
            .map(|(body, scale)| own(body) / scale)
            .fold(0.0, f64::max);
        if worst > 0.0 { norm(free) / worst } else { least }
    }

    /// How far one step more would move the tissue, contact included, with a margin: most of what is left, as steps fall fast where factors serve.
    /// Infinite where there is no such step. Free forces alone would not tell: where tissue is about to slip off the tube they move it little, and
    /// contact goes on from there.
    pub(super) fn unsettled(&mut self) -> f64 {
        let mut v = Vec::new();
        self.contact.touches.take(&self.now.a, &mut v);
        let tube = self.now.tube.clone();
        // The scale may be of a way that was given up.
        self.balance(&tube, &v);
        let wanted = self.wanted(LAST_PART * self.settings.tolerance, LAST_PART * self.settings.depth);
        // What is only told must not change the bits of what comes after it: what the step took in goes again.
        let (near, active) = (Arc::clone(&self.factors.now.near), self.factors.now.active.len());
        let found = self.whole(&tube, &v, &wanted);
        let factor = &mut self.factors.now;
        match Arc::ptr_eq(&near, &factor.near) {
            true => factor.active.truncate(active),
            false => {
                factor.near = near;
                factor.active.clear();
            }
        }
        let step = match found {
            Ok((step, _)) if self.contact.is_whole() => step,
            _ => return f64::INFINITY,
        };
        let next: Vec<f64> = self.now.a.iter().zip(&step).map(|(a, step)| a + step).collect();
        MARGIN * self.others.apart(&self.system, &self.now.a, &next)
    }

    /// New factors at once where those in use are of another state; true where there are.
    fn renew_old(&mut self) -> bool {
        self.mix.clear();
        self.stale && self.renew()
    }

    /// One step: that without contact, contact by the compliance of the points at the tube, and the step of its forces.
    fn step(&mut self, tube: &Tube, v: &[f64], [last, at_start]: [f64; 2]) -> Result<Next, Refused> {
        // What is still far from its end needs no exact forces of contact.
        let part = self
            .settings
            .tolerance
            .max(FAR_PART * last.min(self.scale) / self.scale);
        let wanted = self.wanted(OF_THE_WHOLE * part, OF_THE_WHOLE * self.settings.depth);
        let (step, pressures) = self.whole(tube, v, &wanted)?;
        // Mixed in the space of whole steps: each is a step of the same map from states to states, as the factor does not change meanwhile.
        let mixed = self.mix.next(&self.now.a, &step, &pressures);
        self.line(tube, v, (step, pressures), mixed, at_start)
            .ok_or(Refused::NoStep)
    }

    /// Free forces as a part of those of contact, and a depth, mm; no nearer than places are known.
    fn wanted(&self, part: f64, depth: f64) -> Wanted {
        Wanted {
            force: part * self.scale,
            depth: depth.max(8.0 * f64::EPSILON * self.system.extent()),
        }
    }

    /// The step of the factor at hand, with what presses after it.
    fn whole(&mut self, tube: &Tube, v: &[f64], wanted: &Wanted) -> Result<Step, Refused> {
        // They are what a step starts from; what becomes of them is the step's.
        let mut pressures = self.now.pressures.clone();
        let around = Around {
            tube,
            bones: &self.bones,
        };
        let (factor, forces) = (&mut self.factors.now, &self.now.at.forces);
        let solved = self.contact.solve(factor, forces, &mut pressures, v, &around, wanted);
        solved.map(|step| (step, pressures)).ok_or(Refused::NoContact)
    }

    /// The first of the mixed step, the whole one and its halves that lowers energy and depths together; or that halves the free
    /// forces, where these hardly differ.
    fn line(&self, tube: &Tube, v: &[f64], whole: Step, mixed: Option<Step>, last: f64) -> Option<Next> {
        let around = self.around(tube);
        let cost = |v: &[f64]| self.contact.cost(&whole.1, v, &around);
        let start = self.now.at.energy + cost(v);
        let lower = start + ENERGY_ROUNDING * start.abs();
        // Nor does the work of forces count that may be left free.
        let alike = start + ALIKE * start.abs() + self.settings.tolerance * self.scale * norm(&whole.0);
        let halves = (0..MOST_HALVINGS).map(|k| (0.5_f64.powi(k), &whole));
        let tries = mixed.iter().map(|mixed| (1.0, mixed)).chain(halves);
        tries.into_iter().find_map(|(t, (step, pressures))| {
            let a: Vec<f64> = self.now.a.iter().zip(step).map(|(a, s)| a + t * s).collect();
            let next = self.look_at(a, pressures, &around)?;
            let way: Vec<f64> = next.v.iter().zip(v).map(|(next, v)| next - v).collect();
            if self.contact.passes(v, &way, &around) {
                return None;
            }
            let energy = next.at.energy + cost(&next.v);
            (energy <= lower || energy <= alike && next.free <= 0.5 * last).then_some(next)
        })
    }

    /// A state with its forces.
    fn look_at(&self, a: Vec<f64>, pressures: &[f64], around: &Around<'_>) -> Option<Next> {
        let at = Evaluated::of(&self.system, &a)?;
        let mut v = Vec::new();
        self.contact.touches.take(&a, &mut v);
        let (free, scale) = self.left(&at, pressures, &v, around);
        Some(Next {
            free: norm(&free),
            scale,
            pressures: pressures.to_vec(),
            a,
            at,
            v,
        })
    }
}
