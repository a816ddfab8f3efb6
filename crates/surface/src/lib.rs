//! Floor 1: surfaces of an examination, and drawing them; an overview, nothing is measured on it.
//!
//! [`bone`] and [`structures`] find a surface once ([`nets`]: every edge of it lies in an even number of triangles, and those of a solid
//! without corners that touch in two); [`ZBuffer`] draws triangles by parallel projection along a [`geometry::SlicePlane`]. Both are
//! single-threaded and the same to the bit whenever they are asked the same. Lengths are mm, places LPS.

mod average;
mod field;
mod mesh;
pub mod nets;
mod raster;
mod shapes;

pub use average::{Average, MOST_SAMPLES};
pub use field::{Field, PAINTS, bone, structures};
pub use mesh::Mesh;
pub use raster::{Rgb, ZBuffer};

/// The most triangles of one surface: with their corners about 80 MiB, and twice that while it grows.
pub const MOST_TRIANGLES: usize = 3_000_000;

/// Why there is no surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SurfaceError {
    /// The surface is too rough or too large: noise, or a level that is none.
    #[error("a surface of more than {most} triangles")]
    TooMany {
        /// How many are allowed.
        most: usize,
    },
    /// A voxel of a label map is no label.
    #[error("label {0}; labels are 0 and more")]
    Negative(i16),
}
