//! Nine-node biquadratic meshes: the thesis's deformable solids (II 3.2.2).
//!
//! An element maps `(u, v)` in `[-1, 1]^2` to the plane by nine nodes; node `i + 3 j` lies at `u = i - 1`, `v = j - 1`.
//! Integrals are 3 x 3 Gauss sums: with 2 x 2 the order of convergence would be the same, but three modes of every free
//! element would cost no energy.

pub(crate) mod blocks;
mod build;
pub(crate) mod element;
mod error;
pub(crate) mod field;
mod mesh;
mod mixed;
mod point;
pub(crate) mod shape;

pub use build::{blob, grid, rectangle, ring};
pub use element::Element;
pub use error::Refused;
pub use field::FieldPoint;
pub use mesh::{Arc, Mesh};
pub use point::GaussPoint;
pub use shape::{GAUSS, gradients, values};

/// Nodes of an element.
pub const NODES: usize = 9;

/// The four sides of an element, each from corner to corner by its middle node, counter-clockwise.
pub const SIDES: [[usize; 3]; 4] = [[0, 1, 2], [2, 5, 8], [8, 7, 6], [6, 3, 0]];
