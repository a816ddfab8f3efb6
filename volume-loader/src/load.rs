//! From a scene's volume to a source of voxels.

use bus::run::free_memory_bytes;
use bus::scene::{FileSpec, VolumeSource, VolumeSpec};
use bus::volume::{Layout, OwnedVolume};

use crate::error::LoadError;
use crate::fill::fill;
use crate::nifti::NiftiSource;
use crate::part::part;
use crate::phantom_source::PhantomSource;
use crate::source::{ReadError, VoxelSource};

/// Opens the source of a scene's volume, or of its part; `seed` is the generated patient's.
///
/// # Errors
/// [`LoadError::Read`], [`LoadError::Grid`], [`LoadError::Region`].
pub fn open(spec: &VolumeSpec, seed: u64) -> Result<Box<dyn VoxelSource>, LoadError> {
    let source: Box<dyn VoxelSource> = match &spec.source {
        VolumeSource::Phantom { spacing_mm } => Box::new(PhantomSource::new(seed, [*spacing_mm; 3])?),
        VolumeSource::File(file) => open_file(file)?,
    };
    Ok(part(source, spec)?)
}

fn open_file(file: &FileSpec) -> Result<Box<dyn VoxelSource>, ReadError> {
    Ok(Box::new(NiftiSource::open(&file.path)?))
}

/// Reads an examination into this process's own memory; the generated patient is that of seed 1.
///
/// # Errors
/// [`LoadError`].
pub fn load(spec: &VolumeSpec) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    Ok(load_owned(spec)?)
}

fn load_owned(spec: &VolumeSpec) -> Result<OwnedVolume, LoadError> {
    let mut source = open(spec, 1)?;
    let grid = *source.grid();
    let layout = Layout::choose(grid.dims())?;
    let padding_hu = source.padding_hu();
    check_memory(layout.stored() * 2)?;
    let mut voxels = vec![0; layout.stored() as usize];
    let filled = fill(source.as_mut(), &layout, &mut voxels, |_| true)?;
    Ok(OwnedVolume {
        grid,
        layout,
        voxels,
        padding_hu,
        hash: filled.hash,
        marks: source.marks(),
    })
}

/// A header may promise more than any machine holds: asked before anything is allocated.
fn check_memory(bytes: u64) -> Result<(), LoadError> {
    match free_memory_bytes() {
        Some(free) if free < bytes => Err(LoadError::Memory {
            needed_mib: bytes.div_ceil(1 << 20),
            free_mib: free >> 20,
        }),
        _ => Ok(()),
    }
}
