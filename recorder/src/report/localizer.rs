//! What localizers delivered: how late, by which clock, and which of their markers.

use std::collections::BTreeMap;

use bus::clock;
use bus::message::{CaptureClock, Lost, MarkerFrame};
use serde::Serialize;

use super::quantity::{Quantity, Spread};
use super::short::short;

/// Lateness from a tenth of a microsecond to three hours is told apart, ms.
const LATE_MS: (f64, f64) = (1e-4, 1e7);
/// A file may name a new localizer, or a new marker, in each frame: so many are told apart, the frames of further ones are counted.
const MOST_DEVICES: usize = 8;
const MOST_MARKERS: usize = 64;

/// All that was found so far.
#[derive(Debug, Default)]
pub(super) struct Localizers {
    devices: BTreeMap<String, Device>,
    other_frames: u64,
}

#[derive(Debug)]
struct Device {
    frames: u64,
    mapped: u64,
    late: Quantity,
    uncertain: Quantity,
    refused: u64,
    markers: BTreeMap<u32, MarkerFacts>,
}

/// What the localizers of a recording delivered. Empty where their poses were not recorded.
#[derive(Debug, Default, Serialize)]
pub(super) struct LocalizerFacts {
    pub(super) devices: Vec<DeviceFacts>,
    /// Frames of further localizers than are told apart.
    pub(super) other_frames: u64,
}

/// What one of them delivered.
#[derive(Debug, Serialize)]
pub(super) struct DeviceFacts {
    pub(super) name: String,
    pub(super) frames: u64,
    /// Frames whose capture is the localizer's own stamp, mapped onto the run's clock; that of the others is their arrival.
    pub(super) mapped: u64,
    /// From capture to arrival of the mapped frames, ms, apart from the link's least delay, which no stamp shows.
    pub(super) late_ms: Option<Spread>,
    /// Mapped frames that arrived before they were captured.
    pub(super) late_unknown: u64,
    /// How wrong the mapped times may be, ms, as it was stated with each frame.
    pub(super) uncertain_ms: Option<Spread>,
    /// Mapped frames that state none.
    pub(super) uncertain_unknown: u64,
    /// Frames that name a marker twice, or more markers than a frame holds.
    pub(super) refused: u64,
    pub(super) markers: Vec<MarkerFacts>,
}

/// One marker in the frames of a localizer.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct MarkerFacts {
    /// 0 is the tool's, 1 the patient's.
    pub(super) marker: u32,
    /// Frames with a pose of it.
    pub(super) seen: u64,
    /// Frames without, by reason.
    pub(super) lost: BTreeMap<&'static str, u64>,
}

impl Device {
    fn new() -> Self {
        Self {
            frames: 0,
            mapped: 0,
            late: Quantity::new(LATE_MS.0, LATE_MS.1),
            uncertain: Quantity::new(LATE_MS.0, LATE_MS.1),
            refused: 0,
            markers: BTreeMap::new(),
        }
    }

    fn take(&mut self, frame: &MarkerFrame) {
        self.frames += 1;
        if frame.capture_clock() == CaptureClock::Mapped {
            self.mapped += 1;
            self.late(frame);
        }
        let Ok(sights) = frame.sights() else {
            self.refused += 1;
            return;
        };
        for sight in sights {
            if self.markers.len() == MOST_MARKERS && !self.markers.contains_key(&sight.marker) {
                continue;
            }
            let marker = self.markers.entry(sight.marker).or_default();
            marker.marker = sight.marker;
            match sight.status {
                0 => marker.seen += 1,
                status => {
                    let reason = Lost::from_code(status).map_or("a reason that is not known", Lost::words);
                    *marker.lost.entry(reason).or_default() += 1;
                }
            }
        }
    }

    fn late(&mut self, frame: &MarkerFrame) {
        let t_ns = frame.t_capture_ns.max(0);
        match frame.t_arrival_ns.checked_sub(frame.t_capture_ns) {
            Some(late_ns) if late_ns >= 0 => self.late.add(t_ns, clock::ms(late_ns)),
            _ => self.late.unknown(t_ns),
        }
        match frame.t_uncertain_ns {
            uncertain_ns if uncertain_ns > 0 => self.uncertain.add(t_ns, clock::ms(uncertain_ns)),
            _ => self.uncertain.unknown(t_ns),
        }
    }

