//! A camera, a grid, and where it sees the discs, by formulas of its own.

use geometry::{Point, Rigid, Vector};
use nalgebra::{Matrix2, Vector2, Vector6};
use optics::camera::{Camera, CameraFrame, GridFrame, ImageSize, Sighting, View};

use crate::common::{Random, turn};

/// The images' size.
pub(crate) const SIZE: ImageSize = ImageSize {
    width: 1280,
    height: 720,
};
/// Covariances that discs take turns in, pixels squared.
pub(crate) const COVARIANCES: [Matrix2<f64>; 3] = [
    Matrix2::new(0.0004, 0.0, 0.0, 0.0009),
    Matrix2::new(0.0025, 0.001, 0.001, 0.0016),
    Matrix2::new(0.0009, -0.0004, -0.0004, 0.0004),
];
const COLS: i32 = 9;
const ROWS: i32 = 7;

/// A camera and poses of a grid of 9 x 7 discs.
pub(crate) struct Rig {
    pub(crate) camera: Camera,
    pub(crate) poses: Vec<Rigid<CameraFrame, GridFrame>>,
    pub(crate) pitch_mm: f64,
}

impl Rig {
    /// Views in which the grid fills half of the image's height, tilted by `tilt` radians in directions all round, turned
    /// and shifted.
    pub(crate) fn around(camera: Camera, views: u32, tilt: f64) -> Self {
        let pitch_mm = 10.0;
        let distance = camera.focal.x * f64::from(ROWS) * pitch_mm / (0.5 * SIZE.height as f64);
        let pose = |i: u32| {
            let direction = f64::from(i) * 2.4;
            let (s, c) = direction.sin_cos();
            let share = 0.6 + 0.4 * f64::from(i % 3) / 2.0;
            let tilted: Rigid<CameraFrame, CameraFrame> = Rigid::from_rotation_vector(
                Vector::new(c * tilt * share, s * tilt * share, 0.15 * f64::from(i % 4) - 0.2),
                Vector::new(0.0, 0.0, 0.0),
            )
            .unwrap();
            let wide = distance * SIZE.width as f64 / camera.focal.x;
            let at = Vector::new(
                0.22 * wide * (direction * 1.7).cos(),
                0.1 * wide * (direction * 1.3).sin(),
                distance,
            );
            let middle = Vector::new(
                -0.5 * f64::from(COLS - 1) * pitch_mm,
                -0.5 * f64::from(ROWS - 1) * pitch_mm,
                0.0,
            );
            let shifted = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), middle).unwrap();
            let placed = Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), at).unwrap();
            let from_grid: Rigid<CameraFrame, GridFrame> = shifted;
            placed * (tilted * from_grid)
        };
        Self {
            camera,
            poses: (0..views).map(pose).collect(),
            pitch_mm,
        }
    }

    /// The discs of every view, exactly where the camera sees their centres; with a radius, the centres of their images.
    pub(crate) fn views(&self, radius_mm: Option<f64>) -> Vec<View> {
        let view = |pose: &Rigid<CameraFrame, GridFrame>| {
            let disc = |i: i32| {
                let at = Vector2::new(f64::from(i % COLS), f64::from(i / COLS)) * self.pitch_mm;
                let see = |p: Vector2<f64>| pixel(&self.camera, (*pose * Point::new(p.x, p.y, 0.0)).mm());
                Sighting {
                    at_mm: at,
                    pixel: radius_mm.map_or_else(|| see(at), |r| centroid(at, r, see)),
                    covariance: COVARIANCES[(i % 3) as usize],
                    radius_mm,
                }
            };
            View {
                sightings: (0..COLS * ROWS).map(disc).collect(),
            }
        };
        self.poses.iter().map(view).collect()
    }
}

/// Brown's formula, term by term.
fn pixel(camera: &Camera, [x, y, z]: [f64; 3]) -> Vector2<f64> {
    let (x, y, l) = (x / z, y / z, camera.lens);
    let r2 = x * x + y * y;
    let radial = 1.0 + l.k1 * r2 + l.k2 * r2.powi(2) + l.k3 * r2.powi(3);
    let a = x * radial + 2.0 * l.p1 * x * y + l.p2 * (r2 + 2.0 * x * x);
    let b = y * radial + l.p1 * (r2 + 2.0 * y * y) + 2.0 * l.p2 * x * y;
    let [s1, s2, s3, s4] = l.s;
    let (a, b) = (a + s1 * r2 + s2 * r2 * r2, b + s3 * r2 + s4 * r2 * r2);
    Vector2::new(
        camera.focal.x * a + camera.skew * b + camera.centre.x,
        camera.focal.y * b + camera.centre.y,
    )
}

/// The centre of the area of a polygon of 720 points on the rim's image.
fn centroid(at: Vector2<f64>, radius: f64, see: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Vector2<f64> {
    let middle = see(at);
    let rim = |k: i32| {
        let (s, c) = (f64::from(k) * std::f64::consts::TAU / 720.0).sin_cos();
        see(at + Vector2::new(c, s) * radius) - middle
    };
    let (mut sum, mut area) = (Vector2::zeros(), 0.0);
    for k in 0..720 {
        let (a, b) = (rim(k), rim(k + 1));
        let cross = a.x * b.y - a.y * b.x;
        area += cross / 2.0;
        sum += (a + b) * (cross / 6.0);
    }
    middle + sum / area
}

/// The views with noise of `times` their deviations.
pub(crate) fn noisy(views: &[View], random: &mut Random, times: f64) -> Vec<View> {
    let mut views = views.to_vec();
    for s in views.iter_mut().flat_map(|v| &mut v.sightings) {
        let l = s.covariance.cholesky().unwrap().l();
        s.pixel += l * Vector2::new(random.normal(), random.normal()) * times;
    }
    views
}

/// `(w, v)` with `p -> exp(w) (R p + t) + v` the first pose and `p -> R p + t` the second, to first order in `w`.
pub(crate) fn pose_off(a: &Rigid<CameraFrame, GridFrame>, b: &Rigid<CameraFrame, GridFrame>) -> Vector6<f64> {
    let w = nalgebra::Vector3::from(turn(a.quaternion(), b.quaternion()));
    let [ta, tb] = [a, b].map(|p| nalgebra::Vector3::from(p.translation_mm()));
    let v = ta - tb - w.cross(&tb);
    Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)
}
