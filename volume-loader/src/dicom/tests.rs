//! Files made by hand, element by element: what must be read, and what must be refused by which name.

mod enhanced;
mod entries;
mod fragments;
mod headers;
mod hostile;
mod mixed;
mod order;
mod patient;
mod pixels;
mod places;
mod real_sets;
mod series;
mod sides;
mod whose;
pub(crate) mod writer;

use std::path::{Path, PathBuf};

use super::{DicomError, DicomSource, FileError, Options, Series};
use crate::source::{Conversion, ReadError, Scratch, SliceReader, VoxelSource};
use writer::{File, Value};

/// A folder of files, taken away at the end.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With these files, named so that names say nothing of the order.
    fn of(files: &[File]) -> Self {
        let folder = Self::new();
        for (i, file) in files.iter().enumerate() {
            folder.put(&format!("{:03}.dcm", (i * 37 + 11) % 101), &file.bytes());
        }
        folder
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path().join(name), bytes).unwrap();
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn open_with(&self, options: Options) -> Result<DicomSource, DicomError> {
        DicomSource::open(&Series::scan(self.path())?.choose(None)?, options)
    }

    fn open(&self) -> Result<DicomSource, DicomError> {
        self.open_with(Options::default())
    }

    fn refused(&self) -> String {
        self.open().unwrap_err().to_string()
    }

    fn refused_file(&self) -> FileError {
        match self.open().map(|_| ()) {
            Err(DicomError::File { source, .. }) => source,
            other => panic!("expected a refused file, found {other:?}"),
        }
    }
}

/// A stack of `count` slices, 2.5 mm apart, each with its own pixels.
fn stack(count: usize) -> Vec<File> {
    (0..count).map(|k| File::slice(k, 2.5 * k as f64)).collect()
}

/// Every slice in order, then the end.
fn drink(source: &mut DicomSource) -> Result<(Vec<i16>, Conversion), ReadError> {
    let [nx, ny, nz] = source.grid().dims();
    let slice = nx as usize * ny as usize;
    let mut voxels = vec![0; slice * nz as usize];
    for (k, out) in voxels.chunks_mut(slice).enumerate() {
        source.read_slice(k as u32, out)?;
    }
    Ok((voxels, source.finish()?))
}

/// The real examinations, where this machine has them.
fn shared(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("TROCAR_SHARED").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"));
    let path = folder.join("data").join(name);
    if !path.is_dir() {
        let path = path.display();
        println!("skipped: {path} is not there; TROCAR_SHARED names the folder that holds data/");
        return None;
    }
    Some(path)
}
