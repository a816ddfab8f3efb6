//! Organs that were pushed aside, in a slice: which place of the CT now lies at each pixel.
//!
//! An organ is a mesh of cubes of 27 nodes ([`Shape`]). Where its nodes lie now, the plane cuts small pieces of it: each cube is
//! divided into pieces of one size, and each piece into six tetrahedra. They close without gaps and without overlaps, as neighbours share
//! the bits of their corners and the raster is exact. Of a cube that is bent little only the outline of its pieces is drawn; within it lies
//! the inverse of its quadratic map, found by Newton's method on a coarse grid of pixels and bilinear between. Of any other cube each
//! tetrahedron is drawn, in which the place at rest is an affine function of the pixel. The distance of both from the quadratic maps is in
//! the result ([`Warped::error_mm`]).
//!
//! Where pieces claim a pixel more than once, or turned inside out, the quadratic maps are asked themselves, as what a piece has beyond the
//! organ's surface is no tissue.
//!
//! A pixel is one of four ([`Pixel`]): tissue, untouched surroundings, a place that tissue has left, or one that two claim. Each organ
//! is drawn apart, so that a border along which organs slide stays sharp.

mod border;
mod corners;
mod cut;
mod drawing;
mod edge;
mod error;
mod faces;
mod image;
mod inverse;
mod kinds;
mod lattice;
mod outline;
mod picture;
mod placed;
mod quadratic;
mod raster;
mod region;
mod resolve;
mod shape;
mod sheet;
mod slopes;
mod sweep;
mod view;
mod whole;

pub use error::NoShape;
pub use image::{Organ, Pixel, Warped};
pub use picture::{NoWarp, Warp};
pub use region::Region;
pub use shape::{Cube, Shape};

#[cfg(test)]
mod tests;
