//! Scenes in space end to end: label maps that the tests write, and the one of the shipped scene.

mod contacts;
mod errors;
mod kept;
pub(super) mod maps;
mod refused;
mod shipped;
mod whole;
mod wide;

/// Reads a label map as the program does.
pub(super) const READ: super::ReadLabels = volume_loader::load_label_map;
