//! Energy and gradient of a state, and what the gradient says of its balance.

use super::Potential;
use super::rounding::Rounding;

/// Without any load forces are measured by so many times what rounding leaves of them.
// The inverse of the default tolerance of 1e-8: rounding alone is then just within it.
const LOADS_PER_ROUNDING: f64 = 1e8;

/// Energy and gradient of a state.
#[derive(Debug, Clone)]
pub(super) struct Evaluation {
    pub(super) energy: f64,
    pub(super) gradient: Vec<f64>,
}

/// The forces of a state, both the largest of their kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Balance {
    /// Of the free forces: what is out of balance.
    pub(super) residual: f64,
    /// Of the outer forces and the reactions of what is fixed: what residuals are measured by.
    pub(super) load: f64,
}

/// The largest absolute value.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

impl Evaluation {
    /// `None` where the state has no energy, or numbers that are not finite.
    pub(super) fn of(potential: &impl Potential, a: &[f64]) -> Option<Self> {
        let mut gradient = vec![0.0; potential.size()];
        let energy = potential.gradient(a, &mut gradient)?;
        // An energy of minus infinity, or a gradient with a NaN, would pass the line search, which compares energies
        // only.
        let finite = energy.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then_some(Self { energy, gradient })
    }

    /// The largest free force and the largest load.
    ///
    /// Where nothing is loaded or fixed, the load is the largest force of a constraint, or where there is none either so much
    /// that 1e-8 of it is rounding.
    pub(super) fn balance(&self, potential: &impl Potential, a: &[f64]) -> Balance {
        let (mut residual, mut load) = (0.0_f64, 0.0_f64);
        for (i, (g, fixed)) in self.gradient.iter().zip(potential.fixed()).enumerate() {
            if *fixed {
                // The gradient of a fixed unknown is the reaction of its support.
                load = load.max(g.abs());
            } else {
                residual = residual.max(g.abs());
                load = load.max(potential.load(i).abs());
            }
        }
        // A tolerance relative to no load at all could not be met.
        if load == 0.0 {
            let rounding = Rounding::of(potential, a).largest(potential.fixed());
            load = potential.reaction(a).max(LOADS_PER_ROUNDING * rounding);
        }
        Balance { residual, load }
    }

    /// True where every free force is below `force_tolerance`, or below so many roundings of it by the last matrix:
    /// `roundings` times 2^-52 of its number in `rounding_scale`.
    pub(super) fn is_within_matrix_rounding(
        &self,
        potential: &impl Potential,
        force_tolerance: f64,
        rounding_scale: &[f64],
        roundings: f64,
    ) -> bool {
        let free = self.gradient.iter().zip(potential.fixed()).zip(rounding_scale);
        free.filter(|((_, fixed), _)| !**fixed)
            .all(|((g, _), scale)| g.abs() <= force_tolerance.max(roundings * f64::EPSILON * scale))
    }

    /// True where every free force is below `force_tolerance` or what rounding may leave of it by the potential's account.
    pub(super) fn is_within_potential_rounding(
        &self,
        potential: &impl Potential,
        a: &[f64],
        force_tolerance: f64,
    ) -> bool {
        Rounding::of(potential, a).covers(potential, &self.gradient, force_tolerance)
    }
}
