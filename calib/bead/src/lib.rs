//! Metal beads: their centres in a CT, and which of them was touched (thesis, part III, chapter 5, in three dimensions).
//!
//! [`find`] gives the centres with their covariances, [`matching`] the registration of touched points whose order is not
//! known, [`check`] the verdict on a point that is touched afterwards.
//!
//! # Finding
//!
//! 1. Spots: local maxima of the volume that are brighter than their surroundings by at least half the contrast of the dimmest
//!    bead that is looked for, in the worst place between the voxels, behind the scanner's blur, or by 1500 HU where that is
//!    less. That threshold is in the result ([`Found::least_contrast_hu`]); where it would be below what bone reaches, the
//!    search is refused.
//! 2. The detector, with exact sums of whole HU over regions in mm:
//!
//!    ```text
//!    chi(m) = (mean(I) - mean(E)) / (deviation(I) + deviation(E) / 2 + 1 HU)                               (5.3), signed
//!    ```
//!
//!    I is the ball of the least radius. E is a shell around the greatest radius and 2.2 deviations of the blur, an ellipsoid
//!    where slices are thick. Nothing in E may have more than 0.6 of the spot's contrast: what goes on outwards is a wire, a
//!    screw or an implant.
//! 3. The model: a ball, blurred by a Gaussian, on sloping ground, fitted by weighted least squares ([`Blur`]). Voxels at the
//!    clipping value only say "at least".
//! 4. What fits must be round, of the radius, of the metal, and blurred as the scanner blurs.
//! 5. The ball once more, with what lies around as a random field, so that bone beside a bead does not draw it
//!    ([`Ground`]). Centre, covariance, radius, blur and metal of what is found come from this. What step 4 refused by its blur
//!    or its shape has here a second chance: bone beside a ball on sloping ground looks like a wider blur. It is
//!    accepted where the ball on its field passes step 4, the field is no brighter than bone, and what is left
//!    is no larger in the ball than around it. Else it is told of with the [`Reason`] of step 4 and not taken.
//!    Its centre must be held as that of metal is ([`Reason::Unsure`]): knobs of bone and calcium that look like a ball are hardly brighter
//!    than what is around them, so that the field may have moved them.
//! 6. Slices thicker than 1.1 mm are taken for a Gaussian's and for the mean over their thickness; all beads together say
//!    which, and where they do not, both count: centres are the mean, their distance is in the covariance.
//!
//! Voxels may be of any shape that [`geometry::VolumeGrid`] allows, sheared too; two of the three steps must be alike. Time is
//! one pass over the volume, some microseconds a spot and some tenths of a second a bead, twice that in thick slices; there
//! are at most 300 000 spots.
//!
//! # Accuracy
//!
//! Root mean square error of the centre, mm, of 8 beads of 20 000 HU a row, blur 0.45 mm (0.4 of a slice in thick ones), by
//! the test `centres_are_within_the_goals_and_no_worse_than_the_best_simple_method`; the worse of clipped at 3071 HU and not:
//!
//! | voxel, mm | 2 mm, 10 HU | 2 mm, 50 HU | 1 mm, 10 HU | 1 mm, 50 HU |
//! |---|---|---|---|---|
//! | 0.5 x 0.5 x 0.5 | 0.001 | 0.002 | 0.001 | 0.005 |
//! | 0.5 x 0.5 x 1 | 0.001 | 0.004 | 0.004 | 0.010 |
//! | 0.5 x 0.5 x 3 | 0.028 | 0.037 | 0.054 | 0.110 |
//!
//! Each bead is alone in its volume there; `docs/beads.md` has the errors by profile and by how many beads tell it.
//!
//! ```
//! use bead::{Dense, Search, find};
//! use geometry::{Affine, VolumeGrid};
//!
//! let unit = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
//! let grid = VolumeGrid::checked([20, 20, 20], unit)?;
//! let water = Dense::new(grid, vec![0; 8000])?;
//! assert!(find(&water, &Search::of_radius(1.0))?.beads.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accept;
mod background_field;
pub mod check;
mod detect;
mod error;
mod fit;
mod initial_height;
mod kernel;
pub mod matching;
mod optics;
mod profile;
mod profiles;
mod refine;
mod residuals;
mod search;
mod seeds;
mod special;
mod voxels;

pub use background_field::Ground;
pub use detect::{Bead, Found, Rejected, find};
pub use error::{Reason, Refused};
pub use profile::{Blur, Profile};
pub use search::Search;
pub use voxels::{Dense, DenseError, Voxels};

#[cfg(test)]
mod tests;
