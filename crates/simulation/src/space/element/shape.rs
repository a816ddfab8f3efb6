//! Shape functions of the cube at local coordinates in `[-1, 1]^3`: products of one polynomial for each axis.
//!
//! Nodes run fastest along x, then y, then z: node `i + n j + n^2 k` of `n` an axis.

use nalgebra::{Matrix3, Vector3};

/// Abscissas and weights of Gauss' rule of two points.
pub const GAUSS_2: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
/// And of three points.
pub const GAUSS_3: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// Values and derivatives at `u` of the two linear polynomials, of nodes -1 and 1.
fn linear(u: f64) -> [(f64, f64); 2] {
    [(0.5 * (1.0 - u), -0.5), (0.5 * (1.0 + u), 0.5)]
}

/// Of the three quadratic ones, of nodes -1, 0 and 1.
fn quadratic(u: f64) -> [(f64, f64); 3] {
    [
        (0.5 * u * (u - 1.0), u - 0.5),
        ((1.0 - u) * (1.0 + u), -2.0 * u),
        (0.5 * u * (u + 1.0), u + 0.5),
    ]
}

fn value<const N: usize>(axes: &[[(f64, f64); N]; 3], node: usize) -> f64 {
    let [i, j, k] = [node % N, node / N % N, node / (N * N)];
    axes[0][i].0 * axes[1][j].0 * axes[2][k].0
}

fn gradient<const N: usize>(axes: &[[(f64, f64); N]; 3], node: usize) -> Vector3<f64> {
    let [x, y, z] = [axes[0][node % N], axes[1][node / N % N], axes[2][node / (N * N)]];
    Vector3::new(x.1 * y.0 * z.0, x.0 * y.1 * z.0, x.0 * y.0 * z.1)
}

/// `bends` are the second derivatives of the polynomials of one axis, which are constant.
fn curvature<const N: usize>(axes: &[[(f64, f64); N]; 3], bends: [f64; N], node: usize) -> Matrix3<f64> {
    let at = [node % N, node / N % N, node / (N * N)];
    Matrix3::from_fn(|p, q| {
        let factor = |axis: usize| match usize::from(p == axis) + usize::from(q == axis) {
            0 => axes[axis][at[axis]].0,
            1 => axes[axis][at[axis]].1,
            _ => bends[at[axis]],
        };
        factor(0) * factor(1) * factor(2)
    })
}

/// Values of the 8 trilinear functions.
pub fn values_8(at: [f64; 3]) -> [f64; 8] {
    let axes = at.map(linear);
    std::array::from_fn(|node| value(&axes, node))
}

/// Their derivatives by the local coordinates.
pub fn gradients_8(at: [f64; 3]) -> [Vector3<f64>; 8] {
    let axes = at.map(linear);
    std::array::from_fn(|node| gradient(&axes, node))
}

/// Their second derivatives.
pub fn curvatures_8(at: [f64; 3]) -> [Matrix3<f64>; 8] {
    let axes = at.map(linear);
    std::array::from_fn(|node| curvature(&axes, [0.0; 2], node))
}

/// Values of the 27 triquadratic functions.
pub fn values_27(at: [f64; 3]) -> [f64; 27] {
    let axes = at.map(quadratic);
    std::array::from_fn(|node| value(&axes, node))
}

/// Their derivatives by the local coordinates.
pub fn gradients_27(at: [f64; 3]) -> [Vector3<f64>; 27] {
    let axes = at.map(quadratic);
    std::array::from_fn(|node| gradient(&axes, node))
}

/// Their second derivatives.
pub fn curvatures_27(at: [f64; 3]) -> [Matrix3<f64>; 27] {
    let axes = at.map(quadratic);
    std::array::from_fn(|node| curvature(&axes, [1.0, -2.0, 1.0], node))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node<const N: usize>(k: usize) -> [f64; 3] {
        [k % N, k / N % N, k / (N * N)].map(|i| 2.0 * i as f64 / (N - 1) as f64 - 1.0)
    }

    #[test]
    fn each_function_is_one_at_its_node_alone() {
        for a in 0..8 {
            let values = values_8(node::<2>(a));
            assert!((0..8).all(|b| values[b] == if a == b { 1.0 } else { 0.0 }), "{a}");
        }
        for a in 0..27 {
            let values = values_27(node::<3>(a));
            assert!((0..27).all(|b| values[b] == if a == b { 1.0 } else { 0.0 }), "{a}");
        }
    }

    #[test]
    fn gradients_reproduce_polynomials() {
        let at = [0.3, -0.7, 0.45];
        let linear: Vector3<f64> = (0..8)
            .map(|k| gradients_8(at)[k] * node::<2>(k)[0] * node::<2>(k)[2])
            .sum();
        assert!((linear - Vector3::new(at[2], 0.0, at[0])).amax() < 1e-15);
        let product = |x: [f64; 3]| x[0] * x[0] * x[1] * x[2] * x[2];
        let quadratic: Vector3<f64> = (0..27).map(|k| gradients_27(at)[k] * product(node::<3>(k))).sum();
        let [x, y, z] = at;
        let exact = Vector3::new(2.0 * x * y * z * z, x * x * z * z, 2.0 * x * x * y * z);
        assert!((quadratic - exact).amax() < 1e-15);
        let bent: Matrix3<f64> = (0..27).map(|k| curvatures_27(at)[k] * product(node::<3>(k))).sum();
        let exact = [
            [2.0 * y * z * z, 2.0 * x * z * z, 4.0 * x * y * z],
            [2.0 * x * z * z, 0.0, 2.0 * x * x * z],
            [4.0 * x * y * z, 2.0 * x * x * z, 2.0 * x * x * y],
        ];
        assert!((bent - Matrix3::from_fn(|p, q| exact[p][q])).amax() < 1e-14);
        let bent: Matrix3<f64> = (0..8)
            .map(|k| curvatures_8(at)[k] * node::<2>(k)[0] * node::<2>(k)[2])
            .sum();
        assert!((bent - Matrix3::from_fn(|p, q| if p + q == 2 && p != q { 1.0 } else { 0.0 })).amax() < 1e-15);
        let sum: f64 = values_27(at).iter().sum();
        assert!((sum - 1.0).abs() < 1e-15);
    }

    #[test]
    fn rules_integrate_their_degree() {
        let of = |rule: &[(f64, f64)], degree: i32| rule.iter().map(|(x, w)| w * x.powi(degree)).sum::<f64>();
        for (degree, exact) in [(0, 2.0), (1, 0.0), (2, 2.0 / 3.0), (3, 0.0)] {
            assert!((of(&GAUSS_2, degree) - exact).abs() < 1e-15);
            assert!((of(&GAUSS_3, degree) - exact).abs() < 1e-15);
        }
        assert!((of(&GAUSS_3, 4) - 0.4).abs() < 1e-15);
    }
}
