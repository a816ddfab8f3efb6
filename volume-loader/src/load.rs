//! From a scene's volume, or a path, to a source of voxels.

use std::path::Path;

use bus::run::free_memory_bytes;
use bus::scene::VolumeSource;
use bus::volume::{Layout, OwnedVolume};

use crate::error::LoadError;
use crate::fill::fill;
use crate::nifti::NiftiSource;
use crate::phantom_source::PhantomSource;
use crate::source::VoxelSource;

/// Opens the source of a scene's volume; `seed` is the generated patient's.
///
/// # Errors
/// [`LoadError::Read`], [`LoadError::Grid`].
pub fn open(volume: &VolumeSource, seed: u64) -> Result<Box<dyn VoxelSource>, LoadError> {
    Ok(match volume {
        VolumeSource::Phantom { spacing_mm } => Box::new(PhantomSource::new(seed, [*spacing_mm; 3])?),
        VolumeSource::File(path) => Box::new(NiftiSource::open(path)?),
    })
}

/// Reads a file into this process's own memory; the path `phantom` is the generated patient of seed 1.
///
/// # Errors
/// [`LoadError`].
pub fn load(path: &Path) -> Result<OwnedVolume, Box<dyn std::error::Error + Send + Sync>> {
    Ok(load_owned(path)?)
}

fn load_owned(path: &Path) -> Result<OwnedVolume, LoadError> {
    let volume = match path.to_str() {
        Some("phantom") => VolumeSource::Phantom {
            spacing_mm: phantom::DEFAULT_SPACING_MM[0],
        },
        _ => VolumeSource::File(path.to_owned()),
    };
    let mut source = open(&volume, 1)?;
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
