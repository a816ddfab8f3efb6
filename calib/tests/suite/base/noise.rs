//! Touches with a covariance each: weighed by it, the covariance of the place counted, what is none refused.

use super::*;
use calib::base::Refused;
use nalgebra::{Matrix3, Vector3};

/// A localizer that sees depth, its z, four times worse; the pointer's tilt makes each touch a little different.
fn depth(random: &mut Random) -> Matrix3<f64> {
    let along = 0.4 * (0.7 + 0.6 * random.unit());
    let tilt = Vector3::new(0.3 * random.signed(), 0.3 * random.signed(), 1.0)
        .try_normalize(0.0)
        .unwrap();
    Matrix3::identity() * 0.01 + tilt * tilt.transpose() * (along * along - 0.01)
}

/// A touch disturbed by its covariance.
fn disturbed(random: &mut Random, p: Point<Tracker>, c: &Matrix3<f64>) -> Point<Tracker> {
    let e = c.cholesky().unwrap().l() * Vector3::new(random.normal(), random.normal(), random.normal());
    p + Vector::new(e.x, e.y, e.z)
}

fn noisy(random: &mut Random, exact: &[Group<Tracker>]) -> Vec<Group<Tracker>> {
    let group = |g: &Group<Tracker>| {
        let covariances: Vec<Matrix3<f64>> = g.touches.iter().map(|_| depth(random)).collect();
        let both = g.touches.iter().zip(&covariances);
        let touches = both.map(|(p, c)| disturbed(random, *p, c)).collect();
        Group { touches, ..g.clone() }.with_covariances(covariances)
    };
    exact.iter().map(group).collect()
}

#[test]
fn the_covariance_of_weighed_touches_is_the_counted_one() {
    const TRIALS: usize = 3000;
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 0.0,
        sigma: 0.0,
        counts: [20, 10],
    };
    let mut random = Random::new(31);
    let truth = pose(&mut random);
    let exact = touching.groups(&mut random, truth);
    let centre = truth * Point::<Base>::new(0.0, 0.0, 0.0);
    let c = Vector::<Tracker>::new(centre.mm()[0], centre.mm()[1], centre.mm()[2]);
    let (mut counted, mut predicted, mut ratio) = (Matrix6::zeros(), Matrix6::zeros(), 0.0);
    let (mut weighed, mut even) = (Vec::new(), Vec::new());
    let target = Point::<Base>::new(0.0, 0.0, 80.0);
    for _ in 0..TRIALS {
        let groups = noisy(&mut random, &exact);
        let found = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
        let e = error(truth, found.place.transform());
        let [x, y, z] = (Vector::<Tracker>::new(e[3], e[4], e[5]) + Vector::new(e[0], e[1], e[2]).cross(c)).mm();
        let e = Vector6::new(e[0], e[1], e[2], x, y, z);
        counted += e * e.transpose() / TRIALS as f64;
        // By the noise given, which is right.
        let given = found.noise_ratio.max(1.0).powi(2);
        predicted += found.place.covariance_about(centre) / given / TRIALS as f64;
        ratio += found.noise_ratio.powi(2) / TRIALS as f64;
        weighed.push((found.place.transform() * target).distance(truth * target));
        // The same touches as if their noise were even: 0.26 mm is the root mean square of 0.1, 0.1 and 0.42.
        let plain: Vec<Group<Tracker>> = groups.into_iter().map(|g| g.with_covariances(Vec::new())).collect();
        let found = locate(&drawing, &plain, &Options::new(0.26)).unwrap();
        even.push((found.place.transform() * target).distance(truth * target));
    }
    let seen = whitened(&counted, &predicted);
    // Five deviations of a counted variance, 5 sqrt(2 / 3000), and of the mean of six.
    assert!((seen - Matrix6::identity()).amax() < 0.13, "{seen}");
    assert!((seen.trace() / 6.0 - 1.0).abs() < 0.053, "{seen}");
    assert!((ratio - 1.0).abs() < 5.0 * (2.0_f64 / 74.0 / 3000.0).sqrt(), "{ratio}");
    let (weighed, even) = (rms(&weighed), rms(&even));
    println!("at 80 mm: weighed {weighed:.4} mm, as even noise {even:.4} mm");
    assert!(weighed < 0.85 * even, "{weighed} {even}");
}

