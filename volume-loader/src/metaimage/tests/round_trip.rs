//! What the writer writes, the reader reads.

use super::*;
use crate::metaimage::write;
use crate::phantom_source::PhantomSource;
use crate::raster::test_files::{SHEARED, TURNED, assert_same_place, given};
use crate::source::VoxelSource;
use crate::write::{WriteError, WriteOptions};

const PACKED: WriteOptions = WriteOptions { compress: true };

#[test]
fn the_patient_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let patient = PhantomSource::new(3, [6.0, 5.0, 8.0]).unwrap();
    let (want, _) = drink_both(&mut patient.clone()).unwrap();
    for (name, options, files) in [
        ("a.mha", WriteOptions::default(), 1),
        ("b.mha", PACKED, 2),
        ("c.mhd", WriteOptions::default(), 4),
        ("d.mhd", PACKED, 6),
    ] {
        let path = folder.path().join(name);
        write(&path, &mut patient.clone(), options).unwrap();
        let mut source = open(&path, OpenOptions::default()).unwrap();
        assert_eq!(source.grid(), patient.grid());
        assert_eq!(
            drink_both(&mut source).unwrap(),
            (want.clone(), Conversion::default()),
            "{name}"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files, "{name}");
    }
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
    let folder = tempfile::tempdir().unwrap();
    for name in ["old.mha", "old.mhd"] {
        let path = file(&folder, name, b"old");
        let mut source = given(TURNED[0]);
        source.fails_at = Some(2);
        let error = write(&path, &mut source, PACKED).unwrap_err();
        assert!(matches!(error, WriteError::Read { .. }), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn unwritable_names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str| {
        write(
            &folder.path().join(name),
            &mut given(TURNED[0]),
            WriteOptions::default(),
        )
        .unwrap_err()
    };
    for name in ["volume.nrrd", "mha", "a%d.mhd"] {
        assert!(matches!(refused(name), WriteError::Name { .. }), "{name}");
    }
    assert!(matches!(refused("no/such/folder/a.mhd"), WriteError::Io { .. }));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
