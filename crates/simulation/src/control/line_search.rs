//! A line search that lets no energy rise by more than its rounding (Armijo 1966; near rounding Hager and Zhang 2005).

use super::Potential;
use super::evaluation::{Evaluation, largest};

/// The part of the first-order decrease that a step must bring (Armijo).
const ARMIJO_PART: f64 = 1e-4;
/// Halvings before a search gives up.
// 2^-40 is 1e-12 of the step: shorter ones hardly change an energy by more than its rounding.
const MOST_HALVINGS: usize = 40;
/// Energies are compared to this relative rounding, of themselves and of the work of outer forces in them.
// Some 450 times 2^-52: room for what the sum over elements and contacts loses.
const ENERGY_ROUNDING: f64 = 1e-13;
/// Of the way to the first touch.
const BEFORE_TOUCH: f64 = 0.9;

/// A step to try.
pub(super) struct Line<'a, P> {
    potential: &'a P,
    a: &'a [f64],
    at: &'a Evaluation,
    step: Vec<f64>,
    /// Slope of the energy along the step, below zero.
    slope: f64,
    capped: bool,
    touches: bool,
}

/// A state that was accepted.
pub(super) struct Next {
    pub(super) a: Vec<f64>,
    pub(super) evaluation: Evaluation,
    t: f64,
}

impl<'a, P: Potential> Line<'a, P> {
    /// Shortens the step to the longest allowed and to what may be passed.
    pub(super) fn new(potential: &'a P, a: &'a [f64], at: &'a Evaluation, mut step: Vec<f64>, max_step: f64) -> Self {
        // The longest step first, so that the way to a touch is looked for only on the step that is left.
        let length = largest(&step);
        let capped = length > max_step;
        if capped {
            step.iter_mut().for_each(|s| *s *= max_step / length);
        }
        let feasible_fraction = potential.reach(a, &step);
        let touches = feasible_fraction < 1.0;
        if touches {
            step.iter_mut().for_each(|s| *s *= BEFORE_TOUCH * feasible_fraction);
        }
        let slope = at.gradient.iter().zip(&step).map(|(g, s)| g * s).sum();
        Self {
            potential,
            a,
            at,
            step,
            slope,
            capped,
            touches,
        }
    }

    /// The first of the halved steps that lowers the energy enough; where energies differ by rounding only, that keeps
    /// it and flattens the slope (Hager and Zhang 2005).
    pub(super) fn search(&self, evaluations: &mut usize) -> Option<Next> {
        let mut t = 1.0;
        for _ in 0..MOST_HALVINGS {
            let a = self.moved(t);
            *evaluations += 1;
            if let Some(evaluation) = self.evaluate(&a, t) {
                // Armijo's condition.
                let enough = evaluation.energy <= self.at.energy + ARMIJO_PART * t * self.slope;
                let slope: f64 = evaluation.gradient.iter().zip(&self.step).map(|(g, s)| g * s).sum();
                // Else the approximate Wolfe conditions `(2 d - 1) s(0) >= s(t) >= 0.9 s(0)`, `d` the Armijo part:
                // slopes still have digits where differences of energies have none.
                if enough || (slope <= (2.0 * ARMIJO_PART - 1.0) * self.slope && slope >= 0.9 * self.slope) {
                    return Some(Next { a, evaluation, t });
                }
            }
            t *= 0.5;
        }
        None
    }

    /// Where the part `t` of the step leads: with its turns made whole where that way is free.
    fn moved(&self, t: f64) -> Vec<f64> {
        let part: Vec<f64> = self.step.iter().map(|s| t * s).collect();
        // Only the straight way was proved free: the turned one needs a proof of its own.
        let turned = self.potential.turned(self.a, &part);
        let free = turned.filter(|step| self.potential.reach(self.a, step) >= 1.0);
        let step = free.unwrap_or(part);
        self.a.iter().zip(step).map(|(a, s)| a + s).collect()
    }

    /// The state at `t`, where its energy is not above that of the start. A whole step mostly does: its gradient is asked for at
    /// once, and its energy comes with it.
    fn evaluate(&self, a: &[f64], t: f64) -> Option<Evaluation> {
        let most = self.at.energy + self.rounding();
        if t < 1.0 && !self.potential.energy(a).is_some_and(|energy| energy <= most) {
            return None;
        }
        Evaluation::of(self.potential, a).filter(|evaluation| evaluation.energy <= most)
    }

    fn rounding(&self) -> f64 {
        ENERGY_ROUNDING * (self.at.energy.abs() + self.potential.work(self.a))
    }

    /// True for a step that nothing has shortened.
    pub(super) fn whole(&self, next: &Next) -> bool {
        next.t >= 1.0 && !self.capped && !self.touches
    }

    /// Wider after a full step that the bound cut, narrower after a short one.
    pub(super) fn next_max_step(&self, next: &Next, max_step: f64) -> f64 {
        match next.t {
            1.0 if self.capped && !self.touches => 2.0 * max_step,
            // Four times what was accepted, so that the next step is not halved at once; one bad step costs a factor
            // 1000 at most.
            t if t < 0.25 => (4.0 * t * largest(&self.step)).min(max_step).max(1e-3 * max_step),
            _ => max_step,
        }
    }
}
