//! Planted answers, the agreement of the methods and the invariances of the problem.

use crate::common::{Random, angle, images};
use calib::registration::{Fit, Method, Pairs, fit, fit_horaud_monga, fit_planar, fit_scaled, register};
use geometry::{Ct, Point, Tracker, Vector};
use proptest::prelude::*;

/// Half a unit in the last place of 1.
const U: f64 = 0.5 * f64::EPSILON;

fn solved(to: &[Point<Ct>], from: &[Point<Tracker>], method: Method) -> Fit<Ct, Tracker> {
    fit(Pairs::new(to, from).unwrap(), method).unwrap()
}

/// Angle between two fits in units of `U` times the condition of the first.
fn apart(a: &Fit<Ct, Tracker>, b: &Fit<Ct, Tracker>) -> f64 {
    angle(a.transform.quaternion(), b.transform.quaternion()) / (U * a.condition())
}

/// A noisy set whose shape runs from round to slender.
fn noisy(seed: u64, n: usize, noise: f64) -> (Vec<Point<Ct>>, Vec<Point<Tracker>>) {
    let mut random = Random::new(seed);
    let width = 10.0_f64.powf(-3.0 * random.unit());
    let shape = |p: Point<Tracker>| Point::new(p.mm()[0], p.mm()[1] * width, p.mm()[2] * width);
    let from: Vec<_> = random.cloud(n, 50.0).into_iter().map(shape).collect();
    let transform = random.transform();
    let mut to = images(transform, &from);
    to.iter_mut().for_each(|p| *p = *p + random.noise([noise; 3]));
    (to, from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_planted_transform_is_found(seed in any::<u64>(), n in 3..40_usize) {
        let mut random = Random::new(seed);
        let from = random.cloud(n, 50.0);
        let transform = random.transform();
        let to = images(transform, &from);
        let found = solved(&to, &from, Method::Newton);
        let error = angle(found.transform.quaternion(), transform.quaternion());
        // The bound for exact data, and that of the images: some ten roundings of 600 mm over the cloud's 50 mm.
        let data = 10.0 * 600.0 / 50.0;
        prop_assert!(error <= (20.0 + data) * U * found.condition(), "{error:e} {}", found.condition());
        prop_assert!(found.certificate().is_global(), "{:?}", found.certificate());
        prop_assert!(found.fre_rms_mm(Pairs::new(&to, &from).unwrap()) <= 10.0 * 600.0 * U * (1.0 + found.condition()));
    }

    #[test]
    fn all_methods_agree_to_their_bounds(seed in any::<u64>(), n in 3..30_usize, noise in 0.0..10.0_f64) {
        let (to, from) = noisy(seed, n, noise);
        let best = solved(&to, &from, Method::Newton);
        let c = best.condition();
        for method in Method::ALL {
            let pairs = Pairs::new(&to, &from).unwrap();
            let other = fit(pairs, method).unwrap();
            // Both may be off by 20, in opposite directions; the polar form squares the condition.
            let bound = if method == Method::HornPolar { 20.0 + 20.0 * c } else { 40.0 };
            let ratio = apart(&best, &other);
            prop_assert!(ratio <= bound, "{method:?}: {ratio} at condition {c:e}");
            let certificate = other.certificate();
            prop_assert!(method == Method::HornPolar || certificate.is_global(), "{method:?} {certificate:?}");
        }
    }

    #[test]
    fn next_to_a_line_the_methods_agree_or_refuse(seed in any::<u64>(), n in 3..30_usize, width in -10.0..-2.0_f64) {
        let mut random = Random::new(seed);
        let w = 10.0_f64.powf(width);
        let shape = |p: Point<Tracker>| Point::new(p.mm()[0], p.mm()[1] * w, p.mm()[2] * w);
        let from: Vec<_> = random.cloud(n, 50.0).into_iter().map(shape).collect();
        let to = images(random.transform(), &from);
        let pairs = Pairs::new(&to, &from).unwrap();
        match (fit(pairs, Method::Newton), fit(pairs, Method::Svd)) {
            (Ok(a), Ok(b)) => prop_assert!(apart(&a, &b) <= 40.0, "{} at {:e}", apart(&a, &b), a.condition()),
            (Err(a), Err(b)) => prop_assert_eq!(a, b),
            (a, b) => prop_assert!(false, "{a:?} {b:?}"),
        }
    }

    #[test]
    fn the_order_of_the_pairs_does_not_matter(seed in any::<u64>(), n in 3..30_usize) {
        let (to, from) = noisy(seed, n, 0.5);
        let turned = |k: usize| (k * 7 + 3) % n;
        prop_assume!(n % 7 != 0);
        let (to_2, from_2): (Vec<_>, Vec<_>) = (0..n).map(|k| (to[turned(k)], from[turned(k)])).unzip();
        prop_assert!(apart(&solved(&to, &from, Method::Newton), &solved(&to_2, &from_2, Method::Newton)) <= 40.0);
    }

    #[test]
    fn weights_count_by_their_ratios(seed in any::<u64>(), n in 3..20_usize, power in -900..900_i32) {
        let (to, from) = noisy(seed, n, 0.5);
        let whole: Vec<f64> = (0..n).map(|i| (1 + i % 3) as f64).collect();
        let scaled: Vec<f64> = whole.iter().map(|w| w * 2.0_f64.powi(power)).collect();
        let pairs = Pairs::new(&to, &from).unwrap();
        let by_weight = fit(pairs.weighted(&whole).unwrap(), Method::Newton).unwrap();
        let by_scaled = fit(pairs.weighted(&scaled).unwrap(), Method::Newton).unwrap();
        prop_assert!(apart(&by_weight, &by_scaled) <= 40.0);
        // Weight 3 is three times the same pair.
        let repeated = |i: usize| std::iter::repeat_n(i, 1 + i % 3);
        let (to_2, from_2): (Vec<_>, Vec<_>) = (0..n).flat_map(repeated).map(|i| (to[i], from[i])).unzip();
        prop_assert!(apart(&by_weight, &solved(&to_2, &from_2, Method::Newton)) <= 40.0);
    }

    #[test]
    fn leaving_one_out_is_registering_the_others(seed in any::<u64>(), n in 4..12_usize) {
        let (to, from) = noisy(seed, n, 0.5);
        let all = register(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap();
        let without = |i: usize| -> (Vec<_>, Vec<_>) { (0..n).filter(|k| *k != i).map(|k| (to[k], from[k])).unzip() };
        for i in 0..n {
            let (to_2, from_2) = without(i);
            let others = solved(&to_2, &from_2, Method::Newton);
            let expected = others.residual_mm(to[i], from[i]);
            let found = all.leave_one_out_mm[i].unwrap();
            // Two registrations' rotation errors at the lever of the cloud.
            prop_assert!((found - expected).abs() <= 100.0 * 40.0 * U * (1.0 + others.condition()));
        }
    }

    #[test]
    fn no_other_scale_fits_better(seed in any::<u64>(), n in 3..20_usize, scale in 0.01..100.0_f64) {
        let (to, from) = noisy(seed, n, 2.0);
        let points = to.iter().map(|p| p.mm().map(|x| x * scale));
        let to: Vec<Point<Ct>> = points.map(|[x, y, z]| Point::new(x, y, z)).collect();
        let pairs = Pairs::new(&to, &from).unwrap();
        let best = fit_scaled(pairs, Method::Newton).unwrap();
        for other in [0.999, 1.001] {
            // The same registration of a cloud scaled a little otherwise.
            let by = best.scale * other;
            let points = from.iter().map(|p| p.mm().map(|x| x * by));
            let scaled: Vec<Point<Tracker>> = points.map(|[x, y, z]| Point::new(x, y, z)).collect();
            let pairs = Pairs::new(&to, &scaled).unwrap();
            prop_assert!(fit(pairs, Method::Newton).unwrap().fre_rms_mm(pairs) > best.fre_rms_mm);
        }
    }

    #[test]
    fn the_plane_has_its_closed_form(angle in -3.1..3.1_f64, seed in any::<u64>(), n in 2..20_usize) {
        let mut random = Random::new(seed);
        let from: Vec<[f64; 2]> = (0..n).map(|_| [random.signed() * 50.0, random.signed() * 50.0]).collect();
        let (s, c) = angle.sin_cos();
        let to: Vec<[f64; 2]> = from.iter().map(|[x, y]| [c * x - s * y + 7.0, s * x + c * y - 3.0]).collect();
        let found = fit_planar(&to, &from).unwrap();
        let radius = from.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        let spread = (from[0][0] - from[1][0]).hypot(from[0][1] - from[1][1]);
        // Roundings of 60 mm seen over the cloud's size.
        prop_assert!((found.angle_rad - angle).abs() <= 20.0 * U * (1.0 + 60.0 / spread * n as f64), "{found:?}");
        prop_assert!(found.fre_rms_mm <= 40.0 * U * (radius + 60.0));
        prop_assert!((found.correlation - 1.0).abs() <= 64.0 * U * n as f64);
    }
}

/// Psi then has three equal singular values: the least and the largest are one.
#[test]
fn an_octahedron_is_registered_by_every_method() {
    let ends = [1.0, -1.0].map(|s| [[10.0 * s, 0.0, 0.0], [0.0, 10.0 * s, 0.0], [0.0, 0.0, 10.0 * s]]);
    let from: Vec<Point<Tracker>> = ends.concat().iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
    let to: Vec<Point<Ct>> = ends.concat().iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
    for method in Method::ALL {
        let found = solved(&to, &from, method).transform;
        let off = from.iter().zip(&to).map(|(f, t)| (found * *f).distance(*t));
        // Some roundings of 10 mm.
        assert!(off.fold(0.0, f64::max) < 1e-13, "{method:?}");
    }
}

#[test]
fn a_mirrored_cloud_gets_its_best_proper_rotation() {
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let from = random.cloud(12, 50.0);
        let mirrored: Vec<Point<Ct>> = from
            .iter()
            .map(|p| Point::new(-p.mm()[0], p.mm()[1], p.mm()[2]))
            .collect();
        for method in Method::ALL {
            let found = solved(&mirrored, &from, method);
            assert!(found.singular_values().0[2] < 0.0);
            assert!(
                method == Method::HornPolar || found.certificate().is_global(),
                "{method:?} {:?}",
                found.certificate()
            );
        }
    }
}

#[test]
fn a_hundred_thousand_pairs_keep_the_bound() {
    for seed in 0..5 {
        let (to, from) = noisy(seed, 24, 0.5);
        let repeated_to: Vec<_> = to.iter().cycle().take(120_000).copied().collect();
        let repeated_from: Vec<_> = from.iter().cycle().take(120_000).copied().collect();
        let few = solved(&to, &from, Method::Newton);
        assert!(apart(&few, &solved(&repeated_to, &repeated_from, Method::Newton)) <= 40.0);
    }
}

#[test]
fn next_to_an_even_mirror_image_the_methods_agree_or_refuse() {
    let mut solved = 0;
    for k in 0..400 {
        let mut random = Random::new(k);
        // An octahedron with a little noise, mirrored: the second value and the third cancel but for the noise.
        let noise = 10.0_f64.powf(-16.0 * random.unit());
        let axes = [
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        let from: Vec<Point<Tracker>> = axes
            .map(|[x, y, z]| Point::new(3.0 * x, y, z) + random.noise([noise; 3]))
            .into();
        let to: Vec<Point<Ct>> = from
            .iter()
            .map(|p| Point::new(p.mm()[0], p.mm()[1], -p.mm()[2]))
            .collect();
        let pairs = Pairs::new(&to, &from).unwrap();
        match (fit(pairs, Method::Newton), fit(pairs, Method::Svd)) {
            (Ok(a), Ok(b)) => {
                solved += 1;
                assert!(apart(&a, &b) <= 40.0, "{k}: {} at {:e}", apart(&a, &b), a.condition());
            }
            (Err(a), Err(b)) => assert_eq!(a, b),
            (a, b) => panic!("{k}: {a:?} {b:?}"),
        }
    }
    assert!(solved > 300, "{solved}");
}

#[test]
fn the_linear_method_is_exact_without_noise_and_biased_with_it() {
    for seed in 0..50 {
        let (to, from) = noisy(seed, 24, 0.0);
        let pairs = Pairs::new(&to, &from).unwrap();
        let (linear, best) = (fit_horaud_monga(pairs).unwrap(), solved(&to, &from, Method::Newton));
        let turned = best.transform.angle();
        // The normal equations square the slenderness, and near a half-turn K grows without bound.
        let bound = 40.0 * U * best.condition().powi(2) * (1.0 + (turned / 2.0).tan().powi(2)) * 600.0 / 50.0;
        assert!(
            angle(linear.transform.quaternion(), best.transform.quaternion()) < bound,
            "{seed}"
        );
        let mut random = Random::new(seed);
        let from = random.cloud(24, 50.0);
        let mut to = images(random.transform(), &from);
        to.iter_mut().for_each(|p| *p = *p + random.noise([5.0; 3]));
        let linear = fit_horaud_monga(Pairs::new(&to, &from).unwrap()).unwrap();
        assert!(!linear.certificate().is_global());
    }
}

#[test]
fn residuals_hold_at_extreme_scales_and_offsets() {
    let (to, from) = noisy(7, 12, 0.5);
    let pairs = Pairs::new(&to, &from).unwrap();
    let plain = register(pairs, Method::Newton).unwrap().fre_rms_mm;
    for power in [-530, -300, 300, 530] {
        let scale = 2.0_f64.powi(power);
        let by = |p: [f64; 3]| p.map(|x| x * scale);
        let to: Vec<Point<Ct>> = to
            .iter()
            .map(|p| by(p.mm()))
            .map(|[x, y, z]| Point::new(x, y, z))
            .collect();
        let from: Vec<Point<Tracker>> = from
            .iter()
            .map(|p| by(p.mm()))
            .map(|[x, y, z]| Point::new(x, y, z))
            .collect();
        let found = register(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap();
        assert!(
            (found.fre_rms_mm / scale / plain - 1.0).abs() < 1e-12,
            "2^{power}: {}",
            found.fre_rms_mm
        );
    }
    let far: Vec<Point<Ct>> = to.iter().map(|p| *p + Vector::new(1e8, -1e8, 1e8)).collect();
    let found = register(Pairs::new(&far, &from).unwrap(), Method::Newton).unwrap();
    // The offset rounds each coordinate of `far` by 2^-27 mm at most.
    assert!(
        (found.fre_rms_mm - plain).abs() < 3.0 * 2.0_f64.powi(-27),
        "{} {plain}",
        found.fre_rms_mm
    );
}
