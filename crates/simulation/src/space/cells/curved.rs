//! Second derivatives of the functions that regions are given by.

use nalgebra::{Matrix3, Vector3};

use super::field::{Ball, Field, Plane, Shell};
use super::label::LabelField;
use super::spline::Spline;

/// A field with continuous second derivatives: contact with its surface needs the surface's curvature.
pub trait Curved: Field + std::fmt::Debug + Send {
    /// The second derivative by the place, symmetric.
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64>;
}

impl Curved for Plane {
    fn curvature(&self, _at: &Vector3<f64>) -> Matrix3<f64> {
        Matrix3::zeros()
    }
}

impl Curved for Ball {
    fn curvature(&self, _at: &Vector3<f64>) -> Matrix3<f64> {
        Matrix3::identity() / self.radius
    }
}

impl Curved for Shell {
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        let from = at - self.centre;
        // The slope is the place about the centre times `turn` of its square, whose derivative by the square is `4 scale`.
        let turn = self.turn(from.norm_squared());
        Matrix3::identity() * turn + from * from.transpose() * (8.0 * self.scale())
    }
}

impl Curved for Spline {
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        Spline::curvature(self, at)
    }
}

impl Curved for LabelField {
    fn curvature(&self, at: &Vector3<f64>) -> Matrix3<f64> {
        self.spline.curvature(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(field: &dyn Curved, at: &Vector3<f64>) {
        let h = 1e-4;
        let found = field.curvature(at);
        for k in 0..3 {
            let step = Vector3::ith(k, h);
            let slope = (field.slope(&(at + step)) - field.slope(&(at - step))) / (2.0 * h);
            // Third derivatives are at most one here, and a spline's jump by no more: h of them; rounding is less.
            assert!((slope - found.column(k)).amax() < 2.0 * h, "{slope} {found}");
        }
        assert_eq!(found, found.transpose());
    }

    #[test]
    fn curvatures_by_differences() {
        let (centre, normal) = (Vector3::new(0.3, -0.2, 0.1), Vector3::new(1.0, 2.0, -1.0));
        let coefficients: Vec<f32> = (0..120).map(|k| ((k * k) % 17) as f32 / 17.0).collect();
        let spacing = Vector3::new(1.5, 2.0, 3.0);
        let spline = Spline::new([4, 5, 6], Vector3::zeros(), spacing, coefficients, 0.5).unwrap();
        for at in [[1.0, 0.5, 2.0], [3.2, 5.1, 4.0], [2.0, 7.9, 13.0], [-20.0, 3.0, 40.0]] {
            let at = Vector3::from(at);
            check(&Plane { point: centre, normal }, &at);
            check(&Ball { centre, radius: 7.0 }, &at);
            let radii = [30.0, 40.0];
            check(&Shell { centre, radii }, &at);
            check(&spline, &at);
        }
    }
}
