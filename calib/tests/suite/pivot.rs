//! Pivot calibration against planted tips: errors by method and cone, slips, covariances against counted ones. Seeds and
//! counts are fixed.

#![allow(clippy::print_stdout, reason = "measured errors")]

use crate::common::Random;
use calib::pivot::{Method, Options, Pivot, PoseNoise, calibrate};
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix6, Vector6};

const TIP: Point<Marker> = Point::new(0.0, 0.0, 160.0);
const PIVOT: Point<Tracker> = Point::new(120.0, -340.0, 1800.0);

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// A recording: cone filled evenly, without turning about the shaft.
struct Motion {
    cone_deg: f64,
    poses: usize,
    noise: PoseNoise,
    /// Part of the poses whose tip slipped by `slip_mm`.
    slips: f64,
    slip_mm: f64,
}

fn motion(cone_deg: f64, poses: usize, noise_deg: f64) -> Motion {
    let noise = PoseNoise {
        sigma_mm: 0.1,
        sigma_rad: noise_deg.to_radians(),
    };
    Motion {
        cone_deg,
        poses,
        noise,
        slips: 0.0,
        slip_mm: 10.0,
    }
}

impl Motion {
    fn recorded(&self, random: &mut Random, tip: Point<Marker>) -> Vec<Rigid<Tracker, Marker>> {
        (0..self.poses).map(|i| self.pose(i, random, tip)).collect()
    }

    fn pose(&self, i: usize, random: &mut Random, tip: Point<Marker>) -> Rigid<Tracker, Marker> {
        let tilt = self.cone_deg.to_radians() * random.unit().sqrt();
        let side = std::f64::consts::TAU * random.unit();
        let exact = turn([0.3, 2.1, -0.4]) * turn([tilt * side.cos(), tilt * side.sin(), 0.0]);
        let lever = Rigid::<Tracker, Marker>::from_parts(exact, Vector::new(0.0, 0.0, 0.0)) * tip;
        let origin = PIVOT - (lever - Point::new(0.0, 0.0, 0.0));
        let mut seen = origin + random.noise([self.noise.sigma_mm; 3]);
        if (i as f64) < self.slips * self.poses as f64 {
            let way = random.vector::<Tracker>(1.0).direction().unwrap();
            seen = seen + way * self.slip_mm;
        }
        let error: Vector<Tracker> = random.noise([self.noise.sigma_rad; 3]);
        Rigid::from_parts(turn(error.mm()) * exact, seen - Point::new(0.0, 0.0, 0.0))
    }
}

fn solved(poses: &[Rigid<Tracker, Marker>], method: Method, noise: PoseNoise) -> Pivot<Tracker, Marker> {
    calibrate(poses, &Options { method, noise }).unwrap()
}

/// Root mean square error of the tip, and the length of its mean, mm.
fn tip_error(motion: &Motion, method: Method, seed: u64, trials: usize) -> (f64, f64) {
    let mut random = Random::new(seed);
    let (mut squares, mut sum) = (0.0, Vector::<Marker>::new(0.0, 0.0, 0.0));
    for _ in 0..trials {
        let miss = solved(&motion.recorded(&mut random, TIP), method, motion.noise).tip - TIP;
        squares += miss.dot(miss);
        sum = sum + miss;
    }
    ((squares / trials as f64).sqrt(), sum.norm() / trials as f64)
}

#[test]
fn the_tip_is_as_near_as_promised() {
    // Of 200 trials with about two directions that matter the deviation of a root mean square is 4 %: half of that is
    // added to the first bound, the likelihood itself giving 0.0229.
    const TRIALS: usize = 200;
    for (cone, noise_deg, most, algebraic_least) in [
        (45.0, 0.05, 0.0235, 0.0),
        (20.0, 0.2, 0.11, 0.12),
        (10.0, 0.2, 0.25, 0.3),
        (5.0, 0.2, 0.45, 1.0),
    ] {
        let motion = motion(cone, 500, noise_deg);
        let (error, bias) = tip_error(&motion, Method::ErrorsInVariables, 5, TRIALS);
        let (robust, _) = tip_error(&motion, Method::Robust, 5, TRIALS);
        let (algebraic, pulled) = tip_error(&motion, Method::Algebraic, 5, TRIALS);
        let (two_step, _) = tip_error(&motion, Method::TwoStep, 5, TRIALS);
        println!(
            "cone {cone}: errors in variables {error:.4} (bias {bias:.4}), robust {robust:.4}, algebraic {algebraic:.4} \
             (bias {pulled:.4}), two-step {two_step:.4} mm"
        );
        assert!(error <= most, "cone {cone}: {error}");
        assert!(algebraic >= algebraic_least, "cone {cone}: {algebraic}");
        // The mean of 200 errors has a deviation of error / 14; three of them.
        assert!(bias < 0.22 * error, "cone {cone}: bias {bias}, error {error}");
    }
}

