//! When a frame was captured, on the run's clock, and how sure that is.

use bus::clock::{self, mapping::Handed, mapping::Mapping, mapping::Quality, mapping::Settings};
use bus::message::{CaptureClock, MAY_BE_OLDER};
use scene::localizer::StampRule;

use crate::driver::Frame;
use crate::image_clock::{ImageLaw, Untimed};
use crate::newest::Newest;

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
    newest: Newest,
    /// The newest frame is one of before once more.
    is_again: bool,
    /// Stamps of this peer have kept a law: one that comes again says something.
    has_kept_law: bool,
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
            newest: Newest::default(),
            is_again: false,
            has_kept_law: false,
            images: ImageLaw::new(latest_image_ns),
            is_polled: false,
        }
    }

    /// Of a peer that another process followed before, and of which it knew this.
    #[must_use]
    pub fn going_on(self, handed: Handed) -> Self {
        Self {
            mapping: self.mapping.going_on(handed),
            has_kept_law: handed.law.is_some(),
            ..self
        }
    }

    /// What a process is to know that follows.
    pub fn hand_over(&self) -> Handed {
        let (stamp_ns, arrival_ns) = self.newest.came();
        self.mapping.hand_over(stamp_ns, arrival_ns)
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
        self.newest.forget();
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
        let is_lost = !frame.seen.is_empty() && frame.seen.iter().all(|seen| seen.outcome.is_err());
        self.is_again = false;
        if is_lost && self.newest.is_no_later(frame.device_ns) {
            // A tool that is not seen bears the stamp of when it was: of the clock that says nothing, and the queue is as long as it was.
            let waited_ns = self.at_most_asked(self.mapping.backlog_ns(), frame);
            let lost = Captured {
                at_ns: arrival.at_ns.saturating_sub(waited_ns),
                waited_ns,
                ..arrival
            };
            return (self.later(lost, frame), None);
        }
        let mapped = self.mapping.map(frame.device_ns, frame.first_ns);
        let event = mapped.event.map(|event| event.to_string());
        if let Some(same) = self.of_same_message(frame) {
            return (same, event);
        }
        let waited_ns = match is_lost {
            true => self.mapping.backlog_ns(),
            false => mapped.waited_ns,
        };
        let waited_ns = self.at_most_asked(waited_ns, frame);
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
        self.has_kept_law |= captured.clock == CaptureClock::Mapped;
        (self.later(captured, frame), event)
    }

    /// What was asked for has waited since the question at most, on its way or at the device.
    fn at_most_asked(&self, waited_ns: i64, frame: &Frame) -> i64 {
        match self.is_polled {
            true => waited_ns.min(frame.in_question_ns()),
            false => waited_ns,
        }
    }

    /// The time of the frame before, where this one is the same once more: with its stamp, and nothing that did not come with it. It became no newer.
    fn of_same_message(&mut self, frame: &Frame) -> Option<Captured> {
        let repeats = self.newest.repeats(frame);
        if frame.seen.is_empty() {
            return self.last.filter(|last| repeats && last.clock == CaptureClock::Mapped);
        }
        // Stamps that never kept a law, as where they stand still from the beginning, say nothing of an age.
        let same = self.last.filter(|_| repeats && self.has_kept_law);
        self.is_again = same.is_some();
        same
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

    /// That frames may have waited, for people, in few words, as a note has room for why nothing comes beside it; empty where it is no
    /// more than links do at times.
    pub fn waited_words(&self) -> String {
        let waited_ns = self.waited_ns();
        if waited_ns < TOLD_NS {
            return String::new();
        }
        let ms = (waited_ns / 1_000_000).saturating_add(1);
        format!("{MAY_BE_OLDER}{ms}")
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
