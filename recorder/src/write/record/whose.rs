//! Whose examination it is, for a recording that is asked to say so.

use bus::message::{Identity, VolumeHash};
use bus::port::Subscriber;
use bus::topic::IDENTITY;
use bus::{Bus, BusError};

use crate::wire::proto;
use crate::write::series::Series;

/// What was heard of it.
#[derive(Debug)]
pub(super) struct Whose {
    port: Subscriber<Identity>,
    heard: Heard,
}

/// The newest that came, and the newest that was written.
#[derive(Debug, Default)]
struct Heard {
    came: Option<Identity>,
    written: Option<Identity>,
}

impl Whose {
    /// Subscribes.
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            port: Subscriber::open(bus, &IDENTITY, "", IDENTITY.buffer)?,
            heard: Heard::default(),
        })
    }

    /// Writes it as soon as it is known to be that of the run's volume.
    pub(super) fn step(
        &mut self,
        now_ns: i64,
        volume: Option<VolumeHash>,
        series: &mut Series,
    ) -> Result<(), BusError> {
        self.heard.came = self.port.newest()?.or(self.heard.came);
        if let Some(identity) = self.heard.due(volume) {
            series.identity(now_ns, proto::Identity::of(now_ns, &identity));
        }
        Ok(())
    }
}

impl Heard {
    /// What is to be written: new, and of this volume.
    fn due(&mut self, volume: Option<VolumeHash>) -> Option<Identity> {
        let due = self
            .came
            .filter(|came| Some(came.volume()) == volume && self.written != Some(*came))?;
        self.written = Some(due);
        Some(due)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_belongs_to_the_runs_volume_is_written_and_once() {
        let volumes = [1, 2].map(|byte| VolumeHash([byte; 32]));
        let identity = |volume| Identity::unknown(volume);
        let mut heard = Heard::default();
        assert_eq!(heard.due(None), None);
        heard.came = Some(identity(volumes[1]));
        assert_eq!(heard.due(None), None);
        assert_eq!(heard.due(Some(volumes[0])), None);
        assert_eq!(heard.due(Some(volumes[1])), Some(identity(volumes[1])));
        assert_eq!(heard.due(Some(volumes[1])), None);
        heard.came = Some(identity(volumes[0]));
        assert_eq!(heard.due(Some(volumes[1])), None);
    }
}
