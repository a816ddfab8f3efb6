//! Elements in three dimensions: cubes, and cells of any number of nodes given by tables of points.
//!
//! An element is its quadrature points with the derivatives of its nodes' shape functions; nothing else of its shape is
//! kept. Near incompressibility the measure of volume `theta` of the law is replaced by its mean-square projection on the
//! constant or linear functions of the reference position, as [`crate::q9`]'s mixed form does it in the plane: the
//! two-field form with the element's pressures eliminated.

mod cube;
mod modes;
pub mod shape;
mod state;
mod stiffness;
mod table;

#[cfg(test)]
mod tests;

pub use cube::Order;
pub use modes::Dilatation;
pub(in crate::space) use modes::MODES;
pub use state::State;
pub use table::Table;

use nalgebra::Vector3;

/// A quadrature point of an element in its reference configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The volume it stands for, mm^3; above 0.
    pub weight: f64,
    /// Its position, mm.
    pub at: Vector3<f64>,
    /// For each node the derivative of its shape function by the reference position, 1/mm.
    pub slopes: Vec<Vector3<f64>>,
}

/// Why a table cannot be. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BadTable {
    /// No node or no point, or more nodes than [`Table::MOST_NODES`].
    #[error("an element has {nodes} nodes and {points} points; it needs at least one of each and at most {most} nodes")]
    Size {
        /// Nodes found.
        nodes: usize,
        /// Points found.
        points: usize,
        /// The most nodes that are allowed.
        most: usize,
    },
    /// A point has not one slope for each node.
    #[error("point {point} has {found} slopes; the element has {nodes} nodes")]
    Slopes {
        /// The point.
        point: usize,
        /// How many were found.
        found: usize,
        /// How many nodes there are.
        nodes: usize,
    },
    /// A weight is not a finite number above 0.
    #[error("the weight of point {point} is {found}; it must be a finite number above 0")]
    Weight {
        /// The point.
        point: usize,
        /// The number found.
        found: f64,
    },
    /// The weights are finite, and their sum is not.
    #[error("the weights of the points sum to {found}")]
    Volume {
        /// Their sum.
        found: f64,
    },
    /// A position or a slope is not finite.
    #[error("point {point} has a position or a slope that is not finite")]
    NotFinite {
        /// The point.
        point: usize,
    },
    /// The edge of a cube is not a finite number above 0.
    #[error("the edge of a cube is {found} mm; it must be a finite number above 0")]
    Edge {
        /// The number found.
        found: f64,
    },
}
