//! Series written and read again, by the library that wrote them and, where told, byte by byte.

mod refusals;
mod series;

use std::path::{Path, PathBuf};

use dicom_core::Tag;
use dicom_dictionary_std::tags;
use dicom_object::{DefaultDicomObject, open_file};
use geometry::{Affine, Ct, VolumeGrid, Voxel};

use bus::message::Marks;

use super::{Options, Syntax, write};
use crate::source::{Conversion, ReadError, Turn, VoxelSource};

/// A volume on any grid whose voxel (i, j, k) is a known number.
struct Made {
    grid: VolumeGrid,
    padding_hu: i16,
    marks: Marks,
    turn: Turn,
    /// The slice that cannot be read.
    fails_at: Option<u32>,
}

impl Made {
    fn new(dims: [i64; 3], rows: [[f64; 4]; 3]) -> Self {
        Self {
            grid: VolumeGrid::checked(dims, Affine::<Ct, Voxel>::from_rows(rows)).unwrap(),
            padding_hu: -1024,
            marks: Marks::NONE,
            turn: Turn::default(),
            fails_at: None,
        }
    }

    fn boxed() -> Self {
        Self::new(
            [7, 5, 4],
            [[0.7, 0.0, 0.0, -100.3], [0.0, 0.6, 0.0, 30.1], [0.0, 0.0, 2.5, -700.2]],
        )
    }

    fn voxel([i, j, k]: [u32; 3]) -> i16 {
        ((i * 7919 + j * 104_729 + k * 1_299_709) % 65_536) as u16 as i16
    }

    fn slice(&self, k: u32) -> Vec<i16> {
        let [nx, ny, _] = self.grid.dims();
        (0..ny)
            .flat_map(|j| (0..nx).map(move |i| Self::voxel([i, j, k])))
            .collect()
    }
}

impl VoxelSource for Made {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        self.padding_hu
    }
    fn describe(&self) -> String {
        "made".to_owned()
    }
    fn marks(&self) -> Marks {
        self.marks
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.grid, k, out)?;
        if self.fails_at == Some(k) {
            return Err(ReadError::Missing { path: "made".into() });
        }
        out.copy_from_slice(&self.slice(k));
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.grid)?;
        Ok(Conversion::default())
    }
}

/// The files of a folder, sorted by name.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

fn text(object: &DefaultDicomObject, tag: Tag) -> String {
    object.element(tag).unwrap().to_str().unwrap().into_owned()
}

fn numbers(object: &DefaultDicomObject, tag: Tag) -> Vec<f64> {
    object.element(tag).unwrap().to_multi_float64().unwrap()
}

/// The library takes all voxels for unsigned.
fn voxels(object: &DefaultDicomObject) -> Vec<i16> {
    let unsigned: Vec<u16> = object.element(tags::PIXEL_DATA).unwrap().to_multi_int().unwrap();
    unsigned.into_iter().map(|v| v as i16).collect()
}

/// Writes into a new folder, and reads each file.
fn written(mut source: Made, options: &Options) -> (tempfile::TempDir, Vec<DefaultDicomObject>) {
    let tmp = tempfile::tempdir().unwrap();
    write(&tmp.path().join("series"), &mut source, options).unwrap();
    let objects = files(&tmp.path().join("series"))
        .iter()
        .map(|f| open_file(f).unwrap())
        .collect();
    (tmp, objects)
}
