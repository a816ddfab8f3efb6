//! Newton's method with a line search, on the true second derivatives where they are positive definite.

use super::rounding::Rounding;
use super::search::{Line, Point, largest};
use super::{Failed, Minimum, Potential, Stability};
use crate::sparse::{Inertia, Ldl, Triplets};

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The most steps.
    pub most_iterations: usize,
    /// The largest free force over the largest load: the one criterion, for every system and unit.
    pub tolerance: f64,
    /// The first limit of a parameter's change in a step, in sizes of the largest solid; it adapts.
    pub first_radius: f64,
    /// At a saddle, go on along a direction in which the energy falls.
    pub leave_saddles: bool,
    /// The state is only on the way to another: neither its stability is asked for, nor is a saddle left at its end.
    pub provisional: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            most_iterations: 400,
            tolerance: 1e-8,
            first_radius: 1.0,
            leave_saddles: true,
            provisional: false,
        }
    }
}

/// A shift or eigenvalue below this part of the largest diagonal entry is neutral.
const NEUTRAL: f64 = 1e-12;
/// Shifts of an indefinite matrix, in its scale: from, to.
const LEAST_SHIFT: f64 = 1e-4;
const MOST_SHIFT: f64 = 1e-1;
/// Each shift tried, in the one before.
const GROWS: f64 = 8.0;
/// A state this many sizes away has no equilibrium near.
const FAR: f64 = 1e4;
/// Leaving a saddle must lower the energy by this part of it: more than rounding.
const LOWER: f64 = 1e-12;
/// Directions of falling energy followed away from saddles.
const MOST_SADDLES: usize = 8;
/// Free forces below this part of the largest load, with a falling direction, mean a saddle near.
const NEAR_SADDLE: f64 = 1e-3;

/// A whole step that leaves this part of the free forces says that the matrix has hardly changed: the next step is made with the one
/// before, whose factors are there.
const HARDLY: f64 = 1.0 / 32.0;
/// A step with an old matrix must leave no more than this part for another one.
const ENOUGH: f64 = 1.0 / 8.0;

/// The method, with the memory it keeps from one search to the next.
#[derive(Debug, Default)]
pub struct Newton {
    /// When to stop.
    pub settings: Settings,
    pub(super) ldl: Ldl,
    matrix: Triplets,
    /// Where the true matrix of the last step was not positive definite, a direction of negative curvature.
    pub(super) falling: Option<Vec<f64>>,
    /// The last shift that made the matrix positive definite.
    shift: f64,
    /// The factors are those of a true matrix, without a shift.
    unshifted: bool,
    /// Of each unknown, beside the largest.
    stiffness: Vec<f64>,
}

/// Counters.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Work {
    iterations: usize,
    evaluations: usize,
    factorisations: usize,
    projected: usize,
    saddles: usize,
}

