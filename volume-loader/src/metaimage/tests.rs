//! Headers made by hand: what must be read, and what must be refused by which name.

mod bad_files;
mod hand_made;
mod round_trip;

use std::path::Path;

use super::{MetaImageError, open};
use crate::raster::OpenOptions;
use crate::raster::test_files::{ASSUMED, Format, changed, counted, file};
use crate::source::{Conversion, ReadError};

/// A header of 2 x 3 x 2 little-endian i16, 1 mm, as lines.
const LINES: [&str; 10] = [
    "ObjectType = Image",
    "NDims = 3",
    "BinaryData = True",
    "BinaryDataByteOrderMSB = False",
    "TransformMatrix = 1 0 0 0 1 0 0 0 1",
    "Offset = 0 0 0",
    "ElementSpacing = 1 1 1",
    "DimSize = 2 3 2",
    "ElementType = MET_SHORT",
    "ElementDataFile = LOCAL",
];

/// [`LINES`] with the line of a field replaced, added before the last (where it was not there) or left out (where nothing
/// follows the sign), and voxels.
fn hand(changes: &[&str], voxels: &[u8]) -> Vec<u8> {
    let head = changed(&LINES, '=', changes, 1).join("\n") + "\n";
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
    FORMAT.read_bytes("hand.mha", bytes)
}
