//! When a frame was captured, on the run's clock, and how sure that is.

use bus::clock::{self, mapping::Mapping, mapping::Quality, mapping::Settings};
use bus::message::CaptureClock;
use scene::localizer::StampRule;

use crate::driver::Frame;

/// So far behind its arrival a frame's time may be put to be later than that of the one before, ns.
const MOST_AHEAD_NS: i64 = 1000;

/// An image may come so long after the frames of its time, ns: a stamp further back is none of their clock.
const MOST_LATE_NS: i64 = 2_000_000_000;

/// A law whose newest frame is older than this says nothing of an image: what the clock did since nobody saw, ns.
const OLD_LAW_NS: i64 = 1_000_000_000;

/// The clock of one connection.
#[derive(Debug)]
pub struct DeviceClock {
    rule: StampRule,
    least_delay_ns: i64,
    mapping: Mapping,
    last: Option<Captured>,
}

/// The time of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Captured {
    /// ns on the run's clock.
    pub at_ns: i64,
    /// How wrong that may be apart from the least delay, ns; 0 where nothing bounds it.
    pub uncertain_ns: i64,
    /// What it rests on.
    pub clock: CaptureClock,
}

impl DeviceClock {
    /// Of a connection that was just made: nothing is known of the localizer's clock.
    pub fn new(rule: StampRule, least_delay_ns: i64) -> Self {
        let settings = Settings {
            least_delay_ns,
            ..Settings::default()
        };
        Self {
            rule,
            least_delay_ns,
            mapping: Mapping::new(settings),
            last: None,
        }
    }

    /// When `frame` was captured, and what a person must know of the clock.
    pub fn capture(&mut self, frame: &Frame) -> (Captured, Option<String>) {
        let arrival = Captured {
            at_ns: frame.first_ns.saturating_sub(self.least_delay_ns),
            uncertain_ns: 0,
            clock: CaptureClock::Arrival,
        };
        if self.rule == StampRule::Arrival {
            return (self.later(arrival, frame), None);
        }
        let mapped = self.mapping.map(frame.device_ns, frame.first_ns);
        let captured = match (mapped.quality, mapped.uncertain_ns) {
            (Quality::Mapped, Some(uncertain_ns)) => Captured {
                at_ns: mapped.capture_ns,
                // 0 says that nothing is known.
                uncertain_ns: uncertain_ns.max(1),
                clock: CaptureClock::Mapped,
            },
            _ => Captured {
                at_ns: mapped.capture_ns,
                ..arrival
            },
        };
        (self.later(captured, frame), mapped.event.map(|event| event.to_string()))
    }

    /// When an image was captured that bears a stamp of the frames' clock: by the law that they have made, as it comes later than they do. Where
    /// there is none, or the stamp is no one of that clock, its arrival counts.
    pub fn capture_of_image(&self, device_ns: i64, arrival_ns: i64) -> Captured {
        // Frames that are not mapped, or do not come any more, vouch for no law.
        let is_followed = self.last.is_some_and(|last| {
            last.clock == CaptureClock::Mapped && arrival_ns.saturating_sub(last.at_ns) <= OLD_LAW_NS
        });
        let mapped = match self.rule {
            StampRule::Mapped if is_followed => self.mapping.capture_of(device_ns, arrival_ns, MOST_LATE_NS),
            _ => None,
        };
        match mapped {
            Some((at_ns, uncertain_ns)) => Captured {
                at_ns,
                uncertain_ns: uncertain_ns.max(1),
                clock: CaptureClock::Mapped,
            },
            None => Captured {
                at_ns: arrival_ns.saturating_sub(self.least_delay_ns),
                uncertain_ns: 0,
                clock: CaptureClock::Arrival,
            },
        }
    }

    /// Two frames are two instants: those that come in one piece arrive at one time, and a law that is corrected may put one at the time
    /// of the one before. Both would be taken for the same frame once more.
    fn later(&mut self, captured: Captured, frame: &Frame) -> Captured {
        let next_ns = self.last.map_or(i64::MIN, |last| last.at_ns.saturating_add(1));
        // What came back in time is for the tracker to refuse.
        let is_near = next_ns <= frame.first_ns.saturating_add(MOST_AHEAD_NS);
        let at_ns = if is_near {
            captured.at_ns.max(next_ns)
        } else {
            captured.at_ns
        };
        let captured = Captured { at_ns, ..captured };
        self.last = Some(captured);
        captured
    }

