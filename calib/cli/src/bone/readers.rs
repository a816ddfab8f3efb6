//! Who reads volumes and label maps.

use crate::beads::{LoadLabels, LoadVolume, ReadLabelNames};

/// Handed in by the binary, as this crate knows no formats of volumes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readers {
    pub(crate) load: LoadVolume,
    pub(crate) labels: LoadLabels,
    pub(crate) label_names: ReadLabelNames,
}
