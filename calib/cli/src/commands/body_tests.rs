//! The commands for markers, the base, the seat, tool definitions and the report of a pointer, on planted and real data.

mod base;
mod marker;
mod report;

use std::fs;

use geometry::rotation::Rotation;
use tempfile::TempDir;

use super::tests::{calib, shared, turn};

fn write(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}
