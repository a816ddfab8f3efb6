//! The examination itself: where it lies, and its HU for the pointer and for what speaks against a plan.

use bus::BusError;
use bus::message::VolumeHash;
use bus::port::{SharedVolume, VolumeSubscriber};
use geometry::{Ct, Point, VolumeGrid};
use guidance::plan::{Concern, Plan, concerns};

/// The run's examination: the first that a loader publishes.
#[derive(Debug)]
pub(crate) struct Examination {
    volumes: VolumeSubscriber,
    volume: Option<SharedVolume>,
}

impl Examination {
    pub(crate) fn new(volumes: VolumeSubscriber) -> Self {
        Self { volumes, volume: None }
    }

    /// Whether it has come with this call.
    pub(crate) fn take(&mut self) -> Result<bool, BusError> {
        if self.volume.is_some() {
            return Ok(false);
        }
        self.volume = self.volumes.poll()?;
        Ok(self.volume.is_some())
    }

    pub(crate) fn hash(&self) -> Option<VolumeHash> {
        self.volume.as_ref().map(SharedVolume::hash)
    }

    pub(crate) fn grid(&self) -> Option<&VolumeGrid> {
        self.volume.as_ref().map(SharedVolume::grid)
    }

    /// The HU of the voxel at a point.
    pub(crate) fn hu(&self, p: Point<Ct>) -> Option<i16> {
        self.volume.as_ref()?.view().nearest(p)
    }

    /// What speaks against a plan.
    pub(crate) fn concerns(&self, plan: &Plan) -> Vec<Concern> {
        let Some(volume) = &self.volume else { return Vec::new() };
        let view = volume.view();
        concerns(plan, volume.grid(), &|p| view.nearest(p))
    }
}
