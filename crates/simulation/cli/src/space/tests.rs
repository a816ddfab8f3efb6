//! Scenes in space end to end: label maps that the tests write, and the one of the shipped scene.

mod maps;
mod refused;
mod shipped;
mod whole;

use std::path::Path;

use bus::volume::OwnedVolume;

/// Reads a label map as the program does.
fn read(path: &Path) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    volume_loader::load_label_map(path)
}
