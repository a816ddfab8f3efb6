//! The factored second derivatives that steps are made with, and the inertia that tells minima from saddles.

use super::evaluation::{Evaluation, largest};
use super::report::Work;
use super::{Failed, Potential, Stability};
use crate::sparse::{Dissection, Ldl, Triplets};

/// An eigenvalue below this part of the softest stiffness is neutral.
const NEUTRAL_PART: f64 = 1e-12;
/// Rigid motions that nothing holds: so little is added to a matrix that is singular, in its scale.
// 1e-10 lies far above a zero pivot (1e-14 of its diagonal entry, see `front`), and shortens a step against the
// stiffness of a solid by 1e-10 of itself only.
const HELD_PARTS: [f64; 2] = [0.0, 1e-10];
/// Shifts of an indefinite matrix, in its scale: from, to, and each in the one before.
const LEAST_SHIFT: f64 = 1e-4;
const MOST_SHIFT: f64 = 1e-1;
const SHIFT_GROWTH: f64 = 8.0;
/// Shifts of the convex matrix, which may still be singular, in the same.
// The last ones outweigh the solids' own stiffness: such a step follows the forces.
const CONVEX_SHIFTS: [f64; 8] = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1e2];

/// The factors of the last matrix, with the memory that is kept from one to the next.
#[derive(Debug, Default)]
pub(super) struct Factors {
    ldl: Ldl,
    matrix: Triplets,
    /// The last shift that made the matrix positive definite.
    shift: f64,
    /// Of each unknown, beside the largest.
    stiffness: Vec<f64>,
    /// The factors are those of the true second derivatives: no shift has made them positive definite.
    pub(super) unshifted: bool,
    /// Where the true matrix was not positive definite, a direction of negative curvature.
    pub(super) negative_curvature: Option<Vec<f64>>,
}

impl Factors {
    /// Factors in an order that is found once, from this.
    pub(super) fn ordered_by(dissection: Dissection) -> Self {
        Self {
            ldl: Ldl::ordered_by(dissection),
            ..Self::default()
        }
    }

    /// Newton's step from a state: with the true matrix if that is positive definite, else with a shift that makes it so, else
    /// with the convex one. `None` where none of them leads to finite numbers.
    pub(super) fn new_step(
        &mut self,
        potential: &impl Potential,
        a: &[f64],
        at: &Evaluation,
        work: &mut Work,
    ) -> Option<Vec<f64>> {
        let scale = self.assemble(potential, a, false)?;
        // Without any stiffness, as of a falling rigid solid, the step follows the forces.
        let unit = if scale > 0.0 {
            // Barriers may be much stiffer than solids: a shift by their scale would hold what solids let move.
            scale.min(potential.stiffness())
        } else {
            largest(&at.gradient) / potential.extent()
        };
        if self.is_definite_as_it_is(unit, work) {
            return self.step(potential, at);
        }
        work.projected += 1;
        if self.make_definite(unit, work) {
            return self.step(potential, at);
        }
        // Convex tangents lack the curvature of contacts, so that steps with them oscillate: they come last.
        self.assemble(potential, a, true)?;
        CONVEX_SHIFTS.iter().find(|s| self.is_definite(*s * unit, work))?;
        self.step(potential, at)
    }

    /// The step with the factors at hand, from whatever state they are of.
    pub(super) fn step(&self, potential: &impl Potential, at: &Evaluation) -> Option<Vec<f64>> {
        let free = at.gradient.iter().zip(potential.fixed());
        let mut step: Vec<f64> = free.map(|(g, fixed)| if *fixed { 0.0 } else { -g }).collect();
        self.ldl.solve(&mut step);
        Some(step).filter(|step| step.iter().all(|s| s.is_finite()))
    }

    /// Absolute entries of the last matrix times absolute unknowns: times 2^-52 the rounding of the forces.
    pub(super) fn rounding_scale(&self, a: &[f64]) -> Vec<f64> {
        self.matrix.absolute_product(a)
    }

    /// The direction of negative curvature that the last factorisation has found.
    pub(super) fn negative_curvature_of_last(&self) -> Option<Vec<f64>> {
        self.ldl.falling_direction()
    }

