//! Covariances through composition, inversion and application: against finite differences and against sampling.

use crate::support::{Chance, difference, motion};
use geometry::{Ct, Point, Rigid, Tool, Tracker, Uncertain, UncertainPoint};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Step of the differences: rad and mm.
const STEP: f64 = 1e-4;

/// The derivative of `f` along `e` by central differences.
fn derivative<const N: usize>(e: Vector6<f64>, f: impl Fn(Vector6<f64>) -> SVector<f64, N>) -> SVector<f64, N> {
    (f(e * STEP) - f(e * -STEP)) / (2.0 * STEP)
}

/// The derivative's outer product must be the covariance that a covariance of e e^T is carried to.
///
/// Central differences leave out STEP^2 / 6 times the third derivative, and divide the rounding of lengths by STEP: both
/// relative to the lengths and levers involved, `size_mm`.
fn check<const N: usize>(got: SMatrix<f64, N, N>, derivative: SVector<f64, N>, size_mm: f64) {
    let slack = size_mm * (STEP * STEP + 64.0 * f64::EPSILON / STEP);
    let error = (got - derivative * derivative.transpose()).amax();
    let bound = slack * (slack + 2.0 * derivative.amax());
    assert!(error <= bound, "{error:e} of {:e}, allowed {bound:e}", got.amax());
}

#[test]
fn jacobians_are_the_derivatives() {
    let mut chance = Chance(1);
    for size_mm in [1.0, 300.0, 1e4, 1e6] {
        for _ in 0..20 {
            let e = Vector6::from_fn(|_, _| chance.signed());
            let a: Rigid<Ct, Tracker> = chance.rigid(size_mm);
            let b: Rigid<Tracker, Tool> = chance.rigid(size_mm);
            let p = Point::<Tool>::new(0.0, 0.0, 0.0) + chance.vector(size_mm);
            let outer = e * e.transpose();
            let (first, second) = (Uncertain::new(a, outer).unwrap(), Uncertain::new(b, outer).unwrap());
            // All lengths involved, and the levers they turn on.
            let size_mm = 16.0 * (1.0 + size_mm);

            let by_first = derivative(e, |d| difference(motion(d) * a * b, a * b));
            check((first * b).covariance(), by_first, size_mm);
            let by_second = derivative(e, |d| difference(a * (motion(d) * b), a * b));
            check((a * second).covariance(), by_second, size_mm);
            let inverse = derivative(e, |d| difference((motion(d) * a).inverse(), a.inverse()));
            check(first.inverse().covariance(), inverse, size_mm);
            let image = derivative(e, |d| Vector3::from((motion(d) * b * p).mm()));
            check((second * p).covariance(), image, size_mm);
            let both = outer_sum(by_first, by_second);
            let sum = (first * second).covariance() - both;
            assert!(sum.amax() <= 2.0 * size_mm * (STEP * STEP + 64.0 * f64::EPSILON / STEP) * (size_mm + 1.0));
        }
    }
}

fn outer_sum(a: Vector6<f64>, b: Vector6<f64>) -> Matrix6<f64> {
    a * a.transpose() + b * b.transpose()
}

/// About a point: the turn, and what the point moves by.
#[test]
fn reference_points() {
    let mut chance = Chance(2);
    let a: Rigid<Ct, Tracker> = chance.rigid(300.0);
    let c = Point::<Ct>::new(50.0, -70.0, 110.0);
    let e = Vector6::from_fn(|_, _| chance.signed());
    let uncertain = Uncertain::new(a, e * e.transpose()).unwrap();
    let about = derivative(e, |d| {
        let moved = motion::<Ct>(d) * c - c;
        Vector6::from_iterator(d.iter().take(3).copied().chain(moved.mm()))
    });
    check(uncertain.covariance_about(c), about, 300.0);
    let back = Uncertain::from_covariance_about(c, a, uncertain.covariance_about(c)).unwrap();
    let lever = 1.0 + 150.0 * 150.0;
    assert!((back.covariance() - uncertain.covariance()).amax() < 64.0 * f64::EPSILON * lever);
    let image = uncertain * (a.inverse() * c);
    let own = uncertain.covariance_about(c).fixed_view::<3, 3>(3, 3).into_owned();
    assert!((image.covariance() - own).amax() < 64.0 * f64::EPSILON * lever);
}

