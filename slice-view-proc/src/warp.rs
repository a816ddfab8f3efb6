//! Organs that were pushed aside, in a slice: which place of the CT now lies at each pixel.
//!
//! An organ is a mesh of cubes of 27 nodes ([`Shape`]). Where its nodes lie now, the plane cuts small pieces of it: each cube is
//! divided into pieces of one size, each piece into six tetrahedra, and within a tetrahedron the place at rest is an affine function of
//! the pixel. No equation is solved for a pixel. The pieces close without gaps and without overlaps, as neighbours share the bits of
//! their corners and the raster is exact; their distance from the quadratic map of the cubes is in the result ([`Warped::error_mm`]).
//!
//! A pixel is one of four ([`Pixel`]): tissue, untouched surroundings, a place that tissue has left, or one that two claim. Each organ
//! is drawn apart, so that a border along which organs slide stays sharp.

mod cut;
mod error;
mod lattice;
mod picture;
mod quadratic;
mod raster;
mod region;
mod shape;

pub use error::NoShape;
pub use picture::{NoWarp, Organ, Pixel, Warp, Warped};
pub use region::Region;
pub use shape::{Cube, Shape};

#[cfg(test)]
mod tests;
