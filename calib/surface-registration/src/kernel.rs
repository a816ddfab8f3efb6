//! What a residual costs that may be a gross error: two criteria, both equal to the square near 0.

/// A criterion; lengths are in deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// `m^2 s^2 / (m^2 + s^2)` (Geman and McClure 1985): never quite blind, so that a fit still feels where points lie that are far
    /// off. For the search, from wide to narrow (graduated non-convexity, Yang et al. 2020).
    Wide(f64),
    /// `c^2/3 (1 - (1 - s^2/c^2)^3)`, constant from `c` on (Tukey's biweight): what is beyond has no say at all. For the end.
    Tukey(f64),
}

impl Kernel {
    /// Cost and weight of a residual of this square; the weight is the derivative of the cost by the square.
    #[inline]
    pub(crate) fn at(self, square: f64) -> (f64, f64) {
        match self {
            Self::Wide(m) => {
                let share = m * m / (m * m + square);
                (square * share, share * share)
            }
            Self::Tukey(c) => {
                let left = (1.0 - square / (c * c)).max(0.0);
                (c * c / 3.0 * (1.0 - left * left * left), left * left)
            }
        }
    }

    /// From where on the weight is 0, deviations.
    #[inline]
    pub(crate) fn reach(self) -> f64 {
        match self {
            Self::Wide(_) => f64::INFINITY,
            Self::Tukey(c) => c,
        }
    }

    /// The cost of what lies infinitely far away.
    #[inline]
    pub(crate) fn most(self) -> f64 {
        match self {
            Self::Wide(m) => m * m,
            Self::Tukey(c) => c * c / 3.0,
        }
    }
}

/// By how much the variance of a fit of normal residuals exceeds the inverse of its weighted normal equations, with Tukey's constant
/// `c`: `E[(w s)^2] E[w] / E[(w s)']^2`.
pub(crate) fn tukey_variance(c: f64) -> f64 {
    let [scatter, slope, weight] = moments(c);
    scatter * weight / (slope * slope)
}

/// `E[(w s)^2]` of normal residuals that have a say.
pub(crate) fn tukey_scatter(c: f64) -> f64 {
    moments(c)[0]
}

/// `E[(w s)^2]`, `E[(w s)']` and `E[w]`, by quadrature over the normal law.
fn moments(c: f64) -> [f64; 3] {
    let (mut psi2, mut slope, mut weight) = (0.0, 0.0, 0.0);
    // The rule of the middle on a smooth function: right to 1e-4. Beyond 8 deviations there is nothing.
    const STEPS: usize = 200;
    let end = c.min(8.0);
    for i in 0..STEPS {
        let s = (i as f64 + 0.5) / STEPS as f64 * end;
        let left = 1.0 - s * s / (c * c);
        let density = (-0.5 * s * s).exp() * 2.0 / std::f64::consts::TAU.sqrt() * end / STEPS as f64;
        psi2 += density * (left * left * s).powi(2);
        slope += density * (left * left - 4.0 * left * s * s / (c * c));
        weight += density * left * left;
    }
    [psi2, slope, weight]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_is_the_slope_of_the_cost_and_the_cost_begins_as_the_square() {
        for kernel in [Kernel::Wide(3.0), Kernel::Wide(40.0), Kernel::Tukey(4.5)] {
            for square in [0.3, 2.0, 9.0, 19.0, 400.0] {
                let h = 1e-5;
                let slope = (kernel.at(square + h).0 - kernel.at(square - h).0) / (2.0 * h);
                assert!((slope - kernel.at(square).1).abs() < 1e-8, "{kernel:?} {square}");
            }
            assert!((kernel.at(1e-9).0 / 1e-9 - 1.0).abs() < 1e-6);
            assert!((kernel.at(1e12).0 / kernel.most() - 1.0).abs() < 1e-6);
        }
    }

    /// Tukey's constant of 4.685 has the efficiency 0.95 (Holland and Welsch 1977), here times the mean weight.
    #[test]
    fn the_variance_of_the_biweight_is_that_of_the_tables() {
        let mean_weight = tukey_variance(4.685) / (1.0 / 0.95);
        assert!((0.90..0.93).contains(&mean_weight), "{mean_weight}");
        assert!((tukey_variance(1e3) - 1.0).abs() < 1e-3);
    }
}
