//! Real files, where this machine has them.

use super::*;
use crate::raster::test_files::shared_file;
use crate::source::VoxelSource;

#[test]
fn a_tooth_without_orientation_is_read_only_when_asked() {
    let Some(path) = shared_file("data/vol-small-nrrd-mha/tooth.nhdr") else {
        return;
    };
    let refusal = open(&path, OpenOptions::default()).map(|_| ()).unwrap_err();
    let ReadError::Nrrd {
        source: NrrdError::NoOrientation { .. },
        ..
    } = &refusal
    else {
        panic!("{refusal}");
    };
    // Its free text is not repeated.
    assert!(!refusal.to_string().contains("splice"));
    let mut source = open(&path, ASSUMED).unwrap();
    assert_eq!(source.grid().dims(), [103, 94, 161]);
    assert_eq!(source.grid().spacing_mm(), [1.0; 3]);
    assert!(!source.describe().contains("splice"), "{}", source.describe());
    let (voxels, conversion) = drink_both(&mut source).unwrap();
    assert_eq!(conversion, Conversion::default());
    // Big-endian: the first bytes of the file say so themselves.
    let bytes = std::fs::read(path.with_file_name("tooth.raw")).unwrap();
    for (at, voxel) in voxels.iter().enumerate() {
        assert_eq!(
            u16::from_be_bytes([bytes[2 * at], bytes[2 * at + 1]]),
            *voxel as u16,
            "voxel {at}"
        );
    }
}

#[test]
fn a_tiny_patient_has_its_known_facts() {
    let Some(path) = shared_file("data/vol-small-nrrd-mha/TinyPatientCT.nrrd") else {
        return;
    };
    let mut source = open(&path, OpenOptions::default()).unwrap();
    let grid = *source.grid();
    assert_eq!(grid.dims(), [10; 3]);
    let want = [
        [49.000_000_000_000_014, 0.0, 0.0, -248.843_993_164_062_5],
        [0.0, 49.000_000_000_000_014, 0.0, -248.289_001_464_843_75],
        [0.0, 0.0, 23.000_000_000_000_004, -123.75],
    ];
    for (found, want) in grid.ct_from_voxel().rows().iter().flatten().zip(want.iter().flatten()) {
        assert!((found - want).abs() < 2e-3, "{found} {want}");
    }
    assert_eq!(drink_both(&mut source).unwrap().0.len(), 1000);
}
