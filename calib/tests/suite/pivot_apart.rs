//! Methods of pivot calibration agree to within their errors where the tip stays in place, and are told where it does not.

#![allow(clippy::print_stdout, reason = "shares")]

use crate::common::Random;
use calib::pivot::{Apart, Method, Options, Pivot, PoseNoise, apart, calibrate};
use geometry::rotation::{Rotation, RotationMatrix, RotationVector};
use geometry::{Marker, Point, Rigid, Tracker, Vector};

const TIP: Point<Marker> = Point::new(10.0, -20.0, 160.0);

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// Poses on a cone; the tip is off its place by `slip(i, tilt)`.
fn poses(
    random: &mut Random,
    cone_deg: f64,
    noise: PoseNoise,
    slip: impl Fn(usize, [f64; 2]) -> [f64; 3],
) -> Vec<Rigid<Tracker, Marker>> {
    let pose = |i: usize| {
        let size = cone_deg.to_radians() * random.unit().sqrt();
        let side = std::f64::consts::TAU * random.unit();
        let tilt = [size * side.cos(), size * side.sin()];
        let exact = turn([0.3, 2.1, -0.4]) * turn([tilt[0], tilt[1], 0.2 * random.normal()]);
        let lever = Rigid::<Tracker, Marker>::from_parts(exact, Vector::new(0.0, 0.0, 0.0)) * TIP;
        let [a, b, c] = slip(i, tilt);
        let origin = Point::new(120.0 + a, -340.0 + b, 1800.0 + c) - (lever - Point::new(0.0, 0.0, 0.0));
        let e = random.noise::<Tracker>([noise.sigma_rad; 3]).mm();
        let seen = origin + random.noise([noise.sigma_mm; 3]);
        Rigid::from_parts(turn(e) * exact, seen - Point::new(0.0, 0.0, 0.0))
    };
    (0..80).map(pose).collect()
}

fn judged(poses: &[Rigid<Tracker, Marker>], noise: PoseNoise) -> Option<Apart> {
    let solve = |method| calibrate(poses, &Options { method, noise }).ok();
    let all: Vec<Pivot<Tracker, Marker>> = Method::ALL.into_iter().filter_map(solve).collect();
    apart(&all)
}

const NOISE: PoseNoise = PoseNoise {
    sigma_mm: 0.1,
    sigma_rad: 1.7e-3,
};

/// Noise as assumed: told by chance in 4 of these 240.
#[test]
fn methods_agree_where_the_tip_stays_in_place() {
    for cone in [15.0, 25.0, 40.0] {
        let still = |_: usize, _: [f64; 2]| [0.0; 3];
        let one = |seed: &u64| judged(&poses(&mut Random::new(seed + 1), cone, NOISE, still), NOISE).is_some();
        let told = (0..80).filter(one).count();
        println!("cone {cone}: {told} of 80");
        assert!(told <= 2, "cone {cone}: {told} of 80");
    }
}

/// What errors-in-variables and robust estimates are drawn by in different ways: rotations noisier than was assumed beside the
/// places, on small cones; a divot that gives way with the tilt draws all alike, and is in the residuals only.
#[test]
fn methods_that_differ_beyond_their_errors_are_told() {
    let still = |_: usize, _: [f64; 2]| [0.0; 3];
    for (what, cone, factor, slips) in [
        ("rough rotations", 8.0, 6.0, 0),
        ("rough rotations", 15.0, 10.0, 0),
        ("slips", 25.0, 1.0, 7),
    ] {
        let made = PoseNoise {
            sigma_rad: factor * NOISE.sigma_rad,
            ..NOISE
        };
        let slip = |i: usize, tilt: [f64; 2]| match slips {
            0 => still(i, tilt),
            every => {
                if i.is_multiple_of(every) {
                    [6.0 + 30.0 * tilt[0], 4.0, 0.0]
                } else {
                    [0.0; 3]
                }
            }
        };
        let one = |seed: &u64| judged(&poses(&mut Random::new(seed + 1), cone, made, slip), NOISE).is_some();
        let told = (0..40).filter(one).count();
        println!("{what}, cone {cone}: {told} of 40");
        // By chance it would be one.
        assert!(told >= 12, "{what}, cone {cone}: {told} of 40");
    }
}

/// The published recording: 0.3 deg of noise where 0.1 was assumed beside 0.1 mm, and poses off by up to 12 mm.
#[test]
fn methods_differ_on_a_real_recording() {
    let beside = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = std::env::var_os("TROCAR_SHARED").map_or(beside, std::path::PathBuf::from);
    let Ok(entries) = std::fs::read_dir(shared.join("data/pivot-sks")) else {
        println!("skipped: no data/pivot-sks in {}", shared.display());
        return;
    };
    let pose = |path: std::path::PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let m: Vec<f64> = text.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
        let turn = (m.len() == 16).then(|| RotationMatrix::nearest([row(0), row(1), row(2)]).unwrap());
        turn.map(|turn| Rigid::from_parts(turn.matrix.rotation(), Vector::new(m[3], m[7], m[11])))
    };
    let poses: Vec<Rigid<Tracker, Marker>> = entries.filter_map(|e| pose(e.unwrap().path())).collect();
    let noise = PoseNoise {
        sigma_mm: 0.1,
        sigma_rad: 0.1_f64.to_radians(),
    };
    let found = judged(&poses, noise).unwrap();
    assert!(
        found.methods[1] == Method::ErrorsInVariables && found.mm > 3.0,
        "{found:?}"
    );
}