#[test]
fn slips_are_survived() {
    for (slips, slip_mm, most) in [
        (0.1, 10.0, 0.04),
        (0.3, 10.0, 0.05),
        (0.4, 40.0, 0.06),
        (0.1, 500.0, 0.04),
    ] {
        let motion = Motion {
            slips,
            slip_mm,
            ..motion(45.0, 200, 0.05)
        };
        let (error, _) = tip_error(&motion, Method::ErrorsInVariables, 9, 60);
        let (algebraic, _) = tip_error(&motion, Method::Algebraic, 9, 60);
        println!("slips {slips} of {slip_mm} mm: {error:.4}, algebraic {algebraic:.4} mm");
        assert!(error <= most && algebraic > 4.0 * error, "{slips}: {error} {algebraic}");
        let mut random = Random::new(3);
        let found = solved(&motion.recorded(&mut random, TIP), Method::default(), motion.noise);
        let bad = (slips * 200.0) as usize;
        assert!(found.weights[..bad].iter().all(|w| *w == 0.0), "{slips}");
        // Of normal residuals one in 10^10 is beyond 7 deviations.
        assert_eq!(found.inliers, 200 - bad);
        assert!(found.rms_mm < 0.3 && found.rms_all_mm > 1.0, "{found:?}");
    }
}

#[test]
fn the_covariance_is_the_counted_one() {
    const TRIALS: usize = 2000;
    let tip = Point::new(20.0, -35.0, 150.0);
    for (method, cone, poses, noise_deg, given) in [
        (Method::ErrorsInVariables, 30.0, 100, 0.1, 1.0),
        // The size of the noise is measured: what is given only counts by its ratio.
        (Method::ErrorsInVariables, 30.0, 100, 0.1, 7.0),
        (Method::ErrorsInVariables, 8.0, 300, 0.2, 1.0),
        (Method::Robust, 40.0, 60, 0.0, 1.0),
        (Method::Algebraic, 40.0, 60, 0.1, 1.0),
    ] {
        let motion = motion(cone, poses, noise_deg);
        let noise = PoseNoise {
            sigma_mm: motion.noise.sigma_mm * given,
            sigma_rad: motion.noise.sigma_rad * given,
        };
        let mut random = Random::new(21);
        let (mut counted, mut predicted) = (Matrix6::zeros(), Matrix6::zeros());
        for _ in 0..TRIALS {
            let found = solved(&motion.recorded(&mut random, tip), method, noise);
            let (a, b) = ((found.tip - tip).mm(), (found.pivot - PIVOT).mm());
            let miss = Vector6::new(a[0], a[1], a[2], b[0], b[1], b[2]);
            counted += miss * miss.transpose() / TRIALS as f64;
            predicted += found.covariance.unwrap() / TRIALS as f64;
        }
        // The counted covariance in units of the predicted: the identity but for 1 / sqrt(1000) = 3 % per entry; the
        // predictions' mean is good to 1 %, and the biweight's loss at finite numbers to 2.
        let factor = predicted.cholesky().unwrap().l().try_inverse().unwrap();
        let ratio = factor * counted * factor.transpose();
        let off = (ratio - Matrix6::identity()).amax();
        println!("{method:?} cone {cone}: largest entry off by {off:.3}");
        assert!(off < 0.13, "{method:?} cone {cone}: {ratio}");
    }
}

#[test]
fn the_noise_is_found_from_the_residuals() {
    let motion = motion(30.0, 2000, 0.2);
    let mut random = Random::new(4);
    let found = solved(&motion.recorded(&mut random, TIP), Method::default(), motion.noise);
    // 2000 components along and 4000 across: 1.6 % and 1.2 % of deviation each; three of them.
    let PoseNoise { sigma_mm, sigma_rad } = found.estimated;
    assert!((sigma_mm / 0.1 - 1.0).abs() < 0.05, "{sigma_mm}");
    assert!((sigma_rad.to_degrees() / 0.2 - 1.0).abs() < 0.05, "{sigma_rad}");
}

#[test]
fn exact_poses_give_the_exact_tip() {
    for cone in [3.0, 10.0, 60.0, 120.0] {
        let exact = Motion {
            noise: PoseNoise {
                sigma_mm: 0.0,
                sigma_rad: 0.0,
            },
            ..motion(cone, 30, 0.0)
        };
        let poses = exact.recorded(&mut Random::new(8), TIP);
        for method in Method::ALL {
            let found = solved(&poses, method, PoseNoise::default());
            // Translations of 1800 mm are rounded to 2e-13, and normal equations square the condition; a sphere's centre
            // depends on the opening to the fourth power.
            let power = if method == Method::Sphere { 4 } else { 2 };
            let bound = 4e-13 * found.condition.powi(power) + 1e-11;
            let miss = found.tip.distance(TIP);
            assert!(miss < bound, "{method:?} cone {cone}: {miss:e} {bound:e}");
        }
    }
}
