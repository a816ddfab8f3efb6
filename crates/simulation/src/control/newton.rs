//! Newton's method with a line search, on the true second derivatives where they are positive definite.
//!
//! Each round of a search is in one of three phases:
//!
//! 1. *Balanced*: every free force is below the force tolerance, or below what rounding leaves of it by the last matrix. A
//!    factorisation shows a minimum, and a second one counts negative eigenvalues where the first has found some that are not
//!    positive. A saddle is left along a direction of negative curvature (Moré and Sorensen 1979); one from which no try
//!    lowers the energy is returned, and [`Stability`] tells.
//! 2. *Reuse*: the last whole step left so little of the free forces that its factors serve once more (Shamanskii 1967).
//! 3. *Factor*: new second derivatives, shifted where they are not positive definite (Nocedal and Wright 2006, 3.4); where no
//!    shift makes them so, those of a convex matrix near them. The step is no longer than a bound that adapts, and the line
//!    search lets the energy rise by its rounding at most.
//!
//! Where no step is accepted any more, the search has found its end if forces are within some roundings by the last matrix and
//! near the tolerance, or within what rounding may leave of them by the potential's own account ([`Potential::rounding`]). The
//! latter ends a search too that has made all its steps. Else the search has failed.

use super::evaluation::{Balance, Evaluation, largest};
use super::factors::Factors;
use super::line_search::{Line, Next};
use super::report::Work;
use super::rounding::Rounding;
use super::{Failed, Minimum, Potential, Settings, Stability};
use crate::sparse::Dissection;

/// A state this many sizes away has no equilibrium near.
const FAR_EXTENTS: f64 = 1e4;
/// Leaving a saddle must lower the energy by this part of it: more than rounding.
const SADDLE_FALL: f64 = 1e-12;
/// Saddles that a search leaves.
const MAX_SADDLES: usize = 8;
/// Steps away from a saddle that are tried, in pairs of one length either way.
// Twelve lengths: the last is 2^-11 of the first, 5e-6 of the largest solid.
const MAX_SADDLE_STEPS: i32 = 24;
/// The first of them, in sizes of the largest solid.
const FIRST_SADDLE_STEP: f64 = 1e-2;
/// Free forces below this part of the largest load, with a direction of negative curvature, mean a saddle near.
const NEAR_SADDLE: f64 = 1e-3;
/// A whole step that leaves this part of the free forces says that the matrix has hardly changed.
const REUSE_BELOW: f64 = 1.0 / 32.0;
/// A step with an old matrix must leave no more than this part for another one.
const REUSE_AGAIN_BELOW: f64 = 1.0 / 8.0;
/// Where no step is accepted, forces within so many tolerances and within so many roundings by the last matrix end the search.
const NEAR_TOLERANCES: f64 = 1e3;
const NEAR_ROUNDINGS: f64 = 1e2;

/// The method, with the memory it keeps from one search to the next.
#[derive(Debug, Default)]
pub struct Newton {
    /// When to stop.
    pub settings: Settings,
    factors: Factors,
}

/// What a round of a search does: see the module.
enum Phase {
    Balanced,
    Reuse,
    Factor,
}

/// A search under way.
struct Search<'a, P> {
    newton: &'a mut Newton,
    potential: &'a P,
    a: &'a mut Vec<f64>,
    at: Evaluation,
    balance: Balance,
    /// The largest change of a parameter in a step.
    max_step: f64,
    /// By unknown: times 2^-52 the rounding of the forces that the last matrix makes.
    rounding_scale: Vec<f64>,
    /// Below this free force the factors at hand serve once more.
    reuse_below: Option<f64>,
    work: Work,
}

