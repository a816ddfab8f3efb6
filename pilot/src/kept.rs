//! The run's volume, kept open for processes that start while no loader serves it.

use bus::message::VolumeHash;
use bus::port::{HandedVolume, SharedVolume};

use crate::plan::Planned;

/// The newest volume of the examination that the run began with.
#[derive(Debug, Default)]
pub(crate) struct KeptVolume {
    /// The examination, also where its memory could not be opened.
    first: Option<VolumeHash>,
    handed: Option<HandedVolume>,
}

impl KeptVolume {
    /// A loader published this one. Another examination is not shown in the middle of a run, by no process that starts later either.
    pub(crate) fn published(&mut self, volume: &SharedVolume) {
        if *self.first.get_or_insert(volume.hash()) != volume.hash() {
            return;
        }
        // A loader that has died already leaves nothing to open: what is kept stays.
        self.handed = volume.hand_on().or(self.handed.take());
    }

    /// What `planned` is given when it starts. A loader reads no voxels and would only keep their memory.
    pub(crate) fn for_process(&self, planned: &Planned) -> Option<&HandedVolume> {
        let reads = planned.name != "volume-loader";
        self.handed.as_ref().filter(|_| reads)
    }
}
