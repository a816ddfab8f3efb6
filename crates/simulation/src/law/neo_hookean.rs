//! Neo-Hookean laws, in the form `(mu / 2) q(G) + u(J)`.
//!
//! `q = |G|^2 - 2 det G = (G11 - G22)^2 + (G12 + G21)^2` holds no linear term, so that small strains keep their digits:
//! `|F|^2 - 2 = q + 2 (J - 1)`.
//!
//! * compressible: `w = mu/2 (|F|^2 - 2) - mu ln J + lambda/2 (ln J)^2`, infinite at `J = 0`;
//! * stable (Smith, de Goes and Kim 2018): `w = mu/2 (|F|^2 - 2) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2`, finite at
//!   inversion, so that an inverted start can recover.

use nalgebra::{Matrix4, Vector4};

use super::response::{COFACTOR, IDENTITY, Response, Volume, cofactor, excess, of_determinant};

/// `x - ln(1 + x)` to full relative precision near 0; `x > -1`.
pub(crate) fn x_minus_ln_1p(x: f64) -> f64 {
    if x.abs() > SERIES_BELOW {
        x - x.ln_1p()
    } else {
        series(x)
    }
}

/// Below it the series of [`x_minus_ln_1p`] has all digits.
const SERIES_BELOW: f64 = 0.1;

fn series(x: f64) -> f64 {
    // ln(1 + x) = 2 artanh s with s = x / (2 + x), and x - 2 s = x s.
    let s = x / (2.0 + x);
    let s2 = s * s;
    // The first term left out is `s^15 / 17` of the result, and `|s| <= 1/19`: below 1e-20.
    let terms = [3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0];
    let series = terms.iter().rev().fold(0.0, |sum, k| 1.0 / k + s2 * sum);
    x * s - 2.0 * s * s2 * series
}

fn q(g: &Vector4<f64>) -> f64 {
    let (stretch, shear) = (g[0] - g[3], g[1] + g[2]);
    stretch * stretch + shear * shear
}

/// `(mu / 2) q` and its derivatives.
fn isochoric(mu: f64, g: &Vector4<f64>) -> Response {
    Response {
        density: 0.5 * mu * q(g),
        stress: (g - cofactor(g)) * mu,
        tangent: (Matrix4::identity() - COFACTOR) * mu,
    }
}

fn sum(a: &Response, b: &Response) -> Response {
    Response {
        density: a.density + b.density,
        stress: a.stress + b.stress,
        tangent: a.tangent + b.tangent,
    }
}

/// `(mu / 2) q + mu (J - 1 - ln J)`. `None` where `J <= 0`.
pub(super) fn shear_density(mu: f64, g: &Vector4<f64>) -> Option<f64> {
    let x = excess(g);
    (x > -1.0).then(|| 0.5 * mu * q(g) + mu * x_minus_ln_1p(x))
}

pub(super) fn shear(mu: f64, g: &Vector4<f64>) -> Option<Response> {
    let x = excess(g);
    let j = 1.0 + x;
    (j > 0.0).then(|| {
        let rest = of_determinant(g, mu * x_minus_ln_1p(x), mu * x / j, mu / (j * j));
        sum(&isochoric(mu, g), &rest)
    })
}

/// The compressible law whole: density and stress. `None` where `J <= 0`.
pub(super) fn stress([lambda, mu]: [f64; 2], g: &Vector4<f64>) -> Option<(f64, Vector4<f64>)> {
    let x = excess(g);
    let j = 1.0 + x;
    (j > 0.0).then(|| {
        let theta = x.ln_1p();
        // As in [`x_minus_ln_1p`], with the logarithm at hand.
        let rest = if x.abs() > SERIES_BELOW { x - theta } else { series(x) };
        let density = 0.5 * mu * q(g) + mu * rest + 0.5 * lambda * theta * theta;
        let cofactor = cofactor(g);
        let stress = (g - cofactor) * mu + (IDENTITY + cofactor) * ((mu * x + lambda * theta) / j);
        (density, stress)
    })
}

/// And its tangent. `None` also where a number is not finite.
pub(super) fn tangent([lambda, mu]: [f64; 2], g: &Vector4<f64>) -> Option<Matrix4<f64>> {
    let x = excess(g);
    let j = 1.0 + x;
    // An infinite `x` would pass `j > 0` and leave NaN in the tangent.
    (j > 0.0 && x.is_finite()).then(|| {
        let theta = x.ln_1p();
        let (first, second) = ((mu * x + lambda * theta) / j, (mu + lambda * (1.0 - theta)) / (j * j));
        let cofactor = IDENTITY + cofactor(g);
        let mut tangent = cofactor * (cofactor * second).transpose();
        // `mu` times the identity, and what is left of it in the matrix of cofactors.
        for (k, sign) in [1.0, -1.0, -1.0, 1.0].into_iter().enumerate() {
            tangent[(k, k)] += mu;
            tangent[(k, 3 - k)] += sign * (first - mu);
        }
        tangent
    })
}

/// `theta = ln J`. `None` where `J <= 0`.
pub(super) fn log_volume(g: &Vector4<f64>) -> Option<Volume> {
    let x = excess(g);
    let j = 1.0 + x;
    (j > 0.0).then(|| {
        let r = of_determinant(g, x.ln_1p(), 1.0 / j, -1.0 / (j * j));
        Volume {
            theta: r.density,
            gradient: r.stress,
            hessian: r.tangent,
        }
    })
}

/// `(mu / 2) q + (mu / 2)(J - 1)^2`.
pub(super) fn stable_shear_density(mu: f64, g: &Vector4<f64>) -> f64 {
    let x = excess(g);
    0.5 * mu * (q(g) + x * x)
}

pub(super) fn stable_shear(mu: f64, g: &Vector4<f64>) -> Response {
    let x = excess(g);
    sum(&isochoric(mu, g), &of_determinant(g, 0.5 * mu * x * x, mu * x, mu))
}

/// `theta = J - 1`.
pub(super) fn stable_volume(g: &Vector4<f64>) -> Volume {
    Volume {
        theta: excess(g),
        gradient: IDENTITY + cofactor(g),
        hessian: COFACTOR,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_keeps_its_digits() {
        // x^2/2 - x^3/3 + x^4/4: the next term is x^5/5, below 1e-20 of the first.
        for x in [1e-5_f64, -1e-5, 1e-9, 1e-150] {
            let exact = x * x * (0.5 - x / 3.0 + x * x / 4.0);
            assert!((x_minus_ln_1p(x) / exact - 1.0).abs() < 1e-14, "{x}");
        }
        // Both branches meet; the direct one errs by an ulp of x over x^2 / 2.
        for x in [0.1_f64, -0.1, 0.0999, -0.0999] {
            let direct = x - x.ln_1p();
            assert!((x_minus_ln_1p(x) / direct - 1.0).abs() < 4e-15 / x.abs(), "{x}");
        }
    }
}
