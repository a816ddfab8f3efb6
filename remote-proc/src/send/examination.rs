//! The examination that the run shows.
//!
//! A loader may have come back with another one, which the run's renderers do not show; who looks on from outside sees only what the
//! loader published last. So it is asked of the renderers: their images say which examination they are of.

use bus::message::{FrameStamp, VolumeHash, VolumeHeader};
use bus::port::{Subscriber, VolumeSubscriber};
use bus::topic::FRAME_STAMP;
use bus::{Bus, BusError};
use scene::Scene;

/// What the run's images show, and what the loader has.
pub(super) struct Shown {
    stamps: Vec<Subscriber<FrameStamp>>,
    volumes: VolumeSubscriber,
    /// Of the images.
    shown: Option<VolumeHash>,
    /// The loader's newest.
    loaded: Option<VolumeHeader>,
    is_told: bool,
    is_warned: bool,
}

impl Shown {
    pub(super) fn open(bus: &Bus, scene: &Scene) -> Result<Self, BusError> {
        let renderers = scene.renderers();
        let stamps = renderers
            .iter()
            .map(|(plane, _)| Subscriber::open(bus, &FRAME_STAMP, &plane.process(), 1));
        Ok(Self {
            stamps: stamps.collect::<Result<_, _>>()?,
            volumes: VolumeSubscriber::open(bus)?,
            shown: None,
            loaded: None,
            is_told: false,
            is_warned: false,
        })
    }

    /// The header of the examination, once: when the loader has what the images show.
    pub(super) fn new_header(&mut self) -> Result<Option<VolumeHeader>, BusError> {
        if self.is_told {
            return Ok(None);
        }
        for stamps in &self.stamps {
            self.shown = stamps.newest()?.map(|stamp| stamp.volume()).or(self.shown);
        }
        if let Some(volume) = self.volumes.poll()? {
            self.loaded = Some(*volume.header());
        }
        let (Some(shown), Some(loaded)) = (self.shown, self.loaded) else {
            return Ok(None);
        };
        self.is_told = loaded.volume_hash() == shown;
        if !self.is_told && !self.is_warned {
            self.is_warned = true;
            bus::stderr_line!(
                "remote-proc: error: the run shows the examination {shown}, and its loader has {} by now: none is sent",
                loaded.volume_hash()
            );
        }
        Ok(self.is_told.then_some(loaded))
    }
}
