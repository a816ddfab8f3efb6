//! Pictures of two cameras taken together: refused by the noise ratio, and told apart.

use nalgebra::Vector2;
use optics::camera::{Camera, CameraRefused, Gates, LensModel, Options, Short, View, agreeing, calibrate};

use super::rig::{Rig, SIZE, noisy};
use super::{LENSES, camera};
use crate::common::Random;

/// The two cameras of a stereo laparoscope: as alike as such are, their principal points on either side of the middle.
fn pair() -> [Camera; 2] {
    let left = camera(1200.0, LENSES[3].1);
    let mut right = left;
    right.focal *= 1.01;
    right.centre -= Vector2::new(30.0, 6.0);
    right.lens.k1 += 0.02;
    [left, right]
}

/// Views of one grid in turn by the cameras, `of` each view.
pub(crate) fn mixed(cameras: &[Camera], of: &[usize], tilt: f64, random: &mut Random) -> Vec<View> {
    let each = |camera: &Camera| Rig::around(*camera, of.len() as u32, tilt).views(None);
    let all: Vec<Vec<View>> = cameras.iter().map(each).collect();
    let views: Vec<View> = of.iter().enumerate().map(|(view, k)| all[*k][view].clone()).collect();
    noisy(&views, random, 1.0)
}

#[test]
fn pictures_of_two_cameras_are_refused_and_told_apart() {
    for (seed, of) in [
        vec![0, 0, 0, 1, 1, 1],
        vec![0, 1, 0, 1, 0, 1, 0, 1],
        vec![0, 0, 0, 0, 1, 0],
        vec![1, 1, 1, 0, 0, 0, 0, 0, 1, 1, 1, 1],
    ]
    .into_iter()
    .enumerate()
    {
        let views = mixed(&pair(), &of, 0.5, &mut Random::new(seed as u64 + 1));
        match calibrate(&views, SIZE, &Options::default()) {
            Ok(found) => {
                let ratios = [found.noise_ratio, found.view_ratio];
                let short = Gates::default().judge(&found.coverage, found.rms_px, ratios);
                let apart = |s: &Short| matches!(s, Short::Noise { limit: 3.0, .. } | Short::Views { limit: 3.0, .. });
                assert!(short.iter().any(apart), "{of:?}: {ratios:?}");
            }
            Err(refused) => assert!(matches!(refused, CameraRefused::Outliers { .. }), "{refused}"),
        }
        let agreed = agreeing(&views, SIZE, &Options::default(), 3.0).unwrap();
        let one = of[agreed.group.iter().position(|g| *g).unwrap()];
        let expected: Vec<bool> = of.iter().map(|k| *k == one).collect();
        assert_eq!(agreed.group, expected, "{of:?} {agreed:?}");
        // A chi-square of 8 degrees of freedom or more is below 3.3 times their number in 999 of 1000.
        assert!(agreed.ratio < 1.82, "{agreed:?}");
        let rest = of.iter().filter(|k| **k != one).count();
        assert_eq!(agreed.others.is_some(), rest >= 3, "{of:?} {agreed:?}");
    }
}

/// One camera is accepted however its noise falls, and then no views are told apart.
#[test]
fn pictures_of_one_camera_are_not_told_apart() {
    for seed in 0..6 {
        let views = mixed(&pair(), &[0; 7], 0.4, &mut Random::new(seed + 20));
        let found = calibrate(&views, SIZE, &Options::default()).unwrap();
        // Chi-squares of 800 and of 24 degrees of freedom: four deviations.
        assert!((found.noise_ratio - 1.0).abs() < 0.1, "{}", found.noise_ratio);
        assert!(
            (found.view_ratio.powi(2) - 1.0).abs() < 4.0 * (2.0_f64 / 24.0).sqrt(),
            "{}",
            found.view_ratio
        );
        assert_eq!(agreeing(&views, SIZE, &Options::default(), 3.0), None);
    }
}

/// A lens that the model does not have: no three views agree, and none is blamed.
#[test]
fn a_wrong_lens_blames_no_view() {
    let views = mixed(&pair(), &[0; 6], 0.5, &mut Random::new(40));
    let options = Options {
        lens: LensModel::Pinhole,
        most_rejected: 1.0,
        ..Options::default()
    };
    let found = calibrate(&views, SIZE, &options).unwrap();
    assert!(found.noise_ratio > 3.0, "{}", found.noise_ratio);
    assert_eq!(agreeing(&views, SIZE, &options, 3.0), None);
}

/// What mixtures below the gate cost: a sweep over how far the second camera is from the first.
#[test]
#[ignore = "prints a table; a minute"]
#[allow(clippy::print_stdout, reason = "a table")]
fn mixtures_below_the_gate() {
    println!(
        "focal | centre px | k1 | noise, views ratio, median | refused by noise, by either |  worst |error| / deviation of fx, cx | accepted"
    );
    for (focal, centre, k1) in [
        (0.0, 0.0, 0.0),
        (0.001, 0.0, 0.0),
        (0.003, 0.0, 0.0),
        (0.01, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 3.0, 0.0),
        (0.0, 10.0, 0.0),
        (0.0, 30.0, 0.0),
        (0.0, 0.0, 0.003),
        (0.0, 0.0, 0.01),
        (0.003, 3.0, 0.003),
    ] {
        let (mut ratios, mut views_ratios, mut by_noise) = (Vec::new(), Vec::new(), 0);
        let (mut worst, mut worst_px, mut accepted) = ([0.0_f64; 2], [0.0_f64; 2], 0);
        for seed in 0..40 {
            let [left, _] = pair();
            let mut right = Camera {
                focal: left.focal * (1.0 + focal),
                centre: left.centre + Vector2::new(centre, 0.3 * centre),
                ..left
            };
            right.lens.k1 = left.lens.k1 + k1;
            let views = mixed(
                &[left, right],
                &[0, 1, 0, 1, 0, 1, 0, 1],
                0.5,
                &mut Random::new(seed + 100),
            );
            let Ok(found) = calibrate(&views, SIZE, &Options::default()) else {
                continue;
            };
            ratios.push(found.noise_ratio);
            views_ratios.push(found.view_ratio);
            by_noise += usize::from(found.noise_ratio > 3.0);
            if found.noise_ratio <= 3.0 && found.view_ratio <= 3.0 {
                accepted += 1;
                for (i, k) in [0, 2].into_iter().enumerate() {
                    let off = (found.camera.numbers()[k] - left.numbers()[k]).abs();
                    worst[i] = worst[i].max(off / found.sigmas()[k]);
                    worst_px[i] = worst_px[i].max(off);
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        views_ratios.sort_by(f64::total_cmp);
        println!(
            "{focal} | {centre} | {k1} | {:.2} {:.2} | {by_noise} {} of {} | {:.1} {:.1} ({:.2} {:.2} px)",
            ratios[ratios.len() / 2],
            views_ratios[ratios.len() / 2],
            ratios.len() - accepted,
            ratios.len(),
            worst[0],
            worst[1],
            worst_px[0],
            worst_px[1],
        );
    }
}
