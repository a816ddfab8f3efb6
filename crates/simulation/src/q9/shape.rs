//! Shape functions: products of the quadratic Lagrange polynomials of II 3.15.

use nalgebra::Vector2;

use super::NODES;

/// Points and weights of the three-point Gauss rule on `[-1, 1]`: exact to degree 5.
pub const GAUSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// `P_1, P_2, P_3` at `u`.
pub(crate) fn line(u: f64) -> [f64; 3] {
    [0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)]
}

/// Their derivatives at `u`.
pub(crate) fn line_slope(u: f64) -> [f64; 3] {
    [u - 0.5, -2.0 * u, u + 0.5]
}

/// The nine weights at `(u, v)`.
pub fn values(u: f64, v: f64) -> [f64; NODES] {
    let (p, q) = (line(u), line(v));
    std::array::from_fn(|n| p[n % 3] * q[n / 3])
}

/// Their derivatives by `u` and `v`.
pub fn gradients(u: f64, v: f64) -> [Vector2<f64>; NODES] {
    let (p, q) = (line(u), line(v));
    let (dp, dq) = (line_slope(u), line_slope(v));
    std::array::from_fn(|n| Vector2::new(dp[n % 3] * q[n / 3], p[n % 3] * dq[n / 3]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_one_at_their_node_and_sum_to_one() {
        for n in 0..NODES {
            let (u, v) = ((n % 3) as f64 - 1.0, (n / 3) as f64 - 1.0);
            for (m, value) in values(u, v).iter().enumerate() {
                assert_eq!(*value, f64::from(u8::from(m == n)));
            }
        }
        let sum: Vector2<f64> = gradients(0.3, -0.7).iter().sum();
        assert!((values(0.3, -0.7).iter().sum::<f64>() - 1.0).abs() < 1e-15 && sum.amax() < 1e-15);
    }

    #[test]
    fn slopes_are_the_derivatives() {
        let h = 1e-6;
        let at = gradients(0.31, -0.62);
        for (n, slope) in at.iter().enumerate() {
            let du = (values(0.31 + h, -0.62)[n] - values(0.31 - h, -0.62)[n]) / (2.0 * h);
            let dv = (values(0.31, -0.62 + h)[n] - values(0.31, -0.62 - h)[n]) / (2.0 * h);
            // The functions are quadratic: only rounding, eps / h, is left.
            assert!((slope - Vector2::new(du, dv)).amax() < 1e-9);
        }
    }
}
