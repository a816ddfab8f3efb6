//! Floor 2: scenes of organs in space, from the text of a scene file and a label map to what a simulation needs.
//!
//! Read in three steps: the raw shape ([`raw`], by [`Parsed`]), the [`Plan`] whose every value can be used, and with the
//! [`Labels`] the [`Model`]: organs as meshes, what holds them, targets, and the way of a rigid tube that presses them. Errors
//! say file, line, column, key, what was found and what is allowed.
//!
//! Lengths are mm, stresses N/mm^2, forces N. Places in the patient are LPS; a model's are in the label map's own axes
//! ([`Labels::own`] and [`Labels::patient`] go between them). Nothing is read but the text of a scene ([`read()`]) and the digest
//! of the file of a label map ([`sha`]): its voxels are handed in.
//!
//! [`Parsed`], [`read()`] and [`numbers`] serve scenes in the plane too.

pub mod body;
pub mod hold;
pub mod labels;
pub mod meeting;
pub mod model;
pub mod numbers;
pub mod plan;
mod points;
pub mod raw;
pub mod sha;
pub mod target;
#[cfg(test)]
mod tests;
pub mod text;
pub mod varied;
pub mod way;

pub use body::Body;
pub use labels::{Labels, NoLabels};
pub use meeting::{Meeting, Meetings};
pub use model::{Model, Obstacle};
pub use plan::Plan;
pub use raw::RawSpaceScene;
pub use target::Target;
pub use text::{Parsed, read};
pub use varied::Varied;
pub use way::Way;
