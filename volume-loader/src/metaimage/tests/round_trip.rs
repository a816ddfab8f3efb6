//! What the writer writes, the reader reads.

use super::*;
use crate::WriteError;
use crate::metaimage::write;
use crate::raster::test_files::{PACKED, SHEARED, TURNED, assert_same_place, given};
use crate::source::VoxelSource;
use crate::write::WriteOptions;

#[test]
fn the_patient_comes_back_bit_for_bit() {
    let plain = WriteOptions::default();
    let cases = [
        ("a.mha", plain, 1),
        ("b.mha", PACKED, 2),
        ("c.mhd", plain, 4),
        ("d.mhd", PACKED, 6),
    ];
    FORMAT.assert_the_patient_comes_back(&cases);
}

#[test]
fn every_grid_at_right_angles_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.mha");
    for rows in TURNED {
        let mut source = given(rows);
        write(&path, &mut source, PACKED).unwrap();
        let read = open(&path, OpenOptions::default()).unwrap();
        assert_same_place(read.grid(), &source.grid, 1e-14);
    }
}

#[test]
fn a_tilted_gantry_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "old.mha", b"old");
    let error = write(&path, &mut given(SHEARED), PACKED).unwrap_err();
    let WriteError::Sheared {
        axes: [1, 2], degrees, ..
    } = error
    else {
        panic!("{error}");
    };
    assert!((degrees - 77.005_383).abs() < 1e-3, "{degrees}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_failure_leaves_nothing_new_and_the_old_as_it_was() {
    FORMAT.assert_a_failure_leaves_the_old(["old.mha", "old.mhd"]);
}

#[test]
fn unwritable_names_are_refused() {
    FORMAT.assert_unwritable(&["volume.nrrd", "mha", "a%d.mhd"], "no/such/folder/a.mhd");
}
