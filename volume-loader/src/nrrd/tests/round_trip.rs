//! What the writer writes, the reader reads.

use super::*;
use crate::nrrd::write;
use crate::raster::test_files::{PACKED, SHEARED, TURNED, given};
use crate::source::VoxelSource;
use crate::write::WriteOptions;

#[test]
fn the_patient_comes_back_bit_for_bit() {
    let plain = WriteOptions::default();
    FORMAT.assert_the_patient_comes_back(&[
        ("a.nrrd", plain, 1),
        ("b.nrrd", PACKED, 2),
        ("c.nhdr", plain, 4),
        ("d.nhdr", PACKED, 6),
        ("c.nhdr", plain, 6),
    ]);
}

#[test]
fn every_grid_comes_back_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.nrrd");
    for rows in TURNED.into_iter().chain([SHEARED]) {
        let mut source = given(rows);
        write(&path, &mut source, WriteOptions::default()).unwrap();
        let read = open(&path, OpenOptions::default()).unwrap();
        assert_eq!(read.grid(), &source.grid);
    }
}

#[test]
fn a_failure_leaves_nothing_new_and_the_old_as_it_was() {
    FORMAT.assert_a_failure_leaves_the_old(["old.nrrd", "old.nhdr"]);
}

#[test]
fn unwritable_names_are_refused() {
    FORMAT.assert_unwritable(&["volume.dcm", "nrrd", "a%d.nhdr", " a.nhdr"], "no/such/folder/a.nrrd");
}
