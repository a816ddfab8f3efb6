//! How far a state is from the true one, in three parts that are never added up.
//!
//! Algebraic, what the search left over:
//!
//! * [`residual`]: the free forces through the tangent.
//!
//! Discretisation, the distance from an infinitely fine mesh:
//!
//! * [`Jumps`]: where a mesh is too coarse, from the state alone;
//! * [`halved`], [`taken_over`], [`corrected`]: the same body in cubes half as large, and the state there;
//! * [`Stated`]: what the difference of the two says about the error of the first.
//!
//! Model:
//!
//! * [`Spread`]: what uncertain parameters do to a place or a force, as a covariance and an ellipsoid.

mod correction;
mod halving;
mod jumps;
mod model;
mod pressed;
mod residual;
mod stated;

pub use correction::{Correction, NoCorrection, Touching, corrected};
pub use halving::{halved, taken_over};
pub use jumps::Jumps;
pub use model::{LINEAR_PART, Shift, Spread};
pub use residual::{NoResidual, Residual, Row, residual};
pub use stated::{SAFETY, Stated};
