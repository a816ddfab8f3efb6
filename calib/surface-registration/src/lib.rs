//! Floor 2.

mod field;
mod free;
mod kernel;
mod mesh;
mod points;
mod register;
mod search;
#[cfg(test)]
#[allow(dead_code, reason = "each of its two users takes what it needs")]
mod shapes;
mod solve;
mod tree;
mod verdict;

pub use field::{Field, FieldError, MOST_NODES, Spacing};
pub use free::{Free, free};
pub use kernel::Kernel;
pub use mesh::{DIAGONAL_MM, Distance, Facts, MOST_TRIANGLES, OpenEnd, Surface, SurfaceError};
pub use points::{Beam, BeamNoise, LEAST_POINTS, MOST_POINTS, Points, PointsError, SharedError, SurfacePoint};
pub use register::{
    Class, Landmark, Options, Other, PointResult, RegisterError, Start, SurfaceRegistration, refine, register,
};
pub use search::Effort;
pub use solve::Priors;
pub use verdict::{Limits, Refusal};
