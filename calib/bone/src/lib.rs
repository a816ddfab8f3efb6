//! Floor 2: the surface of a bone from a CT, to register with: each corner with its deviation.
//!
//! Pure numerics: no file, no clock, no process. Lengths are mm, places left, posterior, superior. The same input gives the same bits,
//! however many threads there are.
//!
//! | step | where |
//! |---|---|
//! | voxels above a threshold, as bodies that hang together; which one is meant, joints cut | [`Region`], [`Cut`] |
//! | marrow filled, the outer surface by surface nets, where the CT or the region ends | `fill`, `shell` |
//! | normal and curvature at each corner, by a quadric through those around it | `quadric` |
//! | the voxels about it, up to what rises behind or before it | `patch` |
//! | tissue, cortex and inside, blurred, fitted to them; by nearness to the smooth surface, without interpolation | `model`, `solve` |
//! | blur, kurtosis, cortex's HU and thickness, noise: what all places share, from 400 of them | `scanner` |
//! | contrast medium fitted instead of cortex; where it does as well no cortex is seen, where it does better there is none | [`Contrast`], [`Sight`] |
//! | corners without a position of their own left out, and why | [`Lost`], [`Bone`] |
//!
//! The threshold decides the topology and nothing else: it lies 0.5 to 1.7 mm outside the bone. The deviation of a place has its voxels'
//! noise, with its correlation; what the model leaves there beyond the noise; 3 % of the blur for what no model has; and, as a number of
//! its own, what all places share: the errors of blur and cortex.
//!
//! ```
//! use bone::{Options, Refused, Region, Voxels, extract};
//! use geometry::{Affine, VolumeGrid};
//!
//! struct Water(VolumeGrid);
//! impl Voxels for Water {
//!     fn grid(&self) -> &VolumeGrid {
//!         &self.0
//!     }
//!     fn row(&self, _y: u32, _z: u32, out: &mut [i16]) {
//!         out.fill(0);
//!     }
//! }
//! let unit = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
//! let water = Water(VolumeGrid::checked([20, 20, 20], unit)?);
//! let refused = extract(&water, &Options::of(Region::Only)).unwrap_err();
//! assert!(matches!(refused, Refused::NoBone { brightest: 0, .. }));
//! # Ok::<(), geometry::GridError>(())
//! ```

mod component;
mod components;
mod contrast;
mod enclosed;
mod error;
mod extract;
mod fill;
mod gaps;
mod islands;
mod model;
mod normal;
mod optics;
mod patch;
mod place;
mod quadric;
mod region;
mod result;
mod scanner;
mod shell;
mod sight;
mod solve;
mod uneven;
mod voxels;

pub use component::Component;
pub use contrast::Contrast;
pub use error::Refused;
pub use extract::{Options, Progress, extract};
pub use patch::Lost;
pub use place::{Place, Sight};
pub use region::{Cut, IsLabelled, Region};
pub use result::{Bone, ScannerFound};
pub use shell::MOST_TRIANGLES;
pub use sight::Bare;
pub use voxels::{VoxelBox, Voxels};