    fn facts(self, name: String) -> DeviceFacts {
        DeviceFacts {
            name,
            frames: self.frames,
            mapped: self.mapped,
            late_ms: self.late.spread(),
            late_unknown: self.late.unknowns(),
            uncertain_ms: self.uncertain.spread(),
            uncertain_unknown: self.uncertain.unknowns(),
            refused: self.refused,
            markers: self.markers.into_values().collect(),
        }
    }
}

impl Localizers {
    /// A frame of one of them.
    pub(super) fn take(&mut self, frame: &MarkerFrame) {
        let name = frame.device_name();
        if self.devices.len() == MOST_DEVICES && !self.devices.contains_key(&name) {
            self.other_frames += 1;
            return;
        }
        self.devices.entry(name).or_insert_with(Device::new).take(frame);
    }

    /// What a report says of them.
    pub(super) fn facts(self) -> LocalizerFacts {
        let devices = self.devices.into_iter();
        LocalizerFacts {
            devices: devices.map(|(name, device)| device.facts(short(&name))).collect(),
            other_frames: self.other_frames,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::MarkerSight;
    use geometry::{Frame, Rigid, Tracker};

    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Marker;
    impl Frame for Marker {
        const NAME: &'static str = "marker";
    }

    fn frame(seq: u64, late_ns: i64, sights: &[MarkerSight]) -> MarkerFrame {
        let t_capture_ns = i64::try_from(seq).unwrap() * 1_000_000;
        let mut frame = MarkerFrame {
            seq,
            t_capture_ns,
            t_arrival_ns: t_capture_ns + late_ns,
            t_uncertain_ns: 20_000,
            clock: CaptureClock::Mapped.code(),
            ..MarkerFrame::EMPTY
        }
        .of_device("Vega");
        frame.set(sights).unwrap();
        frame
    }

    #[test]
    fn lateness_is_that_of_the_frames_whose_time_was_mapped() {
        let mut all = Localizers::default();
        let seen = MarkerSight::seen::<Marker>(0, Rigid::<Tracker, Marker>::identity(), 0.1);
        let lost = MarkerSight::lost(1, Lost::NotSeen, 5);
        (0..100).for_each(|seq| all.take(&frame(seq, 1_000_000 + 10_000 * (seq as i64), &[seen, lost])));
        // Their capture is their arrival: a lateness of 0 would be no measurement.
        let arrival = MarkerFrame {
            clock: CaptureClock::Arrival.code(),
            t_uncertain_ns: 0,
            ..frame(100, 0, &[seen])
        };
        all.take(&arrival);
        all.take(&frame(101, -1, &[seen]));
        let facts = all.facts();
        let [device] = facts.devices.as_slice() else {
            panic!("{facts:?}")
        };
        let late = device.late_ms.unwrap();
        assert_eq!(
            (device.frames, device.mapped, late.count, device.late_unknown),
            (102, 101, 100, 1)
        );
        assert_eq!((late.min, late.max), (1.0, 1.99));
        assert!((late.p50 - 1.49).abs() < 0.005 * 1.49 + 0.01, "{late:?}");
        let uncertain = device.uncertain_ms.unwrap();
        assert_eq!(
            (uncertain.min, uncertain.max, device.uncertain_unknown),
            (0.02, 0.02, 0)
        );
        assert_eq!((device.markers[0].seen, device.markers[1].seen), (102, 0));
        assert_eq!(device.markers[1].lost[Lost::NotSeen.words()], 100);
    }

    #[test]
    fn a_file_that_names_a_localizer_and_a_marker_anew_in_each_frame_fills_no_memory() {
        let mut all = Localizers::default();
        for seq in 0..1000 {
            let sight = MarkerSight::lost(u32::try_from(seq).unwrap(), Lost::NotSeen, 0);
            all.take(&frame(seq, 0, &[sight]).of_device(&format!("no. {seq}")));
            all.take(&frame(seq, 0, &[sight]).of_device("no. 0"));
        }
        let facts = all.facts();
        assert_eq!((facts.devices.len(), facts.other_frames), (MOST_DEVICES, 1000 - 8));
        assert_eq!(
            (facts.devices[0].markers.len(), facts.devices[0].frames),
            (MOST_MARKERS, 1001)
        );
    }
}
