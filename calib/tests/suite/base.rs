//! The calibration base with planted answers: error, covariance, labels found, the tool in its seat.

use crate::common::plate::{Touching, pose, star, uneven, unlabelled};
use crate::common::{Random, turn};
use calib::base::{Feature, Group, Located, Options, locate, separate};
use geometry::{Base, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix6, Vector6};

const SIGMA: f64 = 0.2;

/// `(w, v)` with the true transform `p -> exp(w) (R p + t) + v`.
fn error<A, B>(truth: Rigid<A, B>, found: Rigid<A, B>) -> Vector6<f64> {
    let w = turn(truth.quaternion(), found.quaternion());
    let [x, y, z] = (truth * found.inverse()).translation_mm();
    Vector6::new(w[0], w[1], w[2], x, y, z)
}

/// Counted covariance seen in the predicted one's units: the identity where they agree.
fn whitened(counted: &Matrix6<f64>, predicted: &Matrix6<f64>) -> Matrix6<f64> {
    let inverse = predicted.cholesky().unwrap().l().try_inverse().unwrap();
    inverse * counted * inverse.transpose()
}

fn rms(list: &[f64]) -> f64 {
    (list.iter().map(|x| x * x).sum::<f64>() / list.len() as f64).sqrt()
}

#[test]
fn the_error_above_the_plate_reaches_its_figures() {
    let drawing = star();
    let target = Point::<Base>::new(0.0, 0.0, 80.0);
    for (counts, trials, most) in [([20, 10], 2000, 0.14), ([100, 50], 200, 0.064)] {
        let touching = Touching {
            drawing: &drawing,
            tip_radius: 0.0,
            sigma: SIGMA,
            counts,
        };
        let mut random = Random::new(1);
        let (mut errors, mut predicted, mut turns) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..trials {
            let truth = pose(&mut random);
            let groups = touching.groups(&mut random, truth);
            let found: Located<Tracker> = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
            errors.push((found.place.transform() * target).distance(truth * target));
            turns.push(
                found
                    .place
                    .transform()
                    .rotation()
                    .distance(truth.rotation())
                    .to_degrees(),
            );
            // By the noise given, which is right.
            predicted.push((found.place * target).rms_mm() / found.noise_ratio.max(1.0));
        }
        let (counted, predicted) = (rms(&errors), rms(&predicted));
        println!(
            "{counts:?} touches: {counted:.4} mm at 80 mm, predicted {predicted:.4}, turn {:.4} degrees",
            rms(&turns)
        );
        assert!(counted <= most, "{counts:?}: {counted}");
        // Three deviations of a root mean square of three components.
        let bound = 3.0 / (2.0 * 2.0 * trials as f64).sqrt();
        assert!(
            (counted / predicted - 1.0).abs() < bound,
            "{counts:?}: {counted} {predicted}"
        );
    }
}

#[test]
fn the_covariance_is_the_counted_one() {
    const TRIALS: usize = 4000;
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 1.5,
        sigma: SIGMA,
        counts: [20, 10],
    };
    let options = Options {
        tip_radius_mm: 1.5,
        ..Options::new(SIGMA)
    };
    let mut random = Random::new(2);
    let truth = pose(&mut random);
    let exact = Touching { sigma: 0.0, ..touching }.groups(&mut random, truth);
    let centre = truth * Point::<Base>::new(0.0, 0.0, 0.0);
    let (mut counted, mut predicted, mut ratio) = (Matrix6::zeros(), Matrix6::zeros(), 0.0);
    for _ in 0..TRIALS {
        let noisy: Vec<Group<Tracker>> = exact
            .iter()
            .map(|g| Group {
                touches: g.touches.iter().map(|p| *p + random.noise([SIGMA; 3])).collect(),
                ..g.clone()
            })
            .collect();
        let found = locate(&drawing, &noisy, &options).unwrap();
        let e = error(truth, found.place.transform());
        let c = Vector::<Tracker>::new(centre.mm()[0], centre.mm()[1], centre.mm()[2]);
        // What the base's origin moves by: v + w x c.
        let moved = Vector::<Tracker>::new(e[3], e[4], e[5]) + Vector::new(e[0], e[1], e[2]).cross(c);
        let [x, y, z] = moved.mm();
        let e = Vector6::new(e[0], e[1], e[2], x, y, z);
        counted += e * e.transpose() / TRIALS as f64;
        // By the noise given, which is right: by chance alone residuals show more of it half of the time.
        let given = found.noise_ratio.max(1.0).powi(2);
        predicted += found.place.covariance_about(centre) / given / TRIALS as f64;
        ratio += found.noise_ratio.powi(2) / TRIALS as f64;
    }
    let seen = whitened(&counted, &predicted);
    // Five deviations of a counted variance: 5 sqrt(2 / 4000); of the mean of six: 5 sqrt(2 / 24 000).
    assert!((seen - Matrix6::identity()).amax() < 0.112, "{seen}");
    assert!((seen.trace() / 6.0 - 1.0).abs() < 0.046, "{seen}");
    // 20 + 60 - 6 degrees of freedom.
    assert!((ratio - 1.0).abs() < 5.0 * (2.0_f64 / 74.0 / 4000.0).sqrt(), "{ratio}");
}

