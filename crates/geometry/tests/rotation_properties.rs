//! What holds for every rotation of space, needing no references.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops where it cannot go on, and prints what it measured or why it was skipped"
)]

use std::f64::consts::{FRAC_PI_2, PI};

use geometry::rotation::{AxisAngle, Rotation, RotationMatrix, RotationVector, chordal_mean, exp_skew, geodesic_mean};
use nalgebra::{DMatrix, Matrix3};
use proptest::prelude::*;

const ULP: f64 = f64::EPSILON;

fn vector(w: [f64; 3]) -> RotationVector {
    RotationVector::new(w).unwrap()
}

fn turn(w: [f64; 3]) -> Rotation {
    Rotation::from_vector(vector(w))
}

fn norm(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().fold(0.0, f64::hypot)
}

/// The distance of two vectors relative to the second.
fn off<const N: usize>(got: [f64; N], want: [f64; N]) -> f64 {
    norm((0..N).map(|i| got[i] - want[i])) / norm(want)
}

fn nalgebra(m: RotationMatrix) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| m.rows()[i][j])
}

/// Vectors of every magnitude down to denormals, and up to angles beyond a turn.
fn any_vector() -> impl Strategy<Value = [f64; 3]> {
    (prop::array::uniform3(-1.0..1.0), -1074.0..3.0f64)
        .prop_map(|(v, e)| v.map(|x: f64| x * 2f64.powf(e / 2.0) * 2f64.powf(e / 2.0)))
}

fn angles() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.5..3.5)
}

/// Orthonormal and of determinant +1, to 2 ulp of 1; the check's own rounding is a tenth of that (32 more bits).
fn assert_proper(m: RotationMatrix) {
    let m = m.rows();
    for i in 0..3 {
        for j in 0..3 {
            let dot = exact_sum(&[[m[0][i], m[0][j]], [m[1][i], m[1][j]], [m[2][i], m[2][j]]]);
            let want = f64::from(u8::from(i == j));
            assert!((dot - want).abs() <= 2.0 * ULP, "{m:?}: column {i} by {j} is {dot}");
        }
    }
    // Rounding of the determinant itself: 2 ulp more.
    assert!(
        (Matrix3::from_fn(|i, j| m[i][j]).determinant() - 1.0).abs() <= 4.0 * ULP,
        "{m:?}"
    );
}