impl Newton {
    /// The method with these settings.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            ..Self::default()
        }
    }

    /// Moves `a` to a stationary state of the energy by steps none of which raises it.
    ///
    /// Done where the largest free force is at most `tolerance` times the largest load or reaction, or at the level of
    /// rounding (absolute stiffness times absolute displacement times 2^-52, unknown by unknown).
    ///
    /// # Errors
    /// [`Failed`]. `a` is then the last state.
    pub fn minimise(&mut self, potential: &impl Potential, a: &mut Vec<f64>) -> Result<Minimum, Failed> {
        let mut work = Work::default();
        let mut at = Point::of(potential, a).ok_or(Failed::NoEnergy)?;
        let mut radius = self.settings.first_radius * potential.extent();
        let mut rounding = vec![0.0; a.len()];
        // What the last whole step left of the free forces, if its matrix will do for the next.
        let (mut left, mut before): (Option<f64>, f64) = (None, 0.0);
        loop {
            let (residual, load) = at.balance(potential, a);
            let again = left.is_some_and(|most| residual <= most * before);
            let wanted = self.settings.tolerance * load;
            if at.within(potential, wanted, &rounding, 1.0) {
                if self.settings.provisional {
                    return self.minimum(potential, a, &at, Stability::default(), work);
                }
                let stability = self.stability(potential, a, &mut work)?;
                // The factorisation left is that of `stability`.
                self.falling = self.ldl.falling_direction();
                if stability.falling == 0 || !self.leave(potential, a, &mut at, &mut work) {
                    return self.minimum(potential, a, &at, stability, work);
                }
            }
            let failed = Failed::NotConverged {
                iterations: work.iterations,
                residual,
                load,
            };
            if work.iterations >= self.settings.most_iterations {
                return self.ended(potential, a, &at, wanted, &mut work).unwrap_or(Err(failed));
            }
            work.iterations += 1;
            before = residual;
            if again {
                left = self.again(potential, a, &mut at, radius, &mut work);
                continue;
            }
            let step = self.step(potential, a, &at, &mut work).ok_or(failed)?;
            // Near a saddle the convex steps crawl: the force that leads away from it is small.
            if residual <= NEAR_SADDLE * load && self.leave(potential, a, &mut at, &mut work) {
                continue;
            }
            rounding = self.matrix.absolute_product(a);
            let line = Line::new(potential, a, &at, step, radius);
            let Some(next) = line.search(&mut work.evaluations) else {
                // No step lowers the energy any more: rounding, if the forces are near it.
                if residual <= 1e3 * wanted && at.within(potential, 0.0, &rounding, 1e2) {
                    let stability = self.stability(potential, a, &mut work)?;
                    return self.minimum(potential, a, &at, stability, work);
                }
                return self.ended(potential, a, &at, wanted, &mut work).unwrap_or(Err(failed));
            };
            radius = line.next_radius(&next, radius);
            left = (self.unshifted && line.whole(&next)).then_some(HARDLY);
            at = next.point;
            *a = next.a;
            let distance = largest(a);
            if distance > FAR * potential.extent() {
                let extents = distance / potential.extent();
                return Err(Failed::Unbounded {
                    iterations: work.iterations,
                    distance,
                    extents,
                });
            }
        }
    }

    /// A step with the factors of the step before. What it may leave of the free forces, for another; `None` where it is none, and `a` is as
    /// it was, or not whole.
    fn again(
        &mut self,
        potential: &impl Potential,
        a: &mut Vec<f64>,
        at: &mut Point,
        radius: f64,
        work: &mut Work,
    ) -> Option<f64> {
        let step = self.finite_step(potential, at)?;
        let line = Line::new(potential, a, at, step, radius);
        let next = line.search(&mut work.evaluations)?;
        let left = line.whole(&next).then_some(ENOUGH);
        *at = next.point;
        *a = next.a;
        left
    }

    /// Newton's step from a state, with its largest free force and load. `None` without energy, or without a step.
    pub(crate) fn direction(&mut self, potential: &impl Potential, a: &[f64]) -> Option<(Vec<f64>, [f64; 2])> {
        let at = Point::of(potential, a)?;
        let (residual, load) = at.balance(potential, a);
        let mut work = Work::default();
        let step = self.step(potential, a, &at, &mut work)?;
        Some((step, [residual, load]))
    }

    /// The direction of falling energy at the last saddle, once.
    pub(crate) fn falling(&mut self) -> Option<Vec<f64>> {
        self.falling.take()
    }

    /// The largest free force of a state, and the largest load or reaction. `None` without energy.
    pub(crate) fn balance(potential: &impl Potential, a: &[f64]) -> Option<[f64; 2]> {
        Point::of(potential, a).map(|at| at.balance(potential, a).into())
    }

    /// True where every free force of a state is below `wanted` or what rounding leaves of it.
    pub(crate) fn rounded(potential: &impl Potential, a: &[f64], wanted: f64) -> bool {
        Point::of(potential, a).is_some_and(|at| at.rounded(potential, a, wanted))
    }

    /// The second derivatives with fixed unknowns out of the way, and their largest diagonal entry.
    fn assemble(&mut self, potential: &impl Potential, a: &[f64], convex: bool) -> Option<f64> {
        potential.hessian(a, convex, &mut self.matrix)?;
        let scale = largest(&self.matrix.diagonal());
        self.matrix.fix(potential.fixed(), scale.max(f64::MIN_POSITIVE));
        self.ldl.take(&self.matrix);
        potential.relative_stiffness(&mut self.stiffness);
        self.ldl.weigh(&self.stiffness);
        Some(scale)
    }

    /// Newton's step: with the true matrix if it is positive definite, else with a shift that makes it so, else with the
    /// convex one.
    fn step(&mut self, potential: &impl Potential, a: &[f64], at: &Point, work: &mut Work) -> Option<Vec<f64>> {
        let scale = self.assemble(potential, a, false)?;
        // Without any stiffness, as a falling rigid solid, the step follows the forces.
        let unit = if scale > 0.0 {
            scale.min(potential.stiffness())
        } else {
            largest(&at.gradient) / potential.extent()
        };
        (self.falling, self.unshifted) = (None, false);
        for neutral in [0.0, 1e-10] {
            work.factorisations += 1;
            match self.ldl.definite(neutral * unit) {
                Ok(true) => {
                    (self.shift, self.unshifted) = (0.0, true);
                    return self.finite_step(potential, at);
                }
                Ok(false) => {
                    self.falling = self.ldl.falling_direction();
                    break;
                }
                Err(_) => {}
            }
        }
        work.projected += 1;
        if self.shifted(unit, work) {
            return self.finite_step(potential, at);
        }
        self.assemble(potential, a, true)?;
        let shifts = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1e2];
        shifts.iter().find(|s| self.definite(*s * unit, work))?;
        self.finite_step(potential, at)
    }

    /// Shifts the matrix by as little as makes it definite; false where no shift does.
    ///
    /// First all unknowns alike, by parts of the softest stiffness: what is stiff rolls and slides on what is soft as that lets it, and a part of
    /// its own stiffness would hold it. Then each by parts of its own.
    fn shifted(&mut self, unit: f64, work: &mut Work) -> bool {
        let softest = self.stiffness.iter().copied().fold(1.0, f64::min);
        let alike = vec![softest; self.stiffness.len()];
        if self.shifted_by(&alike, unit, work) {
            return true;
        }
        let own = std::mem::take(&mut self.stiffness);
        let found = softest < 1.0 && self.shifted_by(&own, unit, work);
        self.stiffness = own;
        found
    }

    fn shifted_by(&mut self, weights: &[f64], unit: f64, work: &mut Work) -> bool {
        self.ldl.weigh(weights);
        let mut shift = (self.shift / 4.0).max(LEAST_SHIFT);
        while shift <= MOST_SHIFT {
            if self.definite(shift * unit, work) {
                self.shift = shift;
                return true;
            }
            shift *= GROWS;
        }
        false
    }

    fn definite(&mut self, shift: f64, work: &mut Work) -> bool {
        work.factorisations += 1;
        self.ldl.definite(shift).is_ok_and(|definite| definite)
    }

    fn finite_step(&self, potential: &impl Potential, at: &Point) -> Option<Vec<f64>> {
        Some(self.solve(potential, at)).filter(|step| step.iter().all(|s| s.is_finite()))
    }

    fn solve(&self, potential: &impl Potential, at: &Point) -> Vec<f64> {
        let free = at.gradient.iter().zip(potential.fixed());
        let mut step: Vec<f64> = free.map(|(g, fixed)| if *fixed { 0.0 } else { -g }).collect();
        self.ldl.solve(&mut step);
        step
    }

    /// Counts eigenvalues below `-tau` and within `tau` of zero by two factorisations (Sylvester).
    pub(super) fn stability(
        &mut self,
        potential: &impl Potential,
        a: &[f64],
        work: &mut Work,
    ) -> Result<Stability, Failed> {
        let scale = self.assemble(potential, a, false).ok_or(Failed::NoEnergy)?;
        // Not below what the stiffest contact leaves of the digits.
        let (least, own) = (4.0 * f64::EPSILON * scale, NEUTRAL * scale.min(potential.stiffness()));
        let tau = own.max(least).max(f64::MIN_POSITIVE);
        self.stiffness.iter_mut().for_each(|s| *s = (*s * own).max(least) / tau);
        self.ldl.weigh(&self.stiffness);
        let mut negative = |shift: f64| -> usize {
            work.factorisations += 1;
            // A pivot that vanishes at one shift does not at a neighbour.
            let tries = [1.0, 1.37, 0.71, 2.03];
            let found = tries.iter().find_map(|t| self.ldl.shifted(t * shift).ok());
            found.unwrap_or(Inertia::default()).negative
        };
        let below = negative(-tau);
        // Where none lies below `tau`, none lies below `-tau`.
        let falling = if below == 0 { 0 } else { negative(tau) };
        Ok(Stability {
            falling,
            neutral: below.saturating_sub(falling),
        })
    }

    /// Leaves a saddle along a direction of falling energy, either way. False where there is none, or too often.
    fn leave(&mut self, potential: &impl Potential, a: &mut Vec<f64>, at: &mut Point, work: &mut Work) -> bool {
        if !self.settings.leave_saddles || work.saddles >= MOST_SADDLES {
            return false;
        }
        let Some(mut direction) = self.falling.take() else {
            return false;
        };
        work.saddles += 1;
        for (d, fixed) in direction.iter_mut().zip(potential.fixed()) {
            *d = if *fixed { 0.0 } else { *d };
        }
        let size = 1e-2 * potential.extent() / largest(&direction).max(f64::MIN_POSITIVE);
        for k in 0..24 {
            let by = size * 0.5_f64.powi(k / 2) * if k % 2 == 0 { 1.0 } else { -1.0 };
            let step: Vec<f64> = direction.iter().map(|d| d * by).collect();
            let reach = potential.reach(a, &step);
            let moved: Vec<f64> = a.iter().zip(&step).map(|(a, s)| a + reach * s).collect();
            work.evaluations += 1;
            if let Some(point) = Point::of(potential, &moved).filter(|p| p.energy < at.energy - LOWER * at.energy.abs())
            {
                *a = moved;
                *at = point;
                return true;
            }
        }
        false
    }

    pub(super) fn minimum(
        &self,
        potential: &impl Potential,
        a: &[f64],
        at: &Point,
        stability: Stability,
        work: Work,
    ) -> Result<Minimum, Failed> {
        let least_determinant = potential.least_determinant(a);
        if least_determinant.is_nan() || least_determinant <= 0.0 {
            return Err(Failed::Inverted { least_determinant });
        }
        let (residual, load) = at.balance(potential, a);
        Ok(Minimum {
            energy: at.energy,
            residual,
            load,
            rounding: Rounding::of(potential, a).largest(potential.fixed()),
            stability,
            least_determinant,
            iterations: work.iterations,
            evaluations: work.evaluations,
            factorisations: work.factorisations,
            projected: work.projected,
        })
    }
}
