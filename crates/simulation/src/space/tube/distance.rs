//! A signed distance with two derivatives.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Signed distance to a tube at a place, with its derivatives by the place.
///
/// On the axis of the tube (nearer than 1e-12 of the radius) no normal exists: the gradient is then a unit vector square to
/// the segment, always the same one for the same segment (along the tube's own x where the segment is a sphere), and the
/// second derivatives, unbounded there, are given as zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Above zero outside, below zero inside.
    pub value: f64,
    /// The outward normal, of length 1.
    pub gradient: Vector3<f64>,
    /// Symmetric; its product with the gradient is zero. One-sided where it jumps.
    pub hessian: Matrix3<f64>,
}

impl Distance {
    /// The same distance seen from a frame that `rotation` takes this one to.
    pub(super) fn turned(&self, rotation: &UnitQuaternion<f64>) -> Self {
        let turn = rotation.to_rotation_matrix();
        Self {
            value: self.value,
            gradient: turn * self.gradient,
            hessian: turn.matrix() * self.hessian * turn.matrix().transpose(),
        }
    }
}
