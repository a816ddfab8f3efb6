//! Where the adjustment begins: the camera from the homographies of the views (Zhang 2000), in closed form.
//!
//! With `H = [h1 h2 h3]` from the grid to pixels about the image's middle, in units of its longer side, and
//! `w = K^-T K^-1`, every view gives `h1^T w h2 = 0` and `h1^T w h1 = h2^T w h2`. With the principal point in the middle
//! and no skew `w` is `diag(1 / fx^2, 1 / fy^2, 1)`, two unknowns that two tilted views hold; the general form with five
//! is not needed for a start, and fails sooner where the lens bends the grid.
//!
//! The vanishing line of a view is `H^-T (0, 0, 1)`, and `K^T` times that is the normal of the grid's plane.

use geometry::motion::Pose;
use geometry::rotation::{Rotation, RotationMatrix};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::error::CameraRefused;
use super::model::Camera;
use super::paraboloid::Bend;
use super::state::State;
use super::view::{ImageSize, Station};
use crate::grid::homography;

/// The least angle between two of the planes, degrees: below it the focal length is not held.
pub const LEAST_SPREAD_DEG: f64 = 3.0;
/// Focal lengths that are tried where the closed form has none, in units of the image's longer side.
const FOCAL_GUESSES_SIDES: [f64; 4] = [0.6, 1.0, 1.7, 3.0];

/// The homographies of all views in units of the image's longer side about its middle.
fn homographies(stations: &[Station], size: ImageSize) -> Result<Vec<Matrix3<f64>>, CameraRefused> {
    let one = |(view, station): (usize, &Station)| {
        let on_image = |pixel: Vector2<f64>| (pixel - size.middle()) / size.side();
        let pairs: Vec<_> = station
            .sightings
            .iter()
            .map(|s| (s.place.xy(), on_image(s.pixel)))
            .collect();
        let found = homography(&pairs).filter(|h| {
            let values = h.singular_values();
            h.try_inverse().is_some() && values.min() > 1e-12 * values.max()
        });
        found.ok_or(CameraRefused::Singular {
            view,
            discs: station.sightings.len(),
        })
    };
    stations.iter().enumerate().map(one).collect()
}

/// `1 / fx^2` and `1 / fy^2` by least squares over all views; the same for both where `square`.
fn closed_form(homographies: &[Matrix3<f64>], square: bool) -> Option<Vector2<f64>> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for h in homographies {
        // Zhang's (2000) constraints h1^T w h2 = 0 and h1^T w h1 = h2^T w h2 with w = diag(1 / fx^2, 1 / fy^2, 1). They
        // scale with the square of the homography, whose size is free: all views are given the same.
        let h = h / (h.column(0).norm() * h.column(1).norm()).sqrt();
        let (a, b) = (h.column(0), h.column(1));
        let rows = [
            ([a.x * b.x, a.y * b.y], -a.z * b.z),
            ([a.x * a.x - b.x * b.x, a.y * a.y - b.y * b.y], b.z * b.z - a.z * a.z),
        ];
        for ([p, q], value) in rows {
            let row = if square {
                Vector2::new(p + q, 0.0)
            } else {
                Vector2::new(p, q)
            };
            normal += row * row.transpose();
            right += row * value;
        }
    }
    if square {
        let value = right.x / normal[(0, 0)];
        return Some(Vector2::new(value, value));
    }
    normal.try_inverse().map(|inverse| inverse * right)
}

/// Cameras worth trying.
fn candidates(homographies: &[Matrix3<f64>], size: ImageSize) -> Vec<Camera> {
    let side = size.side();
    let mut cameras: Vec<Camera> = Vec::new();
    for square in [false, true] {
        let focal = closed_form(homographies, square).map(|w| w.map(|x| x.powf(-0.5)));
        // Beyond these no start is better than a guess; a NaN is not within.
        let found = focal.filter(|f| f.iter().all(|x| (0.1..=50.0).contains(x)) && f.max() < 3.0 * f.min());
        cameras.extend(found.map(|f| Camera {
            focal: f * side,
            ..Camera::pinhole(1.0, size.middle())
        }));
    }
    cameras.extend(FOCAL_GUESSES_SIDES.map(|f| Camera::pinhole(f * side, size.middle())));
    cameras
}

/// The pose of a grid under a camera: `K^-1 H` up to scale is `[r1 r2 t]`.
fn pose(h: &Matrix3<f64>, focal: Vector2<f64>) -> Option<Pose> {
    let seen = Matrix3::from_diagonal(&Vector3::new(1.0 / focal.x, 1.0 / focal.y, 1.0)) * h;
    // Columns of a rotation have length 1, the mean of both here, as neither is without error.
    let scale = 2.0 / (seen.column(0).norm() + seen.column(1).norm());
    // The grid's middle lies in front of the camera.
    let m = seen * (scale * seen[(2, 2)].signum());
    let third = m.column(0).cross(&m.column(1));
    let rows = [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], third[i]]);
    let turn: Rotation = RotationMatrix::nearest(rows).ok()?.matrix.rotation();
    Some(Pose {
        turn,
        shift: m.column(2).into_owned(),
    })
}

/// The largest angle between two of the planes, degrees.
fn spread_deg(homographies: &[Matrix3<f64>], focal: Vector2<f64>) -> f64 {
    let normal = |h: &Matrix3<f64>| {
        // The plane's horizon is seen at the line H^-T e3, and K^T times that is the plane's normal.
        let line = h.try_inverse().unwrap_or_default().transpose() * Vector3::z();
        Vector3::new(line.x * focal.x, line.y * focal.y, line.z)
    };
    let normals: Vec<Vector3<f64>> = homographies.iter().map(normal).collect();
    // Normals have no sense here. By the tangent, as a cosine tells small angles to half of the digits.
    let angle = |a: &Vector3<f64>, b: &Vector3<f64>| a.cross(b).norm().atan2(a.dot(b).abs()).to_degrees();
    let pairs = normals.iter().enumerate();
    pairs.fold(0.0, |most, (i, a)| {
        normals[..i].iter().fold(most, |m: f64, b| m.max(angle(a, b)))
    })
}

/// A start for every camera worth trying, the nearest to what was seen first.
pub(super) fn starts(
    stations: &[Station],
    size: ImageSize,
    cost: impl Fn(&State) -> f64,
) -> Result<Vec<State>, CameraRefused> {
    let all = homographies(stations, size)?;
    let mut starts: Vec<(f64, State)> = Vec::new();
    for camera in candidates(&all, size) {
        let focal = camera.focal / size.side();
        let poses: Option<Vec<Pose>> = all.iter().map(|h| pose(h, focal)).collect();
        if let Some(poses) = poses {
            let bend = Bend::default();
            let state = State { camera, bend, poses };
            starts.push((cost(&state), state));
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let focal = starts.first().map_or(size.side(), |(_, s)| s.camera.focal.x) / size.side();
    let spread_deg = spread_deg(&all, Vector2::new(focal, focal));
    // A NaN is not spread enough.
    let spread = spread_deg >= LEAST_SPREAD_DEG;
    if !spread {
        return Err(CameraRefused::Parallel {
            views: stations.len(),
            spread_deg,
            needed_deg: LEAST_SPREAD_DEG,
        });
    }
    Ok(starts.into_iter().map(|(_, state)| state).collect())
}
