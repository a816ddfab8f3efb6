//! When a remote device captured a frame, on the run's clock, from its own stamps.
//!
//! The device has a clock of its own, with an epoch, a skew and steps; what is seen of it is the arrival of each frame, which is late by
//! the way there. Arrival less stamp is, but for the steps, a line (the skew) plus a delay that is never less than the least delay of
//! the link. So the law is a line *below* those points: over the last 20 s the one that supports them with a skew of at most
//! 200 ppm. Late frames, however many and however late, lie above it and do not move it; a mean would follow them.
//!
//! ```text
//! capture = arrival - (how far the frame lies above the line) - least_delay_ns
//! ```
//!
//! From one way alone the least delay cannot be told from a clock that is late: every mapped stamp is late by it. Who knows it states
//! it ([`Settings::least_delay_ns`]). A route that grows longer looks like a clock that was set back.
//!
//! Of the line's two numbers the offset is the support itself. The skew is that of the hull's edge over the middle of the window, weighted
//! against what earlier windows said of it. [`Mapped::uncertain_ns`] is a bound for 99 frames of 100: how far the window's least delay may
//! lie above the true one, by the spacing of the lowest frames, and how far the law may lie below the truth, by the least lateness of the last
//! half second. `docs/clocks.md` has the measured errors.

mod backlog;
mod creep;
mod envelope;
mod handed;
mod hull;
mod quality;
mod settings;
mod skew;
mod spread;
mod stamps;
mod told;
mod trial;

pub use handed::{Handed, HandedLaw};
pub use quality::{Event, Mapped, Quality, Reason};
pub use settings::{Settings, Status};
pub use spread::Spread;

use backlog::Backlog;
use creep::{Before, Creep, Step};
use envelope::Envelope;
use spread::Lateness;
use stamps::Stamps;
use told::Told;
use trial::{Side, Trial};

/// The clock of one device.
///
/// Frames are handed over in the order of their arrival. It takes about 20 kB once and nothing more for a frame.
#[derive(Debug, Clone)]
pub struct Mapping {
    least_delay_ns: i64,
    window_ns: i64,
    stamps: Stamps,
    law: Envelope,
    /// Laws of frames ahead of it, far behind it, and behind it.
    ahead: Trial,
    far_behind: Trial,
    behind: Trial,
    creep: Creep,
    /// The law before the one that has not settled yet.
    before: Option<Before>,
    /// That of the process before, until the first frame comes.
    handed: Option<HandedLaw>,
    /// Another connection was made, and no frame came over it yet.
    is_anew: bool,
    backlog: Backlog,
    /// By how much the time of the frame before is later than that frame was captured, as it had its arrival and was late.
    held_up_ns: i64,
    /// Arrivals of the first frame that was mapped and of the newest.
    held: Option<(i64, i64)>,
    /// After a step that may have been a busy link: its size, and until which arrival both may be.
    doubt: Option<(i64, i64)>,
    lateness: Lateness,
    /// Arrival of the frame before and its time before the least delay was taken off.
    last: Option<(i64, i64)>,
    mapped: u64,
    told: Told,
}

/// What is farther ahead of the law has to be said by more than one frame.
const AHEAD_NS: f64 = 3e6;
/// What a clock may go otherwise over a silence than before it.
const UNKNOWN_SKEW: f64 = 20e-6;
/// The law's noise, so many times, and this at least, is kept by every frame of the clock it belongs to.
const NOISES: f64 = 12.0;
const LEAST_STEP_NS: f64 = 0.5e6;
/// A law that held for so long is that of a clock, ns: frames that leave it later are late by it.
const GOOD_NS: i64 = 5_000_000_000;

impl Mapping {
    /// A law that is less certain than this is not used: 100 ms.
    pub const WIDEST_NS: i64 = 100_000_000;

