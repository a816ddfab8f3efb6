//! Why a volume is not loaded.

use std::path::PathBuf;

use bus::volume::LayoutError;
use geometry::GridError;

use crate::part::RegionError;
use crate::source::ReadError;

/// Why a volume was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file was refused.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Voxels that are no labels.
    #[error(
        "this is no label map: of its voxels {rounded} are no whole numbers, {clamped} are below -32768 or above 32767, and {not_finite} are no \
         numbers. Each would come to be another structure's label; write the map anew with whole numbers from 0 to 32767"
    )]
    NotLabels {
        /// No whole numbers.
        rounded: u64,
        /// Beyond what can be held.
        clamped: u64,
        /// No numbers.
        not_finite: u64,
    },
    /// Labels of the generated patient beside somebody else's examination.
    #[error(
        "the label map `phantom` is that of the generated patient, and the examination is {}: expected is a label map of that examination; a \
         file of this name is ./phantom", path.display()
    )]
    Generated {
        /// The examination.
        path: PathBuf,
    },
    /// The generated patient cannot be sampled like this.
    #[error("the generated patient: {0}")]
    Grid(#[from] GridError),
    /// The part that the scene asks for cannot be cut out.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The volume is too large to be laid out.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The volume does not fit into memory.
    #[error("the volume needs {needed_mib} MiB of memory, and {free_mib} MiB are free; load a smaller volume")]
    Memory {
        /// What the volume needs.
        needed_mib: u64,
        /// What there is.
        free_mib: u64,
    },
    /// The process was asked to stop.
    #[error("stopped while reading the volume")]
    Stopped,
}
