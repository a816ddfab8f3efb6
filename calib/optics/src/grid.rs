//! Regular grids of discs in images: which disc is which, and where, to hundredths of a pixel.
//!
//! Section 5.2 of part III of the thesis asks for the grid in its entirety rather than disc by disc; [`find()`] does that.
//!
//! # From pixels to a grid
//!
//! 1. `candidates`: dark or bright spots (`blob`, `region_tree`), and who is next to whom (`neighbours`). An image of half the
//!    resolution goes first, then smoother ones (`smoothing_passes`): what is found there is a start for the fit to the image.
//! 2. `lattice`: columns and rows, grown from a seed; which disc is which (`index_lattice`), marks and all (`assignment`). A disc
//!    that the image's border cuts tells columns and rows but has no say in positions (`Blob::cut`). Lattices that need no fit are
//!    told at once (`rejected`).
//! 3. `disc_fit_by_disc` ([`GridSpec::one_by_one`]): centres as a camera's calibration wants them. A fit of the whole grid would
//!    hide the lens, as it makes discs lie on a homography.
//! 4. `fit`: one fit of all discs, plane (`grid_fit`) or bent by the lens (`lens_fit`, `lens_model`, `lens_polynomial`), grown line
//!    by line to the grid's border (`growth`). `sample_pixels` says which pixels it looks at, disc by disc; `disc::raster`
//!    computes a blurred disc from what its columns and its rows see, so that the normal distribution is evaluated once a
//!    column and row.
//! 5. `check`: what makes a fit's errors larger than noise does, and by how much: each disc's own pixels against the fit
//!    (`own_pixels`, `own_centres`, `misfit`, `agreement`).

mod candidates;
mod check;
mod direction;
mod disc_fit_by_disc;
mod error;
mod find;
mod fit;
mod found;
mod homography;
mod lattice;

pub use direction::{ANGLES, Candidate, Lines, angular_correlation, principal_angles, signature};
pub use error::GridRefused;
pub use find::find;
pub use found::{Found, GridDisc, GridSpec, Measured, Refinement};
pub use homography::{homography, jacobian, project};
