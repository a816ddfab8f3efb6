//! Spin calibration against planted axes: exact, its covariance counted, bad motions refused. Seeds are fixed.

use crate::common::Random;
use calib::spin::{Limits, Refused, Spin, calibrate};
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Direction, Marker, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix3, Vector3};

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

fn axis() -> Direction<Marker> {
    Vector::new(0.2, -0.1, 1.0).direction().unwrap()
}

/// The point of the planted axis nearest to the marker's origin.
fn point() -> Point<Marker> {
    let any = Vector::<Marker>::new(12.0, 30.0, 4.0);
    Point::new(0.0, 0.0, 0.0) + (any - axis() * any.dot(axis().vector()))
}

struct Motion {
    poses: usize,
    range_deg: f64,
    sigma_mm: f64,
    sigma_deg: f64,
    wobble_deg: f64,
}

impl Motion {
    fn recorded(&self, random: &mut Random) -> Vec<Rigid<Tracker, Marker>> {
        let shaft = axis().components();
        let placing = turn([0.3, 2.1, -0.4]);
        let pose = |i: usize| {
            let angle = self.range_deg.to_radians() * (i as f64 / (self.poses - 1) as f64 - 0.3);
            let tilt: Vector<Tracker> = random.noise([self.wobble_deg.to_radians(); 3]);
            let exact = turn(tilt.mm()) * placing * turn(shaft.map(|c| c * angle));
            let carried = Rigid::<Tracker, Marker>::from_parts(exact, Vector::new(0.0, 0.0, 0.0)) * point();
            // The point slides along the axis too.
            let slide = turn(tilt.mm()) * placing;
            let along = slide.apply(shaft.map(|c| c * 5.0 * (0.1 * i as f64).sin()));
            let place = Point::<Tracker>::new(900.0 + along[0], along[1] - 50.0, 2000.0 + along[2]);
            let seen = place - (carried - Point::new(0.0, 0.0, 0.0)) + random.noise([self.sigma_mm; 3]);
            let error: Vector<Tracker> = random.noise([self.sigma_deg.to_radians(); 3]);
            Rigid::from_parts(turn(error.mm()) * exact, seen - Point::new(0.0, 0.0, 0.0))
        };
        (0..self.poses).map(pose).collect()
    }
}

const EXACT: Motion = Motion {
    poses: 60,
    range_deg: 180.0,
    sigma_mm: 0.0,
    sigma_deg: 0.0,
    wobble_deg: 0.0,
};

fn solved(motion: &Motion, random: &mut Random) -> Result<Spin<Tracker, Marker>, Refused> {
    calibrate(&motion.recorded(random), Direction::Z, Limits::default())
}

#[test]
fn exact_poses_give_the_exact_axis() {
    for range_deg in [31.0, 90.0, 300.0, 720.0] {
        let found = solved(&Motion { range_deg, ..EXACT }, &mut Random::new(2)).unwrap();
        // Rotations are good to 1e-15 and translations to 4e-13 mm; the eigenvector divides by 1 - rho^2 > 0.02.
        assert!(
            (found.axis.vector() - axis().vector()).norm() < 1e-12,
            "{range_deg}: {:?}",
            found.axis
        );
        assert!(found.point.distance(point()) < 1e-10, "{range_deg}: {:?}", found.point);
        // Sixty poses leave a gap of a sixtieth.
        let expected = range_deg.min(360.0);
        assert!((found.range_rad.to_degrees() - expected).abs() < expected / 50.0 + 1e-9);
        assert!(found.rms_mm < 1e-11 && found.wobble_rms_rad < 1e-14);
    }
}

#[test]
fn the_covariance_is_the_counted_one() {
    const TRIALS: usize = 4000;
    for (range_deg, sigma_deg, sigma_mm) in [(60.0, 0.1, 0.1), (360.0, 0.3, 0.2)] {
        let motion = Motion {
            poses: 80,
            range_deg,
            sigma_mm,
            sigma_deg,
            ..EXACT
        };
        let mut random = Random::new(6);
        let (mut tilts, mut places) = (Matrix3::zeros(), Matrix3::zeros());
        let (mut tilt, mut place) = (0.0, 0.0);
        for _ in 0..TRIALS {
            let found = solved(&motion, &mut random).unwrap();
            let a = Vector3::from((found.axis.vector() - axis().vector()).mm());
            let b = Vector3::from((found.point - point()).mm());
            tilts += a * a.transpose();
            places += b * b.transpose();
            tilt += found.axis_covariance.trace();
            place += found.point_covariance.trace();
        }
        // 8000 components: 1.6 %; three of them, and 1 % for the second order.
        assert!((tilts.trace() / tilt - 1.0).abs() < 0.06, "{}", tilts.trace() / tilt);
        // As many components, one of them small.
        assert!(
            (places.trace() / place - 1.0).abs() < 0.08,
            "{}",
            places.trace() / place
        );
        // Even about the axis: two eigenvalues of 4000 trials each, 2.2 % apart from one another, three of them.
        let values = tilts.symmetric_eigenvalues();
        let (most, sum) = (values.max(), tilts.trace());
        assert!((most / (0.5 * sum) - 1.0).abs() < 0.08, "{values}");
    }
}

#[test]
fn bad_motions_are_refused_by_name() {
    let refused = |motion: Motion| solved(&motion, &mut Random::new(3)).unwrap_err();
    let small = refused(Motion {
        range_deg: 20.0,
        ..EXACT
    });
    assert!(matches!(small, Refused::SmallRange { .. }), "{small}");
    assert!(
        small
            .to_string()
            .contains("20.0 degrees about the marker's z axis, at least 30"),
        "{small}"
    );
    let still = refused(Motion {
        range_deg: 0.0,
        ..EXACT
    });
    assert!(matches!(still, Refused::SmallRange { .. }), "{still}");
    let wobble = refused(Motion {
        wobble_deg: 5.0,
        ..EXACT
    });
    assert!(matches!(wobble, Refused::Wobble { .. }), "{wobble}");
    let few = refused(Motion { poses: 2, ..EXACT });
    assert!(matches!(few, Refused::TooFew { found: 2, .. }), "{few}");
    let poses = EXACT.recorded(&mut Random::new(3));
    let across = axis().cross(Direction::X).direction().unwrap();
    let sign = calibrate(&poses, across, Limits::default()).unwrap_err();
    assert!(matches!(sign, Refused::NoSign { .. }), "{sign}");
    // The hint chooses the sign.
    let back = Vector::new(0.0, 0.0, -1.0).direction().unwrap();
    let found = calibrate(&poses, back, Limits::default()).unwrap();
    assert!(found.axis.dot(axis()) < -0.999);
    let mut poses = poses;
    poses[7] = Rigid::from_parts(poses[7].rotation(), Vector::new(0.0, f64::NAN, 0.0));
    let bad = calibrate(&poses, Direction::Z, Limits::default()).unwrap_err();
    assert!(matches!(bad, Refused::NotFinite { pose: 7, .. }), "{bad}");
}
