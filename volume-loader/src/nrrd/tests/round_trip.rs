//! What the writer writes, the reader reads.

use super::*;
use crate::nrrd::write;
use crate::phantom_source::PhantomSource;
use crate::raster::test_files::{SHEARED, TURNED, given};
use crate::source::VoxelSource;
use crate::write::{WriteError, WriteOptions};

const PACKED: WriteOptions = WriteOptions { compress: true };

#[test]
fn the_patient_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let patient = PhantomSource::new(3, [6.0, 5.0, 8.0]).unwrap();
    let (want, _) = drink_both(&mut patient.clone()).unwrap();
    for (name, options, files) in [
        ("a.nrrd", WriteOptions::default(), 1),
        ("b.nrrd", PACKED, 2),
        ("c.nhdr", WriteOptions::default(), 4),
        ("d.nhdr", PACKED, 6),
        ("c.nhdr", WriteOptions::default(), 6),
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
    let folder = tempfile::tempdir().unwrap();
    for name in ["old.nrrd", "old.nhdr"] {
        let path = file(&folder, name, b"old");
        let mut source = given(SHEARED);
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
    let refused =
        |name: &str| write(&folder.path().join(name), &mut given(SHEARED), WriteOptions::default()).unwrap_err();
    for name in ["volume.dcm", "nrrd", "a%d.nhdr", " a.nhdr"] {
        assert!(matches!(refused(name), WriteError::Name { .. }), "{name}");
    }
    assert!(matches!(refused("no/such/folder/a.nrrd"), WriteError::Io { .. }));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
