//! How far a state is from that of an infinitely fine mesh.
//!
//! * [`Jumps`]: where a mesh is too coarse, from the state alone;
//! * [`halved`], [`taken_over`], [`corrected`]: the same body in cubes half as large, and the state there;
//! * [`Stated`]: what the difference of the two says about the error of the first.

mod correction;
mod halving;
mod jumps;
mod pressed;
mod stated;

pub use correction::{Correction, NoCorrection, Touching, corrected};
pub use halving::{halved, taken_over};
pub use jumps::Jumps;
pub use stated::{SAFETY, Stated};
