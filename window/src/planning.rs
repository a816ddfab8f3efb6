//! The planning screen: three slices through one point and one along the planned way, targets, distances, what lies beside the way.
//!
//! Slices are those of the renderers, asked for plane by plane (`Command::look`), so that a planned slice and a navigated one are the same
//! code and the same HU. The plan is the pilot's: what a person changes here is asked of it, and what is shown is what it told.

mod asked;
mod band;
mod camera;
mod desk;
mod kept;
mod labels;
mod looks;
mod placed;
mod run;
mod screen;
mod typing;
mod volume;

pub(crate) use run::run;