#[test]
fn even_covariances_are_the_noise_given() {
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 1.0,
        sigma: SIGMA,
        counts: [12, 6],
    };
    let mut random = Random::new(8);
    let truth = pose(&mut random);
    let groups = touching.groups(&mut random, truth);
    let options = |sigma_mm| Options {
        tip_radius_mm: 1.0,
        ..Options::new(sigma_mm)
    };
    let plain = locate(&drawing, &groups, &options(SIGMA)).unwrap();
    let covariances = |g: Group<Tracker>| {
        let each = vec![Matrix3::identity() * SIGMA * SIGMA; g.touches.len()];
        g.with_covariances(each)
    };
    let groups: Vec<Group<Tracker>> = groups.into_iter().map(covariances).collect();
    // The unit in which they are counted does not matter, but for the grey zone of the search.
    for sigma_mm in [SIGMA, 0.15] {
        let found = locate(&drawing, &groups, &options(sigma_mm)).unwrap();
        let e = error(plain.place.transform(), found.place.transform());
        // Steps end at 1e-12 of the radius; a turn is carried over 2000 mm.
        assert!(e.norm() < 1e-8, "{sigma_mm}: {e}");
        assert!(
            (found.noise_ratio / plain.noise_ratio - 1.0).abs() < 1e-9,
            "{}",
            found.noise_ratio
        );
        let (a, b) = (found.place.covariance(), plain.place.covariance());
        assert!((a - b).norm() < 1e-8 * b.norm(), "{sigma_mm}");
    }
}

#[test]
fn what_is_no_covariance_is_refused() {
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 0.0,
        sigma: SIGMA,
        counts: [12, 6],
    };
    let mut random = Random::new(9);
    let truth = pose(&mut random);
    let groups = touching.groups(&mut random, truth);
    let with = |list: Vec<Matrix3<f64>>| {
        let mut groups = groups.clone();
        groups[2] = groups[2].clone().with_covariances(list);
        locate(&drawing, &groups, &Options::new(SIGMA)).unwrap_err()
    };
    let good = Matrix3::identity() * 0.04;
    let (found, touches) = (3, 6);
    assert_eq!(
        with(vec![good; 3]),
        Refused::Unmatched {
            group: 2,
            found,
            touches
        }
    );
    for bad in [
        Matrix3::zeros(),
        -good,
        Matrix3::from_diagonal(&Vector3::new(0.1, f64::NAN, 0.1)),
        Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    ] {
        let mut list = vec![good; 6];
        list[4] = bad;
        assert_eq!(with(list), Refused::BadNoise { group: 2, touch: 4 });
    }
}

/// Touches with one tip share its error: with it taken as each touch's own the base promised more than was true, the more touches
/// the more.
#[test]
fn what_touches_share_is_in_the_covariance_however_many_there_are() {
    const TRIALS: usize = 2000;
    let drawing = uneven();
    for (counts, seed) in [([10, 6], 41), ([60, 40], 42)] {
        let touching = Touching {
            drawing: &drawing,
            tip_radius: 0.0,
            sigma: 0.0,
            counts,
        };
        let mut random = Random::new(seed);
        let truth = pose(&mut random);
        let exact = touching.groups(&mut random, truth);
        let centre = truth * Point::<Base>::new(0.0, 0.0, 0.0);
        let c = Vector::<Tracker>::new(centre.mm()[0], centre.mm()[1], centre.mm()[2]);
        let (mut nees, mut alone) = (0.0, 0.0);
        for _ in 0..TRIALS {
            let z = Vector3::new(random.normal(), random.normal(), random.normal());
            let groups: Vec<Group<Tracker>> = exact.iter().map(|g| shared(&mut random, g, z)).collect();
            let found = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
            let e = error(truth, found.place.transform());
            let [x, y, w] = (Vector::<Tracker>::new(e[3], e[4], e[5]) + Vector::new(e[0], e[1], e[2]).cross(c)).mm();
            let e = Vector6::new(e[0], e[1], e[2], x, y, w);
            let square = |found: &Located<Tracker>| {
                let covariance = found.place.covariance_about(centre);
                e.dot(&covariance.cholesky().unwrap().solve(&e)) / TRIALS as f64
            };
            nees += square(&found);
            let apart: Vec<Group<Tracker>> = groups.iter().map(|g| g.clone().with_shared(Vec::new())).collect();
            alone += square(&locate(&drawing, &apart, &Options::new(SIGMA)).unwrap());
        }
        // Of chi-squared of six: five deviations of a mean of 2000, and a hundredth for the second order.
        assert!(
            (nees - 6.0).abs() < 5.0 * (12.0 / TRIALS as f64).sqrt() + 0.06,
            "{counts:?}: {nees}"
        );
        assert!(alone > 9.0, "{counts:?}: {alone}");
    }
}

/// The touches of a group with noise of their own, and with a tip that is off by `z` deviations, held a little differently each time.
fn shared(random: &mut Random, exact: &Group<Tracker>, z: Vector3<f64>) -> Group<Tracker> {
    let (mut touches, mut covariances, mut moves) = (Vec::new(), Vec::new(), Vec::new());
    for p in &exact.touches {
        let axis = Vector3::new(random.signed(), random.signed(), random.signed()) * 0.4;
        let u = nalgebra::Rotation3::new(axis).matrix() * Matrix3::from_diagonal(&Vector3::new(0.15, 0.1, 0.2));
        let own = depth(random);
        let [x, y, w] = (u * z).into();
        touches.push(disturbed(random, *p, &own) + Vector::new(x, y, w));
        covariances.push(own + u * u.transpose());
        moves.push(u);
    }
    Group {
        touches,
        ..exact.clone()
    }
    .with_covariances(covariances)
    .with_shared(moves)
}
