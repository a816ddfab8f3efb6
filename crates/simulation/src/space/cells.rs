//! Meshes of cubes over a region whose surface cuts through them.
//!
//! A region is where a smooth [`Field`] is negative: a closed form, or the smoothed indicator of a label map. An octree of
//! cubes ([`Grid`]) covers it, refined where asked. Three things make it a mesh whose surface is the field's and not that of
//! the cubes:
//!
//! * [`Rule`]: integrals over the part of a cube inside the region, by one-dimensional roots (Saye 2015), recombined to few
//!   points with positive weights;
//! * ties: nodes that hang on a larger neighbour, and nodes that hardly any material holds, follow others;
//! * [`Mesh`]: the elements, each over nodes that are free.

mod build;
mod curved;
mod denser;
mod eighths;
mod elements;
mod field;
mod fill;
mod grid;
mod label;
mod lattice;
mod mesh;
mod parts;
mod points;
mod recombine;
mod rule;
mod settings;
mod shape;
mod share;
mod spline;
mod surface;
mod ties;

pub use curved::Curved;
pub use field::{Ball, Bounds, Field, Plane, Shell};
pub(in crate::space) use field::{is_clear, steepest};
pub use grid::{Cell, Grid};
pub use label::{Facts, LabelField, LabelMap, NoRegion, Parts, Smoothing};
pub use lattice::{Lattice, LatticeCube};
pub use mesh::Mesh;
pub use parts::{Element, SurfacePoint, VolumePoint};
pub use rule::{Depth, Inside, Rule, Surface};
pub use settings::{NoMesh, Settings};
pub use share::Share;
pub use spline::Spline;
