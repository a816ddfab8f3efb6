//! Ellipses in an image.

use nalgebra::{Matrix2, Matrix3, Vector2};

/// The ellipse `(x - centre)^T shape^-1 (x - centre) = 1`: `shape` is 4 times the second central moment of its area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre, pixels.
    pub centre: Vector2<f64>,
    /// Symmetric positive definite, pixels squared.
    pub shape: Matrix2<f64>,
}

/// The axes of an ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Semi-axes, the longer first, pixels.
    pub semi: [f64; 2],
    /// The direction of the longer, a unit vector.
    pub long: Vector2<f64>,
}

impl Ellipse {
    /// A circle.
    pub fn circle(centre: Vector2<f64>, radius: f64) -> Self {
        let shape = Matrix2::identity() * (radius * radius);
        Self { centre, shape }
    }

    /// The image of the circle about `at` under the homography `h`, and no ellipse where it reaches the horizon.
    ///
    /// Its conic is `H^-T C H^-1`; in dual form, which needs no inverse, `H C* H^T` with
    /// `C* = [r^2 I - a a^T, -a; -a^T, -1]`, whose last column is the centre.
    pub fn of_circle(h: &Matrix3<f64>, at: Vector2<f64>, radius: f64) -> Option<Self> {
        let (a, b, r2) = (at.x, at.y, radius * radius);
        let dual = Matrix3::new(a * a - r2, a * b, a, a * b, b * b - r2, b, a, b, 1.0);
        let image = h * dual * h.transpose();
        let w = image[(2, 2)];
        let centre = Vector2::new(image[(0, 2)], image[(1, 2)]) / w;
        let shape = centre * centre.transpose() - image.fixed_view::<2, 2>(0, 0) / w;
        let good = w > 0.0 && shape.trace() > 0.0 && shape.determinant() > 0.0;
        good.then_some(Self { centre, shape })
    }

    /// Semi-axes and direction.
    pub fn axes(&self) -> Axes {
        let (a, b, c) = (self.shape[(0, 0)], self.shape[(0, 1)], self.shape[(1, 1)]);
        let (mean, half) = (0.5 * (a + c), (0.25 * (a - c).powi(2) + b * b).sqrt());
        let angle = 0.5 * (2.0 * b).atan2(a - c);
        Axes {
            semi: [(mean + half).max(0.0).sqrt(), (mean - half).max(0.0).sqrt()],
            long: Vector2::new(angle.cos(), angle.sin()),
        }
    }

    /// Half the extent along x and along y.
    pub fn extent(&self) -> Vector2<f64> {
        Vector2::new(self.shape[(0, 0)].max(0.0).sqrt(), self.shape[(1, 1)].max(0.0).sqrt())
    }

    /// The radius of the circle of the same area, pixels.
    pub fn mean_radius(&self) -> f64 {
        self.shape.determinant().max(0.0).powf(0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_of_a_circle_passes_through_the_images_of_its_points() {
        let h = Matrix3::new(30.0, -4.0, 250.0, 3.0, 9.0, 200.0, 1e-3, 3e-2, 1.0);
        let (at, radius) = (Vector2::new(1.5, -4.0), 0.2);
        let ellipse = Ellipse::of_circle(&h, at, radius).unwrap();
        let inverse = ellipse.shape.try_inverse().unwrap();
        for k in 0..12 {
            let (s, c) = (f64::from(k) * 0.5).sin_cos();
            let p = h * nalgebra::Vector3::new(at.x + radius * c, at.y + radius * s, 1.0);
            let d = Vector2::new(p.x / p.z, p.y / p.z) - ellipse.centre;
            // The conic is made of products of about 250^2; its smallest term is 1: 1e-16 * 6e4 * condition.
            assert!(((d.transpose() * inverse * d)[0] - 1.0).abs() < 1e-8);
        }
        let turned = Ellipse {
            centre: Vector2::zeros(),
            shape: Matrix2::new(5.0, 3.0, 3.0, 5.0),
        };
        let axes = turned.axes();
        assert!((axes.semi[0] - 8.0_f64.sqrt()).abs() < 1e-12 && (axes.semi[1] - 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((axes.long.x - axes.long.y).abs() < 1e-12);
    }

    #[test]
    fn a_circle_over_the_horizon_has_no_ellipse() {
        let h = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.1);
        assert!(Ellipse::of_circle(&h, Vector2::zeros(), 0.2).is_none());
    }
}
