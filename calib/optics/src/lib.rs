//! Floor 1: targets in images, and the cameras that see them.
//!
//! Pure numerics: no file, no clock, no process. Chapter 5 of part III of the thesis is [`disc`] and [`grid`], which take a
//! [`mod@image`]; [`shell`] looks for spherical markers in slices; [`camera`] calibrates a camera from views of a grid.

pub mod camera;
pub mod disc;
pub mod grid;
pub mod image;
pub mod shell;