impl Newton {
    /// The method with these settings.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            ..Self::default()
        }
    }

    /// The same with matrices eliminated in an order of nested dissection, for systems whose pattern stays: large ones in
    /// three dimensions, which minimum degree fills two to four times as much.
    pub fn ordered_by(settings: Settings, dissection: Dissection) -> Self {
        Self {
            settings,
            factors: Factors::ordered_by(dissection),
        }
    }

    /// Moves `a` to a stationary state of the energy by steps none of which raises it by more than its rounding.
    ///
    /// Done where the largest free force is at most `tolerance` times the largest load or reaction, or at the level of
    /// rounding (absolute stiffness times absolute displacement times 2^-52, unknown by unknown; some of these where no step is
    /// accepted any more: see the module).
    ///
    /// # Errors
    /// [`Failed`]. `a` is then the last state.
    pub fn minimise(&mut self, potential: &impl Potential, a: &mut Vec<f64>) -> Result<Minimum, Failed> {
        let mut search = Search::start(self, potential, a)?;
        loop {
            let end = match search.phase() {
                Phase::Balanced => search.end_or_leave_saddle()?,
                // After the test of balance: what the last step allowed has balanced counts as found.
                _ if search.is_spent() => Some(search.end_if_within_potential_rounding()?),
                Phase::Reuse => {
                    search.reuse();
                    None
                }
                Phase::Factor => search.factor()?,
            };
            if let Some(minimum) = end {
                return Ok(minimum);
            }
        }
    }

    /// Newton's step from a state, with its largest free force and load. `None` without energy, or without a step.
    pub(crate) fn direction(&mut self, potential: &impl Potential, a: &[f64]) -> Option<(Vec<f64>, [f64; 2])> {
        let at = Evaluation::of(potential, a)?;
        let Balance { residual, load } = at.balance(potential, a);
        let step = self.factors.new_step(potential, a, &at, &mut Work::default())?;
        Some((step, [residual, load]))
    }

    /// The direction of negative curvature at the last saddle, once.
    pub(crate) fn negative_curvature(&mut self) -> Option<Vec<f64>> {
        self.factors.negative_curvature.take()
    }

    /// The largest free force of a state, and the largest load or reaction. `None` without energy.
    pub(crate) fn balance(potential: &impl Potential, a: &[f64]) -> Option<[f64; 2]> {
        let Balance { residual, load } = Evaluation::of(potential, a)?.balance(potential, a);
        Some([residual, load])
    }

    /// True where every free force of a state is below `force_tolerance` or what rounding may leave of it by the potential's
    /// account.
    pub(crate) fn is_within_potential_rounding(potential: &impl Potential, a: &[f64], force_tolerance: f64) -> bool {
        Evaluation::of(potential, a).is_some_and(|at| at.is_within_potential_rounding(potential, a, force_tolerance))
    }

    /// What a state is that needs no step: every free force is below `tolerance` times the largest load, or what rounding may
    /// leave of it by the potential's account. `None` where one is not.
    pub(crate) fn at_rest(&mut self, potential: &impl Potential, a: &mut Vec<f64>) -> Option<Minimum> {
        let mut search = Search::start(self, potential, a).ok()?;
        if !search
            .at
            .is_within_potential_rounding(potential, search.a, search.force_tolerance())
        {
            return None;
        }
        let found = search.end().ok();
        // Of this state, for whoever leaves it: else that of a step before.
        self.factors.negative_curvature = self.factors.negative_curvature_of_last();
        found
    }
}

impl<'a, P: Potential> Search<'a, P> {
    fn start(newton: &'a mut Newton, potential: &'a P, a: &'a mut Vec<f64>) -> Result<Self, Failed> {
        let at = Evaluation::of(potential, a).ok_or(Failed::NoEnergy)?;
        Ok(Self {
            balance: at.balance(potential, a),
            max_step: newton.settings.first_radius * potential.extent(),
            // Without a matrix nothing is known of rounding, and nothing is excused by it.
            rounding_scale: vec![0.0; a.len()],
            reuse_below: None,
            work: Work::default(),
            newton,
            potential,
            a,
            at,
        })
    }

