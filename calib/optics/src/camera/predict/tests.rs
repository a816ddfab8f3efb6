//! Predictions against closed forms and differences.

use super::*;
use crate::camera::Lens;
use crate::camera::state::in_place;
use crate::disc::Ellipse;
use geometry::motion::Pose;
use geometry::rotation::{Rotation, RotationVector};
use nalgebra::Vector6;

fn pose() -> Pose {
    Pose {
        turn: Rotation::from_vector(RotationVector::new([0.9, -0.4, 0.3]).unwrap()),
        shift: Vector3::new(4.0, -7.0, 120.0),
    }
}

fn eye(camera: Camera, pose: &Pose) -> Eye {
    Eye {
        camera,
        bend: Bend::default(),
        turn: pose.matrix(),
        shift: pose.shift,
    }
}

fn ready(radius_mm: Option<f64>) -> Ready {
    Ready {
        disc: 0,
        place: Vector3::new(21.0, -12.0, 0.0),
        pixel: Vector2::zeros(),
        information: nalgebra::Matrix2::identity(),
        bow: [0.4, -0.2, 0.3],
        radius_mm,
    }
}

/// Under a pinhole the closed form is that of the ellipse. The eighth order of radius over distance, 1.4 / 100, times
/// the shift is below its rounding: numbers of 1000 and products of 1e6 in the conic.
#[test]
fn a_pinholes_centre_is_the_ellipses() {
    let camera = Camera {
        skew: 1.5,
        ..Camera::pinhole(1500.0, Vector2::new(640.0, 360.0))
    };
    let (pose, seen) = (pose(), ready(Some(1.4)));
    let eye = eye(camera, &pose);
    let turn = eye.turn;
    let k = Matrix3::new(1500.0, 1.5, 640.0, 0.0, 1500.0, 360.0, 0.0, 0.0, 1.0);
    let plane = Matrix3::from_columns(&[turn.column(0).into(), turn.column(1).into(), pose.shift]);
    let ellipse = Ellipse::of_circle(&(k * plane), seen.place.xy(), 1.4).unwrap();
    let found = predicted(&seen, &eye);
    let centre = predicted(&ready(None), &eye);
    assert!((ellipse.centre - centre).norm() > 0.05, "no shift to speak of");
    assert!((found - ellipse.centre).norm() < 1e-8, "{found} {}", ellipse.centre);
}

/// With a lens, against the sum over a grid of 1e6 small squares of the disc. Their number on the rim is uncertain by
/// its root, sqrt(2 pi 560) of 1e6: the middle's error is radius x 6e-5 / sqrt(1e6 pi) x 15 px/mm, below 1e-5.
#[test]
fn a_lenss_centre_is_that_of_the_area() {
    let lens = Lens {
        k1: -0.4,
        k2: 0.1,
        p1: 0.01,
        ..Lens::default()
    };
    let camera = Camera {
        lens,
        ..Camera::pinhole(1500.0, Vector2::new(640.0, 360.0))
    };
    let (pose, seen) = (pose(), ready(Some(1.4)));
    let eye = eye(camera, &pose);
    let turn = eye.turn;
    let (mut sum, mut area) = (Vector2::zeros(), 0.0);
    let n = 560;
    for i in -n..n {
        for j in -n..n {
            let at = Vector2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(n);
            if at.norm_squared() > 1.0 {
                continue;
            }
            let by_shift = |s: &Ready| slopes(s, &eye).1.1.fixed_columns::<3>(3).into_owned();
            let here = Ready {
                place: seen.place + Vector3::new(at.x, at.y, 0.0) * 1.4,
                ..ready(None)
            };
            let slope = by_shift(&here);
            let (a, b) = (slope * turn.column(0), slope * turn.column(1));
            let weight = a.x * b.y - a.y * b.x;
            sum += predicted(&here, &eye) * weight;
            area += weight;
        }
    }
    let found = predicted(&seen, &eye);
    assert!((found - sum / area).norm() < 1e-5, "{found} {}", sum / area);
}

#[test]
fn a_disc_behind_the_camera_is_seen_nowhere() {
    let camera = Camera::pinhole(1500.0, Vector2::zeros());
    let behind = Pose {
        shift: Vector3::new(0.0, 0.0, -50.0),
        ..pose()
    };
    assert!(predicted(&ready(None), &eye(camera, &behind)).x.is_nan());
}

/// Central differences of numbers of 1e3 with steps of 1e-5: rounding 1e-13 / 1e-5 and third derivatives h^2 x 1e3.
#[test]
fn derivatives_are_those_of_differences() {
    let camera = Camera::from_numbers([
        1500.0, 1480.0, 640.0, 360.0, 2.0, -0.3, 0.1, 0.004, -0.003, 0.02, 0.02, -0.01, 0.03, 0.05,
    ]);
    let (pose, h) = (pose(), 1e-5);
    let eye = Eye {
        bend: Bend([0.7, -0.4, 1.1]),
        ..eye(camera, &pose)
    };
    for radius_mm in [None, Some(1.4), Some(9.0)] {
        let seen = ready(radius_mm);
        let (at, (by_shared, by_pose)) = slopes(&seen, &eye);
        assert_eq!(at, predicted(&seen, &eye));
        for k in 0..6 {
            let moved = |d: f64| {
                let moved = in_place(&pose, &Vector6::ith(k, d)).unwrap();
                let (turn, shift) = (moved.matrix(), moved.shift);
                predicted(&seen, &Eye { turn, shift, ..eye })
            };
            let by = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((by_pose.column(k) - by).norm() < 1e-6 * by.norm().max(1.0), "{k}: {by}");
        }
        for k in 0..SHARED {
            let moved = |d: f64| {
                let (mut numbers, mut bend) = (camera.numbers(), eye.bend);
                match k {
                    k if k < PARAMETERS => numbers[k] += d,
                    k => bend.0[k - PARAMETERS] += d,
                }
                let camera = Camera::from_numbers(numbers);
                predicted(&seen, &Eye { camera, bend, ..eye })
            };
            let by = (moved(h) - moved(-h)) / (2.0 * h);
            assert!(
                (by_shared.column(k) - by).norm() < 1e-6 * by.norm().max(1.0),
                "{k}: {by}"
            );
        }
    }
}
