//! A camera: from points in front of it to pixels and back.
//!
//! The camera's frame has its origin at the centre of projection, x to the right, y down, z forward, mm. Pixels have
//! their centres at whole coordinates. With `x = (X / Z, Y / Z)` and the lens' [`Lens::distort`]
//!
//! ```text
//! u = fx f(x)_1 + skew f(x)_2 + cx,     v = fy f(x)_2 + cy                                                      (3)
//! ```

use geometry::{Frame, Point};
use nalgebra::{Matrix2, Vector2};

use super::lens::Lens;

/// The camera's frame: z forward, x to the right, y down, mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraFrame {}
impl Frame for CameraFrame {
    const NAME: &'static str = "Camera";
}

/// The grid's frame: disc (0, 0) at the origin, x along its columns, y along its rows, mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridFrame {}
impl Frame for GridFrame {
    const NAME: &'static str = "Grid";
}

/// How many numbers a camera has, in the order of [`NAMES`] wherever there is a vector of them.
pub const PARAMETERS: usize = 14;
/// Their names.
pub const NAMES: [&str; PARAMETERS] = [
    "fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3", "s1", "s2", "s3", "s4",
];

/// The numbers of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Focal lengths along x and y, pixels.
    pub focal: Vector2<f64>,
    /// The principal point, pixels.
    pub centre: Vector2<f64>,
    /// The share of the vertical in x: 0 for every camera whose pixels are rectangles, pixels.
    pub skew: f64,
    /// The lens.
    pub lens: Lens,
}

/// Why a point has no image, or a pixel no ray.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Outside {
    /// The point is not in front of the camera.
    #[error("the point is {depth_mm} mm in front of the camera; it must be above 0")]
    Behind {
        /// Its distance along the axis.
        depth_mm: f64,
    },
    /// The point is further off the axis than the lens' model reaches.
    #[error("the point lies {tangent:.4} off the axis (tangent of its angle); the lens' model ends at {limit:.4}")]
    Wide {
        /// Tangent of its angle off the axis.
        tangent: f64,
        /// The largest.
        limit: f64,
    },
    /// No point within the lens' domain has this image.
    #[error(
        "no point within the lens' domain has its image at pixel {pixel:?}; the domain ends {limit:.4} off the axis"
    )]
    NoRay {
        /// The pixel.
        pixel: [f64; 2],
        /// The domain's end, tangent of the angle off the axis.
        limit: f64,
    },
}

impl Camera {
    /// A pinhole of square pixels.
    pub fn pinhole(focal_px: f64, centre: Vector2<f64>) -> Self {
        Self {
            focal: Vector2::new(focal_px, focal_px),
            centre,
            skew: 0.0,
            lens: Lens::default(),
        }
    }

    /// The pixel at which a point is seen.
    ///
    /// # Errors
    /// [`Outside::Behind`] and [`Outside::Wide`].
    pub fn project(&self, point: Point<CameraFrame>) -> Result<Vector2<f64>, Outside> {
        let [x, y, z] = point.mm();
        // A NaN is not in front either.
        let in_front = z > 0.0;
        if !in_front {
            return Err(Outside::Behind { depth_mm: z });
        }
        let at = Vector2::new(x / z, y / z);
        let (tangent, limit) = (at.norm(), self.lens.limit());
        let within = tangent <= limit;
        if !within {
            return Err(Outside::Wide { tangent, limit });
        }
        Ok(self.pixel(self.lens.distort(at)))
    }

    /// The ray of a pixel: the point at distance 1 along the axis, on the undistorted plane.
    ///
    /// # Errors
    /// [`Outside::NoRay`].
    pub fn undistort(&self, pixel: Vector2<f64>) -> Result<Vector2<f64>, Outside> {
        let y = (pixel.y - self.centre.y) / self.focal.y;
        let x = (pixel.x - self.centre.x - self.skew * y) / self.focal.x;
        let found = self.lens.undistort(Vector2::new(x, y));
        found.ok_or_else(|| Outside::NoRay {
            pixel: pixel.into(),
            limit: self.lens.limit(),
        })
    }