    /// A device of which nothing is known.
    pub fn new(settings: Settings) -> Self {
        let window_ns = settings.window_ns.max(1_000_000_000);
        let bound = settings.skew_ppm.abs().min(1000.0) * 1e-6;
        let law = || Envelope::new(window_ns, if bound.is_finite() { bound } else { 0.0 });
        Self {
            least_delay_ns: settings.least_delay_ns.max(0),
            window_ns,
            stamps: Stamps::default(),
            ahead: Trial::new(law(), Side::Ahead),
            far_behind: Trial::new(law(), Side::ClearlyBehind),
            behind: Trial::new(law(), Side::Behind),
            creep: Creep::default(),
            before: None,
            handed: None,
            is_anew: false,
            backlog: Backlog::default(),
            held_up_ns: 0,
            held: None,
            doubt: None,
            law: law(),
            lateness: Lateness::new(window_ns),
            last: None,
            mapped: 0,
            told: Told::new(window_ns),
        }
    }

    /// The same, of a device that another process has followed: neither another process nor another connection ends a queue of the peer.
    #[must_use]
    pub fn going_on(self, handed: Handed) -> Self {
        Self {
            backlog: Backlog::of(handed.waited_ns),
            // A law that somebody followed is that of a clock: frames that leave it are late by it.
            held: handed
                .law
                .map(|law| (law.arrival_ns.saturating_sub(GOOD_NS), law.arrival_ns)),
            handed: handed.law,
            ..self
        }
    }

    /// What a process that follows is to know; a frame of this stamp came then.
    pub fn hand_over(&self, device_ns: i64, arrival_ns: i64) -> Handed {
        let skew = self.law.skew().now;
        let settled = self.law.has_settled().then(|| HandedLaw {
            device_ns,
            arrival_ns: self.law.arrival_of(device_ns, arrival_ns),
            skew,
        });
        // One that has not settled knows less than the one before.
        let before = self.before.map(|before| HandedLaw {
            device_ns: before.device_ns,
            arrival_ns: before.arrival_ns,
            skew,
        });
        Handed {
            law: settled.or(before).or(self.handed),
            waited_ns: self.backlog.ns(),
        }
    }

    /// Another connection with the same peer was made. The law begins anew with its frames and is held against the one before, as behind a
    /// silence: a queue on the peer's side outlives a connection, and is not the least delay of the next one.
    pub fn reconnected(&mut self) {
        self.is_anew = true;
        self.last = None;
        self.stamps.reconnected();
        self.told.reconnected();
    }

    /// How long frames may have waited beside what the law says, as of the newest, ns.
    pub fn waits_ns(&self) -> i64 {
        self.backlog.ns().saturating_add(self.held_up_ns)
    }

    /// The same of all frames, and not of the newest alone, which may be one of before.
    pub fn backlog_ns(&self) -> i64 {
        self.backlog.ns()
    }

    /// When the frame was captured that the device stamped `device_ns` and that arrived at `arrival_ns` on the run's clock, both in
    /// nanoseconds. Any numbers are taken; what is wrong with them is said.
    pub fn map(&mut self, device_ns: i64, arrival_ns: i64) -> Mapped {
        let judged = self.stamps.judge(device_ns, arrival_ns);
        let back = self.last.is_some_and(|(last, _)| arrival_ns < last);
        let judged = if back { Some(Reason::ArrivalBackwards) } else { judged };
        let before = self.law.has_settled().then(|| self.law.late(device_ns, arrival_ns));
        let (placed, step) = match judged {
            Some(reason) => {
                if reason == Reason::Backwards {
                    self.trials().into_iter().for_each(Trial::set_back);
                }
                (Err(reason), None)
            }
            None => self.follow(device_ns, arrival_ns),
        };
        self.backlog.rises(self.law_rose(before, step, device_ns, arrival_ns));
        let told = step.filter(|step| step.is_told);
        let step = told.and_then(|step| self.told.step(step.by_ns, arrival_ns));
        let placed = placed.and_then(|()| self.place(device_ns, arrival_ns));
        let arrived = placed.err().and_then(|reason| self.told.arrival(reason, arrival_ns));
        self.held_up_ns = match placed {
            Ok((capture_ns, _)) => self.raised(capture_ns, device_ns, arrival_ns).min(self.held_up_ns),
            Err(reason) => self.late_for_arrival(reason, device_ns, arrival_ns),
        };
        Mapped {
            waited_ns: self.waits_ns(),
            ..self.conclude(placed, step.or(arrived), arrival_ns)
        }
    }

