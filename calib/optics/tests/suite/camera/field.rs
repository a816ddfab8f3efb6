//! Plates whose discs lie off a paraboloid by a smooth field: it is found where it is, and ends in nothing where it is not.

use nalgebra::{Vector2, Vector3};
use optics::camera::{Calibrated, Options, View, calibrate, held_out};

use super::plate::{moved, place};
use super::rig::{self, Rig, SIZE};
use super::{LENSES, camera};
use crate::common::Random;

/// A bend, a wave across in height and waves in the plane, mm: no paraboloid is like them. Odd in both coordinates, those in
/// the plane have no linear part, which would be an error of the stated pitch.
fn offset(at: Vector2<f64>) -> Vector3<f64> {
    let [u, w] = place(at);
    Vector3::new(
        0.08 * (2.0 * u).sin() * (2.0 * w).sin(),
        -0.06 * (2.5 * u).sin() * (1.5 * w).sin(),
        0.3 * u * w + 0.15 * (3.0 * u + 1.0).sin() * w,
    )
}

fn rig() -> Rig {
    Rig::around(camera(1200.0, LENSES[3].1), 7, 0.5)
}

fn options(field: bool) -> Options {
    Options {
        bent: true,
        field,
        gate: 1e6,
        ..Options::default()
    }
}

/// How far the found offsets are from the planted ones, RMS in units of their deviations and in mm, after what pose, focal
/// lengths and pitch have of them: places of a plate can be told only up to a plane in height and a linear map in it.
fn off(found: &Calibrated, views: &[View]) -> [f64; 2] {
    let plate = found.plate.as_ref().unwrap();
    let places: Vec<Vector2<f64>> = views[0].sightings.iter().map(|s| s.at_mm).collect();
    let powers = nalgebra::DMatrix::from_fn(places.len(), 3, |i, k| match (k, place(places[i])) {
        (0, _) => 1.0,
        (k, p) => p[k - 1],
    });
    let inverse = powers.clone().pseudo_inverse(1e-12).unwrap();
    let mut sums = [0.0; 2];
    for axis in 0..3 {
        let each = places.iter().map(|at| plate.offset_mm(*at)[axis] - offset(*at)[axis]);
        let raw = nalgebra::DVector::from_iterator(places.len(), each);
        let left = &raw - &powers * (&inverse * &raw);
        for (at, left) in places.iter().zip(left.iter()) {
            sums[0] += (left / plate.deviation_mm(*at)[axis]).powi(2);
            sums[1] += left * left;
        }
    }
    sums.map(|s| (s / (3 * places.len()) as f64).sqrt())
}

#[test]
fn a_planted_field_is_found_to_its_deviations() {
    let rig = rig();
    let noisy = rig::noisy(&moved(&rig, offset), &mut Random::new(2), 1.0);
    let found = calibrate(&noisy, SIZE, &options(true)).unwrap();
    let bent = calibrate(&noisy, SIZE, &options(false)).unwrap();
    let [ratio, mm] = off(&found, &noisy);
    // Neighbouring discs err together, some dozens of numbers in all: their mean square is known to a third, and twice
    // that is allowed.
    assert!((0.4..1.5).contains(&ratio), "{ratio} {mm}");
    assert!(mm < 0.3 * off(&bent, &noisy)[1], "{mm}");
    // The noise is that stated, of 7 x 63 discs: a ratio known to 3.5 %.
    assert!((found.noise_ratio - 1.0).abs() < 0.14, "{}", found.noise_ratio);
    assert!(bent.noise_ratio > 2.0, "{}", bent.noise_ratio);
}

/// Every number within five of its deviations of the planted one.
#[test]
fn a_camera_beside_a_field_is_within_its_covariance() {
    let rig = rig();
    for seed in 0..4 {
        let noisy = rig::noisy(&moved(&rig, offset), &mut Random::new(seed + 20), 1.0);
        let found = calibrate(&noisy, SIZE, &options(true)).unwrap();
        let (numbers, sigmas) = (found.camera.numbers(), found.sigmas());
        for k in [0, 1, 2, 3, 5, 6, 7, 8] {
            let away = (numbers[k] - rig.camera.numbers()[k]).abs() / sigmas[k];
            assert!(away < 5.0, "{seed} {k}: {away}");
        }
    }
}

#[test]
fn views_held_out_tell_where_a_field_is() {
    let rig = rig();
    let rms = |views: &[View], field: bool| {
        let all = held_out(views, SIZE, &options(field)).unwrap();
        (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt()
    };
    let there = rig::noisy(&moved(&rig, offset), &mut Random::new(3), 1.0);
    assert!(rms(&there, true) < 0.6 * rms(&there, false));
    let flat = rig::noisy(&rig.views(None), &mut Random::new(3), 1.0);
    // Sizes of nothing take and give nothing: a hundredth of the noise.
    assert!(rms(&flat, true) < 1.01 * rms(&flat, false));
    let found = calibrate(&flat, SIZE, &options(true)).unwrap();
    let field = found.plate.unwrap().field.unwrap();
    // A pixel's noise of 0.03 over seven views is 0.01 mm of a place.
    assert!(
        field.sizes_mm.iter().all(|s| *s < 0.01) && field.fixed < 15.0,
        "{:?} {}",
        field.sizes_mm,
        field.fixed
    );
}
