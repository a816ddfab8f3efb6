//! The slice renderer: one process per plane direction, drawing that direction's global and local images; and the overview, whose
//! direction is `surface`.
//!
//! A pose comes in over the bus, [`plane`] says which plane of the patient each image shows, [`reslice`] samples
//! the shared volume there, [`to_grey`] turns HU into grey, [`Overlay`] draws the tube, the targets and the words, and the
//! image goes out with its stamp. In the place of a plane, the overview has a [`scene::Surface::camera`] and the examination's [`Anatomy`]. What is shown is never older than it says.

mod accuracy;
pub mod cli;
mod grey;
mod guide;
mod mha;
mod output;
mod outside;
mod overlay;
mod overview;
mod remarks;
mod render;
pub mod reslice;
mod run;
mod shot;
mod snapshot;
mod stride;
pub mod tissue;
mod view;
pub mod warp;

pub use accuracy::Accuracy;
pub use geometry::letters;
pub use grey::to_grey;
pub use mha::{MhaError, write_mha};
pub use overlay::{NEAR_PLANE_MM, Notice, Origin, Overlay};
pub use overview::{Anatomy, LabelFile, LoadLabels, LoadVolume, OtherLabels};
pub use render::{RenderError, Rendered, Renderer};
pub use run::RunError;
pub use snapshot::{At, LoadRecorded, Recorded, RecordedError, RecordedMesh, RecordedState, SnapshotError};
pub use view::plane;