    /// The pixel at which a pinhole camera of the same focal lengths and centre sees what is seen at `pixel`.
    ///
    /// # Errors
    /// [`Outside::NoRay`].
    pub fn straightened(&self, pixel: Vector2<f64>) -> Result<Vector2<f64>, Outside> {
        self.undistort(pixel).map(|ray| self.pixel(ray))
    }

    /// (3) of a point of the distorted plane.
    pub(super) fn pixel(&self, at: Vector2<f64>) -> Vector2<f64> {
        self.matrix() * at + self.centre
    }

    /// Pixels per unit of the distorted plane.
    pub(super) fn matrix(&self) -> Matrix2<f64> {
        Matrix2::new(self.focal.x, self.skew, 0.0, self.focal.y)
    }

    /// The numbers in the order of [`NAMES`].
    pub fn numbers(&self) -> [f64; PARAMETERS] {
        let Lens { k1, k2, k3, p1, p2, s } = self.lens;
        let [s1, s2, s3, s4] = s;
        let (f, c) = (self.focal, self.centre);
        [f.x, f.y, c.x, c.y, self.skew, k1, k2, p1, p2, k3, s1, s2, s3, s4]
    }

    /// The camera of these numbers.
    pub fn from_numbers(numbers: [f64; PARAMETERS]) -> Self {
        let [fx, fy, cx, cy, skew, k1, k2, p1, p2, k3, s @ ..] = numbers;
        Self {
            focal: Vector2::new(fx, fy),
            centre: Vector2::new(cx, cy),
            skew,
            lens: Lens { k1, k2, k3, p1, p2, s },
        }
    }

    /// The derivatives of a pixel by fx, fy, cx, cy and skew, `at` its place on the distorted plane.
    pub(super) fn by_pinhole(at: Vector2<f64>) -> [Vector2<f64>; 5] {
        [[at.x, 0.0], [0.0, at.y], [1.0, 0.0], [0.0, 1.0], [at.y, 0.0]].map(Vector2::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laparoscope() -> Camera {
        Camera::from_numbers([
            1766.3, 1769.6, 915.7, 459.0, 0.7, -0.29, -0.0019, 0.0072, -0.00017, 0.37, 0.004, -0.02, 0.01, 0.03,
        ])
    }

    #[test]
    fn a_pixel_is_where_its_ray_is_seen() {
        let camera = laparoscope();
        for i in 0..=16 {
            for j in 0..=9 {
                let pixel = Vector2::new(f64::from(i) * 119.94, f64::from(j) * 119.9);
                let ray = camera.undistort(pixel).unwrap();
                let back = camera.project(Point::new(ray.x * 70.0, ray.y * 70.0, 70.0)).unwrap();
                // Pixels are products of numbers of 2000: some roundings of that.
                assert!((back - pixel).norm() < 1e-11, "{pixel} {back}");
            }
        }
        let numbers = camera.numbers();
        assert_eq!(Camera::from_numbers(numbers), camera);
    }

    #[test]
    fn what_has_no_image_is_refused_with_the_numbers() {
        let camera = laparoscope();
        let behind = camera.project(Point::new(0.0, 0.0, -5.0)).unwrap_err();
        assert_eq!(behind, Outside::Behind { depth_mm: -5.0 });
        assert!(camera.project(Point::new(0.0, 0.0, f64::NAN)).is_err());
        let folded = Camera {
            lens: Lens {
                k1: -0.5,
                ..Lens::default()
            },
            ..camera
        };
        let wide = folded.project(Point::new(3.0, 0.0, 1.0)).unwrap_err();
        assert!(wide.to_string().contains("3.0000 off the axis"), "{wide}");
        let none = folded.undistort(Vector2::new(9000.0, 400.0)).unwrap_err();
        assert!(none.to_string().contains("9000"), "{none}");
    }
}
