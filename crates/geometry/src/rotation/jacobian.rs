//! Derivatives of the exponential.

use super::RotationVector;

impl RotationVector {
    /// The left Jacobian by rows: exp(w + d) = exp(J d) exp(w) to first order in d; of no unit.
    ///
    /// J = 1 + (1 - cos a) / a^2 W + (a - sin a) / a^3 W^2, W the skew matrix (2.25) and a its angle: the integral of 2.39
    /// along the ray. Domain: finite vectors up to 1e150. Error: 8 ulp up to a = 2 pi. The right Jacobian is its transpose.
    pub fn left_jacobian(self) -> [[f64; 3]; 3] {
        let a = self.angle();
        combine(self, first(a), second(a))
    }

    /// The inverse of the left Jacobian: log(exp(d) exp(w)) = w + J^-1 d to first order; of no unit.
    ///
    /// 1 - W / 2 + (1 - (a/2) cot(a/2)) / a^2 W^2. Domain: angles below 2 pi, where it is singular. Error: 8 ulp up to pi.
    pub fn left_jacobian_inverse(self) -> [[f64; 3]; 3] {
        combine(self, -0.5, cotangent(self.angle()))
    }
}

/// 1 + x W + y W^2, with W^2 = w wT - a^2.
fn combine(w: RotationVector, x: f64, y: f64) -> [[f64; 3]; 3] {
    let (v, skew) = (w.radians(), w.skew());
    let square = |i: usize, j: usize| {
        let others = [(i + 1) % 3, (i + 2) % 3];
        if i == j {
            // w_i^2 - a^2 without the difference: minus the sum of the two other squares.
            -(v[others[0]] * v[others[0]] + v[others[1]] * v[others[1]])
        } else {
            v[i] * v[j]
        }
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(u8::from(i == j)) + (x * skew[i][j] + y * square(i, j))))
}

/// (1 - cos a) / a^2, as half the square of the half angle's sinc: no cancellation.
fn first(a: f64) -> f64 {
    let h = a / 2.0;
    // 1 - sinc(h) < h^2 / 6, below 2^-55 here.
    let sinc = if h < 1e-8 { 1.0 } else { h.sin() / h };
    0.5 * sinc * sinc
}

/// (a - sin a) / a^3; the series below 1, whose next term is below 2^-56 of it there.
fn second(a: f64) -> f64 {
    if a >= 1.0 {
        return (a - a.sin()) / (a * a * a);
    }
    // Horner's scheme on 1/3! - a^2/5! + a^4/7! ...: each ratio of neighbours is 1 / (2n (2n + 1)).
    let x = a * a;
    let tail = [42.0, 72.0, 110.0, 156.0, 210.0, 272.0]
        .iter()
        .rev()
        .fold(1.0, |rest, r| 1.0 - x * rest / r);
    (1.0 - x * tail / 20.0) / 6.0
}

/// (1 - (a/2) cot(a/2)) / a^2.
fn cotangent(a: f64) -> f64 {
    if a >= 1.0 {
        let h = a / 2.0;
        return (1.0 - h / h.tan()) / (a * a);
    }
    // Through the two functions without cancellation: 1 - h cot h = (sin h - h cos h) / sin h, and sin h - h cos h =
    // (1 - cos h) h - (h - sin h).
    let h = a / 2.0;
    let sinc = if h < 1e-8 { 1.0 } else { h.sin() / h };
    (first(h) - second(h)) / (4.0 * sinc)
}
