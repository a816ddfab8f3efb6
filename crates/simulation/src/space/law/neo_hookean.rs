//! Neo-Hookean laws, in the form `(mu / 2) q(G) + u(J)`.
//!
//! `q = |F|^2 - 3 - 2 (J - 1) = |G|^2 - 2 (second invariant of G) - 2 det G` holds no linear term, so that small strains
//! keep their digits.
//!
//! * compressible: `w = mu/2 (|F|^2 - 3) - mu ln J + lambda/2 (ln J)^2`, infinite at `J = 0`;
//! * stable (Smith, de Goes and Kim 2018): `w = mu/2 (|F|^2 - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2`, finite at
//!   inversion, so that an inverted start can recover.

use super::response::{
    Tangent, Tensor, add_determinant_hessian, add_square, cofactor_excess, deformation, determinant, excess,
    isochoric_square,
};
use crate::law::x_minus_ln_1p;

fn q(g: &Tensor) -> f64 {
    isochoric_square(g) - 2.0 * determinant(g)
}

/// `mu (F - cof F) + slope cof F`, from `slope` the derivative of `u` by `J`.
fn stress(mu: f64, g: &Tensor, slope: f64) -> Tensor {
    // `F - cof F = G - (cof F - I)` to the last digit, as both lose the same I.
    let c = cofactor_excess(g);
    (g - c) * mu + deformation(&c) * slope
}

/// `mu I + first (second derivative of J) + second cof F cof F^T`.
fn tangent(mu: f64, g: &Tensor, [first, second]: [f64; 2]) -> Tangent {
    let mut tangent = Tangent::identity() * mu;
    add_determinant_hessian(&mut tangent, &deformation(g), first);
    add_square(&mut tangent, &deformation(&cofactor_excess(g)), second);
    tangent
}

/// `J` and `J - 1`. `None` where `J <= 0` or is no finite number.
fn positive(g: &Tensor) -> Option<(f64, f64)> {
    let x = excess(g);
    let j = 1.0 + x;
    // False where `J` is not a number, so that a NaN never becomes an energy.
    (j > 0.0 && j.is_finite()).then_some((j, x))
}

/// `(mu / 2) q + mu (J - 1 - ln J)`. `None` where `J <= 0`.
pub(super) fn shear_density(mu: f64, g: &Tensor) -> Option<f64> {
    positive(g).map(|(_, x)| 0.5 * mu * q(g) + mu * x_minus_ln_1p(x))
}

pub(super) fn shear_stress(mu: f64, g: &Tensor) -> Option<(f64, Tensor)> {
    let (j, x) = positive(g)?;
    // The slope `mu (1 - 1 / J)` in the form `mu x / J`, which keeps its digits where J is near 1.
    Some((0.5 * mu * q(g) + mu * x_minus_ln_1p(x), stress(mu, g, mu * x / j)))
}

/// That of the shear part and of `pressure ln J` at once: the parts cancel but for `pressure - mu`.
pub(super) fn tangent_at_pressure(mu: f64, g: &Tensor, pressure: f64) -> Option<Tangent> {
    // The `-mu J` in q and the `mu J` of the rest cancel: what is left of both is `-mu ln J`.
    positive(g).map(|(j, _)| tangent(mu, g, [(pressure - mu) / j, (mu - pressure) / (j * j)]))
}

/// `theta = ln J`. `None` where `J <= 0`.
pub(super) fn log_theta(g: &Tensor) -> Option<f64> {
    // Of `x`, not of `1 + x`: a strain of 1e-20 would be lost in the sum.
    positive(g).map(|(_, x)| x.ln_1p())
}

/// `theta` and its derivative.
pub(super) fn log_volume(g: &Tensor) -> Option<(f64, Tensor)> {
    let (j, x) = positive(g)?;
    Some((x.ln_1p(), deformation(&cofactor_excess(g)) / j))
}

/// Its second derivative.
pub(super) fn log_hessian(g: &Tensor) -> Option<Tangent> {
    // Without mu the shared form is that of any function of J alone.
    positive(g).map(|(j, _)| tangent(0.0, g, [1.0 / j, -1.0 / (j * j)]))
}

/// `(mu / 2) q + (mu / 2)(J - 1)^2`.
pub(super) fn stable_shear_density(mu: f64, g: &Tensor) -> f64 {
    let x = excess(g);
    // Alone `q` falls without bound in a large expansion: the square of x holds it.
    0.5 * mu * (q(g) + x * x)
}

pub(super) fn stable_shear_stress(mu: f64, g: &Tensor) -> (f64, Tensor) {
    (stable_shear_density(mu, g), stress(mu, g, mu * excess(g)))
}

/// And with that of `pressure (J - 1)`.
pub(super) fn stable_tangent_at_pressure(mu: f64, g: &Tensor, pressure: f64) -> Tangent {
    // The -1 is that of the linear term in q; nothing is divided by J, so that inverted states have a tangent too.
    tangent(mu, g, [mu * (excess(g) - 1.0) + pressure, mu])
}

/// `theta = J - 1`, and its derivative.
pub(super) fn stable_volume(g: &Tensor) -> (f64, Tensor) {
    (excess(g), deformation(&cofactor_excess(g)))
}

/// Its second derivative.
pub(super) fn stable_hessian(g: &Tensor) -> Tangent {
    let mut hessian = Tangent::zeros();
    add_determinant_hessian(&mut hessian, &deformation(g), 1.0);
    hessian
}
