//! The thesis's own iteration over the axis of the rotation (4.36 to 4.40), corrected and safeguarded.
//!
//! For a unit axis `k` the best angle has `sin = <k, Gamma> / root`, `cos = -<k, Lk k> / root` with `root = hypot(<k,
//! Lk k>, <k, Gamma>)`, and the criterion becomes `w0(k) = tr Psi + <k, Lk k> + root` (4.39; the signs of 4.37 and 4.38
//! by the errata). The iteration is `k <- grad w0(k)`, normalised, with the gradient `2 Lk k + (<k, G> G + 2 <k, Lk k>
//! Lk k) / root` (errata 4.40).
//!
//! Printed, it diverges; corrected, it still fails for angles below a radian and for slender clouds. Three safeguards:
//! a shift by a bound of the curvature makes every step go uphill; it is run on `Psi` turned by the identity and by the
//! three half-turns, one of which leaves an angle of at least 120 degrees, where it converges best; and its result is
//! finished by Newton's method, which returns nothing but the proven global optimum.

use nalgebra::{Matrix3, Vector3};

use super::newton::polish;
use super::quaternion::{Quaternion, gamma};

/// Steps in one frame; the iteration converges linearly and is only asked for the neighbourhood of the optimum.
const MAX_STEPS: usize = 40;
/// Half-turns and the identity, as quaternions.
const FRAMES: [Quaternion; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// The optimal rotation, or `None` where no frame leads to a proven optimum.
pub(super) fn solve(psi: &Matrix3<f64>) -> Option<Quaternion> {
    FRAMES.iter().find_map(|frame| {
        // tr(R'^T Psi F) = tr((R' F^T)^T Psi), and a half-turn is its own inverse: R = R' F.
        let turned = psi * super::quaternion::matrix(frame);
        let q = product(&iterate(&turned), frame);
        polish(psi, q)
    })
}

/// The rotation that the iteration reaches from the axis `Gamma`.
fn iterate(psi: &Matrix3<f64>) -> Quaternion {
    let axis = Axis {
        gamma: gamma(psi),
        lambda: (psi + psi.transpose()) * 0.5 - Matrix3::identity() * psi.trace(),
    };
    let shift = 2.0 * axis.lambda.norm();
    // Without a skew part there is no such axis; any will do, as `polish` proves what comes of it.
    let mut k = axis.gamma.try_normalize(0.0).unwrap_or_else(Vector3::x);
    for _ in 0..MAX_STEPS {
        let next = axis.gradient(&k) + k * shift;
        let next = next.try_normalize(0.0).unwrap_or(k);
        let moved = (next - k).norm();
        k = next;
        // Newton's method squares an error of this size away in two steps.
        if moved < 1e-4 {
            break;
        }
    }
    axis.rotation(&k)
}

/// `Gamma` and `Lk` of 4.12 and 4.36.
struct Axis {
    gamma: Vector3<f64>,
    lambda: Matrix3<f64>,
}

impl Axis {
    /// `(<k, Gamma>, <k, Lk k>, Lk k)`.
    fn products(&self, k: &Vector3<f64>) -> (f64, f64, Vector3<f64>) {
        let image = self.lambda * k;
        (self.gamma.dot(k), image.dot(k), image)
    }

    /// The corrected gradient 4.40; where the root vanishes, every angle is equally good and its term is left out.
    fn gradient(&self, k: &Vector3<f64>) -> Vector3<f64> {
        let (sine, curve, image) = self.products(k);
        let root = sine.hypot(curve);
        if root == 0.0 {
            return image * 2.0;
        }
        image * 2.0 + (self.gamma * sine + image * (2.0 * curve)) / root
    }

    /// The quaternion of axis `k` and the best angle about it (4.38, corrected).
    fn rotation(&self, k: &Vector3<f64>) -> Quaternion {
        let (sine, curve, _) = self.products(k);
        let half = 0.5 * sine.atan2(-curve);
        let v = k * half.sin();
        [half.cos(), v.x, v.y, v.z]
    }
}

/// The quaternion product `p * q`: first `q`, then `p`.
fn product(p: &Quaternion, q: &Quaternion) -> Quaternion {
    let [a, b, c, d] = *p;
    let [w, x, y, z] = *q;
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registration::quaternion::matrix;
    use crate::registration::svd::Decomposition;

    #[test]
    fn one_of_the_frames_leads_to_the_optimum_at_every_angle() {
        for i in 0..4000_u32 {
            let part = |k: u32| f64::from((i * 7 + 1).wrapping_mul(k) >> 8 & 0xffff) / 32768.0 - 1.0;
            let axis = Vector3::new(part(2_654_435_761), part(2_246_822_519), part(3_266_489_917));
            let v = axis.try_normalize(0.0).unwrap_or_else(Vector3::x);
            // From nothing to a half-turn; clouds from round to 1 : 0.05 : 0.05, the third value of either sign.
            let half = f64::from(i) / 4000.0 * std::f64::consts::FRAC_PI_2;
            let r = matrix(&[half.cos(), v.x * half.sin(), v.y * half.sin(), v.z * half.sin()]);
            let width = [1.0, 0.3, 0.05][i as usize % 3];
            let basis = matrix(&[0.5, 0.5, 0.5, -0.5]);
            let s = Matrix3::from_diagonal(&Vector3::new(1.0, width, part(668_265_263) * width * 0.9));
            let psi = r * basis * s * basis.transpose();
            let found = solve(&psi).map(|q| matrix(&q));
            let best = Decomposition::of(&psi).rotation();
            // 20 units of half an ulp by the condition, for each of the two.
            let bound = 20.0 * f64::EPSILON * 10.0 / width * 2.0_f64.sqrt();
            assert!(found.is_some_and(|r| (r - best).norm() < bound), "case {i}: {found:?}");
        }
    }
}
