//! What the writer writes, the reader reads.

use geometry::{Affine, Point, VolumeGrid, Voxel};

use super::*;
use crate::nifti::{WriteError, write};
use crate::phantom_source::PhantomSource;

/// A source of given voxels on any grid, which can fail at a slice.
struct Given {
    grid: VolumeGrid,
    fails_at: Option<u32>,
}

impl VoxelSource for Given {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        0
    }
    fn describe(&self) -> String {
        "given".to_owned()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        if self.fails_at == Some(k) {
            return Err(ReadError::Order {
                expected: 0,
                found: k,
                count: 0,
            });
        }
        (0..).zip(out).for_each(|(i, v)| *v = i - 7 * k as i16);
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}

fn given(rows: [[f64; 4]; 3]) -> Given {
    let grid = VolumeGrid::checked([5, 4, 3], Affine::from_rows(rows)).unwrap();
    Given { grid, fails_at: None }
}

fn assert_same_place(a: &VolumeGrid, b: &VolumeGrid, tolerance_mm: f64) {
    assert_eq!(a.dims(), b.dims());
    let [nx, ny, nz] = a.dims().map(f64::from);
    for (x, y, z) in [
        (0.0, 0.0, 0.0),
        (nx, 0.0, 0.0),
        (0.0, ny, 0.0),
        (0.0, 0.0, nz),
        (nx, ny, nz),
    ] {
        let voxel = Point::<Voxel>::new(x, y, z);
        let apart = (a.ct_from_voxel() * voxel).distance(b.ct_from_voxel() * voxel);
        assert!(apart < tolerance_mm, "{apart} mm at {voxel:?}");
    }
}

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
        // f32 at 700 mm: 3e-5 mm per number, four of them.
        assert_same_place(NiftiSource::open(&path).unwrap().grid(), &source.grid, 2e-4);
        let by_qform = without_sform(&path);
        assert!(by_qform.describe().contains("qform 1"));
        assert_same_place(by_qform.grid(), &source.grid, 2e-4);
    }
}

#[test]
fn a_sheared_grid_has_no_qform() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheared.nii");
    let mut source = given([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.3, 0.0], [0.0, 0.0, 2.0, 0.0]]);
    write(&path, &mut source).unwrap();
    assert_same_place(NiftiSource::open(&path).unwrap().grid(), &source.grid, 1e-6);
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
