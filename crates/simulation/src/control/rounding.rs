//! Forces that rounding leaves.
//!
//! An elastic force is a sum of stiffnesses times displacements, each rounded to 2^-53 of itself, and so are the displacements: what is left of it
//! at an equilibrium is up to some 2^-52 of the sum of their absolute values, whatever the load. So is a barrier's with the positions that
//! its gaps are differences of.

use super::Potential;

/// Roundings of each product: of the displacement, of the gradient that it enters, of the stress, of the force and of their sums.
const ROUNDINGS_PER_PRODUCT: f64 = 8.0;

/// What rounding may leave of each force.
pub(crate) struct Rounding(Vec<f64>);

impl Rounding {
    pub(crate) fn of(potential: &impl Potential, a: &[f64]) -> Self {
        let mut sizes = Vec::new();
        potential.rounding(a, &mut sizes);
        sizes
            .iter_mut()
            .for_each(|s| *s *= ROUNDINGS_PER_PRODUCT * f64::EPSILON);
        Self(sizes)
    }

    /// The largest of a free unknown; 0 where none is known.
    pub(crate) fn largest(&self, fixed: &[bool]) -> f64 {
        let free = self.0.iter().zip(fixed).filter(|(_, fixed)| !**fixed);
        free.map(|(r, _)| *r).fold(0.0, f64::max)
    }

    /// True where every free force is below `force_tolerance` or what rounding leaves of it.
    pub(crate) fn covers(&self, potential: &impl Potential, gradient: &[f64], force_tolerance: f64) -> bool {
        // No sizes means that rounding is not known: then it excuses nothing.
        let least = |i: usize| self.0.get(i).copied().unwrap_or(0.0);
        let each = gradient.iter().zip(potential.fixed()).enumerate();
        each.filter(|(_, (_, fixed))| !**fixed)
            .all(|(i, (g, _))| g.abs() <= force_tolerance.max(least(i)))
    }
}
