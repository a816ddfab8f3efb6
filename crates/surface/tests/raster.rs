//! The z-buffer against rays: a triangle is hit or missed by its barycentric coordinates, in f64, one pixel and one triangle at a time.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use chance::SplitMix64;
use geometry::{Ct, Direction, Point, SlicePlane, Vector};
use surface::{Mesh, ZBuffer};

const SIZE: [u32; 2] = [90, 70];

struct Random(SplitMix64);

impl Random {
    /// In -1..1.
    fn number(&mut self) -> f64 {
        self.0.around(0.0, 1.0)
    }

    fn vector(&mut self) -> Vector<Ct> {
        Vector::new(self.number(), self.number(), self.number())
    }

    fn camera(&mut self) -> SlicePlane {
        loop {
            let (Some(right), other) = (self.vector().direction(), self.vector()) else {
                continue;
            };
            let Some(into) = right.vector().cross(other).direction() else {
                continue;
            };
            let down = into.cross(right).direction().unwrap();
            if let Ok(camera) = SlicePlane::centred(Point::new(30.0, -20.0, 150.0), [right, down], 0.8, SIZE) {
                return camera;
            }
        }
    }

    fn scene(&mut self, camera: &SlicePlane) -> Mesh {
        let mut mesh = Mesh::default();
        let middle = camera.point(f64::from(SIZE[0]) / 2.0, f64::from(SIZE[1]) / 2.0);
        for i in 0..8 {
            let at = middle + self.vector() * 25.0;
            let radius = self.0.around(6.0, 4.0);
            match i % 2 {
                0 => mesh.ball(at, radius, (i % 7) as u8),
                _ => mesh.tube([at, at + self.vector() * 40.0], radius / 2.0, (i % 7) as u8),
            }
        }
        mesh
    }
}

/// A triangle on the screen: its corners, pixels, and their depths.
type Seen = [[f64; 3]; 3];

fn seen(mesh: &Mesh, camera: &SlicePlane) -> Vec<(Seen, u8)> {
    let corner = |i: u32| {
        let [x, y, z] = mesh.points()[i as usize].map(f64::from);
        let p = camera.project(Point::new(x, y, z));
        [p.x, p.y, p.depth_mm]
    };
    let triangles = mesh.triangles().iter().zip(mesh.paints());
    triangles
        .map(|(triangle, paint)| (triangle.map(corner), *paint))
        .collect()
}

