//! A marker of diodes on a ball, seen from all sides.

use calib::bundle::View;
use calib::marker::even_directions;
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use nalgebra::Vector3;

use super::Random;

/// Of half of the emission's cone, 75 degrees: 8.9 of 24 on an even ball are seen.
const LEAST_COSINE: f64 = 0.258_819;

/// `n` emitters on a sphere of `radius` mm.
pub(crate) fn ball(n: usize, radius: f64) -> Vec<Point<Marker>> {
    let origin = Point::new(0.0, 0.0, 0.0);
    even_directions(n).iter().map(|d| origin + *d * radius).collect()
}

/// Poses in front of the localizer, about 2 m away, turned every way.
pub(crate) fn poses(random: &mut Random, count: usize) -> Vec<Rigid<Tracker, Marker>> {
    let pose = |_| {
        let axis = Vector3::new(random.normal(), random.normal(), random.normal());
        let turn = axis.try_normalize(0.0).unwrap_or_default() * (random.unit() * std::f64::consts::PI);
        let [x, y, z] = random.vector::<Tracker>(200.0).mm();
        let shift = Vector::new(x, y, z - 2000.0);
        Rigid::from_rotation_vector(Vector::new(turn.x, turn.y, turn.z), shift).unwrap()
    };
    (0..count).map(pose).collect()
}

/// The emitters that face the localizer in each pose, each with its noise of `sigma[k]` along axis k.
pub(crate) fn seen(
    random: &mut Random,
    emitters: &[Point<Marker>],
    poses: &[Rigid<Tracker, Marker>],
    sigma: [f64; 3],
) -> Vec<View> {
    let mut view = |pose: &Rigid<Tracker, Marker>| {
        let mut list = View::new();
        for (i, b) in emitters.iter().enumerate() {
            let normal = *pose * (*b - Point::new(0.0, 0.0, 0.0));
            if normal.mm()[2] >= LEAST_COSINE * normal.norm() {
                list.push((i, *pose * *b + random.noise(sigma)));
            }
        }
        list
    };
    poses.iter().map(&mut view).collect()
}