const SAMPLES: usize = 40_000;

/// The mean of x x^T over samples must be the covariance, to five deviations of such a mean: for normal errors,
/// sqrt((c_ii c_jj + c_ij^2) / n); and what first order leaves out, at 1e-3 rad a few thousandths of that size.
fn check_sampled<const N: usize>(want: SMatrix<f64, N, N>, mut sample: impl FnMut() -> SVector<f64, N>) {
    let mut sum = SMatrix::<f64, N, N>::zeros();
    for _ in 0..SAMPLES {
        let x = sample();
        sum += x * x.transpose();
    }
    let got = sum / SAMPLES as f64;
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let both = want[(i, i)] * want[(j, j)];
        let deviation = ((both + want[(i, j)].powi(2)) / SAMPLES as f64).sqrt();
        let error = (got[(i, j)] - want[(i, j)]).abs();
        assert!(
            error < 5.0 * deviation + 4e-3 * both.sqrt(),
            "{i} {j}: {error:e}, {deviation:e}"
        );
    }
}

#[test]
fn sampled_errors_have_these_covariances() {
    let mut chance = Chance(3);
    let (a, b): (Rigid<Ct, Tracker>, Rigid<Tracker, Tool>) = (chance.rigid(200.0), chance.rigid(200.0));
    let (l, m) = (chance.factor(1e-3, 0.3), chance.factor(1e-3, 0.3));
    let first = Uncertain::new(a, l * l.transpose()).unwrap();
    let second = Uncertain::new(b, m * m.transpose()).unwrap();
    check_sampled((first * second).covariance(), || {
        let actual = motion(l * chance.normals()) * a * (motion(m * chance.normals()) * b);
        difference(actual, a * b)
    });
    check_sampled(first.inverse().covariance(), || {
        difference((motion(l * chance.normals()) * a).inverse(), a.inverse())
    });
    let tip = Point::<Tool>::new(3.0, -4.0, 180.0);
    let k = Matrix3::from_fn(|_, _| 0.2 * chance.signed());
    let uncertain_tip = UncertainPoint::new(tip, k * k.transpose()).unwrap();
    check_sampled((second * uncertain_tip).covariance(), || {
        let normals = chance.normals();
        let d = k * normals.fixed_rows::<3>(0);
        let moved = tip + geometry::Vector::new(d[0], d[1], d[2]);
        Vector3::from((motion(m * chance.normals()) * b * moved - b * tip).mm())
    });
}

/// The share of samples within the radius: 95 % for errors alike in all directions, more for others.
#[test]
fn the_radius_holds_95_of_100() {
    let mut chance = Chance(4);
    for (deviations, want) in [([0.4, 0.4, 0.4], 0.95), ([0.4, 0.0, 0.0], 0.994_8)] {
        let covariance = Matrix3::from_diagonal(&Vector3::from(deviations.map(|d: f64| d * d)));
        let radius = UncertainPoint::new(Point::<Ct>::new(0.0, 0.0, 0.0), covariance)
            .unwrap()
            .radius_95_mm();
        let inside = (0..SAMPLES).filter(|_| {
            let n = chance.normals();
            Vector3::new(n[0] * deviations[0], n[1] * deviations[1], n[2] * deviations[2]).norm() <= radius
        });
        let share = inside.count() as f64 / SAMPLES as f64;
        // Five deviations of a binomial share.
        let deviation = (want * (1.0 - want) / SAMPLES as f64).sqrt();
        assert!((share - want).abs() < 5.0 * deviation, "{share}");
    }
}
