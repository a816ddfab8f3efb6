//! When a frame was captured, on the run's clock, and how sure that is.

use bus::clock::{self, mapping::Mapping, mapping::Quality, mapping::Settings};
use bus::message::{CaptureClock, MAY_BE_OLDER};
use scene::localizer::StampRule;

use crate::driver::{Frame, Seen};
use crate::image_clock::{ImageLaw, Untimed};

/// So far behind its arrival a frame's time may be put to be later than that of the one before, ns.
const MOST_AHEAD_NS: i64 = 1000;

/// A law whose newest frame is older than this says nothing of an image: what the clock did since nobody saw, ns.
const OLD_LAW_NS: i64 = 1_000_000_000;

/// Waiting that is less is counted and not told: ways grow longer by as much, ns.
const TOLD_NS: i64 = 10_000_000;

/// The clock of one connection.
#[derive(Debug)]
pub struct DeviceClock {
    rule: StampRule,
    least_delay_ns: i64,
    mapping: Mapping,
    last: Option<Captured>,
    /// Stamp of the newest frame, and what it held.
    newest: (i64, Vec<Seen>),
    /// That frame is the one before once more.
    is_again: bool,
    images: ImageLaw,
    /// Frames come in answer to a question.
    is_polled: bool,
}

/// The time of an image's capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageTime {
    /// By the clock of the frames, or the image's arrival.
    pub captured: Captured,
    /// Why it is the arrival.
    pub untimed: Option<Untimed>,
    /// By how much the clock of the images was found to be set against that of the frames, ns.
    pub set_by_ns: Option<i64>,
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
    /// What `at_ns` was put earlier by, as the frame may have waited for so long in a queue on the peer's side, ns.
    pub waited_ns: i64,
}

impl DeviceClock {
    /// Of a connection that was just made: nothing is known of the localizer's clock. Its images come at most `latest_image_ns` later
    /// than the frames of their time.
    pub fn new(rule: StampRule, least_delay_ns: i64, latest_image_ns: i64) -> Self {
        Self {
            rule,
            least_delay_ns,
            mapping: Mapping::new(settings(least_delay_ns)),
            last: None,
            newest: (0, Vec::new()),
            is_again: false,
            images: ImageLaw::new(latest_image_ns),
            is_polled: false,
        }
    }

    /// Of a peer whose frames may have waited for so long, as a process found that followed it before.
    #[must_use]
    pub fn having_waited(self, waited_ns: i64) -> Self {
        Self {
            mapping: self.mapping.having_waited(waited_ns),
            ..self
        }
    }

    /// Of a peer that is asked for each frame, and answers with the newest: none is older than its question, but for the time between two.
    #[must_use]
    pub fn polled(self) -> Self {
        Self {
            is_polled: true,
            ..self
        }
    }

    /// Another connection was made: what is known is how late images were on the one before, and the law of the frames.
    pub fn reconnected(&mut self) {
        self.mapping.reconnected();
        self.last = None;
        self.newest.0 = 0;
        self.images.reconnected();
    }

    /// When `frame` was captured, and what a person must know of the clock.
    pub fn capture(&mut self, frame: &Frame) -> (Captured, Option<String>) {
        // By its arrival alone nothing says how long a reply took: it is taken for as old as its question.
        let asked_ns = if self.is_polled { frame.in_question_ns() } else { 0 };
        let arrival = Captured {
            at_ns: frame.first_ns.saturating_sub(asked_ns.max(self.least_delay_ns)),
            uncertain_ns: 0,
            clock: CaptureClock::Arrival,
            waited_ns: 0,
        };
        if self.rule == StampRule::Arrival {
            return (self.later(arrival, frame), None);
        }
        let mapped = self.mapping.map(frame.device_ns, frame.first_ns);
        let event = mapped.event.map(|event| event.to_string());
        if let Some(same) = self.of_same_message(frame, arrival) {
            return (same, event);
        }
        let waited_ns = match self.is_polled {
            // What was asked for has waited since the question at most, on its way or at the device.
            true => mapped.waited_ns.min(frame.in_question_ns()),
            false => mapped.waited_ns,
        };
        // Never younger than it may be: which of the two it was, nothing tells.
        let at_ns = mapped.capture_ns.saturating_sub(waited_ns);
        let captured = match (mapped.quality, mapped.uncertain_ns) {
            (Quality::Mapped, Some(uncertain_ns)) => Captured {
                at_ns,
                // 0 says that nothing is known.
                uncertain_ns: uncertain_ns.saturating_add(waited_ns).max(1),
                clock: CaptureClock::Mapped,
                waited_ns,
            },
            _ => Captured {
                at_ns: at_ns.min(arrival.at_ns),
                waited_ns,
                ..arrival
            },
        };
        (self.later(captured, frame), event)
    }

