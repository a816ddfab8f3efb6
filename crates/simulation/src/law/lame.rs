//! Lamé's coefficients from Young's modulus and Poisson's ratio.

use super::Refused;

/// Lamé's coefficients, in units of stress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lame {
    /// `lambda = E nu / ((1 - 2 nu)(1 + nu))` (III 3.22).
    pub lambda: f64,
    /// `mu = E / (2 (1 + nu))`, for `Sigma = lambda tr(E) I + 2 mu E`. The thesis prints twice that (III 3.23), which
    /// makes a bar nearly twice too stiff.
    pub mu: f64,
}

impl Lame {
    /// The coefficients of a Young's modulus, in units of stress, and a Poisson's ratio.
    ///
    /// # Errors
    /// [`Refused::Young`], [`Refused::Poisson`].
    pub fn new(young: f64, poisson: f64) -> Result<Self, Refused> {
        // Written so that a NaN is refused too.
        if !(young.is_finite() && young > 0.0) {
            return Err(Refused::Young { found: young });
        }
        if !(poisson > -1.0 && poisson < 0.5) {
            return Err(Refused::Poisson { found: poisson });
        }
        Ok(Self {
            lambda: young * poisson / ((1.0 - 2.0 * poisson) * (1.0 + poisson)),
            mu: young / (2.0 * (1.0 + poisson)),
        })
    }

    /// Young's modulus, `mu (3 lambda + 2 mu) / (lambda + mu)`.
    pub fn young(&self) -> f64 {
        self.mu * (3.0 * self.lambda + 2.0 * self.mu) / (self.lambda + self.mu)
    }

    /// The stiffness of a confined bar, `lambda + 2 mu`: the scale of every stiffness of the material.
    pub fn confined(&self) -> f64 {
        self.lambda + 2.0 * self.mu
    }
}
