//! What directed and shared errors of pairs make of a registration, against many trials that know nothing of the formulas.

use crate::common::{Random, turn};
use calib::registration::{Method, Noise, PairError, Pairs, Propagated, chi_squared, propagated, register, rms_at};
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix3, Vector3, Vector6};

/// Errors of touches: depth worse than the rest, and a tip that is off by some tenths and held a little differently each time.
fn errors(random: &mut Random, count: usize, tilt: f64) -> Vec<PairError> {
    let one = |_| {
        let turn = nalgebra::Rotation3::new(Vector3::new(random.signed(), random.signed(), random.signed()) * tilt);
        PairError {
            own: Matrix3::from_diagonal(&Vector3::new(0.09, 0.09, 0.25 + 0.2 * random.unit())),
            shared: turn.matrix() * Matrix3::new(0.3, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0, 0.1, 0.4),
        }
    };
    (0..count).map(one).collect()
}

/// `(w, v)` with the true transform `p -> exp(w) (R p + t) + v`.
fn error(truth: Rigid<Ct, Tracker>, found: Rigid<Ct, Tracker>) -> Vector6<f64> {
    let [a, b, c] = turn(truth.quaternion(), found.quaternion());
    let [x, y, z] = (truth * found.inverse()).translation_mm();
    Vector6::new(a, b, c, x, y, z)
}

#[test]
fn covariance_and_chi_squared_are_the_counted_ones() {
    const TRIALS: usize = 4000;
    for (count, tilt, seed) in [(3, 0.3, 1), (6, 0.3, 2), (6, 3.0, 3), (20, 0.1, 4)] {
        let mut random = Random::new(seed);
        let truth = random.transform();
        let exact = random.cloud(count, 120.0);
        let errors = errors(&mut random, count, tilt);
        let (mut nees, mut chi, mut rest) = (0.0, 0.0, 0.0);
        for _ in 0..TRIALS {
            let z = Vector3::new(random.normal(), random.normal(), random.normal());
            let touched = exact.iter().zip(&errors).map(|(p, e)| {
                let own = e.own.map(f64::sqrt).component_mul(&Matrix3::identity());
                let off = own * Vector3::new(random.normal(), random.normal(), random.normal()) + e.shared * z;
                *p + Vector::new(off.x, off.y, off.z)
            });
            let touched: Vec<Point<Tracker>> = touched.collect();
            let to: Vec<Point<Ct>> = exact.iter().map(|p| truth * *p).collect();
            let pairs = Pairs::new(&to, &touched).unwrap();
            let found = register(pairs, Method::default()).unwrap();
            let Propagated { covariance, shared } = propagated(&found.fit, pairs, &errors).unwrap();
            let e = error(truth, found.fit.transform);
            nees += e.dot(&covariance.cholesky().unwrap().solve(&e)) / TRIALS as f64;
            // Without what is shared, whose numbers are known here, the rest is left.
            let (own, e) = (covariance - shared * shared.transpose(), e - shared * z);
            rest += e.dot(&own.cholesky().unwrap().solve(&e)) / TRIALS as f64;
            chi += chi_squared(&found.fit, pairs, &errors).unwrap() / TRIALS as f64;
        }
        // Chi-squared of k degrees of freedom has the variance 2 k: five deviations of a mean of 4000. Second order: errors of
        // 1 mm over clouds of 120 mm, a hundredth of each.
        let bound = |k: f64| 5.0 * (2.0 * k / TRIALS as f64).sqrt() + 0.01 * k;
        let freedom = 3.0 * count as f64 - 6.0;
        assert!((nees - 6.0).abs() < bound(6.0), "{count} {tilt}: {nees}");
        assert!((rest - 6.0).abs() < bound(6.0), "{count} {tilt}: {rest}");
        assert!((chi - freedom).abs() < bound(freedom), "{count} {tilt}: {chi}");
    }
}

#[test]
fn what_all_pairs_share_does_not_fall_with_their_number() {
    let mut random = Random::new(9);
    let truth = random.transform();
    for count in [3, 6, 50, 500] {
        let exact = random.cloud(count, 120.0);
        let to: Vec<Point<Ct>> = exact.iter().map(|p| truth * *p).collect();
        let pairs = Pairs::new(&to, &exact).unwrap();
        let found = register(pairs, Method::default()).unwrap();
        let errors = errors(&mut random, count, 0.0);
        let [x, y, z] = found.centre().mm();
        let rms = rms_at(
            &propagated(&found.fit, pairs, &errors).unwrap().covariance,
            Point::<Ct>::new(x, y, z),
        );
        let shared = errors[0].shared.norm();
        let own = errors.iter().map(|e| e.own.trace()).sum::<f64>() / (count * count) as f64;
        // Held alike, the tip's error moves all as one; at the centre the own errors are those of a mean. To rounding of 500 mm.
        assert!((rms - (shared * shared + own).sqrt()).abs() < 1e-9, "{count}: {rms}");
    }
}

#[test]
fn even_errors_make_the_covariance_of_plain_noise() {
    let mut random = Random::new(5);
    let truth = random.transform();
    let exact = random.cloud(7, 80.0);
    let to: Vec<Point<Ct>> = exact.iter().map(|p| truth * *p + random.noise([0.2; 3])).collect();
    let weights: Vec<f64> = exact.iter().map(|_| 0.5 + random.unit()).collect();
    let pairs = Pairs::new(&to, &exact).unwrap().weighted(&weights).unwrap();
    let found = register(pairs, Method::default()).unwrap();
    // Weights inverse to variances, as `Registration::covariance` takes them: of mean 1.
    let mean = weights.iter().sum::<f64>() / 7.0;
    let errors: Vec<PairError> = weights
        .iter()
        .map(|w| PairError {
            own: Matrix3::identity() * (0.04 * mean / w),
            shared: Matrix3::zeros(),
        })
        .collect();
    let plain = found.covariance(Noise { sigma_mm: 0.2 }).unwrap();
    let directed = propagated(&found.fit, pairs, &errors).unwrap().covariance;
    // Products of six terms at a centre 300 mm away.
    assert!((plain - directed).amax() < 1e-10 * plain.amax(), "{plain}{directed}");
    let target = Point::new(10.0, -200.0, 35.0);
    let both = [
        found.predicted_tre_mm(Noise { sigma_mm: 0.2 }, target),
        rms_at(&directed, target),
    ];
    assert!((both[0] - both[1]).abs() < 1e-9, "{both:?}");
}
