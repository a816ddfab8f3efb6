//! Shape functions of either kind of cube.

use nalgebra::{Matrix3, Vector3};

use crate::space::element::{Order, shape};

/// Values of the shape functions of a cube's nodes at a place in its own coordinates.
pub(super) fn values(order: Order, at: [f64; 3]) -> Vec<f64> {
    match order {
        Order::Linear => shape::values_8(at).to_vec(),
        Order::Quadratic => shape::values_27(at).to_vec(),
    }
}

/// Their derivatives by these coordinates.
pub(super) fn gradients(order: Order, at: [f64; 3]) -> Vec<Vector3<f64>> {
    match order {
        Order::Linear => shape::gradients_8(at).to_vec(),
        Order::Quadratic => shape::gradients_27(at).to_vec(),
    }
}

/// Their second derivatives.
pub(super) fn curvatures(order: Order, at: [f64; 3]) -> Vec<Matrix3<f64>> {
    match order {
        Order::Linear => shape::curvatures_8(at).to_vec(),
        Order::Quadratic => shape::curvatures_27(at).to_vec(),
    }
}
