//! How far a recorded motion turned the marker, about which axes, and what is missing.
//!
//! With `q_i` the quaternions of the poses and `q0` the eigenvector of the largest eigenvalue of `mean(q q^T)` (their
//! chordal mean), `conj(q0) q_i = (cos(theta_i / 2), n_i sin(theta_i / 2))` is the turn from the mean in the marker's
//! frame. The eigenvectors of `mean(sin^2(theta / 2) n n^T)` are the principal axes, and `2 asin(sqrt(eigenvalue))` the
//! root mean square turn about each: no sign of a quaternion and no angle near a half-turn disturbs it.

pub mod seen;

use std::fmt;

use geometry::rotation::Rotation;
use geometry::{Direction, Frame, Vector};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

use crate::registration::jacobi::{symmetric3, symmetric4};

/// An axis is called by the name of a frame's axis within this angle of it: 20 degrees.
const NAMED_COSINE: f64 = 0.939_692_620_785_908_4;

/// A principal axis of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Principal<F: Frame> {
    /// The axis, in the marker's frame; of either sign.
    pub axis: Direction<F>,
    /// Twice the root mean square turn about it, radians: the half opening of a cone that is filled evenly.
    pub angle_rad: f64,
}

/// The turns of a motion about their mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage<F: Frame> {
    /// The three principal axes, the widest turn first.
    pub principal: [Principal<F>; 3],
}

impl<F: Frame> Coverage<F> {
    /// The coverage by rotations from the marker's frame `F` to a fixed one. `None` without any.
    pub fn of(rotations: impl Iterator<Item = Rotation> + Clone) -> Option<Self> {
        let quaternions = rotations.map(|r| Vector4::from(r.quaternion()));
        let count = quaternions.clone().count() as f64;
        let mean = mean(quaternions.clone())?;
        // Each turn by itself: small ones would drown in the rounding of the 4 x 4 matrix.
        let outer = quaternions.map(|q| turn(&mean, &q)).map(|v| v * v.transpose());
        let (values, vectors) = symmetric3(outer.sum::<Matrix3<f64>>() / count);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
        let principal = |i: usize| Principal {
            axis: direction(vectors.column(i).into_owned(), i),
            // The eigenvalue is the mean of sin^2(theta / 2): theta = 2 asin(root), and twice that. Rounding may lead
            // out of 0 to 1.
            angle_rad: 4.0 * values[i].clamp(0.0, 1.0).sqrt().asin(),
        };
        Some(Self {
            principal: order.map(principal),
        })
    }

    /// The angles of the principal axes in degrees, the widest first.
    pub fn angles_deg(&self) -> [f64; 3] {
        self.principal.each_ref().map(|p| p.angle_rad.to_degrees())
    }

    /// The half opening of the cone that the motion fills, radians: the second principal angle, since turning about one
    /// axis, however far, leaves a tip undetermined along it.
    pub fn cone_rad(&self) -> f64 {
        self.principal[1].angle_rad
    }

    /// What to do where the cone is below `needed_rad`: turn about the second principal axis, and about the third where
    /// both are short. `None` where it is wide enough.
    pub fn advice(&self, needed_rad: f64) -> Option<Advice<F>> {
        let poorest = &self.principal[1];
        (poorest.angle_rad < needed_rad).then_some(Advice {
            axis: poorest.axis,
            so_far_rad: poorest.angle_rad,
            needed_rad,
        })
    }
}

/// The chordal mean of some rotations; `None` without any.
fn mean(quaternions: impl Iterator<Item = Vector4<f64>> + Clone) -> Option<Vector4<f64>> {
    let count = quaternions.clone().count() as f64;
    if count == 0.0 {
        return None;
    }
    // q q^T is the same for q and -q, so that no sign has to be chosen (Markley et al. 2007).
    let outer = quaternions.map(|q| q * q.transpose());
    let (values, vectors) = symmetric4(outer.sum::<Matrix4<f64>>() / count);
    Some(vectors.column(values.imax()).into_owned())
}

/// The vector part of `conj(mean) q`: axis times the sine of half the angle, in the marker's frame.
fn turn(mean: &Vector4<f64>, q: &Vector4<f64>) -> Vector3<f64> {
    let (m, v) = (Vector3::new(mean[1], mean[2], mean[3]), Vector3::new(q[1], q[2], q[3]));
    v * mean[0] - m * q[0] - m.cross(&v)
}

fn direction<F: Frame>(v: Vector3<f64>, fallback: usize) -> Direction<F> {
    let axes = [Direction::X, Direction::Y, Direction::Z];
    // An eigenvector has norm 1; the fallback is for the compiler.
    Vector::new(v.x, v.y, v.z).direction().unwrap_or(axes[fallback % 3])
}

