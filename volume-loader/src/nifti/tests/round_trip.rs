//! What the writer writes, the reader reads.

use super::*;
use crate::nifti::{WriteError, write};
use crate::phantom_source::PhantomSource;
use crate::raster::test_files::{assert_same_place, given};

#[test]
fn the_patient_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut patient = PhantomSource::new(3, [6.0, 5.0, 8.0]).unwrap();
    let (want, _) = drink(&mut patient.clone()).unwrap();
    for name in ["patient.nii", "patient.nii.gz"] {
        let path = folder.path().join(name);
        write(&path, &mut patient.clone()).unwrap();
        let mut source = NiftiSource::open(&path).unwrap();
        // These numbers are whole or halves: exact in f32.
        assert_same_place(source.grid(), patient.grid(), 1e-12);
        assert_eq!(drink(&mut source).unwrap(), (want.clone(), Conversion::default()));
    }
    patient.finish().unwrap_err();
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

/// Turns the sform off, so that the qform alone is read.
fn without_sform(path: &Path) -> NiftiSource {
    let mut bytes = std::fs::read(path).unwrap();
    bytes[254..256].fill(0);
    std::fs::write(path, bytes).unwrap();
    NiftiSource::open(path).unwrap()
}

#[test]
fn sform_and_qform_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.nii");
    let (c, s) = (0.8, 0.6);
    let turned = [
        [
            [c * 2.0, -s * 3.0, 0.0, -120.5],
            [s * 2.0, c * 3.0, 0.0, 33.3],
            [0.0, 0.0, 4.0, 700.1],
        ],
        [
            [c * 2.0, s * 3.0, 0.0, 1.0],
            [s * 2.0, -c * 3.0, 0.0, 2.0],
            [0.0, 0.0, 4.0, 3.0],
        ],
        [[0.0, 0.0, -4.0, 1.0], [-2.0, 0.0, 0.0, 2.0], [0.0, 3.0, 0.0, 3.0]],
        [[-2.0, 0.0, 0.0, 0.0], [0.0, -3.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0]],
        [[2.0, 0.0, 0.0, 0.0], [0.0, -3.0, 0.0, 0.0], [0.0, 0.0, -4.0, 0.0]],
    ];
    for rows in turned {
        let mut source = given(rows);
        write(&path, &mut source).unwrap();
        // Four numbers in f32, each true to 6e-8 of itself, none larger than the distance.
        assert_same_place(NiftiSource::open(&path).unwrap().grid(), &source.grid, 2.4e-7);
        let by_qform = without_sform(&path);
        assert!(by_qform.describe().contains("qform 1"));
        assert_same_place(by_qform.grid(), &source.grid, 2.4e-7);
    }
}

#[test]
fn a_half_turn_by_qform_is_one_after_f32() {
    // Axes x and z exchanged: (0, b, 0, d) with b = d = 0.70710677, whose squares leave 8e-8 for a: 0.57 mrad, 0.2 mm over 400 mm.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.nii");
    let mut source = given([[0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]);
    write(&path, &mut source).unwrap();
    let by_qform = without_sform(&path);
    for axis in 0..3 {
        let apart = by_qform.grid().ct_from_voxel().step(axis) - source.grid.ct_from_voxel().step(axis);
        assert!(apart.norm() < 1e-7, "axis {axis} is {} off", apart.norm());
    }
}

#[test]
fn a_sheared_grid_has_no_qform() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheared.nii");
    let mut source = given([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.3, 0.0], [0.0, 0.0, 2.0, 0.0]]);
    write(&path, &mut source).unwrap();
    assert_same_place(NiftiSource::open(&path).unwrap().grid(), &source.grid, 2.4e-7);
    assert_eq!(std::fs::read(&path).unwrap()[252..256], [0, 0, 1, 0]);
}

#[test]
fn a_failure_leaves_nothing_new_and_the_old_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "old.nii.gz", b"old");
    let mut source = given([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]);
    source.fails_at = Some(2);
    assert!(matches!(write(&path, &mut source), Err(WriteError::Read { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn unwritable_names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut source = given([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]);
    let mut refused = |name: &str| write(&folder.path().join(name), &mut source).unwrap_err();
    assert!(matches!(refused("volume.dcm"), WriteError::Name { .. }));
    assert!(matches!(refused("no/such/folder/volume.nii"), WriteError::Io { .. }));
}
