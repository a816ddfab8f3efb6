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
//! Rims are eight points; the dash is that of the trigonometric polynomial through them, `D_jk = (-1)^(j-k) / 2
//! cot((j - k) pi / 8)`. Harmonics of the rim's image fall as powers of radius over distance, and the first three that
//! add up to eight, 3 + 3 + 2, are of its fifth. As (6) is a function of the points alone, so are its derivatives:
//!
//! ```text
//! dA/du = v',  dA/dv = -u',  dMx/du = u v',  dMx/dv = -D u^2 / 2,  dMy/du = D v^2 / 2,  dMy/dv = -v u',  c = M / A    (7)
//! ```
//!
//! A centre of area goes with every affine map. So (6) is taken on the distorted plane, in front of the focal lengths, and
//! only the lens and the pose are summed over the rim.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, SMatrix, Vector2, Vector3};

use super::lens::{COEFFICIENTS, Lens};
use super::model::{Camera, PARAMETERS};
use super::paraboloid::Bend;
use super::paraboloid::SHARED;
use super::view::Ready;

/// Points on a rim.
const RIM_POINTS: usize = 8;
type Rim = [f64; RIM_POINTS];
/// One over the root of 2.
const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// The rim's points on the unit circle, every 45 degrees.
const CIRCLE: [[f64; 2]; RIM_POINTS] = [
    [1.0, 0.0],
    [DIAGONAL, DIAGONAL],
    [0.0, 1.0],
    [-DIAGONAL, DIAGONAL],
    [-1.0, 0.0],
    [-DIAGONAL, -DIAGONAL],
    [0.0, -1.0],
    [DIAGONAL, -DIAGONAL],
];
/// `D_jk` for `j - k` from 1 to 3, whose negatives are those for -1 to -3; that for 4 is 0.
const ALONG: [f64; 3] = [-(DIAGONAL + 0.5), 0.5, -(DIAGONAL - 0.5)];

/// The derivatives of a prediction by what all views share and by the pose.
pub(super) type Slopes = (SMatrix<f64, 2, SHARED>, SMatrix<f64, 2, 6>);

/// What looks at a view: the camera, the plate, and where the plate is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye {
    pub(super) camera: Camera,
    pub(super) bend: Bend,
    pub(super) turn: Matrix3<f64>,
    pub(super) shift: Vector3<f64>,
}

impl Eye {
    /// A place of the grid, lifted by the plate's bend, from the view's middle in the camera's axes.
    fn turned(&self, s: &Ready) -> Vector3<f64> {
        self.turn * s.place + self.turn.column(2) * self.bend.height(&s.bow)
    }

    /// A sighting's middle in the camera's frame.
    pub(super) fn at(&self, s: &Ready) -> Vector3<f64> {
        self.turned(s) + self.shift
    }
}

/// A point of the grid in the camera's frame.
#[derive(Clone, Copy)]
struct CameraPoint {
    /// From the view's middle.
    turned: Vector3<f64>,
    /// On the plane at distance 1; NaN where it is not in front of the camera.
    flat: Vector2<f64>,
    depth: f64,
}

/// A sighting's middle and, where it has a radius, its rim.
struct Outline {
    middle: CameraPoint,
    rim: Option<[CameraPoint; RIM_POINTS]>,
}

impl CameraPoint {
    fn of(turned: Vector3<f64>, shift: &Vector3<f64>) -> Self {
        let at = turned + shift;
        let flat = if at.z > 0.0 {
            at.xy() / at.z
        } else {
            Vector2::repeat(f64::NAN)
        };
        Self {
            turned,
            flat,
            depth: at.z,
        }
    }

    /// The derivative of `flat` by the point.
    fn by_point(&self) -> Matrix2x3<f64> {
        let d = self.depth.recip();
        Matrix2x3::new(d, 0.0, -self.flat.x * d, 0.0, d, -self.flat.y * d)
    }
}

impl Outline {
    fn of(s: &Ready, eye: &Eye) -> Self {
        let middle = eye.turned(s);
        let rim = s.radius_mm.map(|radius| {
            // On a bent plate, too, the disc has the tilt of the whole plane: only its height follows the bend.
            let (a, b) = (eye.turn.column(0) * radius, eye.turn.column(1) * radius);
            CIRCLE.map(|[c, s]| CameraPoint::of(middle + a * c + b * s, &eye.shift))
        });
        Self {
            middle: CameraPoint::of(middle, &eye.shift),
            rim,
        }
    }

    /// The rim's image on the distorted plane from the middle's: differences, so that no digit of the shift is lost.
    fn distorted(rim: &[CameraPoint; RIM_POINTS], lens: &Lens, middle: Vector2<f64>) -> [Vector2<f64>; RIM_POINTS] {
        rim.each_ref().map(|p| lens.distort(p.flat) - middle)
    }
}

