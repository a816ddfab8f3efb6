//! Why a volume is not loaded.

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
