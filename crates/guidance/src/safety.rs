//! The safety distance: how far a tube stays from each structure of a label map along its way.
//!
//! # Definitions
//!
//! A label map gives each voxel of a grid the number of a structure, or 0. The tube is a solid cylinder of radius `r` with flat ends,
//! from the entry `e` along the unit axis `a` for the length `L`. With the depth `t = a . (p - e)` and the distance `s` from the axis, its
//! signed distance function is
//!
//! ```text
//! phi(p) = max(s - r, abs(t - L / 2) - L / 2)                               where one of the two is not above zero        (1)
//! phi(p) = hypot(s - r, abs(t - L / 2) - L / 2)                             elsewhere
//! distance = min phi(c)                                                     over the centres c of a structure's voxels    (2)
//! ```
//!
//! (2) is exact, and no interpolation of a distance field: [`Structures::clearance`]. Along the way, [`Structures::profile`] gives the
//! same for parts of the tube.
//!
//! # What may be said of a patient
//!
//! A structure is the cells of its voxels, not their centres. As (1) changes by no more than one moves, a cell is nearer than its
//! centre by at most half its diagonal: [`Clearance::at_least_mm`] subtracts that, and the predicted error of the tube. Where
//! (2) is not above half a diagonal the tube may cut the structure, and [`Clearance::cuts`] says where it does for certain. Where the
//! tube leaves the map's field it is NOT CHECKED: [`Coverage`]. What the map has wrong or leaves out is in no number.
//!
//! # Index
//!
//! For each label and each block of 8 x 8 x 8 voxels that holds it, two sets of 512 bits say which voxels have it, and which of
//! them lie at the structure's boundary, that is have one of their six neighbours of another label. Farther from the tube than a length
//! of the grid (for right angles half a voxel's diagonal) the nearest voxel of a structure is one of its boundary; nearer, all are looked
//! at. A ball about a block bounds (1) from both sides, and what cannot be nearest is never looked at.

mod block;
mod build;
mod clearance;
mod coverage;
mod grids;
mod lattice;
mod names;
mod placed;
mod profile;
mod refusal;
mod search;
mod sections;
mod slab;
mod structures;
mod tube;
mod window;

pub use build::{Builder, MAX_BYTES, MAX_SLICE_VOXELS};
pub use clearance::{Clearance, Clearances, Distance, Nearest};
pub use coverage::Coverage;
pub use grids::GridMatch;
pub use names::{LabelNames, MAX_NAME, MAX_NAMES, NamesError};
pub use profile::{MAX_SECTIONS, Section};
pub use refusal::{Input, MapError, TubeError};
pub use structures::{Structure, Structures};
pub use tube::{MAX_COORDINATE_MM, MAX_LENGTH_MM, MIN_LENGTH_MM, Tube};