/// Where the sighting should be; NaN where part of it is not in front of the camera.
pub(super) fn predicted(s: &Ready, eye: &Eye) -> Vector2<f64> {
    let (camera, outline) = (&eye.camera, Outline::of(s, eye));
    let middle = camera.lens.distort(outline.middle.flat);
    let off = |rim: &[CameraPoint; RIM_POINTS]| Area::of(&Outline::distorted(rim, &camera.lens, middle)).centre;
    camera.pixel(middle + outline.rim.as_ref().map_or(Vector2::zeros(), off))
}

/// [`predicted`], and its derivatives.
pub(super) fn slopes(s: &Ready, eye: &Eye) -> (Vector2<f64>, Slopes) {
    let (camera, outline) = (&eye.camera, Outline::of(s, eye));
    let middle = camera.lens.distort(outline.middle.flat);
    let mut sums = Sums::default();
    let at = match &outline.rim {
        None => {
            sums.add(&outline.middle, &camera.lens, &Matrix2::identity());
            middle
        }
        Some(rim) => {
            let area = Area::of(&Outline::distorted(rim, &camera.lens, middle));
            for (point, by) in rim.iter().zip(&area.slopes()) {
                sums.add(point, &camera.lens, by);
            }
            middle + area.centre
        }
    };
    (camera.pixel(at), sums.slopes(s, eye, at))
}

/// Derivatives of a place on the distorted plane, summed over the points it is made of.
#[derive(Default)]
struct Sums {
    lens: SMatrix<f64, 2, COEFFICIENTS>,
    turn: Matrix2x3<f64>,
    shift: Matrix2x3<f64>,
}

impl Sums {
    /// Adds a point of whose distorted image the place has the derivative `by`.
    fn add(&mut self, point: &CameraPoint, lens: &Lens, by: &Matrix2<f64>) {
        self.lens += by * lens.slope_by_coefficients(point.flat);
        let by_point = by * lens.slope(point.flat) * point.by_point();
        self.shift += by_point;
        // b . (w x p) = w . (p x b)
        for k in 0..2 {
            let row = point.turned.cross(&by_point.row(k).transpose());
            let mut sum = self.turn.row_mut(k);
            sum += row.transpose();
        }
    }

    /// Those of the pixel, `at` the place.
    fn slopes(&self, s: &Ready, eye: &Eye, at: Vector2<f64>) -> Slopes {
        let matrix = eye.camera.matrix();
        let mut shared = SMatrix::<f64, 2, SHARED>::zeros();
        for (k, column) in Camera::by_pinhole(at).into_iter().enumerate() {
            shared.set_column(k, &column);
        }
        let lens = matrix * self.lens;
        shared.fixed_columns_mut::<COEFFICIENTS>(5).copy_from(&lens);
        let lifted = matrix * self.shift * eye.turn.column(2);
        for (k, height) in s.bow.iter().enumerate() {
            shared.set_column(PARAMETERS + k, &(lifted * *height));
        }
        let mut pose = SMatrix::<f64, 2, 6>::zeros();
        pose.fixed_columns_mut::<3>(0).copy_from(&(matrix * self.turn));
        pose.fixed_columns_mut::<3>(3).copy_from(&(matrix * self.shift));
        (shared, pose)
    }
}

/// What a rim encloses.
struct Area {
    u: Rim,
    v: Rim,
    du: Rim,
    dv: Rim,
    size: f64,
    /// The centre (6).
    centre: Vector2<f64>,
}

impl Area {
    fn of(points: &[Vector2<f64>; RIM_POINTS]) -> Self {
        let (u, v) = (points.map(|p| p.x), points.map(|p| p.y));
        let (du, dv) = (along(&u), along(&v));
        let (mut size, mut moment) = (0.0, Vector2::zeros());
        for k in 0..RIM_POINTS {
            size += 0.5 * (u[k] * dv[k] - v[k] * du[k]);
            moment += Vector2::new(u[k] * u[k] * dv[k], -v[k] * v[k] * du[k]) * 0.5;
        }
        let centre = moment / size;
        Self {
            u,
            v,
            du,
            dv,
            size,
            centre,
        }
    }

    /// The centre's derivatives (7) by each point.
    fn slopes(&self) -> [Matrix2<f64>; RIM_POINTS] {
        let Self { u, v, du, dv, .. } = self;
        let (du2, dv2) = (along(&u.map(|x| x * x)), along(&v.map(|x| x * x)));
        std::array::from_fn(|k| {
            let moment = Matrix2::new(u[k] * dv[k], -0.5 * du2[k], 0.5 * dv2[k], -v[k] * du[k]);
            let grown = Vector2::new(dv[k], -du[k]);
            // The quotient rule for c = M / A.
            (moment - self.centre * grown.transpose()) / self.size
        })
    }
}

/// The derivative along the rim of values on it.
fn along(values: &Rim) -> Rim {
    std::array::from_fn(|j| {
        let pair = |(m, weight): (usize, &f64)| {
            let step = m + 1;
            weight * (values[(j + RIM_POINTS - step) % RIM_POINTS] - values[(j + step) % RIM_POINTS])
        };
        ALONG.iter().enumerate().map(pair).sum()
    })
}

#[cfg(test)]
mod tests;
