//! When a frame was captured, on the run's clock, and how sure that is.

use bus::clock::{self, mapping::Mapping, mapping::Quality, mapping::Settings};
use bus::message::CaptureClock;
use scene::localizer::StampRule;

use crate::driver::Frame;

/// The clock of one connection.
#[derive(Debug)]
pub(crate) struct DeviceClock {
    rule: StampRule,
    least_delay_ns: i64,
    mapping: Mapping,
    last: Option<Captured>,
}

/// The time of a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Captured {
    /// ns on the run's clock.
    pub(crate) at_ns: i64,
    /// How wrong that may be apart from the least delay, ns; 0 where nothing bounds it.
    pub(crate) uncertain_ns: i64,
    /// What it rests on.
    pub(crate) clock: CaptureClock,
}

impl DeviceClock {
    /// Of a connection that was just made: nothing is known of the localizer's clock.
    pub(crate) fn new(rule: StampRule, least_delay_ns: i64) -> Self {
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
    pub(crate) fn capture(&mut self, frame: &Frame) -> (Captured, Option<String>) {
        let arrival = Captured {
            at_ns: frame.first_ns.saturating_sub(self.least_delay_ns),
            uncertain_ns: 0,
            clock: CaptureClock::Arrival,
        };
        if self.rule == StampRule::Arrival {
            self.last = Some(arrival);
            return (arrival, None);
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
        self.last = Some(captured);
        (captured, mapped.event.map(|event| event.to_string()))
    }

    /// How the times of captures come about, for people; empty before the first frame.
    pub(crate) fn words(&self) -> String {
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
}
