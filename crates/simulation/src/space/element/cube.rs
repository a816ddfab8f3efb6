//! A full cube of 8 or 27 nodes.

use nalgebra::Vector3;

use super::shape::{GAUSS_2, GAUSS_3, gradients_8, gradients_27};
use super::{BadTable, Dilatation, Point, Table};

/// How many nodes a cube has along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Two: 8 nodes, 2^3 Gauss points.
    Linear,
    /// Three: 27 nodes, 3^3 Gauss points.
    Quadratic,
}

impl Order {
    /// Nodes of a cube.
    pub fn nodes(self) -> usize {
        match self {
            Self::Linear => 8,
            Self::Quadratic => 27,
        }
    }

    fn rule(self) -> &'static [(f64, f64)] {
        match self {
            Self::Linear => &GAUSS_2,
            Self::Quadratic => &GAUSS_3,
        }
    }

    /// Derivatives of the shape functions by the local coordinates at a point of `[-1, 1]^3`.
    fn gradients(self, at: [f64; 3]) -> Vec<Vector3<f64>> {
        match self {
            Self::Linear => gradients_8(at).to_vec(),
            Self::Quadratic => gradients_27(at).to_vec(),
        }
    }
}

impl Table {
    /// The cube `[0, size]^3`, size in mm, with Gauss' points; nodes as in [`super::shape`].
    ///
    /// # Errors
    /// [`BadTable::Edge`]; [`BadTable::Weight`] or [`BadTable::NotFinite`] where its volume or a slope is no number.
    pub fn cube(order: Order, size: f64, dilatation: Dilatation) -> Result<Self, BadTable> {
        if !(size.is_finite() && size > 0.0) {
            return Err(BadTable::Edge { found: size });
        }
        let (rule, half) = (order.rule(), 0.5 * size);
        let mut points = Vec::new();
        for (w, z) in rule.iter().map(|(x, w)| (w, x)) {
            for (v, y) in rule.iter().map(|(x, w)| (w, x)) {
                for (u, x) in rule.iter().map(|(x, w)| (w, x)) {
                    let slopes = order.gradients([*x, *y, *z]);
                    // Halves of the edge are exact where it is a power of two: cubes of such sizes differ by no rounding.
                    points.push(Point {
                        weight: u * v * w * (half * half * half),
                        at: Vector3::new(1.0 + x, 1.0 + y, 1.0 + z) * half,
                        slopes: slopes.iter().map(|q| q / half).collect(),
                    });
                }
            }
        }
        Self::new(order.nodes(), &points, dilatation)
    }
}
