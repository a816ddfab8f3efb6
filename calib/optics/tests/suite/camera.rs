//! Cameras with a planted answer: found exactly, within their covariance, or refused by name.

mod field;
mod mixed;
mod plate;
mod refusals;
mod rig;

use crate::common::{Random, turn};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector6};
use optics::camera::{Camera, Lens, LensModel, NAMES, Options, PARAMETERS, calibrate};
use rig::{Rig, SIZE};

/// The lenses of the sweep: none, barrel, pincushion, with tangential terms, a laparoscope's, a prism: k1, k2, p1, p2, k3,
/// s1 to s4.
const LENSES: [(LensModel, [f64; 9]); 6] = [
    (LensModel::Pinhole, [0.0; 9]),
    (LensModel::Radial, [-0.3, 0.12, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (LensModel::Radial, [0.15, -0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (LensModel::Brown, [-0.25, 0.1, 0.004, -0.007, 0.0, 0.0, 0.0, 0.0, 0.0]),
    (
        LensModel::Brown5,
        [-0.29, -0.0019, 0.0072, -0.0002, 0.37, 0.0, 0.0, 0.0, 0.0],
    ),
    (
        LensModel::Prism,
        [-0.35, 0.3, 0.0, 0.0, 0.0, -0.008, 0.02, 0.024, -0.03],
    ),
];

fn camera(focal: f64, [k1, k2, p1, p2, k3, s @ ..]: [f64; 9]) -> Camera {
    Camera {
        focal: Vector2::new(focal, focal * 1.01),
        centre: Vector2::new(655.0, 340.0),
        skew: 0.0,
        lens: Lens { k1, k2, k3, p1, p2, s },
    }
}

/// Deviations of the numbers per pixel of noise are below 3e4 in all of these; pixels are rounded to 2e-13 and there are
/// hundreds: 1e-7 of a number of 1000, and 1e-7 of the lens', are a hundred times that.
#[test]
fn a_planted_camera_is_found_from_exact_discs() {
    for (model, lens) in LENSES {
        for focal in [600.0, 1200.0, 4000.0] {
            let planted = camera(focal, lens);
            let rig = Rig::around(planted, 7, 0.35);
            let options = Options {
                lens: model,
                ..Options::default()
            };
            let found = calibrate(&rig.views(None), SIZE, &options).unwrap();
            let (numbers, expected) = (found.camera.numbers(), planted.numbers());
            for k in 0..PARAMETERS {
                let off = (numbers[k] - expected[k]).abs();
                assert!(
                    off < 1e-7 * expected[k].abs().max(1.0),
                    "{model:?} {focal} {}: {off:e}",
                    NAMES[k]
                );
            }
            assert!(found.rms_px < 1e-9 && found.counts()[1] == 0, "{}", found.rms_px);
            for (view, pose) in found.views.iter().zip(&rig.poses) {
                let off = turn(view.pose.quaternion(), pose.quaternion());
                assert!(off.iter().all(|x| x.abs() < 1e-7), "{off:?}");
            }
        }
    }
}

#[test]
fn a_skew_is_found_where_it_is_free() {
    let planted = Camera {
        skew: 3.0,
        ..camera(1100.0, LENSES[3].1)
    };
    let views = Rig::around(planted, 8, 0.4).views(None);
    let options = Options {
        skew: true,
        ..Options::default()
    };
    let found = calibrate(&views, SIZE, &options).unwrap();
    assert!((found.camera.skew - 3.0).abs() < 1e-6, "{}", found.camera.skew);
    let held = calibrate(
        &views,
        SIZE,
        &Options {
            most_rejected: 1.0,
            ..Options::default()
        },
    )
    .unwrap();
    assert_eq!((held.camera.skew, held.sigmas()[4]), (0.0, 0.0));
}

/// Discs given by the centres of their images: with the radius the camera is exact to the polygon that stood for the
/// rim, without it the focal length is off by what perspective and the lens move centres, and residuals are left.
#[test]
fn centres_of_images_are_told_from_images_of_centres() {
    let planted = camera(1200.0, LENSES[3].1);
    let rig = Rig::around(planted, 7, 0.6);
    let views = rig.views(Some(rig.pitch_mm * 0.35));
    let found = calibrate(&views, SIZE, &Options::default()).unwrap();
    // A polygon of 720 sides errs by 1e-5 of the shift, itself below 0.3 px.
    assert!(
        (found.camera.focal - planted.focal).amax() < 1e-3 && found.rms_px < 1e-5,
        "{}",
        found.rms_px
    );
    let mut plain = views;
    plain
        .iter_mut()
        .flat_map(|v| &mut v.sightings)
        .for_each(|s| s.radius_mm = None);
    let biased = calibrate(&plain, SIZE, &Options::default()).unwrap();
    let off = (biased.camera.focal - planted.focal).amax();
    assert!(off > 0.03 && biased.rms_px > 1e-4, "{off} {}", biased.rms_px);
}

/// 200 calibrations under noise of a covariance of its own for every disc. A mean of chi-squares of n degrees has the
/// deviation sqrt(2 n / 200); a ratio of variances sqrt(2 / 200) = 0.1. Both within four of theirs.
#[test]
fn the_covariance_is_that_of_repeated_calibrations() {
    const TRIALS: u32 = 200;
    let planted = camera(1200.0, LENSES[3].1);
    let rig = Rig::around(planted, 6, 0.5);
    let exact = rig.views(None);
    let reference = calibrate(&exact, SIZE, &Options::default()).unwrap();
    let free: Vec<usize> = (0..PARAMETERS).filter(|k| reference.sigmas()[*k] > 0.0).collect();
    assert_eq!(free, [0, 1, 2, 3, 5, 6, 7, 8]);
    let block = SMatrix::<f64, 8, 8>::from_fn(|i, j| reference.covariance[(free[i], free[j])]);
    let information = block.try_inverse().unwrap();
    let pose_information = reference.views[2].covariance.try_inverse().unwrap();
    let (mut chi, mut pose_chi, mut ratio) = (0.0, 0.0, 0.0);
    let mut squares = SVector::<f64, 8>::zeros();
    for trial in 0..TRIALS {
        let mut random = Random::new(u64::from(trial) + 1);
        let found = calibrate(&rig::noisy(&exact, &mut random, 1.0), SIZE, &Options::default()).unwrap();
        let numbers = found.camera.numbers();
        let off = SVector::<f64, 8>::from_fn(|i, _| numbers[free[i]] - planted.numbers()[free[i]]);
        chi += off.dot(&(information * off));
        squares += off.component_mul(&off);
        let pose_off = rig::pose_off(&found.views[2].pose, &rig.poses[2]);
        pose_chi += pose_off.dot(&(pose_information * pose_off));
        ratio += found.noise_ratio;
    }
    let n = f64::from(TRIALS);
    assert!((chi / n - 8.0).abs() < 4.0 * (16.0 / n).sqrt(), "camera {}", chi / n);
    assert!(
        (pose_chi / n - 6.0).abs() < 4.0 * (12.0 / n).sqrt(),
        "pose {}",
        pose_chi / n
    );
    for i in 0..8 {
        let share = squares[i] / n / block[(i, i)];
        assert!(
            (share - 1.0).abs() < 4.0 * (2.0 / n).sqrt(),
            "{}: {share}",
            NAMES[free[i]]
        );
    }
    // 6 views of 63 discs: 756 coordinates, 712 degrees of freedom; the mean of 200 roots is known to 0.2 %.
    assert!((ratio / n - 1.0).abs() < 0.01, "{}", ratio / n);
}

/// Noise three times what was stated: the ratio says so, and the covariance grows with its square.
#[test]
fn noise_beyond_what_was_stated_grows_the_covariance() {
    let rig = Rig::around(camera(1200.0, LENSES[3].1), 6, 0.5);
    let exact = rig.views(None);
    let stated = calibrate(&exact, SIZE, &Options::default()).unwrap();
    let found = calibrate(&rig::noisy(&exact, &mut Random::new(5), 3.0), SIZE, &Options::default()).unwrap();
    // One deviation of the ratio is 3 / sqrt(2 x 712) = 0.08.
    assert!((found.noise_ratio - 3.0).abs() < 0.32, "{}", found.noise_ratio);
    let grown = found.sigmas()[0] / stated.sigmas()[0];
    assert!((grown / found.noise_ratio - 1.0).abs() < 0.05, "{grown}");
}

#[test]
fn discs_of_wrong_places_are_left_out() {
    let planted = camera(1200.0, LENSES[3].1);
    let rig = Rig::around(planted, 6, 0.5);
    let mut views = rig::noisy(&rig.views(None), &mut Random::new(9), 1.0);
    for (view, disc, by) in [(0, 3, [25.0, 0.0]), (2, 40, [0.0, -8.0]), (5, 11, [2.0, 2.0])] {
        views[view].sightings[disc].pixel += Vector2::from(by);
    }
    let found = calibrate(&views, SIZE, &Options::default()).unwrap();
    assert_eq!(found.counts()[1], 3);
    let out = |v: usize, d: usize| !found.views[v].residuals[d].used;
    assert!(out(0, 3) && out(2, 40) && out(5, 11));
    let (numbers, sigmas) = (found.camera.numbers(), found.sigmas());
    for k in [0, 1, 2, 3, 5, 6, 7, 8] {
        let off = (numbers[k] - planted.numbers()[k]).abs();
        assert!(off < 5.0 * sigmas[k], "{}: {off} {}", NAMES[k], sigmas[k]);
    }
    let refused = calibrate(
        &views,
        SIZE,
        &Options {
            most_rejected: 0.001,
            ..Options::default()
        },
    )
    .unwrap_err();
    assert!(refused.to_string().contains("3 of 378 discs"), "{refused}");
}

/// A rotation vector and a translation of one pose over another.
#[test]
fn the_test_rig_measures_poses_as_the_covariance_does() {
    let rig = Rig::around(camera(1200.0, LENSES[0].1), 6, 0.5);
    let off = rig::pose_off(&rig.poses[1], &rig.poses[1]);
    assert!(off.amax() < 1e-12 && off == Vector6::from(off));
    assert_eq!(rig::COVARIANCES[0], Matrix2::new(0.0004, 0.0, 0.0, 0.0009));
}