/// Up to twice the noise given was accepted with an error of the noise given: 95 % held 34 %.
#[test]
fn noise_that_shows_is_in_the_covariance() {
    const TRIALS: usize = 400;
    const MORE: f64 = 1.6;
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 0.0,
        sigma: MORE * SIGMA,
        counts: [20, 10],
    };
    let mut random = Random::new(3);
    let truth = pose(&mut random);
    let (mut squares, mut count) = (0.0, 0.0);
    for _ in 0..TRIALS {
        let groups = touching.groups(&mut random, truth);
        // By chance a touch in some hundreds lies beyond the gate of 6 / 1.6 deviations.
        let Ok(found) = locate(&drawing, &groups, &Options::new(SIGMA)) else {
            continue;
        };
        let e = error(truth, found.place.transform());
        squares += (e.transpose() * found.place.covariance().try_inverse().unwrap() * e)[0];
        count += 1.0;
    }
    assert!(count > 0.9 * TRIALS as f64, "{count}");
    // chi-square of 6 over one of 74 on 74: its mean is 6 * 74 / 72; a variance of 12, some more by the denominator, five deviations.
    // What was left out beyond the gate takes 2 % of the variance away.
    let (mean, bound) = (squares / count, 5.0 * (14.0 / count).sqrt() + 0.02 * 6.0);
    assert!((mean - 6.0 * 74.0 / 72.0).abs() < bound, "{mean} {bound}");
}

#[test]
fn without_noise_the_place_is_exact_for_every_tip() {
    let drawing = uneven();
    for (seed, tip_radius) in [(3, 0.0), (4, 0.5), (5, 2.0)] {
        let touching = Touching {
            drawing: &drawing,
            tip_radius,
            sigma: 0.0,
            counts: [6, 3],
        };
        let mut random = Random::new(seed);
        let truth = pose(&mut random);
        let groups = touching.groups(&mut random, truth);
        let options = Options {
            tip_radius_mm: tip_radius,
            ..Options::new(SIGMA)
        };
        let found = locate(&drawing, &groups, &options).unwrap();
        let target = Point::<Base>::new(0.0, 0.0, 80.0);
        // Touches are rounded at 2000 mm, 2e-13 mm, and the turn carries that over 80 mm.
        let off = (found.place.transform() * target).distance(truth * target);
        assert!(off < 1e-10, "{off:e}");
        // A tip taken for sharp lifts the base: by r on the plane and by r / sin 45 degrees in the grooves.
        if tip_radius > 0.0 {
            let sharp = locate(&drawing, &groups, &Options::new(SIGMA));
            let lifted = sharp.map(|f| (f.place.transform() * target).distance(truth * target));
            // A large one lifts it by more in the grooves than on the plane, which is seen.
            match lifted {
                Ok(lifted) => assert!(lifted > tip_radius && tip_radius < 1.0, "{tip_radius}"),
                Err(refused) => assert!(matches!(refused, calib::base::Refused::OneSide { .. }), "{refused}"),
            }
        }
    }
}

#[test]
fn labels_are_found_whatever_the_order() {
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 0.0,
        sigma: SIGMA,
        counts: [20, 10],
    };
    let orders = [[0, 1, 2, 3], [3, 1, 0, 2], [2, 3, 1, 0], [1, 0, 3, 2]];
    for (seed, order) in (10..34).zip(orders.iter().cycle()) {
        let mut random = Random::new(seed);
        let truth = pose(&mut random);
        let groups = touching.groups(&mut random, truth);
        let labelled = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
        let mixed = unlabelled(&order.map(|i| groups[i].clone()));
        let found = locate(&drawing, &mixed, &Options::new(SIGMA)).unwrap();
        assert_eq!(found.assignment, order.map(|i| Feature::ALL[i]));
        let e = error(labelled.place.transform(), found.place.transform());
        // The iteration ends at 1e-12 of the radius, and lies 2000 mm from the origin.
        assert!(e.fixed_rows::<3>(0).norm() < 1e-11 && e.norm() < 1e-7, "{e}");
        // All touches in one heap, in no order.
        let mut heap: Vec<Point<Tracker>> = groups.iter().flat_map(|g| g.touches.clone()).collect();
        for i in (1..heap.len()).rev() {
            heap.swap(i, (random.unit() * (i + 1) as f64) as usize);
        }
        let found = locate(&drawing, &separate(&heap, 6.0 * SIGMA).unwrap(), &Options::new(SIGMA)).unwrap();
        let target = Point::<Base>::new(0.0, 0.0, 80.0);
        let off = (found.place.transform() * target).distance(truth * target);
        // Eight deviations of the usual error.
        assert!(off < 1.2, "seed {seed}: {off}");
    }
}

#[test]
fn gross_errors_are_left_out() {
    let drawing = uneven();
    let touching = Touching {
        drawing: &drawing,
        tip_radius: 0.0,
        sigma: SIGMA,
        counts: [20, 10],
    };
    for seed in 40..60 {
        let mut random = Random::new(seed);
        let truth = pose(&mut random);
        let mut groups = touching.groups(&mut random, truth);
        let planted = [(0, 3), (0, 11), (1, 0), (2, 9), (3, 4)];
        for (group, touch) in planted {
            let p = &mut groups[group].touches[touch];
            // Lifted off by 5 to 25 mm.
            *p = *p + truth * Vector::<Base>::new(0.0, 0.0, 5.0 + 20.0 * random.unit());
        }
        let found = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
        let named: Vec<_> = found.rejected.iter().map(|r| (r.group, r.touch)).collect();
        assert_eq!(named, planted, "seed {seed}");
        let target = Point::<Base>::new(0.0, 0.0, 80.0);
        let off = (found.place.transform() * target).distance(truth * target);
        assert!(off < 1.2 && found.noise_ratio < 1.5, "seed {seed}: {off}");
    }
}

mod noise;
mod properties;
mod refusals;
mod seat;
