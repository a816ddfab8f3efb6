//! Contacts that become exact: what they are before, and what is the same of all of them.

use super::continuation::{Continuation, Stage};
use super::exact::Exact;
use super::{Active, Change, Constraint, Force, Term};
use crate::bodies::Bodies;
use crate::sparse::Triplets;

/// A contact before it is exact: a barrier, or multipliers. See [`Term`] for what its methods return.
pub(super) trait Contact: std::fmt::Debug + Clone + Send + Sync + 'static {
    /// Its last stage where exact contact never takes over.
    const STAGE_WITHOUT_EXACT: Stage;

    fn continuation(&self) -> &Continuation;

    fn continuation_mut(&mut self) -> &mut Continuation;

    fn soft_energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64>;

    fn soft_gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64>;

    fn soft_hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()>;

    fn soft_reach(&self, _bodies: &Bodies, _a: &[f64], _step: &[f64]) -> f64 {
        1.0
    }

    fn soft_forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force>;

    /// Takes multipliers from a state: how they changed, and whether they are settled enough for the next stage.
    fn settle(&mut self, _bodies: &Bodies, _a: &[f64]) -> (Change, bool) {
        (Change::default(), true)
    }

    /// The exact contact that begins with the forces of a state.
    fn hand_over(&self, bodies: &Bodies, a: &[f64]) -> Exact;

    /// Moves a wall along its normal; nothing for what is none.
    fn move_soft_wall(&mut self, _by: f64) {}
}

impl<C: Contact> Term for C {
    fn energy(&self, bodies: &Bodies, a: &[f64]) -> Option<f64> {
        match self.continuation().exact() {
            Some(exact) => exact.energy(bodies, a),
            None => self.soft_energy(bodies, a),
        }
    }

    fn gradient(&self, bodies: &Bodies, a: &[f64], gradient: &mut [f64]) -> Option<f64> {
        match self.continuation().exact() {
            Some(exact) => exact.gradient(bodies, a, gradient),
            None => self.soft_gradient(bodies, a, gradient),
        }
    }

    fn hessian(&self, bodies: &Bodies, a: &[f64], convex: bool, sink: &mut Triplets) -> Option<()> {
        match self.continuation().exact() {
            Some(exact) => exact.hessian(bodies, a, convex, sink),
            None => self.soft_hessian(bodies, a, convex, sink),
        }
    }

    fn reach(&self, bodies: &Bodies, a: &[f64], step: &[f64]) -> f64 {
        match self.continuation().exact() {
            Some(exact) => exact.reach(bodies, a, step),
            None => self.soft_reach(bodies, a, step),
        }
    }

    fn forces(&self, bodies: &Bodies, a: &[f64]) -> Vec<Force> {
        match self.continuation().exact() {
            Some(exact) => exact.forces(bodies, a),
            None => self.soft_forces(bodies, a),
        }
    }
}

impl<C: Contact> Constraint for C {
    fn stage(&self) -> Stage {
        Contact::continuation(self).stage(C::STAGE_WITHOUT_EXACT)
    }

    fn update(&mut self, bodies: &Bodies, a: &[f64]) -> Change {
        if let Some(exact) = Contact::continuation_mut(self).exact_mut() {
            return exact.update(bodies, a);
        }
        // Multipliers on the move would hand over forces that do not hold the state.
        let (change, is_settled) = self.settle(bodies, a);
        if !is_settled {
            return change;
        }
        let exact = Contact::continuation(self).is_due().then(|| self.hand_over(bodies, a));
        let again = Contact::continuation_mut(self).advance(exact);
        Change {
            again: change.again || again,
            ..change
        }
    }

    fn way_to_exact(&mut self) -> Option<&mut Continuation> {
        Some(Contact::continuation_mut(self))
    }

    fn rows(&mut self) -> Option<&mut dyn Active> {
        let exact = Contact::continuation_mut(self).exact_mut()?;
        Some(exact)
    }

    fn move_wall(&mut self, by: f64) {
        self.move_soft_wall(by);
        if let Some(exact) = Contact::continuation_mut(self).exact_mut() {
            exact.move_wall(by);
        }
    }

    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}
