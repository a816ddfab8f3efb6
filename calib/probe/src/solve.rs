//! From a start to the minimum below it: the image's place, sizes of pixels, and what else is asked for.
//!
//! With `(u, v)` a pixel, `(u0, v0)` the middle of all, `(R, t)` the place of that middle in the probe, `X` the pose
//! of the probe in the
//! reference, `D` a linear error of the tracker about the middle `c` of all poses, `(w, m)` a motion of the phantom:
//!
//! ```text
//! x = R ((u - u0) s_u, (v - v0) s_v, 0) + t
//! y = X x + D (t_X - c)                                                                                          (1)
//! r = E' (exp(w) (P y) + m - a)        of a wire at a, E two directions across it
//! r = n' y - d                         of a wall
//! ```
//!
//! Minimised is the sum of `r' V^-1 r`, Tukey's biweight of each point, and what is known before. `V` has each
//! point's own noise and
//! the error of the pose, which all points of a frame share: nine points of one frame do not tell nine times as much
//! of where the
//! frame is. The pose's six errors are unknowns with a prior, eliminated frame by frame.

mod frame;
mod options;
mod problem;
mod state;
#[cfg(test)]
mod tests;

pub(crate) use frame::{Data, Posed, Poses};
pub use options::{Options, PointNoise, PoseNoise, Priors};
pub(crate) use problem::{Ended, MEDIAN_CHI2_1, Solver};
pub(crate) use state::{Layout, State, Wall, unskewed};
