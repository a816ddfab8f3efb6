//! Floor 2: the surface of a bone from a CT.

mod components;
mod error;
mod extract;
mod fill;
mod model;
mod normal;
mod optics;
mod patch;
mod quadric;
mod region;
mod result;
mod scanner;
mod shell;
mod solve;
mod voxels;

pub use components::Component;
pub use error::Refused;
pub use extract::{Options, Progress, extract};
pub use patch::Lost;
pub use region::{Cut, IsLabelled, Region};
pub use result::{Bone, Place, ScannerFound};
pub use shell::MOST_TRIANGLES;
pub use voxels::{VoxelBox, Voxels};
