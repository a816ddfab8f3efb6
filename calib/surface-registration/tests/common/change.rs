//! Drawn points with something the matter: moved, mirrored, held still, of the skin, along one line.

use chance::Chance;
use geometry::rotation::{Rotation, RotationMatrix, RotationVector};
use geometry::{Ct, Point, Rigid, Tracker, Vector, checked};
use nalgebra::{Matrix3, Matrix6, Vector3};
use surface_registration::{SharedError, Surface};

use super::draw::{Drawn, across};

type V = Vector3<f64>;

fn way(c: Chance, first: u64) -> V {
    V::from_fn(|k, _| c.normal(first + k as u64))
        .try_normalize(0.0)
        .unwrap()
}

/// Takes the points at these places, in this order.
fn taken(drawn: &mut Drawn, order: &[usize]) {
    drawn.points = order.iter().map(|i| drawn.points[*i]).collect();
    drawn.is_outlier = order.iter().map(|i| drawn.is_outlier[*i]).collect();
    drawn.exact = order.iter().map(|i| drawn.exact[*i]).collect();
}

/// In the order of a sweep over the phantom: left crest, pubis, right crest, along each of them.
pub(crate) fn in_order(mut drawn: Drawn) -> Drawn {
    let key = |i: usize| {
        let [x, _, z] = drawn.exact[i].mm();
        // Third of the pelvis, and strokes along it that are 4 mm wide.
        ((x / 120.0) as i64, (z / 4.0) as i64, x)
    };
    let mut order: Vec<usize> = (0..drawn.points.len()).collect();
    order.sort_by(|a, b| {
        let (a, b) = (key(*a), key(*b));
        (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
    });
    taken(&mut drawn, &order);
    drawn
}

/// The bone moves by so much, in a direction that follows from the seed, after 30 to 70 % of the points: it turns about the middle of the
/// points by a quarter of a degree for each mm, and shifts. The truth is where it was before. Gives the number of points before.
pub(crate) fn moved(drawn: &mut Drawn, mm: f64, seed: u64) -> usize {
    let c = Chance::new(seed, 1 << 42);
    let n = drawn.points.len();
    let before = (n as f64 * (0.3 + 0.4 * c.uniform(30))) as usize;
    let middle = drawn.exact.iter().map(|p| V::from(p.mm())).sum::<V>() / n as f64;
    let turn = Rotation::from_vector(RotationVector::new((way(c, 0) * (0.25 * mm).to_radians()).into()).unwrap());
    let shift = middle - V::from(turn.apply(middle.into())) + way(c, 10) * mm;
    let motion: Rigid<Ct, Ct> = Rigid::from_parts(turn, Vector::new(shift.x, shift.y, shift.z));
    let pose = drawn.ct_from_tracker;
    for point in &mut drawn.points[before..] {
        point.place = pose.inverse() * (motion * (pose * point.place));
    }
    before
}

/// Soft tissue of so many mm lies between tip and bone on one side of the middle of the points; which one follows from the seed.
pub(crate) fn one_sided(drawn: &mut Drawn, surface: &Surface<Ct>, mm: f64, seed: u64) {
    let side = way(Chance::new(seed, 1 << 48), 0);
    let middle = drawn.exact.iter().map(|p| V::from(p.mm())).sum::<V>() / drawn.exact.len() as f64;
    raised(drawn, surface, mm, |_, p| side.dot(&(p - middle)) > 0.0);
}

/// The points that are chosen by their number and place lie so many mm outside of the bone.
pub(crate) fn raised(drawn: &mut Drawn, surface: &Surface<Ct>, mm: f64, chosen: impl Fn(usize, V) -> bool) {
    let tracked = drawn.ct_from_tracker.inverse();
    for (i, (point, exact)) in drawn.points.iter_mut().zip(&drawn.exact).enumerate() {
        if chosen(i, V::from(exact.mm())) {
            let [x, y, z] = surface.distance(*exact).normal.map(|n| n * mm);
            point.place = point.place + tracked * Vector::<Ct>::new(x, y, z);
        }
    }
}

/// The bone drifts evenly while the points are taken, by so many mm in all, in a direction that follows from the seed, and turns by a quarter
/// of a degree for each. The truth is where it ends.
pub(crate) fn drifting(drawn: &mut Drawn, mm: f64, seed: u64) {
    let c = Chance::new(seed, 1 << 49);
    let n = drawn.points.len();
    let middle = drawn.exact.iter().map(|p| V::from(p.mm())).sum::<V>() / n as f64;
    let (axis, along) = (way(c, 0), way(c, 10));
    let pose = drawn.ct_from_tracker;
    for (i, point) in drawn.points.iter_mut().enumerate() {
        // What is still to come is missing.
        let share = i as f64 / (n - 1) as f64 - 1.0;
        let turn = (axis * (0.25 * mm * share).to_radians()).into();
        let turn = Rotation::from_vector(RotationVector::new(turn).unwrap());
        let shift = middle - V::from(turn.apply(middle.into())) + along * (mm * share);
        let motion: Rigid<Ct, Ct> = Rigid::from_parts(turn, Vector::new(shift.x, shift.y, shift.z));
        point.place = pose.inverse() * (motion * (pose * point.place));
    }
}

/// Left for right: of the tracker's x.
pub(crate) fn mirrored(mut drawn: Drawn) -> Drawn {
    for point in &mut drawn.points {
        let [x, y, z] = point.place.mm();
        point.place = Point::new(-x, y, z);
        let flip = Matrix3::from_diagonal(&V::new(-1.0, 1.0, 1.0));
        point.covariance_mm2 = flip * point.covariance_mm2 * flip;
        if let Some(beam) = &mut point.beam {
            let [x, y, z] = beam.direction.components();
            beam.direction = checked::direction([-x, y, z]).unwrap();
        }
    }
    drawn
}

/// Half of the points are those of a probe held still at ten places: one point and its error again and again, with the tracker's own
/// noise of 0.05 mm.
pub(crate) fn held(mut drawn: Drawn, seed: u64) -> Drawn {
    let n = drawn.points.len();
    let order: Vec<usize> = (0..n).map(|i| if i < n / 2 { i } else { i % 10 }).collect();
    taken(&mut drawn, &order);
    for (i, point) in drawn.points.iter_mut().enumerate().skip(n / 2) {
        let c = Chance::new(seed, (1 << 43) + i as u64);
        let [x, y, z] = point.place.mm();
        let [a, b, d] = [0, 1, 2].map(|k| 0.05 * c.normal(k));
        point.place = Point::new(x + a, y + b, z + d);
    }
    drawn
}

/// Of a skin: an ellipsoid about the phantom, 15 mm before the crests and some 40 mm before what lies between; the beams stay.
pub(crate) fn skin(mut drawn: Drawn) -> Drawn {
    let (centre, half) = (V::new(172.0, 10.0, 120.0), V::new(210.0, 100.0, 260.0));
    let pose = drawn.ct_from_tracker;
    for (point, exact) in drawn.points.iter_mut().zip(&drawn.exact) {
        let noise = V::from((pose * point.place).mm()) - V::from(exact.mm());
        let u = (V::from(exact.mm()) - centre).component_div(&half);
        let on = V::from(exact.mm());
        // Along y to the ellipsoid.
        let y = centre.y + half.y * (1.0 - u.x * u.x - u.z * u.z).max(0.0).sqrt();
        let p = V::new(on.x, y, on.z) + noise * if noise.norm() < 3.0 { 1.0 } else { 0.0 };
        point.place = pose.inverse() * Point::new(p.x, p.y, p.z);
    }
    drawn
}

/// Of the points those within 3 mm of one line over the left crest.
pub(crate) fn line(mut drawn: Drawn, most: usize) -> Drawn {
    let order: Vec<usize> = (0..drawn.points.len())
        .filter(|i| {
            let [x, y, z] = drawn.exact[*i].mm();
            let first = drawn.exact[0].mm();
            // Across the crest: a stroke of the probe.
            (z - first[2]).abs() < 3.0 && (x - first[0]).abs() < 40.0 && (y - first[1]).abs() < 40.0
        })
        .take(most)
        .collect();
    taken(&mut drawn, &order);
    drawn
}

/// The error of a probe's calibration, drawn: all points move by it, each as its pose of the probe has it. Gives what a user knows of it.
///
/// Deviations: rad about, and mm along, the lateral, elevation and axial axes of the image, whose origin is the transducer.
pub(crate) fn with_calibration_error(drawn: &mut Drawn, sigma: [f64; 6], seed: u64) -> SharedError {
    let c = Chance::new(seed, 1 << 44);
    let mut poses: Vec<Rigid<Tracker, Tracker>> = Vec::new();
    let mut places: Vec<Point<Tracker>> = Vec::new();
    for point in &drawn.points {
        let beam = point.beam.unwrap();
        let axial = V::from(beam.direction.components());
        let lateral = V::from(across(beam.direction).components());
        let elevation = axial.cross(&lateral);
        let rows = [0, 1, 2].map(|k| [lateral[k], elevation[k], axial[k]]);
        let depth = beam.depth_mm.unwrap();
        let origin = V::from(point.place.mm()) - axial * depth;
        let turn = RotationMatrix::new(rows, 1e-9).unwrap().rotation();
        poses.push(Rigid::from_parts(turn, Vector::new(origin.x, origin.y, origin.z)));
        places.push(Point::new(0.0, 0.0, depth));
    }
    let [a, b, d, x, y, z] = [0, 1, 2, 3, 4, 5].map(|k| sigma[k] * c.normal(k as u64));
    let error: Rigid<Tracker, Tracker> =
        Rigid::from_rotation_vector(Vector::new(a, b, d), Vector::new(x, y, z)).unwrap();
    for (point, (pose, place)) in drawn.points.iter_mut().zip(poses.iter().zip(&places)) {
        point.place = *pose * (error * *place);
    }
    SharedError::of_tool(Matrix6::from_diagonal(&sigma.map(|s| s * s).into()), &poses, &places)
}
