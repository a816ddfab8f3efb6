//! A real examination, where this machine has it.

use super::*;
use crate::raster::test_files::shared_file;

/// Abdomen and pelvis, stored as RAS int32.
const FILE: &str = "data/ct-abdopelvis-nifti/example_ct.nii.gz";

#[test]
fn a_real_examination_has_its_known_facts() {
    let Some(path) = shared_file(FILE) else { return };
    let mut source = NiftiSource::open(&path).unwrap();
    let grid = *source.grid();
    assert_eq!(grid.dims(), [122, 101, 112]);
    assert!(grid.spacing_mm().iter().all(|s| (s - 3.0).abs() < 1e-5), "{grid:?}");
    // Stored RAS: the first axis goes to the patient's right, the second to the front.
    let steps = [0, 1, 2].map(|axis| grid.ct_from_voxel().step(axis).mm());
    assert!(
        steps[0][0] < -2.9 && steps[1][1] < -2.9 && steps[2][2] > 2.9,
        "{steps:?}"
    );
    assert!(source.describe().contains("sform 2"), "{}", source.describe());
    let (voxels, conversion) = drink(&mut source).unwrap();
    assert_eq!((voxels.iter().min(), voxels.iter().max()), (Some(&-1207), Some(&3382)));
    assert_eq!(conversion, Conversion::default());
}
