//! Predicted errors against counted ones; wrong pairs; noise with a direction. Seeds and counts are fixed.

use crate::common::{Random, angle, images, turn};
use calib::registration::{Method, Noise, Pairs, fit, register, register_anisotropic, register_robust};
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix3, Matrix6, Vector6};

const TRIALS: usize = 20_000;

struct Planted {
    transform: Rigid<Ct, Tracker>,
    from: Vec<Point<Tracker>>,
    exact: Vec<Point<Ct>>,
    target: Point<Tracker>,
}

fn planted(random: &mut Random, n: usize) -> Planted {
    let from = random.cloud(n, 30.0);
    let transform = random.transform();
    Planted {
        transform,
        exact: images(transform, &from),
        from,
        target: Point::new(20.0, -50.0, 180.0),
    }
}

impl Planted {
    fn noisy(&self, random: &mut Random, sigma: impl Fn(usize) -> [f64; 3]) -> Vec<Point<Ct>> {
        let noisy = |(i, p): (usize, &Point<Ct>)| *p + random.noise(sigma(i));
        self.exact.iter().enumerate().map(noisy).collect()
    }

    fn miss(&self, found: Rigid<Ct, Tracker>) -> f64 {
        (found * self.target).distance(self.transform * self.target)
    }
}

fn rms(list: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = list.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
    f64::sqrt(sum / count)
}

#[test]
fn predicted_target_error_is_the_counted_one() {
    for (seed, n) in [(1, 3), (2, 4), (3, 6), (4, 24)] {
        let mut random = Random::new(seed);
        let case = planted(&mut random, n);
        let noise = Noise { sigma_mm: 0.2 };
        let exact = register(Pairs::new(&case.exact, &case.from).unwrap(), Method::Newton).unwrap();
        let predicted = exact.predicted_tre_mm(noise, case.transform * case.target);
        let counted = rms((0..TRIALS).map(|_| {
            let to = case.noisy(&mut random, |_| [noise.sigma_mm; 3]);
            case.miss(
                fit(Pairs::new(&to, &case.from).unwrap(), Method::Newton)
                    .unwrap()
                    .transform,
            )
        }));
        assert!((predicted / counted - 1.0).abs() < 0.05, "n {n}: {predicted} {counted}");
        let body = calib::registration::predicted_tre_mm(&case.from, case.target, noise);
        assert!((body / predicted - 1.0).abs() < 1e-9, "{body} {predicted}");
    }
}

#[test]
fn weights_inverse_to_variances_give_the_predicted_error_and_noise() {
    let mut random = Random::new(11);
    let case = planted(&mut random, 8);
    let sigma = |i: usize| if i.is_multiple_of(2) { 0.05 } else { 0.5 };
    let weights: Vec<f64> = (0..8).map(|i| 1.0 / (sigma(i) * sigma(i))).collect();
    let mean = weights.iter().sum::<f64>() / 8.0;
    let noise = Noise {
        sigma_mm: (1.0 / mean).sqrt(),
    };
    let weighted = |to: &[Point<Ct>]| {
        register(
            Pairs::new(to, &case.from).unwrap().weighted(&weights).unwrap(),
            Method::Newton,
        )
        .unwrap()
    };
    let predicted = weighted(&case.exact).predicted_tre_mm(noise, case.transform * case.target);
    let (mut misses, mut sigmas) = (Vec::new(), Vec::new());
    for _ in 0..TRIALS / 4 {
        let found = weighted(&case.noisy(&mut random, |i| [sigma(i); 3]));
        misses.push(case.miss(found.fit.transform));
        sigmas.push(found.estimated_noise().sigma_mm);
    }
    assert!((predicted / rms(misses.into_iter()) - 1.0).abs() < 0.05);
    assert!((noise.sigma_mm / rms(sigmas.into_iter()) - 1.0).abs() < 0.05);
}

/// `(w, v)` with the true transform `p -> exp(w) (R p + t) + v`.
fn error(truth: Rigid<Ct, Tracker>, found: Rigid<Ct, Tracker>) -> Vector6<f64> {
    let w = turn(truth.quaternion(), found.quaternion());
    let step = truth * found.inverse();
    let [x, y, z] = step.translation_mm();
    Vector6::new(w[0], w[1], w[2], x, y, z)
}

/// Counted covariance seen in the predicted one's units: the identity where they agree.
fn whitened(errors: &[Vector6<f64>], predicted: &Matrix6<f64>) -> Matrix6<f64> {
    let counted = errors.iter().map(|e| e * e.transpose()).sum::<Matrix6<f64>>() / errors.len() as f64;
    let inverse = predicted.cholesky().unwrap().l().try_inverse().unwrap();
    inverse * counted * inverse.transpose()
}

#[test]
fn the_covariance_is_the_counted_one() {
    let mut random = Random::new(21);
    let case = planted(&mut random, 6);
    let noise = Noise { sigma_mm: 0.05 };
    let exact = register(Pairs::new(&case.exact, &case.from).unwrap(), Method::Newton).unwrap();
    let errors: Vec<_> = (0..TRIALS)
        .map(|_| {
            let to = case.noisy(&mut random, |_| [noise.sigma_mm; 3]);
            error(
                case.transform,
                fit(Pairs::new(&to, &case.from).unwrap(), Method::Newton)
                    .unwrap()
                    .transform,
            )
        })
        .collect();
    let seen = whitened(&errors, &exact.covariance(noise).unwrap());
    // Five deviations of a counted variance: 5 sqrt(2 / 20000).
    assert!((seen - Matrix6::identity()).amax() < 0.05, "{seen}");
}