/// The sum of products, each split exactly into halves and the whole summed by decreasing size.
fn exact_sum(factors: &[[f64; 2]]) -> f64 {
    let half = |x: f64| f64::from_bits(x.to_bits() & !0x7ff_ffff);
    let mut terms: Vec<f64> = factors
        .iter()
        .flat_map(|[a, b]| {
            let (c, d) = (half(*a), half(*b));
            [c * d, c * (b - d), (a - c) * d, (a - c) * (b - d)]
        })
        .collect();
    // Neumaier's sum, which is exact to an ulp of the result here.
    terms.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    let (mut sum, mut rest) = (0.0f64, 0.0);
    for t in terms {
        let next = sum + t;
        rest += if sum.abs() >= t.abs() {
            (sum - next) + t
        } else {
            (t - next) + sum
        };
        sum = next;
    }
    sum + rest
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn vectors_come_back(w in any_vector()) {
        let n = norm(w);
        prop_assume!(n < PI - 1e-9);
        // 2 ulp each way through the quaternion, 3 more through the matrix; denormals have an absolute ulp.
        let floor = |x: f64| x.max(3.0 * 5e-324);
        let got = turn(w).vector().radians();
        prop_assert!(norm((0..3).map(|i| got[i] - w[i])) <= floor(5.0 * ULP * n), "{got:?}");
        let got = turn(w).matrix().vector().radians();
        prop_assert!(norm((0..3).map(|i| got[i] - w[i])) <= floor(9.0 * ULP * n), "{got:?}");
        let got = vector(w).axis_angle().vector().radians();
        prop_assert!(norm((0..3).map(|i| got[i] - w[i])) <= floor(3.0 * ULP * n), "{got:?}");
        prop_assert_eq!(RotationVector::from_skew(vector(w).skew()).unwrap(), vector(w));
    }

    #[test]
    fn matrices_are_proper(w in any_vector(), v in angles()) {
        assert_proper(vector(w).matrix());
        assert_proper((turn(w) * turn(v)).matrix());
        assert_proper(vector(w).matrix() * vector(v).matrix());
        assert_proper(turn(v).slerp(turn(w), 0.3).matrix());
    }

    #[test]
    fn composition_is_application(w in angles(), v in angles(), x in prop::array::uniform3(-100.0..100.0)) {
        let (a, b) = (turn(w), turn(v));
        // 4 ulp of angle for the product, 12 for each of three images.
        prop_assert!(off((a * b).apply(x), a.apply(b.apply(x))) <= 40.0 * ULP);
        // 4 for the product, 3 for each of three images.
        prop_assert!(off((a * b).matrix().apply(x), a.matrix().apply(b.matrix().apply(x))) <= 16.0 * ULP);
        let (m, n) = (a.matrix(), b.matrix());
        let product = nalgebra(m) * nalgebra(n);
        prop_assert!((nalgebra(m * n) - product).norm() <= 12.0 * ULP * 3f64.sqrt());
    }

    #[test]
    fn inverses(w in angles(), x in prop::array::uniform3(-100.0..100.0)) {
        let r = turn(w);
        // 12 ulp for each image.
        prop_assert!(off(r.inverse().apply(r.apply(x)), x) <= 24.0 * ULP);
        prop_assert_eq!(r.inverse().matrix().rows(), r.matrix().inverse().rows());
        prop_assert!((r.inverse() * r).angle() <= 4.0 * ULP);
        prop_assert_eq!(r.distance(r), 0.0);
    }

    #[test]
    fn quaternions_of_any_length(q in prop::array::uniform4(-1.0..1.0), e in -1000..1000) {
        let scaled = q.map(|x: f64| x * 2f64.powi(e));
        // So that all components stay above denormals.
        prop_assume!(q.iter().all(|x| x.abs() > 1e-3));
        prop_assert_eq!(Rotation::from_quaternion(scaled), Rotation::from_quaternion(q));
        let m = Rotation::from_quaternion(q).unwrap().matrix();
        assert_proper(m);
        let back = m.rotation();
        prop_assert!(Rotation::from_quaternion(q).unwrap().distance(back) <= 8.0 * ULP);
    }

    #[test]
    fn slerp_goes_at_constant_speed(w in angles(), v in prop::array::uniform3(-1.7..1.7), t in 0.0..1.0f64) {
        let (a, b) = (turn(w), turn(w) * turn(v));
        prop_assert_eq!(a.slerp(b, 0.0), a);
        prop_assert!(a.slerp(b, 1.0).distance(b) <= 10.0 * ULP);
        let part = a.slerp(b, t);
        prop_assert!((a.distance(part) - t * a.distance(b)).abs() <= 16.0 * ULP);
        prop_assert!(a.slerp(a, t) == a && a.slerp(b, f64::NAN) == a);
    }

    #[test]
    fn the_nearest_rotation_is_the_polar_factor(w in angles(), s in prop::array::uniform6(-1.0..1.0),
                                                size in -30.0..-4.0f64, scale in -300..300) {
        let s = s.map(|x: f64| x * 2f64.powf(size));
        let stretch = Matrix3::new(1.0 + s[0], s[1], s[2], s[1], 1.0 + s[3], s[4], s[2], s[4], 1.0 + s[5]);
        let r = turn(w).matrix();
        let m = nalgebra(r) * stretch;
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]));
        let near = RotationMatrix::nearest(rows).unwrap();
        // 2 ulp, and the product's own rounding divided by the least sum of two singular values, above 1.6.
        prop_assert!(near.matrix.rotation().distance(turn(w)) <= 16.0 * ULP);
        let want = (stretch - Matrix3::identity()).norm();
        prop_assert!((near.distance - want).abs() <= 16.0 * ULP);
        assert_proper(near.matrix);
        let far = rows.map(|row| row.map(|x| x * 2f64.powi(scale)));
        let scaled = RotationMatrix::nearest(far).unwrap().matrix;
        prop_assert!(scaled.rotation().distance(near.matrix.rotation()) <= 4.0 * ULP);
    }

    #[test]
    fn means_of_symmetric_sets_are_their_centre(w in angles(), d in prop::array::uniform3(-0.7..0.7),
                                               e in prop::array::uniform3(-0.7..0.7)) {
        let centre = turn(w);
        let set = [d, d.map(|x: f64| -x), e, e.map(|x: f64| -x), [0.0; 3]].map(|v| centre * turn(v));
        let weights = [2.0, 2.0, 0.5, 0.5, 1.0];
        // 20 eps over a gap of at least cos^2(0.61) - sin^2(0.61) = 0.34, in angle twice that.
        prop_assert!(chordal_mean(&set, &weights).unwrap().distance(centre) <= 120.0 * ULP);
        prop_assert!(geodesic_mean(&set, &weights).unwrap().distance(centre) <= 20.0 * ULP);
    }

    #[test]
    fn the_exponential_agrees_with_any_dimension(w in angles()) {
        let skew = vector(w).skew();
        let h = DMatrix::from_fn(3, 3, |i, j| skew[i][j]);
        let m = vector(w).matrix().rows();
        // 16 n eps (1 + abs(H)^2), the Frobenius norm of H counting each number twice.
        let bound = 16.0 * 3.0 * ULP * (1.0 + 2.0 * norm(w).powi(2));
        prop_assert!((exp_skew(&h).unwrap() - DMatrix::from_fn(3, 3, |i, j| m[i][j])).norm() <= bound);
    }

    #[test]
    fn jacobians_match_finite_differences(w in prop::array::uniform3(-2.0..2.0), scale in -20..1) {
        let w = w.map(|x: f64| x * 2f64.powi(scale));
        let (left, inverse) = (vector(w).left_jacobian(), vector(w).left_jacobian_inverse());
        let step = 2f64.powi(-17);
        for j in 0..3 {
            let moved = |s: f64| {
                let mut v = w;
                v[j] += s;
                (turn(v) * turn(w).inverse()).vector().radians()
            };
            let (plus, minus) = (moved(step), moved(-step));
            for i in 0..3 {
                let slope = (plus[i] - minus[i]) / (2.0 * step);
                // Third derivatives are below 1: step^2 / 6, and rounding of 4 ulp / step.
                prop_assert!((slope - left[i][j]).abs() <= 1e-10 + 8.0 * ULP / step, "{slope} {left:?}");
                let unit: f64 = (0..3).map(|k| left[i][k] * inverse[k][j]).sum();
                // The condition near 2 pi / 3.46 is below 4.
                prop_assert!((unit - f64::from(u8::from(i == j))).abs() <= 64.0 * ULP, "{unit}");
            }
        }
    }
}