/// The depth of a triangle along the ray of a pixel, where it looks at the viewer and is hit with `margin` pixels to spare (negative: or
/// missed by less than that).
fn hit(triangle: &Seen, [x, y]: [f64; 2], margin: f64) -> Option<f64> {
    let cross = |a: [f64; 3], b: [f64; 3]| (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    let [a, b, c] = *triangle;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    // Anticlockwise to the viewer; rows go down.
    if area >= 0.0 {
        return None;
    }
    let sides = [(b, c), (c, a), (a, b)];
    let far = sides.map(|(p, q)| -cross(p, q) / (q[0] - p[0]).hypot(q[1] - p[1]).max(1e-12));
    far.iter().all(|d| *d >= margin).then(|| {
        let weights = sides.map(|(p, q)| cross(p, q) / area);
        (0..3).map(|i| weights[i] * triangle[i][2]).sum()
    })
}

/// **The bound.** Corners are put to 1/256 of a pixel, so a side is off by at most 1/256 * sqrt(1/2) of one, 0.003 with the rounding of
/// f32; what a ray hits by more than that is drawn, and what it misses by more is not. Depth is off by what the triangle's slope makes of
/// as much: within the range of depths that it has in 0.006 of a pixel about the ray, and 1e-4 mm for f32.
#[test]
fn each_pixel_has_the_nearest_triangle_that_its_ray_hits() {
    let mut random = Random(SplitMix64::new(7));
    let near = 0.003;
    let paints: Vec<[u8; 3]> = (0..7).map(|i| [40 * i + 10, 0, 0]).collect();
    for _ in 0..8 {
        let camera = random.camera();
        let mesh = random.scene(&camera);
        let mut buffer = ZBuffer::new(SIZE);
        buffer.draw(&mesh, &camera, &paints);
        let triangles = seen(&mesh, &camera);
        let mut covered = 0;
        for (i, depth) in buffer.depths().iter().enumerate() {
            let ray = [(i % SIZE[0] as usize) as f64, (i / SIZE[0] as usize) as f64];
            let depth = f64::from(*depth);
            let hits = triangles
                .iter()
                .filter_map(|(t, _)| Some(hit(t, ray, near)? + slope(t, ray)));
            let surely = hits.fold(f64::INFINITY, f64::min);
            assert!(depth <= surely, "{ray:?}: {depth} behind {surely}");
            if depth.is_infinite() {
                continue;
            }
            covered += 1;
            let mut maybe = triangles.iter().filter(|(t, _)| hit(t, ray, -near).is_some());
            let is_of =
                |(t, _): &(Seen, u8)| (depth - plane_depth(t, ray)).abs() <= slope(t, ray) || is_edge_on(t, depth);
            assert!(maybe.any(is_of), "{ray:?}: {depth}");
        }
        assert!(covered > 400, "{covered}");
    }
}

/// What the depth of a triangle changes in 0.006 of a pixel about a ray, mm, and the rounding of f32.
fn slope(t: &Seen, [x, y]: [f64; 2]) -> f64 {
    let [across, down] = [[x + 0.006, y], [x, y + 0.006]].map(|at| plane_depth(t, at) - plane_depth(t, [x, y]));
    across.abs() + down.abs() + 1e-4
}

/// A triangle as thin as the parts of a pixel has no plane to speak of: its depth is within its corners'.
fn is_edge_on(t: &Seen, depth: f64) -> bool {
    let [a, b, c] = *t;
    let area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
    let longest = [(a, b), (b, c), (c, a)].map(|(p, q)| (q[0] - p[0]).hypot(q[1] - p[1]));
    let thin = area / longest.into_iter().fold(0.0, f64::max) < 0.05;
    let depths = || t.iter().map(|corner| corner[2]);
    let range = depths().fold(f64::MAX, f64::min) - 1e-4..=depths().fold(f64::MIN, f64::max) + 1e-4;
    thin && range.contains(&depth)
}

/// The depth of the plane of a triangle at a pixel.
fn plane_depth([a, b, c]: &Seen, [x, y]: [f64; 2]) -> f64 {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let s = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
    let t = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
    a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
}

/// Every pixel of a square of two triangles, once and once only, wherever their common side runs.
#[test]
fn neighbours_leave_no_crack() {
    let camera = SlicePlane::centred(Point::new(0.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [64, 64]).unwrap();
    let mut random = Random(SplitMix64::new(3));
    for _ in 0..200 {
        // A ball has no cracks: each pixel whose ray passes well within is covered.
        let centre = Point::new(3.0 * random.number(), 3.0 * random.number(), 50.0);
        let mut mesh = Mesh::default();
        mesh.ball(centre, 20.0, 0);
        let mut buffer = ZBuffer::new([64, 64]);
        buffer.draw(&mesh, &camera, &[[255; 3]]);
        for (i, depth) in buffer.depths().iter().enumerate() {
            let at = camera.point((i % 64) as f64, (i / 64) as f64).mm();
            let off = (at[0] - centre.mm()[0]).hypot(at[1] - centre.mm()[1]);
            if off < 18.5 {
                // Within 4 % of the true ball: a polygon of 12 bands.
                let truth = 50.0 - (400.0 - off * off).sqrt();
                assert!((f64::from(*depth) - truth).abs() < 1.8, "{i}: {depth} {truth}");
            } else if off > 20.01 {
                assert!(depth.is_infinite());
            }
        }
    }
}

/// Of two balls the nearer one is seen, in its paint, whichever is drawn first.
#[test]
fn the_nearer_one_is_seen() {
    let camera = SlicePlane::centred(Point::new(0.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [64, 64]).unwrap();
    let balls = [(Point::new(0.0, 0.0, 40.0), 0), (Point::new(6.0, 0.0, -40.0), 1)];
    for order in [[0, 1], [1, 0]] {
        let mut mesh = Mesh::default();
        for i in order {
            let (centre, paint): (Point<Ct>, u8) = balls[i];
            mesh.ball(centre, 8.0, paint);
        }
        let mut buffer = ZBuffer::new([64, 64]);
        buffer.draw(&mesh, &camera, &[[200, 0, 0], [0, 200, 0]]);
        let at = |x: usize| buffer.colours()[32 * 64 + x];
        // Alone the one, both with the second one before the first, alone the second.
        assert!(at(25)[0] > 40 && at(25)[1] == 0 && at(34)[0] == 0 && at(34)[1] > 40 && at(44)[1] > 40);
        buffer.line(
            &camera,
            [Point::new(-20.0, 0.5, 0.0), Point::new(20.0, 0.5, 0.0)],
            2.0,
            0.0,
            [9, 9, 9],
        );
        assert_eq!(
            [25, 34, 44].map(|x| buffer.colours()[32 * 64 + x] == [9; 3]),
            [true, false, false]
        );
    }
}

/// However steeply it goes into the image, and however wide its rim is.
#[test]
fn a_line_lies_before_its_rim_over_its_whole_length() {
    let camera = SlicePlane::centred(Point::new(0.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [64, 64]).unwrap();
    for into in [0.0, 5.0, 80.0, -80.0, 400.0] {
        let ends = [Point::new(-20.0, 0.5, 0.0), Point::new(20.0, 0.5, into)];
        let mut buffer = ZBuffer::new([64, 64]);
        buffer.line(&camera, ends, 6.0, 0.0, [1; 3]);
        buffer.line(&camera, ends, 2.0, 0.5, [9; 3]);
        assert!((13..51).all(|x| buffer.colours()[32 * 64 + x] == [9; 3]), "{into}");
        assert!((13..51).all(|x| buffer.colours()[34 * 64 + x] == [1; 3]), "{into}");
    }
    let mut buffer = ZBuffer::new([64, 64]);
    buffer.line(
        &camera,
        [Point::new(0.5, 0.5, 9.0), Point::new(0.5, 0.5, -9.0)],
        4.0,
        0.0,
        [9; 3],
    );
    let dot: Vec<f32> = buffer
        .depths()
        .iter()
        .copied()
        .filter(|depth| depth.is_finite())
        .collect();
    assert!(
        dot.len() == 16 && dot.iter().all(|depth| (depth + 9.0).abs() < 1e-4),
        "{dot:?}"
    );
}

#[test]
fn what_is_far_or_no_number_is_left_out() {
    let camera = SlicePlane::centred(Point::new(0.0, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [64, 64]).unwrap();
    let mut buffer = ZBuffer::new([64, 64]);
    for far in [1e7, 1e30, f64::MAX, f64::NAN, f64::INFINITY] {
        let mut mesh = Mesh::default();
        mesh.ball(Point::new(far, 0.0, 0.0), 5.0, 0);
        mesh.ball(Point::new(0.0, 0.0, 0.0), far, 0);
        mesh.tube([Point::new(0.0, far, 0.0), Point::new(0.0, 0.0, far)], 3.0, 0);
        buffer.draw(&mesh, &camera, &[[255; 3]]);
        buffer.line(
            &camera,
            [Point::new(far, far, far), Point::new(1.0, 1.0, far)],
            2.0,
            0.0,
            [255; 3],
        );
    }
    // Neither is a paint that there is not.
    let mut mesh = Mesh::default();
    mesh.ball(Point::new(0.0, 0.0, 0.0), 5.0, 9);
    mesh.tube([Point::new(1.0, 1.0, 1.0); 2], 3.0, 0);
    buffer.draw(&mesh, &camera, &[[255; 3]]);
    assert!(buffer.depths().iter().all(|depth| !depth.is_nan()));
}

#[test]
fn the_same_is_drawn_to_the_same_bytes() {
    let draw = || {
        let mut random = Random(SplitMix64::new(11));
        let camera = random.camera();
        let mesh = random.scene(&camera);
        let mut buffer = ZBuffer::new(SIZE);
        buffer.draw(&mesh, &camera, &[[200, 100, 50]; 7]);
        buffer.line(
            &camera,
            [camera.point(3.0, 3.0), camera.point(60.3, 41.7)],
            2.5,
            0.1,
            [1, 2, 3],
        );
        let bits: Vec<u32> = buffer.depths().iter().map(|depth| depth.to_bits()).collect();
        (bits, buffer.colours().to_vec())
    };
    assert!(draw() == draw());
}