#[test]
fn anisotropic_noise_is_weighed_by_its_covariance() {
    let mut random = Random::new(31);
    let case = planted(&mut random, 6);
    let sigma = |i: usize| [0.05, 0.05, 0.15 * (1 + i % 3) as f64];
    let covariances: Vec<Matrix3<f64>> = (0..6)
        .map(|i| Matrix3::from_diagonal(&sigma(i).map(|s| s * s).into()))
        .collect();
    let (mut errors, mut plain, mut chi, mut predicted) = (Vec::new(), Vec::new(), 0.0, Matrix6::zeros());
    for _ in 0..TRIALS / 4 {
        let to = case.noisy(&mut random, sigma);
        let pairs = Pairs::new(&to, &case.from).unwrap();
        let found = register_anisotropic(pairs, &covariances).unwrap();
        errors.push(error(case.transform, found.transform));
        plain.push(error(case.transform, fit(pairs, Method::Newton).unwrap().transform));
        chi += found.chi_squared;
        predicted += found.covariance / (TRIALS / 4) as f64;
    }
    let seen = whitened(&errors, &predicted);
    // Five deviations of a counted variance: 5 sqrt(2 / 5000).
    assert!((seen - Matrix6::identity()).amax() < 0.1, "{seen}");
    assert!(whitened(&plain, &predicted).trace() > 1.2 * seen.trace());
    // 3 N - 6 degrees of freedom: five deviations of a mean of 5000.
    assert!((chi / (TRIALS / 4) as f64 - 12.0).abs() < 5.0 * (24.0_f64 / 5000.0).sqrt());
}

#[test]
fn equal_covariances_are_the_plain_registration() {
    let mut random = Random::new(41);
    for n in [3, 4, 24] {
        let case = planted(&mut random, n);
        let to = case.noisy(&mut random, |_| [0.5; 3]);
        let pairs = Pairs::new(&to, &case.from).unwrap();
        let found = register_anisotropic(pairs, &vec![Matrix3::identity() * 0.25; n]).unwrap();
        let plain = fit(pairs, Method::Newton).unwrap();
        // The iteration ends at a step of 1e-12.
        assert!(angle(found.transform.quaternion(), plain.transform.quaternion()) < 1e-12 * (1.0 + plain.condition()));
    }
}

#[test]
fn sixteen_of_twenty_four_wrong_pairs_are_told() {
    for seed in 0..100 {
        let mut random = Random::new(100 + seed);
        let case = planted(&mut random, 24);
        let mut to = case.noisy(&mut random, |_| [0.1; 3]);
        let shift = Vector::<Ct>::new(0.0, 0.0, 0.0);
        for p in to.iter_mut().skip(8) {
            // Anywhere in a box of the cloud's size, about its centre.
            *p = case.transform * Point::new(0.0, 0.0, 0.0) + random.vector(50.0) + shift;
        }
        let found = register_robust(Pairs::new(&to, &case.from).unwrap(), Method::Newton, 0.6, 5).unwrap();
        let right = found.inliers.iter().take(8).filter(|x| **x).count();
        let wrong = found.inliers.iter().skip(8).filter(|x| **x).count();
        assert_eq!((right, wrong), (8, 0), "seed {seed}");
        let pairs = Pairs::new(&to[..8], &case.from[..8]).unwrap();
        let best = fit(pairs, Method::Newton).unwrap();
        let apart = angle(
            best.transform.quaternion(),
            found.registration.fit.transform.quaternion(),
        );
        assert!(apart < 40.0 * f64::EPSILON * best.condition(), "{apart}");
    }
}

#[test]
fn too_little_agreement_is_said() {
    let mut random = Random::new(77);
    let case = planted(&mut random, 12);
    let to: Vec<Point<Ct>> = (0..12)
        .map(|_| Point::new(0.0, 0.0, 0.0) + random.vector(50.0))
        .collect();
    let found = register_robust(Pairs::new(&to, &case.from).unwrap(), Method::Newton, 0.1, 5);
    assert!(
        matches!(found, Err(calib::registration::Refused::NoConsensus { needed: 5, .. })),
        "{found:?}"
    );
}

/// At the end of such fits rounding alone moves the cost: steps that lead up by it end the iteration and do not refuse it.
#[test]
fn thin_clouds_of_exact_points_are_registered_with_a_covariance_each() {
    let mut random = Random::new(11);
    for width in [1.0, 1e-1, 1e-2, 1e-3, 1e-4] {
        for _ in 0..50 {
            let from: Vec<Point<Tracker>> = random.cloud(8, 60.0).into_iter().map(|p| thinned(p, width)).collect();
            let transform = random.transform();
            let to = images(transform, &from);
            let covariances: Vec<Matrix3<f64>> = (0..8)
                .map(|i| Matrix3::from_diagonal(&nalgebra::Vector3::new(0.01, 0.04, 0.1 + f64::from(i))))
                .collect();
            let found = register_anisotropic(Pairs::new(&to, &from).unwrap(), &covariances)
                .unwrap_or_else(|error| panic!("width {width}: {error}"));
            // Rounding of places of some 1e3 mm, thrown across by a cloud so much thinner than long.
            let off = from
                .iter()
                .map(|p| (found.transform * *p).distance(transform * *p))
                .fold(0.0, f64::max);
            assert!(off < 1e-10 / width, "width {width}: {off}");
        }
    }
}

fn thinned(p: Point<Tracker>, width: f64) -> Point<Tracker> {
    let [x, y, z] = p.mm();
    Point::new(x, width * y, width * z)
}