    /// The free force at which the search is done.
    fn force_tolerance(&self) -> f64 {
        self.newton.settings.tolerance * self.balance.load
    }

    fn phase(&self) -> Phase {
        if self
            .at
            .is_within_matrix_rounding(self.potential, self.force_tolerance(), &self.rounding_scale, 1.0)
        {
            return Phase::Balanced;
        }
        match self.reuse_below {
            Some(most) if self.balance.residual <= most => Phase::Reuse,
            _ => Phase::Factor,
        }
    }

    fn is_spent(&self) -> bool {
        self.work.iterations >= self.newton.settings.most_iterations
    }

    fn not_converged(&self) -> Failed {
        Failed::NotConverged {
            iterations: self.work.iterations,
            residual: self.balance.residual,
            load: self.balance.load,
        }
    }

    /// Makes another state the current one. The factors at hand serve there if it has at most the part `reuse_below` of the
    /// free forces before.
    fn accept(&mut self, next: Next, reuse_below: Option<f64>) {
        self.reuse_below = reuse_below.map(|part| part * self.balance.residual);
        (self.at, *self.a) = (next.evaluation, next.a);
        self.balance = self.at.balance(self.potential, self.a);
    }

    /// The minimum, or `None` where this was a saddle and another state has less energy.
    fn end_or_leave_saddle(&mut self) -> Result<Option<Minimum>, Failed> {
        // Another energy takes over: its stability would be that of a state that does not stay.
        if self.newton.settings.provisional {
            return self.minimum(Stability::default()).map(Some);
        }
        let stability = self.newton.factors.stability(self.potential, self.a, &mut self.work)?;
        // The last factorisation is that of the stability.
        self.newton.factors.negative_curvature = self.newton.factors.negative_curvature_of_last();
        // A saddle from which no try lowers the energy is returned as what it is: `stability` says so.
        if stability.falling == 0 || !self.leave_saddle() {
            return self.minimum(stability).map(Some);
        }
        Ok(None)
    }

    /// A step with the factors of the step before. Where there is none, the next round factors.
    fn reuse(&mut self) {
        self.work.iterations += 1;
        let next = self.newton.factors.step(self.potential, &self.at).and_then(|step| {
            let line = Line::new(self.potential, self.a, &self.at, step, self.max_step);
            let next = line.search(&mut self.work.evaluations)?;
            let again = line.whole(&next).then_some(REUSE_AGAIN_BELOW);
            Some((next, again))
        });
        match next {
            Some((next, again)) => self.accept(next, again),
            None => self.reuse_below = None,
        }
    }

    /// A step with new factors; a minimum where no step is accepted and what is left of the forces is rounding.
    fn factor(&mut self) -> Result<Option<Minimum>, Failed> {
        let failed = self.not_converged();
        self.work.iterations += 1;
        let factors = &mut self.newton.factors;
        let step = factors
            .new_step(self.potential, self.a, &self.at, &mut self.work)
            .ok_or(failed)?;
        // Near a saddle the convex steps crawl: the force that leads away from it is small.
        if self.balance.residual <= NEAR_SADDLE * self.balance.load && self.leave_saddle() {
            return Ok(None);
        }
        self.rounding_scale = self.newton.factors.rounding_scale(self.a);
        let line = Line::new(self.potential, self.a, &self.at, step, self.max_step);
        let Some(next) = line.search(&mut self.work.evaluations) else {
            return self.end_without_a_step().map(Some);
        };
        // What a shifted matrix or a shortened step leaves of the forces does not tell how good the factors are.
        let is_whole = self.newton.factors.unshifted && line.whole(&next);
        self.max_step = line.next_max_step(&next, self.max_step);
        self.accept(next, is_whole.then_some(REUSE_BELOW));
        self.check_distance()?;
        Ok(None)
    }

