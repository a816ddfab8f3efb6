//! Where a marker is: from the emitters that a localizer sees to the marker's pose, with its covariance, or the reason
//! why there is none.
//!
//! The emitters of a rigid body are known in its own frame ([`Body`], the thesis's B); a localizer sees some of them, each
//! with noise that is larger along its line of sight than across it and grows with the distance ([`Localizer`]). The pose
//! of greatest likelihood under that noise is found from the closed solution of chapter 4 ([`crate::registration::fit`])
//! by a few Gauss-Newton steps with the full 3 x 3 weight of each emitter; emitters that disagree with all others are left
//! out; and a pose that could be wrong is refused ([`Lost`]): an emitter too few, residuals too large, a geometry that does
//! not hold the tip. Nothing is allocated.

mod body;
mod cloud;
mod error95;
mod localizer;
mod sighting;
mod solve;

#[cfg(test)]
mod tests;

pub use body::{Body, BodyError, Emitter};
pub use error95::radius_95_mm;
pub use localizer::{Localizer, LocalizerError};
pub use sighting::{Gates, Lost, MAX_EMITTERS, Pose, Sighting};
pub use solve::solve;