    /// How much the law rose with a frame that was late by `before`: by a step that was found, else by what left its window or came to it.
    fn law_rose(&self, before: Option<f64>, step: Option<Step>, device_ns: i64, arrival_ns: i64) -> i64 {
        match (step, before) {
            (Some(step), _) => step.counted_ns.saturating_sub(step.by_ns),
            (None, Some(before)) if self.law.has_settled() => (before - self.law.late(device_ns, arrival_ns)) as i64,
            _ => 0,
        }
    }

    /// How late a frame is by the law of a clock that was good, where it has the time of its arrival as its stamps do not keep that law: it has
    /// waited for so long beside what steps back may have been as a queue. A stamp that went back is no excuse until the law has followed it: one
    /// frame that comes once more, or a few, are as old as they say. A law that begins anew knows nothing: the one before says it.
    fn late_for_arrival(&self, reason: Reason, device_ns: i64, arrival_ns: i64) -> i64 {
        let leaves_law = matches!(
            reason,
            Reason::Rate
                | Reason::Unsteady
                | Reason::Behind
                | Reason::Vague
                | Reason::Backwards
                | Reason::Ahead
                | Reason::Repeated
        );
        if !self.law.has_settled() {
            let is_of_clock = leaves_law || reason == Reason::JustBegun;
            return self
                .before
                .filter(|_| is_of_clock)
                .map_or(0, |before| before.late(device_ns, arrival_ns));
        }
        let is_good = self
            .held
            .is_some_and(|(first, last)| last.saturating_sub(first) >= GOOD_NS);
        if is_good && leaves_law {
            self.law.late(device_ns, arrival_ns).max(0.0) as i64
        } else {
            0
        }
    }

    /// When something was captured that the device stamped `device_ns` by the same clock and that arrived at `arrival_ns`, and how wrong that
    /// may be, ns: by the law of the frames alone, which learns nothing of it. Of images, which come later than the frames of their time.
    /// `None` where frames are not mapped either, and where the stamp lies ahead of the law or more than `most_late_ns` behind it:
    /// it is none of this clock.
    pub fn capture_of(&self, device_ns: i64, arrival_ns: i64, most_late_ns: i64) -> Option<(i64, i64)> {
        let (late, uncertain) = self.lawful(device_ns, arrival_ns).ok()?;
        let is_of_clock = device_ns > 0 && late >= -AHEAD_NS && late <= most_late_ns as f64;
        let late = late.max(0.0).round() as i64;
        let capture = arrival_ns.saturating_sub(late).saturating_sub(self.least_delay_ns);
        (is_of_clock && uncertain <= Self::WIDEST_NS).then_some((capture, uncertain))
    }

    /// What is known by now.
    pub fn status(&self) -> Status {
        Status {
            spread: self.lateness.spread(),
            skew_ppm: self.law.skew().now * 1e6,
            steps: self.told.steps,
            mapped: self.mapped,
            arrivals: self.told.arrivals,
        }
    }

    /// Lets the law take the frame. Gives whether the frame may be placed by it, and by how much the device's clock was found to be set.
    fn follow(&mut self, device_ns: i64, arrival_ns: i64) -> (Result<(), Reason>, Option<Step>) {
        let silence = self.law.silence(device_ns, arrival_ns);
        let is_anew = std::mem::take(&mut self.is_anew);
        if is_anew || self.law.is_empty() || silence > self.window_ns as f64 {
            self.begin_anew(silence.max(0.0), device_ns, arrival_ns);
        }
        if self.ahead.is_stale(device_ns, arrival_ns) {
            self.ahead.forget();
        }
        let late = self.law.late(device_ns, arrival_ns);
        let tolerance = (NOISES * self.law.noise()).clamp(LEAST_STEP_NS, trial::CLEARLY_NS);
        if self.law.has_settled() && late < 0.0 {
            return self.follow_ahead(-late, tolerance.max(AHEAD_NS), device_ns, arrival_ns);
        }
        // A frame that is late may be one of a clock that was set back, or of a busy link: it is taken as both.
        self.law.push(device_ns, arrival_ns);
        let step = self.try_late(late, tolerance, device_ns, arrival_ns);
        (Ok(()), step.or_else(|| self.crept(device_ns, arrival_ns)))
    }