#[test]
fn half_turns_and_denormals() {
    for axis in [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.6, 0.0, 0.8],
        [-0.36, 0.48, 0.8],
    ] {
        let m = AxisAngle::new(axis, PI).unwrap().matrix();
        assert_proper(m);
        let found = m.axis_angle();
        assert!((found.angle() - PI).abs() <= 2.0 * ULP);
        let along: f64 = (0..3).map(|i| found.axis()[i] * axis[i]).sum();
        assert!((along.abs() - 1.0).abs() <= 4.0 * ULP);
    }
    let exact = RotationMatrix::new([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], 0.0).unwrap();
    assert_eq!(exact.vector().radians().map(f64::abs), [0.0, 0.0, PI]);
    let denormal = [4.0 * 5e-324, -2.0 * 5e-324, 0.0];
    assert_eq!(turn(denormal).vector().radians(), denormal);
    assert_eq!(vector(denormal).matrix().vector().radians(), denormal);
    assert_eq!(
        turn(denormal).axis_angle().axis(),
        AxisAngle::new([2.0, -1.0, 0.0], 0.0).unwrap().axis()
    );
}

#[test]
fn many_products_stay_rotations() {
    let step = turn([0.1, -0.2, 0.3]);
    let end = (0..1_000_000).fold(Rotation::IDENTITY, |r, _| r * step);
    let square = exact_sum(&end.quaternion().map(|x| [x, x]));
    // The norm to 2 ulp.
    assert!((square - 1.0).abs() <= 4.0 * ULP);
    assert_proper(end.matrix());
}

#[test]
fn long_vectors_are_still_rotations() {
    for scale in [1e3, 1e9, 1e17, 1e150, 1e300] {
        assert_proper(vector([scale, -scale / 3.0, scale / 7.0]).matrix());
    }
    assert_proper(vector([f64::MAX; 3]).matrix());
    // 10^6 turns and a right angle: the angle's rounding is the input's, not the function's.
    let angle = 1e6 * 2.0 * PI + FRAC_PI_2;
    let (sin, cos) = angle.sin_cos();
    let m = vector([0.0, 0.0, angle]).matrix().rows();
    assert!((m[1][0] - sin).abs() <= 3.0 * ULP && (m[0][0] - cos).abs() <= 3.0 * ULP);
}
