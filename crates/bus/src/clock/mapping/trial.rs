//! A second law for frames that do not keep the first.

use super::envelope::Envelope;

/// Frames that a new law needs at least.
const FRAMES: u32 = 9;
/// How long a new law must hold, by arrivals and by half as much of the stamps, before it takes the old one's place: shortly where
/// frames are ahead of the old law, or clearly behind it after a stamp that went back; longer where they are clearly behind and none did,
/// which very late frames in a row look like; longer than a link is busy where they are a little behind.
const SHORTLY_NS: f64 = 120e6;
const LATE_NS: f64 = 250e6;
const LONG_NS: f64 = 4e9;
/// How late all frames must be for the clock to have been set rather than the link to be busy: 50 ms.
pub(super) const CLEARLY_NS: f64 = 50e6;
/// Frames on both sides of a silence say nothing of the time between.
const SILENCE_NS: f64 = 1e9;
/// At what age a law that begins with frames from before a step is found out: its floor is over half a second.
const EXAMINED_NS: std::ops::Range<f64> = 600e6..1e9;

/// Which frames a trial takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// They arrive before they were allowed to.
    Ahead,
    /// They are later than [`CLEARLY_NS`].
    ClearlyBehind,
    /// They are later than the tolerance of the old law.
    Behind,
}

#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) law: Envelope,
    side: Side,
    frames: u32,
    /// A stamp went back before the first frame.
    after_setback: bool,
}

impl Trial {
    pub(super) fn new(law: Envelope, side: Side) -> Self {
        Self {
            law,
            side,
            frames: 0,
            after_setback: false,
        }
    }

    /// Takes a frame that does not keep the old law, whose tolerance is given, and says whether the frames hold a law of their own now.
    pub(super) fn push(&mut self, old: &Envelope, tolerance: f64, device_ns: i64, arrival_ns: i64) -> bool {
        if self.is_stale(device_ns, arrival_ns) || self.began_before_a_step(tolerance) {
            self.forget();
        }
        if self.frames == 0 {
            self.law.clear(old.skew());
        }
        self.frames = self.frames.saturating_add(1);
        self.law.push(device_ns, arrival_ns);
        self.is_ready()
    }

    fn began_before_a_step(&self, tolerance: f64) -> bool {
        self.side == Side::Behind && EXAMINED_NS.contains(&self.law.age().0) && self.law.floor() > tolerance
    }

    /// Whether no frame came to it for so long that those before say nothing any more.
    pub(super) fn is_stale(&self, device_ns: i64, arrival_ns: i64) -> bool {
        self.frames > 0 && self.law.silence(device_ns, arrival_ns) > SILENCE_NS
    }

    /// A frame kept the old law. Of a clock that was set forward late frames do: only time ends a trial of frames ahead.
    pub(super) fn keep(&mut self) {
        if self.side != Side::Ahead {
            self.forget();
        }
    }

    pub(super) fn forget(&mut self) {
        (self.frames, self.after_setback) = (0, false);
    }

    /// A stamp went back: what came before was stamped by the clock as it was.
    pub(super) fn set_back(&mut self) {
        self.forget();
        self.after_setback = true;
    }

    pub(super) fn frames(&self) -> u32 {
        self.frames
    }

    fn is_ready(&self) -> bool {
        let least = match self.side {
            Side::Ahead => SHORTLY_NS,
            Side::ClearlyBehind if self.after_setback => SHORTLY_NS,
            Side::ClearlyBehind => LATE_NS,
            Side::Behind => LONG_NS,
        };
        // Of a burst both are short: by arrivals at once, by stamps where they stand still.
        let (by_arrivals, by_stamps) = self.law.age();
        self.frames >= FRAMES && self.law.has_settled() && by_arrivals >= least && by_stamps >= least / 2.0
    }
}