    /// How the times of captures come about, for people; empty before the first frame.
    pub fn words(&self) -> String {
        let Some(last) = self.last else {
            return String::new();
        };
        match last.clock {
            CaptureClock::Arrival => "clock: arrival".to_owned(),
            CaptureClock::Mapped => {
                let spread = self.mapping.status().spread;
                let [p50, p99] = [spread.p50_ns, spread.p99_ns].map(clock::ms);
                let bound = clock::ms(last.uncertain_ns);
                format!("clock mapped to {bound:.2} ms, late p50 {p50:.2} p99 {p99:.2} ms")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(device_ns: i64, first_ns: i64) -> Frame {
        Frame {
            device_ns,
            first_ns,
            arrival_ns: first_ns + 1_000_000,
            seen: Vec::new(),
        }
    }

    /// 2026, as a device that states UTC has it.
    const EPOCH_NS: i64 = 1_790_000_000_000_000_000;

    #[test]
    fn stamps_are_mapped_once_there_are_enough_and_never_later_than_the_arrival() {
        let mut clock = DeviceClock::new(StampRule::Mapped, 0);
        for i in 0..100 {
            let t_ns = i * 16_666_667;
            // Every fifth frame is 5 ms late.
            let late_ns = if i % 5 == 3 { 5_000_000 } else { 0 };
            let (captured, event) = clock.capture(&frame(EPOCH_NS + t_ns, t_ns + 400_000 + late_ns));
            assert_eq!(event, None);
            let (rests, off_ns) = if i < 8 {
                (CaptureClock::Arrival, late_ns)
            } else {
                (CaptureClock::Mapped, 0)
            };
            assert_eq!((captured.clock, captured.uncertain_ns > 0), (rests, i >= 8), "{i}");
            // The frames themselves are 33 ppm of nothing off: 0.1 ms is what the first law may be wrong by.
            assert!(
                (captured.at_ns - (t_ns + 400_000 + off_ns)).abs() < 100_000,
                "{i}: {captured:?}"
            );
        }
        assert!(clock.words().starts_with("clock mapped to 0."), "{}", clock.words());
    }

    /// Two frames in one piece had one time of arrival, and the tracker left the second one out.
    #[test]
    fn no_two_frames_have_one_time() {
        for rule in [StampRule::Mapped, StampRule::Arrival] {
            let mut clock = DeviceClock::new(rule, 0);
            let mut last_ns = i64::MIN;
            for i in 0..2000_i64 {
                // Three by three, with the last of them.
                let arrival_ns = (i / 3 * 3 + 2) * 1_000_000 + 400_000;
                let (captured, _) = clock.capture(&frame(EPOCH_NS + i * 1_000_000, arrival_ns));
                assert!(
                    captured.at_ns > last_ns && captured.at_ns <= arrival_ns + MOST_AHEAD_NS,
                    "{i}"
                );
                last_ns = captured.at_ns;
            }
        }
    }

    #[test]
    fn a_localizer_without_stamps_has_the_arrival_and_says_so() {
        let mut clock = DeviceClock::new(StampRule::Mapped, 2_000_000);
        let (captured, event) = clock.capture(&frame(0, 10_000_000));
        assert_eq!(
            (captured.at_ns, captured.uncertain_ns, captured.clock),
            (8_000_000, 0, CaptureClock::Arrival)
        );
        assert_eq!(
            event.unwrap(),
            "frames have the time of their arrival: the device states no time"
        );
        assert_eq!(clock.words(), "clock: arrival");
        let mut clock = DeviceClock::new(StampRule::Arrival, 2_000_000);
        let (captured, event) = clock.capture(&frame(EPOCH_NS, 10_000_000));
        assert_eq!(
            (captured.at_ns, captured.clock, event),
            (8_000_000, CaptureClock::Arrival, None)
        );
    }

    /// A law that no frame follows any more was used for images for ever.
    #[test]
    fn an_image_is_mapped_only_while_frames_are() {
        let mut clock = DeviceClock::new(StampRule::Mapped, 0);
        assert_eq!(clock.capture_of_image(EPOCH_NS, 0).clock, CaptureClock::Arrival);
        let (mut t_ns, step_ns) = (0, 16_666_667);
        for _ in 0..100 {
            t_ns += step_ns;
            clock.capture(&frame(EPOCH_NS + t_ns, t_ns));
        }
        let late_ns = 150_000_000;
        let seen = clock.capture_of_image(EPOCH_NS + t_ns - late_ns, t_ns);
        assert_eq!(seen.clock, CaptureClock::Mapped);
        assert!((seen.at_ns - (t_ns - late_ns)).abs() < 100_000, "{seen:?}");
        let alone = clock.capture_of_image(EPOCH_NS + t_ns + 1_000_000_000, t_ns + 1_100_000_000);
        assert_eq!((alone.clock, alone.uncertain_ns), (CaptureClock::Arrival, 0));
        // Frames without stamps are timed by their arrival, and so are images.
        clock.capture(&frame(0, t_ns + step_ns));
        let unsure = clock.capture_of_image(EPOCH_NS + t_ns, t_ns + step_ns);
        assert_eq!(unsure.clock, CaptureClock::Arrival);
    }
}