/// What a person holding the instrument should do. Its text is a sentence without a full stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advice<F: Frame> {
    /// The axis to turn about, in the marker's frame.
    pub axis: Direction<F>,
    /// The angle reached, radians.
    pub so_far_rad: f64,
    /// The angle asked for, radians.
    pub needed_rad: f64,
}

impl<F: Frame> fmt::Display for Advice<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (so_far, needed) = (self.so_far_rad.to_degrees(), self.needed_rad.to_degrees());
        let axis = Named::from(self.axis);
        write!(
            f,
            "rotate more about {axis}; {so_far:.1} degrees so far, {needed:.0} are needed"
        )
    }
}

/// An axis of a marker, told in words: "the marker's y axis", or by its components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Named {
    /// The frame's name.
    pub frame: &'static str,
    /// A unit vector in it.
    pub axis: [f64; 3],
}

impl<F: Frame> From<Direction<F>> for Named {
    fn from(axis: Direction<F>) -> Self {
        Self {
            frame: F::NAME,
            axis: axis.components(),
        }
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frame = self.frame.to_lowercase();
        // Only the axis of the largest component can lie within 20 degrees.
        let nearest = Vector3::from(self.axis).iamax();
        let largest = self.axis[nearest];
        if largest.abs() >= NAMED_COSINE {
            return write!(f, "the {frame}'s {} axis", ["x", "y", "z"][nearest]);
        }
        // Of the two signs, the one whose largest component is positive; and no zero with a sign.
        let [x, y, z] = self.axis.map(|x| x * largest.signum() + 0.0);
        write!(f, "the axis ({x:.2}, {y:.2}, {z:.2}) of the {frame}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Marker;
    use geometry::rotation::RotationVector;

    fn turn(v: [f64; 3]) -> Rotation {
        Rotation::from_vector(RotationVector::new(v).unwrap())
    }

    /// Turns about `axis` by evenly spread angles up to `most` either way, after a fixed placing.
    fn about(axis: [f64; 3], most: f64, count: usize) -> Vec<Rotation> {
        let placing = turn([0.4, 2.0, -1.1]);
        let angle = |i: usize| most * ((2 * i + 1) as f64 / count as f64 - 1.0);
        (0..count).map(|i| placing * turn(axis.map(|c| c * angle(i)))).collect()
    }

    #[test]
    fn one_axis_is_found_with_its_angle() {
        for most in [1e-6, 0.01, 0.5, 3.0] {
            let coverage = Coverage::<Marker>::of(about([0.0, 1.0, 0.0], most, 1001).into_iter()).unwrap();
            let widest = coverage.principal[0];
            assert!(widest.axis.dot(Direction::Y).abs() > 1.0 - 1e-9, "{coverage:?}");
            // The mean of sin^2(x / 2) over -m..m is (1 - sin(m) / m) / 2; formed by its series where it cancels.
            let mean = if most < 0.1 {
                most * most / 12.0
            } else {
                0.5 * (1.0 - most.sin() / most)
            };
            let expected = 4.0 * f64::sqrt(mean).asin();
            // 1 / 1001^2 of the angle is missing at the ends; the moment's own rounding is 1e-16 beside mean.
            assert!(
                (widest.angle_rad / expected - 1.0).abs() < 1e-4,
                "{most}: {widest:?} {expected}"
            );
            assert!(coverage.cone_rad() < 1e-7, "{most}: {coverage:?}");
            let advice = coverage.advice(20.0_f64.to_radians()).unwrap().to_string();
            assert!(advice.ends_with("0.0 degrees so far, 20 are needed"), "{advice}");
        }
    }

    #[test]
    fn the_poorest_of_two_axes_is_named_in_the_markers_frame() {
        let mut turns = about([1.0, 0.0, 0.0], 0.6, 100);
        turns.extend(about([0.0, 0.0, 1.0], 0.06, 100));
        let coverage = Coverage::<Marker>::of(turns.iter().copied()).unwrap();
        let advice = coverage.advice(0.35).unwrap();
        assert!(advice.to_string().contains("the marker's z axis"), "{advice}");
        assert!(coverage.advice(0.01).is_none());
        // The sign of a quaternion means nothing.
        let turned = turns.iter().enumerate().map(|(i, r)| match i % 2 {
            0 => *r,
            _ => Rotation::from_quaternion(r.quaternion().map(|c| -c)).unwrap(),
        });
        let again = Coverage::<Marker>::of(turned).unwrap();
        assert!((again.cone_rad() - coverage.cone_rad()).abs() < 1e-12);
    }

    #[test]
    fn an_axis_between_others_is_given_by_its_components() {
        let axis = Vector::<Marker>::new(-1.0, -1.0, 0.0).direction().unwrap();
        assert_eq!(
            Named::from(axis).to_string(),
            "the axis (0.71, 0.71, 0.00) of the marker"
        );
        assert!(Coverage::<Marker>::of(std::iter::empty()).is_none());
    }
}
