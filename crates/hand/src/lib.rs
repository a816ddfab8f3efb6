//! Floor 2: a hand in silico. A scripted operator steers a rigid tube to a target by what a display shows, in a closed
//! loop, so that displays, noise and lag are compared by the time that it takes and by where the tip ends. No person
//! was measured: constants of people are from the literature, all in [`Human`]. Pure functions of a seed; no input or
//! output, no clock.
//!
//! # The loop
//!
//! ```text
//! she looks (0.1 s) -> decides (0.2 s) -> one minimum jerk stroke -> waits until the picture stands still -> looks ...
//!      ^                                          |
//!      |                                          v
//!   picture <- quantised <- delay + added lag <- pose with its error <- true pose, with tremor
//! ```
//!
//! * [`Task`]: an entry, a target, and how the tube stands at the beginning.
//! * [`Way`]: the tube turns about the entry and slides through it; its own roll is what the hand holds.
//! * [`Errors`]: what the measured pose is off by, and the covariance that it states.
//! * [`Reader`]: what of a display reaches the operator. [`SightReader`] has the numbers of `guidance::sight`, as
//!   coarse as they are drawn ([`Dial`]).
//! * [`Sensor`]: what measures the tube where that is not [`Errors`] but a chain of its own ([`perform_with`]).
//! * [`perform`]: one task, from the first look until she lets go.
//!
//! Lengths are millimetres, angles radians, times seconds, patient axes LPS.

mod conditions;
mod decide;
mod dial;
mod errors;
mod human;
mod reader;
mod sensor;
mod sight;
mod stroke;
mod task;
mod tremor;
mod trial;
mod tube;
mod world;

pub use conditions::Conditions;
pub use decide::{Act, Percept, decide};
pub use dial::Dial;
pub use errors::Errors;
pub use human::Human;
pub use reader::{Reader, Reading, Shown, upright_axes};
pub use sensor::{Measured, Sensor};
pub use sight::SightReader;
pub use stroke::{PEAK, Stroke, part, speed};
pub use task::{Approach, Task};
pub use tremor::Tremor;
pub use trial::{Outcome, perform, perform_with};
pub use tube::{Posture, Way};