    /// The time of the frame before, where this one is the same once more: with its stamp, and nothing else in it. It became no newer.
    fn of_same_message(&mut self, frame: &Frame, arrival: Captured) -> Option<Captured> {
        let is_same = frame.device_ns != 0 && self.newest.0 == frame.device_ns && self.newest.1 == frame.seen;
        if !is_same {
            self.newest.0 = frame.device_ns;
            self.newest.1.clone_from(&frame.seen);
        }
        // Stamps that never kept a law, as where they stand still from the beginning, say nothing of an age.
        let same = self.last.filter(|last| is_same && last.clock == CaptureClock::Mapped);
        let is_pose = frame.seen.iter().any(|seen| seen.outcome.is_ok());
        self.is_again = same.is_some() && is_pose;
        match is_same && !is_pose && !frame.seen.is_empty() {
            // A tool that is not seen bears the stamp of when it was, and is not seen now.
            true => Some(self.later(arrival, frame)),
            false => same,
        }
    }

    /// Whether the newest frame is the one before once more, and no news.
    pub fn is_again(&self) -> bool {
        self.is_again
    }

    /// When an image was captured that bears a stamp of the frames' clock: by the law that they have made, as it comes later than they do. Where
    /// there is none, or images do not keep to that clock, its arrival counts.
    pub fn capture_of_image(&mut self, device_ns: i64, arrival_ns: i64) -> ImageTime {
        let (placed, set_by_ns) = match self.by_frames(device_ns, arrival_ns) {
            Ok((at_ns, uncertain_ns)) => {
                let late_ns = arrival_ns.saturating_sub(at_ns).saturating_sub(self.least_delay_ns);
                let (kept, set_by_ns) = self.images.judge(late_ns, uncertain_ns, arrival_ns);
                (kept.map(|()| (at_ns, uncertain_ns)), set_by_ns)
            }
            Err(why) => (Err(why), None),
        };
        let waited_ns = self.waited_ns();
        let captured = match placed {
            // As old as the poses of its stamp may be.
            Ok((at_ns, uncertain_ns)) => Captured {
                at_ns: at_ns.saturating_sub(waited_ns),
                uncertain_ns: uncertain_ns.saturating_add(waited_ns).max(1),
                clock: CaptureClock::Mapped,
                waited_ns,
            },
            Err(_) => Captured {
                at_ns: arrival_ns.saturating_sub(self.least_delay_ns).saturating_sub(waited_ns),
                uncertain_ns: 0,
                clock: CaptureClock::Arrival,
                waited_ns,
            },
        };
        ImageTime {
            captured,
            untimed: placed.err(),
            set_by_ns,
        }
    }

    /// Time and bound of a stamp by the law of the frames.
    fn by_frames(&self, device_ns: i64, arrival_ns: i64) -> Result<(i64, i64), Untimed> {
        if self.rule == StampRule::Arrival {
            return Err(Untimed::Wanted);
        }
        // Frames that are not mapped, or do not come any more, vouch for no law.
        let is_followed = self.last.is_some_and(|last| {
            last.clock == CaptureClock::Mapped && arrival_ns.saturating_sub(last.at_ns) <= OLD_LAW_NS
        });
        if !is_followed {
            return Err(Untimed::NoPoses);
        }
        // How late one may be is for the law of the images.
        let placed = self.mapping.capture_of(device_ns, arrival_ns, i64::MAX);
        placed.ok_or(Untimed::OtherClock)
    }

    /// Two frames are two instants: those that come in one piece arrive at one time, and a law that is corrected may put one at the time
    /// of the one before. Both would be taken for the same frame once more.
    fn later(&mut self, captured: Captured, frame: &Frame) -> Captured {
        let next_ns = self.last.map_or(i64::MIN, |last| last.at_ns.saturating_add(1));
        let most_ns = captured
            .uncertain_ns
            .saturating_sub(captured.waited_ns)
            .max(MOST_AHEAD_NS);
        // What came back in time, or is older than the one before, is for the tracker to refuse.
        let is_near = next_ns <= frame.first_ns.saturating_add(MOST_AHEAD_NS)
            && next_ns.saturating_sub(captured.at_ns) <= most_ns;
        let at_ns = if is_near {
            captured.at_ns.max(next_ns)
        } else {
            captured.at_ns
        };
        let captured = Captured { at_ns, ..captured };
        self.last = Some(captured);
        captured
    }

    /// How long frames may have waited in a queue on the peer's side, beside what their times say, ns.
    pub fn waited_ns(&self) -> i64 {
        self.last.map_or(self.mapping.waits_ns(), |last| last.waited_ns)
    }

    /// That frames may have waited, for people; empty where it is no more than links do at times.
    pub fn waited_words(&self) -> String {
        let waited_ns = self.waited_ns();
        if waited_ns < TOLD_NS {
            return String::new();
        }
        let ms = (waited_ns / 1_000_000).saturating_add(1);
        format!("{MAY_BE_OLDER}{ms} (a queue, or its clock was set)")
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

fn settings(least_delay_ns: i64) -> Settings {
    Settings {
        least_delay_ns,
        ..Settings::default()
    }
}

#[cfg(test)]
mod tests;
