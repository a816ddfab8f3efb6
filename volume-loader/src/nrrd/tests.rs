//! Headers made by hand: what must be read, and what must be refused by which name.

mod bad_files;
mod hand_made;
mod real_file;
mod round_trip;

use std::path::Path;

use super::{NrrdError, open};
use crate::raster::OpenOptions;
use crate::raster::test_files::{drink_both, file};
use crate::source::{Conversion, ReadError};

/// A header of 2 x 3 x 2 little-endian i16 in LPS, 1 mm, as lines.
const LINES: [&str; 9] = [
    "NRRD0004",
    "type: short",
    "dimension: 3",
    "space: left-posterior-superior",
    "sizes: 2 3 2",
    "space directions: (1,0,0) (0,1,0) (0,0,1)",
    "endian: little",
    "encoding: raw",
    "space origin: (0,0,0)",
];

/// [`LINES`] with the line of a field replaced, added (where it was not there) or left out (where `text` is empty), the
/// empty line at the end, and voxels.
fn hand(changes: &[&str], voxels: &[u8]) -> Vec<u8> {
    let mut lines: Vec<String> = LINES.iter().map(|line| (*line).to_owned()).collect();
    for change in changes {
        let (field, text) = change.split_once(':').unwrap();
        let place = lines.iter().position(|line| line.starts_with(&format!("{field}:")));
        match (place, text.is_empty()) {
            (Some(at), true) => drop(lines.remove(at)),
            (Some(at), false) => (*change).clone_into(&mut lines[at]),
            (None, _) => lines.push((*change).to_owned()),
        }
    }
    let mut bytes = (lines.join("\n") + "\n\n").into_bytes();
    bytes.extend(voxels);
    bytes
}

/// The voxels 0 to 11.
fn counted() -> Vec<u8> {
    (0..12_i16).flat_map(i16::to_le_bytes).collect()
}

const ASSUMED: OpenOptions = OpenOptions { assume_lps: true };

fn read(path: &Path) -> Result<(Vec<i16>, Conversion), ReadError> {
    drink_both(&mut open(path, OpenOptions::default())?)
}

fn read_bytes(bytes: &[u8]) -> Result<(Vec<i16>, Conversion), ReadError> {
    let folder = tempfile::tempdir().unwrap();
    read(&file(&folder, "hand.nrrd", bytes))
}
