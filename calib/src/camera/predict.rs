//! Where a camera sees a disc: the image of its centre, or the centre of its image.
//!
//! The centre of a disc's image is that of its area. Under a pinhole the image is an ellipse and this is its centre; under
//! a lens it is what a fit of an ellipse finds, to the third order of the disc's size. With `(u, v)` the images of the rim
//! and a dash for the derivative along it
//!
//! ```text
//! A = 1/2 int (u v' - v u'),     c = (int u^2 v', -int v^2 u') / 2 A                                            (6)
//! ```
//!
//! Rims are twelve points; the dash is that of the trigonometric polynomial through them, `D_jk = (-1)^(j-k) / 2
//! cot((j - k) pi / 12)`. Harmonics of the rim's image fall as powers of radius over distance, and the sums are exact up to
//! the ninth. As (6) is a function of the points alone, so are its derivatives:
//!
//! ```text
//! dA/du = v',  dA/dv = -u',  dMx/du = u v',  dMx/dv = -D u^2 / 2,  dMy/du = D v^2 / 2,  dMy/dv = -v u',  c = M / A    (7)
//! ```

use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

use super::adjust::Pose;
use super::model::{Camera, PARAMETERS};
use super::view::Ready;

/// Points on a rim.
const RIM: usize = 12;
type Rim = [f64; RIM];

/// The derivatives of a prediction by the camera's numbers and by the pose.
pub(super) type Slopes = (SMatrix<f64, 2, PARAMETERS>, SMatrix<f64, 2, 6>);

/// Where the sighting should be under this camera and pose; NaN where part of it is not in front of the camera.
pub(super) fn predicted(s: &Ready, camera: &Camera, turn: &Matrix3<f64>, pose: &Pose) -> Vector2<f64> {
    let see = |place: Vector3<f64>| {
        let at = turn * place + pose.shift;
        if at.z > 0.0 {
            camera.image(&at)
        } else {
            Vector2::repeat(f64::NAN)
        }
    };
    let middle = see(s.place);
    match s.radius_mm {
        None => middle,
        // Differences from the middle, so that no digit of the shift is lost.
        Some(radius) => middle + Centre::of(&rim(s.place, radius).map(|p| see(p) - middle)).at,
    }
}

/// The derivatives of [`predicted`].
pub(super) fn slopes(s: &Ready, camera: &Camera, turn: &Matrix3<f64>, pose: &Pose) -> Slopes {
    let Some(radius) = s.radius_mm else {
        return point_slopes(&s.place, camera, turn, pose);
    };
    let places = rim(s.place, radius);
    let middle = camera.image(&(turn * s.place + pose.shift));
    let centre = Centre::of(&places.map(|p| camera.image(&(turn * p + pose.shift)) - middle));
    let mut sum = (SMatrix::zeros(), SMatrix::zeros());
    for (place, by) in places.iter().zip(&centre.by) {
        let (numbers, motion) = point_slopes(place, camera, turn, pose);
        sum.0 += by * numbers;
        sum.1 += by * motion;
    }
    sum
}

/// The derivatives of the image of one point of the grid.
fn point_slopes(place: &Vector3<f64>, camera: &Camera, turn: &Matrix3<f64>, pose: &Pose) -> Slopes {
    let turned = turn * place;
    let at = turned + pose.shift;
    let by_point = camera.by_point(&at);
    let mut by_pose = SMatrix::<f64, 2, 6>::zeros();
    let turning = by_point * -turned.cross_matrix();
    by_pose.fixed_view_mut::<2, 3>(0, 0).copy_from(&turning);
    by_pose.fixed_view_mut::<2, 3>(0, 3).copy_from(&by_point);
    (camera.by_numbers(&at), by_pose)
}

/// Points of the rim about a place of the grid.
fn rim(place: Vector3<f64>, radius: f64) -> [Vector3<f64>; RIM] {
    std::array::from_fn(|k| {
        let (s, c) = (k as f64 * (std::f64::consts::TAU / RIM as f64)).sin_cos();
        place + Vector3::new(c, s, 0.0) * radius
    })
}

