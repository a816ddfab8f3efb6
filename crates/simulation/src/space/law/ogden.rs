//! Ogden's law in the three principal stretches:
//! `w = sum_p (m_p / a_p)(l1^a_p + l2^a_p + l3^a_p - 3) - M ln J + (lambda / 2)(ln J)^2`, `M = sum m_p`,
//! `sum m_p a_p = 2 mu`.
//!
//! The part without `lambda` is a sum over the stretches: with `h` as in the plane ([`crate::law::Ogden`]) its tangent has
//! the eigenvalues `h'(l_i)` and, for each pair, `(h_i + h_j) / (l_i + l_j)` (twist) and `(h_i - h_j) / (l_i - l_j)`
//! (flip), the last of which is a divided difference that keeps its digits where both stretches meet.

use super::principal::Principal;
use super::response::{Tangent, Tensor, add_square, excess};
use crate::law::Ogden;

/// Below it the series of [`exp_minus_1_minus`] has all digits.
const SERIES_BELOW: f64 = 0.5;

/// `e^x - 1 - x` to full relative precision near 0.
fn exp_minus_1_minus(x: f64) -> f64 {
    if x.abs() > SERIES_BELOW {
        return x.exp_m1() - x;
    }
    // Horner of `x^2/2 (1 + x/3 (1 + x/4 (1 + ...)))`; the first term left out is below 0.5^15 2 / 17!, 1e-19 of the first.
    let series = (3..=16).rev().fold(1.0, |sum, k| 1.0 + sum * x / f64::from(k));
    0.5 * x * x * series
}

/// Principal stretches and their logarithms. `None` where `det F <= 0`.
fn principal(g: &Tensor) -> Option<(Principal, [f64; 3])> {
    // False where it is not a number.
    let upright = excess(g) > -1.0;
    if !upright {
        return None;
    }
    // The determinant is asked before, as it costs far less than the stretches.
    let principal = Principal::of(g);
    let logs = principal.logs()?;
    Some((principal, logs))
}

fn density(ogden: &Ogden, mu: f64, logs: &[f64; 3]) -> f64 {
    // `m / a` is above 0 and so is each exponential's rest: a sum without cancellation.
    let of_term = |(m, a): &(f64, f64)| m / a * logs.iter().map(|log| exp_minus_1_minus(a * log)).sum::<f64>();
    2.0 * mu * ogden.terms().iter().map(of_term).sum::<f64>()
}

pub(super) fn shear_density(ogden: &Ogden, mu: f64, g: &Tensor) -> Option<f64> {
    principal(g).map(|(_, logs)| density(ogden, mu, &logs))
}

pub(super) fn shear_stress(ogden: &Ogden, mu: f64, g: &Tensor) -> Option<(f64, Tensor)> {
    let (principal, logs) = principal(g)?;
    let parts = (0..3).map(|i| principal.dyad(i, i) * ogden.h(logs[i]));
    Some((density(ogden, mu, &logs), parts.sum::<Tensor>() * (2.0 * mu)))
}

pub(super) fn shear_tangent(ogden: &Ogden, mu: f64, g: &Tensor) -> Option<Tangent> {
    let (principal, logs) = principal(g)?;
    let mut tangent = Tangent::zeros();
    for i in 0..3 {
        add_square(&mut tangent, &principal.dyad(i, i), 2.0 * mu * ogden.slope(logs[i]));
        let j = (i + 1) % 3;
        let [l, m] = [principal.stretches[i], principal.stretches[j]];
        // Both stretches are above 0 here: their sum never vanishes, though the difference in the flip may.
        let twist = (ogden.h(logs[i]) + ogden.h(logs[j])) / (l + m);
        // From the logarithms, whose difference is exact where both stretches meet.
        let flip = ogden.divided_difference([logs[i], logs[j]]);
        let (ij, ji) = (principal.dyad(i, j), principal.dyad(j, i));
        // The halves of the squares of `(ij -+ ji) / sqrt 2`.
        add_square(&mut tangent, &(ij - ji), mu * twist);
        add_square(&mut tangent, &(ij + ji), mu * flip);
    }
    Some(tangent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_keeps_its_digits() {
        for x in [1e-5_f64, -1e-5, 1e-9, 1e-100] {
            // The next term is x^5/120, below 1e-17 of the first.
            let exact = x * x * (0.5 + x / 6.0 + x * x / 24.0);
            assert!((exp_minus_1_minus(x) / exact - 1.0).abs() < 1e-15, "{x}");
        }
        for x in [0.5_f64, -0.5, 0.499, -0.499] {
            let direct = x.exp_m1() - x;
            // The direct difference errs by two units of 0.65 over 0.1.
            assert!((exp_minus_1_minus(x) / direct - 1.0).abs() < 4e-15, "{x}");
        }
    }
}
