//! What has no registration is refused by name, with its numbers.

use crate::common::{Random, images};
use calib::registration::{Method, Pairs, Refused, fit, fit_planar, register, register_anisotropic};
use geometry::{Ct, Point, Tracker};
use nalgebra::Matrix3;

fn points<F>(list: &[[f64; 3]]) -> Vec<Point<F>> {
    list.iter().map(|[x, y, z]| Point::new(*x, *y, *z)).collect()
}

/// By every method, which must agree on the reason.
fn refusal(to: &[[f64; 3]], from: &[[f64; 3]]) -> Refused {
    let (to, from) = (points::<Ct>(to), points::<Tracker>(from));
    let pairs = Pairs::new(&to, &from).unwrap();
    let reasons = Method::ALL.map(|method| fit(pairs, method).unwrap_err());
    for (reason, method) in reasons.iter().zip(Method::ALL) {
        let same = std::mem::discriminant(reason) == std::mem::discriminant(&reasons[0]);
        assert!(same, "{method:?}: {reason}");
    }
    reasons[0].clone()
}

const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 20.0, 0.0]];

#[test]
fn too_few_or_unpaired() {
    assert_eq!(
        refusal(&TRIANGLE[..2], &TRIANGLE[..2]),
        Refused::TooFew { found: 2, needed: 3 }
    );
    assert_eq!(refusal(&[], &[]), Refused::TooFew { found: 0, needed: 3 });
    let (to, from) = (points::<Ct>(&TRIANGLE), points::<Tracker>(&TRIANGLE[..2]));
    assert_eq!(Pairs::new(&to, &from).err(), Some(Refused::Unpaired { to: 3, from: 2 }));
}

#[test]
fn numbers_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut spoilt = TRIANGLE;
        spoilt[1][2] = bad;
        for reason in [refusal(&spoilt, &TRIANGLE), refusal(&TRIANGLE, &spoilt)] {
            assert!(matches!(reason, Refused::NotFinite { pair: 1, .. }), "{reason}");
        }
    }
}

#[test]
fn weights() {
    let (to, from) = (points::<Ct>(&TRIANGLE), points::<Tracker>(&TRIANGLE));
    let pairs = Pairs::new(&to, &from).unwrap();
    let with = |weights: [f64; 3]| fit(pairs.weighted(&weights).unwrap(), Method::Newton).err();
    assert_eq!(with([0.0; 3]), Some(Refused::NoWeight { pairs: 3 }));
    assert_eq!(with([1.0, 0.0, 1.0]), Some(Refused::TooFew { found: 2, needed: 3 }));
    assert_eq!(
        with([1.0, -1.0, 1.0]),
        Some(Refused::BadWeight { pair: 1, found: -1.0 })
    );
    assert!(matches!(
        with([1.0, 1.0, f64::NAN]),
        Some(Refused::BadWeight { pair: 2, .. })
    ));
    assert_eq!(with([1e-300, 2e-300, 1e-300]), None);
    assert_eq!(with([1e300, 2e300, 1e300]), None);
    assert!(matches!(
        pairs.weighted(&[1.0]).err(),
        Some(Refused::Unmatched { found: 1, pairs: 3, .. })
    ));
}

#[test]
fn coincident_points() {
    for p in [[0.0; 3], [0.1, 0.2, 0.3], [1e8, -1e8, 0.1], [1e-200, 0.0, 0.0]] {
        let reason = refusal(
            &[p; 5],
            &[[0.0; 3], [1.0; 3], [1.0, 2.0, 3.0], [2.0; 3], [0.5, 0.0, 0.0]],
        );
        assert!(matches!(reason, Refused::Coincident { .. }), "{p:?}: {reason}");
    }
}

#[test]
fn collinear_points() {
    let mut random = Random::new(3);
    let line: Vec<[f64; 3]> = (0..8)
        .map(|i| [0.1, 0.3, -0.7].map(|x| x * f64::from(i * i) + 0.1))
        .collect();
    let cloud: Vec<[f64; 3]> = random.cloud(8, 30.0).iter().map(|p| p.mm()).collect();
    for (to, from) in [(&line, &line), (&line, &cloud), (&cloud, &line)] {
        let reason = refusal(to, from);
        let Refused::Collinear(values) = reason else {
            panic!("{reason}")
        };
        assert!(
            values.0[1] < 1e-14 * values.0[0] && reason.to_string().contains("singular values"),
            "{reason}"
        );
    }
    // Two distinct points, repeated, are a line.
    let two: Vec<[f64; 3]> = TRIANGLE[..2].iter().cycle().take(6).copied().collect();
    assert!(matches!(refusal(&two, &two), Refused::Collinear(_)));
}

#[test]
fn an_even_body_and_its_mirror_image() {
    let signs = [-1.0, 1.0];
    let cube: Vec<[f64; 3]> = (0..8)
        .map(|i| [signs[i & 1], signs[i >> 1 & 1], signs[i >> 2]])
        .collect();
    let mirrored: Vec<[f64; 3]> = cube.iter().map(|[x, y, z]| [-x, *y, *z]).collect();
    let reason = refusal(&mirrored, &cube);
    assert!(matches!(reason, Refused::Reflected(_)), "{reason}");
}

#[test]
fn duplicates_do_no_harm() {
    let mut random = Random::new(5);
    let transform = random.transform();
    let from: Vec<Point<Tracker>> = points(&TRIANGLE).into_iter().cycle().take(9).collect();
    let to = images(transform, &from);
    let found = register(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap();
    // Images are rounded at 600 mm.
    assert!(found.fre_mm.iter().all(|r| *r < 1e-12) && found.leave_one_out_mm.iter().all(Option::is_some));
    let three = register(Pairs::new(&to[..3], &from[..3]).unwrap(), Method::Newton).unwrap();
    assert!(three.leave_one_out_mm.iter().all(Option::is_none));
}

#[test]
fn covariances() {
    let (to, from) = (points::<Ct>(&TRIANGLE), points::<Tracker>(&TRIANGLE));
    let pairs = Pairs::new(&to, &from).unwrap();
    let good = Matrix3::identity();
    let skewed = Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    // Only the lower triangle is factorised.
    let above = Matrix3::new(1.0, f64::NAN, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    for bad in [Matrix3::zeros(), -good, skewed, good * f64::NAN, above] {
        let found = register_anisotropic(pairs, &[good, bad, good]).err();
        assert_eq!(found, Some(Refused::BadCovariance { pair: 1 }));
    }
    assert!(matches!(
        register_anisotropic(pairs, &[good]).err(),
        Some(Refused::Unmatched { .. })
    ));
}

#[test]
fn in_the_plane() {
    assert!(matches!(
        fit_planar(&[[1.0, 2.0]], &[[1.0, 2.0]]),
        Err(Refused::TooFew { .. })
    ));
    assert!(matches!(
        fit_planar(&[[1.0, 2.0]; 3], &[[1.0, 2.0]; 2]),
        Err(Refused::Unpaired { .. })
    ));
    assert!(matches!(
        fit_planar(&[[0.1, 0.2]; 3], &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        Err(Refused::Coincident { .. })
    ));
    let square = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    assert!(matches!(
        fit_planar(&square.map(|[x, y]| [-x, y]), &square),
        Err(Refused::Reflected(_))
    ));
    assert!(matches!(
        fit_planar(&square, &square.map(|[x, _]| [x, f64::NAN])),
        Err(Refused::NotFinite { pair: 0, .. })
    ));
}