/// The centre (6) of what a rim encloses, and its derivatives (7) by each point.
struct Centre {
    at: Vector2<f64>,
    by: [Matrix2<f64>; RIM],
}

impl Centre {
    fn of(points: &[Vector2<f64>; RIM]) -> Self {
        let (u, v) = (points.map(|p| p.x), points.map(|p| p.y));
        let [du, dv, du2, dv2] = [u, v, u.map(|x| x * x), v.map(|x| x * x)].map(|values| along(&values));
        let sum = |value: &dyn Fn(usize) -> f64| (0..RIM).map(value).sum::<f64>() / 2.0;
        let area = sum(&|k| u[k] * dv[k] - v[k] * du[k]);
        let at = Vector2::new(sum(&|k| u[k] * u[k] * dv[k]), -sum(&|k| v[k] * v[k] * du[k])) / area;
        let by = std::array::from_fn(|k| {
            let moment = Matrix2::new(u[k] * dv[k], -0.5 * du2[k], 0.5 * dv2[k], -v[k] * du[k]);
            let grown = Vector2::new(dv[k], -du[k]);
            (moment - at * grown.transpose()) / area
        });
        Self { at, by }
    }
}

/// The derivative along the rim of values on it.
fn along(values: &Rim) -> Rim {
    std::array::from_fn(|j| {
        let others = (0..RIM).filter(|k| *k != j);
        let part = |k: usize| {
            let apart = j as f64 - k as f64;
            let sign = if (j + k).is_multiple_of(2) { 0.5 } else { -0.5 };
            sign / (apart * std::f64::consts::PI / RIM as f64).tan() * values[k]
        };
        others.map(part).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Lens;
    use crate::disc::Ellipse;
    use geometry::rotation::{Rotation, RotationVector};

    fn pose() -> Pose {
        Pose {
            turn: Rotation::from_vector(RotationVector::new([0.9, -0.4, 0.3]).unwrap()),
            shift: Vector3::new(4.0, -7.0, 120.0),
        }
    }

    fn ready(radius_mm: Option<f64>) -> Ready {
        Ready {
            disc: 0,
            place: Vector3::new(21.0, -12.0, 0.0),
            pixel: Vector2::zeros(),
            information: nalgebra::Matrix2::identity(),
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
        let turn = pose.matrix();
        let k = Matrix3::new(1500.0, 1.5, 640.0, 0.0, 1500.0, 360.0, 0.0, 0.0, 1.0);
        let plane = Matrix3::from_columns(&[turn.column(0).into(), turn.column(1).into(), pose.shift]);
        let ellipse = Ellipse::of_circle(&(k * plane), seen.place.xy(), 1.4).unwrap();
        let found = predicted(&seen, &camera, &turn, &pose);
        let centre = predicted(&ready(None), &camera, &turn, &pose);
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
        let turn = pose.matrix();
        let (mut sum, mut area) = (Vector2::zeros(), 0.0);
        let n = 560;
        for i in -n..n {
            for j in -n..n {
                let at = Vector2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(n);
                if at.norm_squared() > 1.0 {
                    continue;
                }
                let point = turn * (seen.place + Vector3::new(at.x, at.y, 0.0) * 1.4) + pose.shift;
                let slope = camera.by_point(&point);
                let (a, b) = (slope * turn.column(0), slope * turn.column(1));
                let weight = a.x * b.y - a.y * b.x;
                sum += camera.image(&point) * weight;
                area += weight;
            }
        }
        let found = predicted(&seen, &camera, &turn, &pose);
        assert!((found - sum / area).norm() < 1e-5, "{found} {}", sum / area);
    }

    #[test]
    fn a_disc_behind_the_camera_is_seen_nowhere() {
        let camera = Camera::pinhole(1500.0, Vector2::zeros());
        let behind = Pose {
            shift: Vector3::new(0.0, 0.0, -50.0),
            ..pose()
        };
        assert!(predicted(&ready(None), &camera, &behind.matrix(), &behind).x.is_nan());
    }
}
