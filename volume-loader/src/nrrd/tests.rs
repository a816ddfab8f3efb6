//! Headers made by hand: what must be read, and what must be refused by which name.

mod bad_files;
mod hand_made;
mod real_file;
mod round_trip;

use std::path::Path;

use super::{NrrdError, open};
use crate::raster::OpenOptions;
use crate::raster::test_files::{ASSUMED, Format, changed, counted, drink_both, file};
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
    let head = changed(&LINES, ':', changes, 0).join("\n") + "\n\n";
    [head.as_bytes(), voxels].concat()
}

const FORMAT: Format = Format {
    write: super::write,
    open,
};

fn read(path: &Path) -> Result<(Vec<i16>, Conversion), ReadError> {
    FORMAT.read(path)
}

fn read_bytes(bytes: &[u8]) -> Result<(Vec<i16>, Conversion), ReadError> {
    FORMAT.read_bytes("hand.nrrd", bytes)
}
