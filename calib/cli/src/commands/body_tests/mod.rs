//! The commands for markers, the base, the seat, tool definitions and the report of a pointer, on planted and real data.

mod base;
mod marker;
mod report;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use geometry::rotation::{Rotation, RotationVector};
use tempfile::TempDir;

use super::Outcome;
use crate::cli::{Cli, run};

fn calib(line: &str) -> Result<Outcome, String> {
    run(Cli::try_parse_from(line.split(' ')).map_err(|error| error.to_string())?)
}

/// Real files beside the working tree; `None`, with the reason said, where they are not there.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if !path.exists() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    Some(path)
}

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

fn write(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}