    /// The law begins with this frame, and is held against the one before once it has settled.
    fn begin_anew(&mut self, silence: f64, device_ns: i64, arrival_ns: i64) {
        let least_ns = |silence: f64| (AHEAD_NS + UNKNOWN_SKEW * silence) as i64;
        if self.law.has_settled() {
            self.before = Some(Before {
                device_ns,
                arrival_ns: self.law.arrival_of(device_ns, arrival_ns),
                least_ns: least_ns(silence),
                counted_ns: 0,
            });
        } else if let Some(handed) = self.handed.take() {
            self.before = Some(handed.before(device_ns, least_ns, arrival_ns));
        }
        let skew = self.law.skew();
        self.law.clear(skew);
        self.trials().into_iter().for_each(Trial::forget);
        self.creep.forget();
    }

    /// The same of a frame that arrived `early`, before the law allowed it to.
    fn follow_ahead(
        &mut self,
        early: f64,
        tolerance: f64,
        device_ns: i64,
        arrival_ns: i64,
    ) -> (Result<(), Reason>, Option<Step>) {
        if early > tolerance {
            let is_ready = self.ahead.push(&self.law, tolerance, device_ns, arrival_ns);
            let step = is_ready.then(|| self.adopt(Side::Ahead, device_ns, arrival_ns));
            return (step.map(|_| ()).ok_or(Reason::Ahead), step);
        }
        if let Some(by) = self.creep.lower(early, tolerance, arrival_ns) {
            self.before = Some(Before {
                device_ns,
                arrival_ns: arrival_ns.saturating_add(by as i64),
                least_ns: 0,
                // The law was lowered by the rest, frame by frame.
                counted_ns: (by - early) as i64,
            });
            let skew = self.law.skew();
            self.law.clear(skew);
            self.creep.forget();
        }
        self.law.push(device_ns, arrival_ns);
        self.trials().into_iter().for_each(Trial::keep);
        (Ok(()), None)
    }

    /// The step that a law crept by, or was found behind a silence, once the new one has settled. Less than is told counts too: many make a queue.
    fn crept(&mut self, device_ns: i64, arrival_ns: i64) -> Option<Step> {
        let before = self.before.filter(|_| self.law.has_settled())?;
        self.before = None;
        let by_new_law = arrival_ns.saturating_sub(self.law.late(device_ns, arrival_ns) as i64);
        Some(before.step(device_ns, by_new_law))
    }

    /// Lets the trials take a frame that is not ahead, and gives a step.
    fn try_late(&mut self, late: f64, tolerance: f64, device_ns: i64, arrival_ns: i64) -> Option<Step> {
        if late <= tolerance {
            self.trials().into_iter().for_each(Trial::keep);
            return None;
        }
        let is_behind = self.behind.push(&self.law, tolerance, device_ns, arrival_ns);
        if late <= trial::CLEARLY_NS {
            self.far_behind.keep();
        } else if self.far_behind.push(&self.law, tolerance, device_ns, arrival_ns) {
            return Some(self.adopt(Side::ClearlyBehind, device_ns, arrival_ns));
        }
        // What is about to be found farther behind, or ahead, is not told in two steps.
        let is_alone = self.far_behind.frames() == 0 && self.ahead.frames() == 0;
        (is_behind && is_alone).then(|| self.adopt(Side::Behind, device_ns, arrival_ns))
    }

    fn trials(&mut self) -> [&mut Trial; 3] {
        [&mut self.ahead, &mut self.far_behind, &mut self.behind]
    }

