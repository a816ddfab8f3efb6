//! Ogden's law: `w = sum_p (m_p / a_p)(l1^a_p + l2^a_p - 2) - M ln J + (lambda / 2)(ln J)^2`, `M = sum m_p`, in the
//! principal stretches; `sum m_p a_p = 2 mu`.
//!
//! Derivatives by principal directions: with `h(l) = sum m_p (l^(a_p - 1) - 1 / l)` the tangent has the eigenvalues
//! `h'(l1)`, `h'(l2)`, `(h1 + h2) / (l1 + l2)` (twist) and `(h1 - h2) / (l1 - l2)` (flip).

use nalgebra::{Matrix4, Vector2, Vector4};

use super::Refused;
use super::response::{Response, excess};
use super::saint_venant::strain;

/// The most terms.
const MAX_TERMS: usize = 3;

/// Weights and exponents of an Ogden law, scaled so that `sum m_p a_p = 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ogden {
    terms: [(f64, f64); MAX_TERMS],
    count: usize,
}

impl Ogden {
    /// A law of these `(weight, exponent)`. Only the ratios of the weights count: their scale is the material's `mu`.
    ///
    /// # Errors
    /// [`Refused::OgdenTerms`], [`Refused::OgdenTerm`] (the product of weight and exponent must be above 0).
    pub fn new(terms: &[(f64, f64)]) -> Result<Self, Refused> {
        let found = terms.len();
        if found == 0 || found > MAX_TERMS {
            return Err(Refused::OgdenTerms { found, most: MAX_TERMS });
        }
        for (term, &(weight, exponent)) in terms.iter().enumerate() {
            let product = weight * exponent;
            if !(product.is_finite() && product > 0.0) {
                return Err(Refused::OgdenTerm { term, weight, exponent });
            }
        }
        let total: f64 = terms.iter().map(|(m, a)| m * a).sum();
        let mut kept = [(0.0, 1.0); MAX_TERMS];
        for (slot, (m, a)) in kept.iter_mut().zip(terms) {
            *slot = (m / total, *a);
        }
        Ok(Self {
            terms: kept,
            count: found,
        })
    }

    /// `(m_p, a_p)`, scaled.
    pub(crate) fn terms(&self) -> &[(f64, f64)] {
        &self.terms[..self.count]
    }

    /// `h(l) / (2 mu)` from `ln l`, without cancellation at rest.
    pub(crate) fn h(&self, log: f64) -> f64 {
        let term = |(m, a): &(f64, f64)| m * (((a - 1.0) * log).exp_m1() - (-log).exp_m1());
        self.terms().iter().map(term).sum()
    }

    /// `h'(l) / (2 mu)`.
    pub(crate) fn slope(&self, log: f64) -> f64 {
        let term = |(m, a): &(f64, f64)| m * ((a - 1.0) * ((a - 2.0) * log).exp() + (-2.0 * log).exp());
        self.terms().iter().map(term).sum()
    }

    /// `(h(l1) - h(l2)) / (l1 - l2) / (2 mu)`, also where they meet.
    pub(crate) fn divided_difference(&self, [log1, log2]: [f64; 2]) -> f64 {
        let t = log1 - log2;
        let power = |b: f64| {
            // `(l1^b - l2^b) / (l1 - l2)` is `l2^(b - 1)` times a quotient that tends to `b`; `exp_m1` keeps its digits
            // next to that.
            let ratio = if t.abs() < f64::MIN_POSITIVE {
                b
            } else {
                (b * t).exp_m1() / t.exp_m1()
            };
            ((b - 1.0) * log2).exp() * ratio
        };
        let term = |(m, a): &(f64, f64)| m * (power(a - 1.0) + (-log1 - log2).exp());
        self.terms().iter().map(term).sum()
    }

    /// `sum_p (m_p / a_p)(l^a_p - 1) - M ln l` of one stretch, over `2 mu`. Loses half the digits of a tiny strain.
    fn stretch_density(&self, log: f64) -> f64 {
        let term = |(m, a): &(f64, f64)| m * ((a * log).exp_m1() / a - log);
        self.terms().iter().map(term).sum()
    }

    pub(super) fn shear_density(&self, mu: f64, g: &Vector4<f64>) -> Option<f64> {
        let Principal { logs, .. } = Principal::of(g)?;
        Some(2.0 * mu * (self.stretch_density(logs[0]) + self.stretch_density(logs[1])))
    }

    pub(super) fn shear(&self, mu: f64, g: &Vector4<f64>) -> Option<Response> {
        let Principal { logs, left, right } = Principal::of(g)?;
        let dyad = |i: usize, j: usize| {
            let (u, v) = (left[i], right[j]);
            Vector4::new(u.x * v.x, u.y * v.x, u.x * v.y, u.y * v.y)
        };
        let [h1, h2] = logs.map(|l| self.h(l));
        let twist = (dyad(1, 0) - dyad(0, 1)) * std::f64::consts::FRAC_1_SQRT_2;
        let flip = (dyad(1, 0) + dyad(0, 1)) * std::f64::consts::FRAC_1_SQRT_2;
        let square = |v: Vector4<f64>| -> Matrix4<f64> { v * v.transpose() };
        let tangent = square(dyad(0, 0)) * self.slope(logs[0])
            + square(dyad(1, 1)) * self.slope(logs[1])
            + square(twist) * ((h1 + h2) / (logs[0].exp() + logs[1].exp()))
            + square(flip) * self.divided_difference(logs);
        Some(Response {
            density: 2.0 * mu * (self.stretch_density(logs[0]) + self.stretch_density(logs[1])),
            stress: (dyad(0, 0) * h1 + dyad(1, 1) * h2) * (2.0 * mu),
            tangent: tangent * (2.0 * mu),
        })
    }
}

/// `F = sum_i l_i u_i v_i^T` of a deformation without inversion, from the eigenvectors of the strain.
struct Principal {
    /// `ln l_i`.
    logs: [f64; 2],
    left: [Vector2<f64>; 2],
    right: [Vector2<f64>; 2],
}

impl Principal {
    /// `None` where `det F <= 0`.
    fn of(g: &Vector4<f64>) -> Option<Self> {
        if excess(g) <= -1.0 {
            return None;
        }
        let [e11, e22, e12] = strain(g);
        // The first principal direction of the strain, by its double angle; at equal stretches any direction serves.
        let angle = 0.5 * (2.0 * e12).atan2(e11 - e22);
        let (sin, cos) = angle.sin_cos();
        let right = [Vector2::new(cos, sin), Vector2::new(-sin, cos)];
        let logs = right.map(|v| {
            let e = v.x * v.x * e11 + 2.0 * v.x * v.y * e12 + v.y * v.y * e22;
            // `ln l = ln(1 + 2 e) / 2`; rounding may carry `2 e` below -1 where a stretch is next to nothing.
            0.5 * (2.0 * e).max(f64::EPSILON - 1.0).ln_1p()
        });
        let image = |v: Vector2<f64>| Vector2::new(v.x + g[0] * v.x + g[2] * v.y, v.y + g[1] * v.x + g[3] * v.y);
        let first = image(right[0]).try_normalize(0.0)?;
        // The other one by a quarter turn, as `det F > 0`: its own image could be too short for a direction.
        let left = [first, Vector2::new(-first.y, first.x)];
        Some(Self { logs, left, right })
    }
}
