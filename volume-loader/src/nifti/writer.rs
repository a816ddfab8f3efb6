//! Any examination to a NIfTI-1 file: i16, HU as they are, sform always and qform where it can say the same.
//!
//! The header holds f32: places are true to 1e-7 of the volume's distance from the origin, 0.00003 mm for a patient.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::{Compression, write::GzEncoder};
use geometry::VolumeGrid;

use super::orientation::ras_forms;
use crate::source::{Conversion, ReadError, VoxelSource};

/// The header and the four bytes that announce no extension.
const HEADER_BYTES: usize = 352;
/// Scanner coordinates; both forms mean the same.
const SCANNER: i16 = 1;

/// Why a file was not written. Nothing is left of it then, and what was at its path before is still there.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The name ends in neither `.nii` nor `.nii.gz`.
    #[error("{}: expected a name that ends in .nii or .nii.gz", path.display())]
    Name {
        /// The path.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// The path.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The examination could not be read.
    #[error("{}: not written: {source}", path.display())]
    Read {
        /// The path.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
}

/// Writes every slice of `source` to `path`, `.nii` or `.nii.gz` by its ending, and gives what `source` changed.
///
/// The file is written under another name in the same folder and renamed when it is whole.
///
/// # Errors
/// Each variant of [`WriteError`].
pub fn write(path: &Path, source: &mut dyn VoxelSource) -> Result<Conversion, WriteError> {
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    let gzip = name.ends_with(".nii.gz");
    if !gzip && !name.ends_with(".nii") {
        return Err(WriteError::Name { path: path.to_owned() });
    }
    let partial = Partial::create(path, name)?;
    let file = BufWriter::new(partial.file.try_clone().map_err(io(path, "write it"))?);
    let conversion = if gzip {
        let mut encoder = GzEncoder::new(file, Compression::fast());
        let conversion = write_volume(path, &mut encoder, source)?;
        let mut file = encoder.finish().map_err(io(path, "write its end"))?;
        file.flush().map_err(io(path, "write its end"))?;
        conversion
    } else {
        let mut file = file;
        let conversion = write_volume(path, &mut file, source)?;
        file.flush().map_err(io(path, "write its end"))?;
        conversion
    };
    partial.rename(path)?;
    Ok(conversion)
}

fn io(path: &Path, doing: &'static str) -> impl Fn(std::io::Error) -> WriteError {
    move |source| WriteError::Io {
        path: path.to_owned(),
        doing,
        source,
    }
}

fn write_volume(path: &Path, out: &mut dyn Write, source: &mut dyn VoxelSource) -> Result<Conversion, WriteError> {
    let read = |source| WriteError::Read {
        path: path.to_owned(),
        source,
    };
    let grid = *source.grid();
    out.write_all(&header(&grid)).map_err(io(path, "write its header"))?;
    let [nx, ny, nz] = grid.dims();
    let mut slice = vec![0_i16; nx as usize * ny as usize];
    let mut bytes = Vec::with_capacity(2 * slice.len());
    for k in 0..nz {
        source.read_slice(k, &mut slice).map_err(read)?;
        bytes.clear();
        bytes.extend(slice.iter().flat_map(|v| v.to_le_bytes()));
        out.write_all(&bytes).map_err(io(path, "write its voxels"))?;
    }
    source.finish().map_err(read)
}

/// A NIfTI-1 header, little-endian, in RAS and mm.
fn header(grid: &VolumeGrid) -> [u8; HEADER_BYTES] {
    let mut bytes = [0; HEADER_BYTES];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    let forms = ras_forms(&grid.ct_from_voxel(), grid.spacing_mm());
    let (quaternion, qfac) = forms.quaternion_bcd_qfac.unwrap_or(([0.0; 3], 1.0));
    put(0, &348_i32.to_le_bytes());
    put(40, &3_i16.to_le_bytes());
    put(76, &(qfac as f32).to_le_bytes());
    for (i, (dim, spacing)) in grid.dims().into_iter().zip(grid.spacing_mm()).enumerate() {
        // A checked grid has at most 16384 voxels along an axis.
        put(42 + 2 * i, &(dim as i16).to_le_bytes());
        put(80 + 4 * i, &(spacing as f32).to_le_bytes());
        put(256 + 4 * i, &(quaternion[i] as f32).to_le_bytes());
        put(268 + 4 * i, &(forms.srow[i][3] as f32).to_le_bytes());
        for (c, value) in forms.srow[i].into_iter().enumerate() {
            put(280 + 16 * i + 4 * c, &(value as f32).to_le_bytes());
        }
    }
    // Further dimensions have length 1.
    (3..7).for_each(|i| put(42 + 2 * i, &1_i16.to_le_bytes()));
    put(70, &4_i16.to_le_bytes());
    put(72, &16_i16.to_le_bytes());
    put(108, &(HEADER_BYTES as f32).to_le_bytes());
    put(112, &1.0_f32.to_le_bytes());
    // Millimetres.
    put(123, &[2]);
    let qform = if forms.quaternion_bcd_qfac.is_some() {
        SCANNER
    } else {
        0
    };
    put(252, &qform.to_le_bytes());
    put(254, &SCANNER.to_le_bytes());
    put(344, b"n+1\0");
    bytes
}

/// A file under a name of its own, removed again unless it is renamed.
struct Partial {
    file: File,
    path: PathBuf,
    done: bool,
}

impl Partial {
    fn create(target: &Path, name: &str) -> Result<Self, WriteError> {
        // Two writers of one process, and of two, never share a name.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = target.with_file_name(format!(".{name}.{}-{count}.part", std::process::id()));
        let file = OpenOptions::new().write(true).create_new(true).open(&path);
        let file = file.map_err(io(target, "make a new file beside it"))?;
        Ok(Self {
            file,
            path,
            done: false,
        })
    }

    fn rename(mut self, target: &Path) -> Result<(), WriteError> {
        self.file.sync_all().map_err(io(target, "bring it to the disk"))?;
        std::fs::rename(&self.path, target).map_err(io(target, "give it its name"))?;
        self.done = true;
        Ok(())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.done {
            // Nobody is left to tell: the first failure is already on its way up.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
