//! Regular grids of discs in images: which disc is which, and where, to hundredths of a pixel.
//!
//! Section 5.2 of part III of the thesis asks for the grid in its entirety rather than disc by disc; [`find()`] does that.
//!
//! # From pixels to a grid
//!
//! 1. `way`: an image of half the resolution first; what is found there is a start for the fit to the image itself.
//! 2. `blob`, `near`, `tree`: dark or bright spots, and who is next to whom.
//! 3. `direction`, `lines`, `lattice`, `tried`, `local`: columns and rows; lattices that need no fit are told at once. A disc
//!    that the image's border cuts tells columns and rows but has no say in places (`blob::Blob::cut`).
//! 4. `seat`, `place`, `evidence`, `told`: which disc is which, marks and all, or what was seen instead.
//! 5. `each`: disc by disc ([`GridSpec::one_by_one`]), as a camera's calibration wants it: a fit of the whole grid hides the lens,
//!    as it makes discs lie on a homography.
//! 6. `whole`, `bent`, `sheet`, `warp`, `equations`: one fit of all discs, plane or bent by the lens. `places` says which pixels
//!    it looks at, disc by disc; `disc::raster` computes a blurred disc from what its columns and its rows see, so that the
//!    normal distribution is evaluated once a column and row.
//! 7. `border`, `grazing`, `light`, `misfit`, `outline`: what makes a fit's errors larger than noise does, and by how much.

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
mod search;
mod seat;
mod sheet;
mod slopes;
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