    /// Puts the law of a trial in the place of the old one, and gives the step.
    fn adopt(&mut self, side: Side, device_ns: i64, arrival_ns: i64) -> Step {
        let trial = match side {
            Side::Ahead => &mut self.ahead,
            Side::ClearlyBehind => &mut self.far_behind,
            Side::Behind => &mut self.behind,
        };
        let set_back = trial.law.above(&self.law, device_ns);
        // The old law is of a clock that was not set: at the stamp of the new one it has gone on by the skew for as long as the step is.
        let set_back = (set_back as f64 / (1.0 + self.law.skew().now)).round() as i128;
        std::mem::swap(&mut self.law, &mut trial.law);
        self.trials().into_iter().for_each(Trial::forget);
        self.creep.forget();
        self.before = None;
        let by_ns = -set_back.clamp(-i128::from(i64::MAX), i128::from(i64::MAX)) as i64;
        let until = arrival_ns.saturating_add(self.window_ns);
        // Little may have been a link that is busy for long, or a longer way: both stay possible while the window remembers the old law.
        self.doubt = (side == Side::Behind).then_some((by_ns.saturating_abs(), until));
        Step {
            by_ns,
            counted_ns: 0,
            is_told: true,
        }
    }

    /// How late something came by the law, and how wrong that may be, ns; or why nothing is known.
    fn lawful(&self, device_ns: i64, arrival_ns: i64) -> Result<(f64, i64), Reason> {
        if self.told.is_unsteady(arrival_ns) {
            return Err(Reason::Unsteady);
        }
        if !self.law.has_settled() {
            return Err(Reason::JustBegun);
        }
        // One stamp alone may be wrong; after a second one the old law is in doubt for all frames.
        if self.ahead.frames() > 1 {
            return Err(Reason::Ahead);
        }
        let uncertain = (self.law.uncertain().ceil() as i64)
            .saturating_add(self.stamps.grain_ns())
            .saturating_add(self.doubt_ns(arrival_ns));
        Ok((self.law.late(device_ns, arrival_ns), uncertain))
    }

    /// Where the law puts a frame and how surely, or why it does not.
    fn place(&self, device_ns: i64, arrival_ns: i64) -> Result<(i64, i64), Reason> {
        let (late, uncertain) = self.lawful(device_ns, arrival_ns)?;
        let capture = arrival_ns.saturating_sub(late.max(0.0).round() as i64);
        // The law moves a little as frames come; a capture does not go back for that.
        let earliest = self.last.map_or(capture, |(_, last)| last);
        let raised = earliest.saturating_sub(capture).max(0);
        if raised > uncertain {
            return Err(Reason::Behind);
        }
        let uncertain = uncertain.saturating_add(raised);
        if uncertain > Self::WIDEST_NS {
            return Err(Reason::Vague);
        }
        Ok((capture.max(earliest), uncertain))
    }

    fn doubt_ns(&self, arrival_ns: i64) -> i64 {
        let doubt = self.doubt.filter(|(_, until)| arrival_ns < *until);
        doubt.map_or(0, |(by, _)| by)
    }

    /// By how much a frame's time was put later than the law has it, so as not to be before that of the frame before.
    fn raised(&self, capture_ns: i64, device_ns: i64, arrival_ns: i64) -> i64 {
        let lawful = arrival_ns.saturating_sub(self.law.late(device_ns, arrival_ns).max(0.0).round() as i64);
        capture_ns.saturating_sub(lawful).max(0)
    }

    fn conclude(&mut self, placed: Result<(i64, i64), Reason>, event: Option<Event>, arrival_ns: i64) -> Mapped {
        let capture = placed.map_or(arrival_ns, |(capture, _)| capture.min(arrival_ns));
        self.last = Some((arrival_ns, capture));
        if placed.is_ok() {
            self.mapped += 1;
            let first = self.held.map_or(arrival_ns, |(first, _)| first);
            self.held = Some((first, arrival_ns));
            self.lateness.count(arrival_ns, arrival_ns.saturating_sub(capture));
        }
        Mapped {
            capture_ns: capture.saturating_sub(self.least_delay_ns),
            waited_ns: 0,
            uncertain_ns: placed.ok().map(|(_, uncertain)| uncertain),
            quality: placed.map_or_else(Quality::Arrival, |_| Quality::Mapped),
            event,
        }
    }
}

#[cfg(test)]
mod tests;
