//! Regular grids of discs in images: which disc is which, and where, to hundredths of a pixel.
//!
//! Section 5.2 of part III of the thesis asks for the grid in its entirety rather than disc by disc; [`find()`] does that.

mod bent;
mod blob;
mod border;
mod direction;
mod each;
mod equations;
mod error;
mod evidence;
mod find;
mod found;
mod grazing;
mod homography;
mod lattice;
mod light;
mod lines;
mod local;
mod misfit;
mod model;
mod near;
mod outline;
mod place;
mod places;
mod seat;
mod sheet;
mod told;
mod tree;
mod tried;
mod warp;
mod way;
mod whole;

pub use direction::{ANGLES, Candidate, Lines, angular_correlation, principal_angles, signature};
pub use error::GridRefused;
pub use find::find;
pub use found::{Found, GridDisc, GridSpec, Measured, Refinement};
pub use homography::{homography, jacobian, project};