    fn check_distance(&self) -> Result<(), Failed> {
        let (distance, length_scale) = (largest(self.a), self.potential.extent());
        if distance <= FAR_EXTENTS * length_scale {
            return Ok(());
        }
        Err(Failed::Unbounded {
            iterations: self.work.iterations,
            distance,
            extents: distance / length_scale,
        })
    }

    /// The end where no step is accepted: a state near the tolerance with some roundings left by the last matrix, or one within
    /// the potential's account of rounding; else the search has failed.
    fn end_without_a_step(&mut self) -> Result<Minimum, Failed> {
        let near = self.balance.residual <= NEAR_TOLERANCES * self.force_tolerance();
        if near
            && self
                .at
                .is_within_matrix_rounding(self.potential, 0.0, &self.rounding_scale, NEAR_ROUNDINGS)
        {
            return self.end();
        }
        self.end_if_within_potential_rounding()
    }

    /// The end where the forces are within the potential's account of rounding; else the search has failed.
    fn end_if_within_potential_rounding(&mut self) -> Result<Minimum, Failed> {
        match self
            .at
            .is_within_potential_rounding(self.potential, self.a, self.force_tolerance())
        {
            true => self.end(),
            false => Err(self.not_converged()),
        }
    }

    fn end(&mut self) -> Result<Minimum, Failed> {
        let factors = &mut self.newton.factors;
        let stability = factors.stability(self.potential, self.a, &mut self.work)?;
        self.minimum(stability)
    }

    /// Leaves a saddle along a direction of negative curvature, either way. False where there is none, where no try lowers the
    /// energy, or where too many were left.
    fn leave_saddle(&mut self) -> bool {
        if !self.newton.settings.leave_saddles || self.work.saddles >= MAX_SADDLES {
            return false;
        }
        let Some(mut direction) = self.newton.factors.negative_curvature.take() else {
            return false;
        };
        self.work.saddles += 1;
        for (d, fixed) in direction.iter_mut().zip(self.potential.fixed()) {
            *d = if *fixed { 0.0 } else { *d };
        }
        // A direction whose unknowns are all fixed is zero: no division by that.
        let length = FIRST_SADDLE_STEP * self.potential.extent() / largest(&direction).max(f64::MIN_POSITIVE);
        let most = self.at.energy - SADDLE_FALL * self.at.energy.abs();
        for k in 0..MAX_SADDLE_STEPS {
            // Curvature is the same both ways, but a contact may bar one of them.
            let by = length * 0.5_f64.powi(k / 2) * if k % 2 == 0 { 1.0 } else { -1.0 };
            let step: Vec<f64> = direction.iter().map(|d| d * by).collect();
            let feasible_fraction = self.potential.reach(self.a, &step);
            let a: Vec<f64> = self
                .a
                .iter()
                .zip(&step)
                .map(|(a, s)| a + feasible_fraction * s)
                .collect();
            self.work.evaluations += 1;
            if let Some(at) = Evaluation::of(self.potential, &a).filter(|at| at.energy < most) {
                (self.at, *self.a) = (at, a);
                self.balance = self.at.balance(self.potential, self.a);
                // The factors at hand are those of the saddle.
                self.reuse_below = None;
                return true;
            }
        }
        false
    }

    fn minimum(&self, stability: Stability) -> Result<Minimum, Failed> {
        let least_determinant = self.potential.least_determinant(self.a);
        // A NaN is not `<= 0` and would pass.
        if least_determinant.is_nan() || least_determinant <= 0.0 {
            return Err(Failed::Inverted { least_determinant });
        }
        Ok(Minimum {
            energy: self.at.energy,
            residual: self.balance.residual,
            load: self.balance.load,
            rounding: Rounding::of(self.potential, self.a).largest(self.potential.fixed()),
            stability,
            least_determinant,
            iterations: self.work.iterations,
            evaluations: self.work.evaluations,
            factorisations: self.work.factorisations,
            projected: self.work.projected,
        })
    }
}