    /// The second derivatives with fixed unknowns out of the way, and their largest diagonal entry.
    fn assemble(&mut self, potential: &impl Potential, a: &[f64], convex: bool) -> Option<f64> {
        potential.hessian(a, convex, &mut self.matrix)?;
        let scale = largest(&self.matrix.diagonal());
        // A matrix of zeros, as of rigid solids out of contact, must not leave a fixed unknown without a pivot.
        self.matrix.fix(potential.fixed(), scale.max(f64::MIN_POSITIVE));
        self.ldl.take(&self.matrix);
        potential.relative_stiffness(&mut self.stiffness);
        self.ldl.weigh(&self.stiffness);
        Some(scale)
    }

    /// Factors the true matrix. False, with a direction of negative curvature, where it is not positive definite.
    fn is_definite_as_it_is(&mut self, unit: f64, work: &mut Work) -> bool {
        (self.negative_curvature, self.unshifted) = (None, false);
        for part in HELD_PARTS {
            work.factorisations += 1;
            match self.ldl.definite(part * unit) {
                Ok(true) => {
                    (self.shift, self.unshifted) = (0.0, true);
                    return true;
                }
                Ok(false) => {
                    self.negative_curvature = self.ldl.falling_direction();
                    return false;
                }
                // A pivot vanishes: the matrix is singular as it is.
                Err(_) => {}
            }
        }
        false
    }

    /// Shifts the matrix by as little as makes it definite; false where no shift does.
    ///
    /// First all unknowns alike, by parts of the softest stiffness: what is stiff rolls and slides on what is soft as that lets
    /// it, and a part of its own stiffness would hold it. Then each by parts of its own.
    fn make_definite(&mut self, unit: f64, work: &mut Work) -> bool {
        let softest = self.stiffness.iter().copied().fold(1.0, f64::min);
        let alike = vec![softest; self.stiffness.len()];
        if self.make_definite_by(&alike, unit, work) {
            return true;
        }
        let own = std::mem::take(&mut self.stiffness);
        let found = softest < 1.0 && self.make_definite_by(&own, unit, work);
        self.stiffness = own;
        found
    }

    fn make_definite_by(&mut self, weights: &[f64], unit: f64, work: &mut Work) -> bool {
        self.ldl.weigh(weights);
        // A quarter of the last shift lets it fall again; the second try is twice the last.
        let mut shift = (self.shift / 4.0).max(LEAST_SHIFT);
        while shift <= MOST_SHIFT {
            if self.is_definite(shift * unit, work) {
                self.shift = shift;
                return true;
            }
            shift *= SHIFT_GROWTH;
        }
        false
    }

    fn is_definite(&mut self, shift: f64, work: &mut Work) -> bool {
        work.factorisations += 1;
        self.ldl.definite(shift).is_ok_and(|definite| definite)
    }

    /// Counts eigenvalues below `-tau` and within `tau` of zero (Sylvester's law of inertia): by one factorisation where none is
    /// below `tau`, else by two.
    pub(super) fn stability(
        &mut self,
        potential: &impl Potential,
        a: &[f64],
        work: &mut Work,
    ) -> Result<Stability, Failed> {
        let scale = self.assemble(potential, a, false).ok_or(Failed::NoEnergy)?;
        // Not below what the stiffest contact leaves of the digits.
        let least = 4.0 * f64::EPSILON * scale;
        // In the solids' scale, since a stiff contact would make all that is soft neutral.
        let own = NEUTRAL_PART * scale.min(potential.stiffness());
        let tau = own.max(least).max(f64::MIN_POSITIVE);
        // Weights such that `tau` times each is that unknown's own bound, and none below the rounding.
        self.stiffness.iter_mut().for_each(|s| *s = (*s * own).max(least) / tau);
        self.ldl.weigh(&self.stiffness);
        let mut negative = |shift: f64| -> Result<usize, Failed> {
            work.factorisations += 1;
            // A pivot that vanishes at one shift does not at a neighbour.
            let tries = [1.0, 1.37, 0.71, 2.03];
            let found = tries.iter().find_map(|t| self.ldl.shifted(t * shift).ok());
            // Without a factor nothing is known of the eigenvalues: none counted would be a minimum stated.
            found.map(|inertia| inertia.negative).ok_or(Failed::NoInertia)
        };
        // The matrix less `tau` has a negative pivot for every eigenvalue below `tau`, the matrix plus `tau` for every
        // one below `-tau`: the difference is neutral.
        let below = negative(-tau)?;
        // Where none lies below `tau`, none lies below `-tau`.
        let negative_eigenvalues = if below == 0 { 0 } else { negative(tau)? };
        Ok(Stability {
            falling: negative_eigenvalues,
            neutral: below.saturating_sub(negative_eigenvalues),
        })
    }
}
