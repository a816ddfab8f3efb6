//! The law of a device's clock: a line below the newest frames.

use super::hull::{Line, Point, eighth, slope_below};
use super::skew::Skew;

/// Bins of a window at most. Of each bin the frame with the least delay is kept.
const BINS: usize = 80;
/// Bins begin 64 times narrower than they end, so that a law that has just begun has as many as an old one.
const FIRST_OF_WIDTH: f64 = 1.0 / 64.0;
/// Between the beginning of a law and its first use.
const SETTLE_NS: f64 = 120e6;
/// Slots of the floor and the time of arrivals that one holds: half a second, or more where frames are few.
const SLOTS: usize = 8;
const SLOT_NS: f64 = 64e6;
/// What is made of the eighth distance: the deviation of a skew, whose two ends are each that uncertain, and the bound of an offset. With
/// these the bound held 99 frames of 100 where delays grow evenly from the least one, and where few are near it (sums of two).
const SKEW_FACTOR: f64 = 4.0;
const OFFSET_FACTOR: f64 = 2.5;
/// What the clocks cannot resolve.
const RESOLUTION_NS: f64 = 1000.0;

/// The lower envelope of arrival less stamp over a window, as a line.
#[derive(Debug, Clone)]
pub(super) struct Envelope {
    window: f64,
    skew_bound: f64,
    /// The first frame: stamp, and arrival less stamp, which may not fit into 64 bits. All else is counted from there.
    base: Option<(i64, i128)>,
    /// The frame of least delay of each closed bin, the oldest first.
    bins: Vec<Point>,
    width: f64,
    open: Option<Point>,
    open_from: f64,
    hull: Vec<Point>,
    line: Line,
    skew: Skew,
    /// How far the line may lie above the least delay; `None` until there are bins enough.
    noise: Option<f64>,
    /// The frame of least delay of each of the last slots of arrivals, and where the newest slot began.
    slots: [Option<Point>; SLOTS],
    slot: usize,
    slot_from: f64,
    /// Stamps and arrivals from the base to the newest frame.
    newest: Point,
}

impl Envelope {
    pub(super) fn new(window_ns: i64, skew_bound: f64) -> Self {
        let window = window_ns as f64;
        Self {
            window,
            skew_bound,
            base: None,
            bins: Vec::with_capacity(BINS),
            width: 0.0,
            open: None,
            open_from: 0.0,
            hull: Vec::with_capacity(BINS + 1),
            line: Line::default(),
            skew: Skew::new(),
            noise: None,
            slots: [None; SLOTS],
            slot: 0,
            slot_from: 0.0,
            newest: Point { x: 0.0, y: 0.0 },
        }
    }

    /// Forgets all frames. The skew is kept: whoever sets a clock does not change its crystal.
    pub(super) fn clear(&mut self, skew: Skew) {
        self.base = None;
        self.bins.clear();
        self.open = None;
        self.noise = None;
        self.slots = [None; SLOTS];
        self.skew = skew.after_a_step();
    }

    pub(super) fn skew(&self) -> Skew {
        self.skew
    }

    pub(super) fn is_empty(&self) -> bool {
        self.base.is_none()
    }

    /// A frame from the base; the base itself where there is none yet.
    fn point(&self, device_ns: i64, arrival_ns: i64) -> Point {
        let offset = i128::from(arrival_ns) - i128::from(device_ns);
        let (device_base, offset_base) = self.base.unwrap_or((device_ns, offset));
        // Exact for frames within 104 days of the base.
        Point {
            x: (i128::from(device_ns) - i128::from(device_base)) as f64,
            y: (offset - offset_base) as f64,
        }
    }

    /// How much later than the law says a frame arrived; negative before it was allowed to.
    pub(super) fn late(&self, device_ns: i64, arrival_ns: i64) -> f64 {
        self.line.below(self.point(device_ns, arrival_ns))
    }

    /// When a frame of this stamp arrives at the earliest by the law; about `near_ns`, for the precision.
    pub(super) fn arrival_of(&self, device_ns: i64, near_ns: i64) -> i64 {
        near_ns.saturating_sub(self.late(device_ns, near_ns) as i64)
    }

    /// How long no frame was taken before this one. Both its stamp and its arrival must say so: one alone is a step, or a stall.
    pub(super) fn silence(&self, device_ns: i64, arrival_ns: i64) -> f64 {
        let (point, newest) = (self.point(device_ns, arrival_ns), self.newest);
        let by_stamps = point.x - newest.x;
        by_stamps.min(by_stamps + point.y - newest.y)
    }

    /// From the first frame to the newest, by arrivals and by stamps.
    pub(super) fn age(&self) -> (f64, f64) {
        (self.newest.x + self.newest.y, self.newest.x)
    }

    /// Takes a frame whose stamp is later than that of the one before. The line never lies above it.
    pub(super) fn push(&mut self, device_ns: i64, arrival_ns: i64) {
        let point = self.point(device_ns, arrival_ns);
        if self.base.is_none() {
            self.begin(device_ns, arrival_ns);
        }
        self.newest = point;
        self.line.offset += self.line.below(point).min(0.0);
        self.put_in_slot(point);
        match self.open {
            Some(open) if point.x - self.open_from < self.width => {
                if self.line.below(point) < self.line.below(open) {
                    self.open = Some(point);
                }
            }
            _ => self.close_bin(point),
        }
    }

    fn begin(&mut self, device_ns: i64, arrival_ns: i64) {
        self.base = Some((device_ns, i128::from(arrival_ns) - i128::from(device_ns)));
        self.line = Line {
            slope: self.skew.now,
            offset: 0.0,
        };
        self.width = self.window / BINS as f64 * FIRST_OF_WIDTH;
        self.slot_from = f64::NEG_INFINITY;
    }

    /// A burst of late frames fills one slot, however many they are, and says no more than one frame.
    fn put_in_slot(&mut self, point: Point) {
        let arrival = point.x + point.y;
        if arrival - self.slot_from >= SLOT_NS {
            self.slot = (self.slot + 1) % SLOTS;
            (self.slots[self.slot], self.slot_from) = (None, arrival);
        }
        let kept = &mut self.slots[self.slot];
        if kept.is_none_or(|kept| self.line.below(point) < self.line.below(kept)) {
            *kept = Some(point);
        }
    }

    fn close_bin(&mut self, point: Point) {
        self.bins.extend(self.open.replace(point));
        self.open_from = point.x;
        let expired = self.bins.iter().take_while(|p| p.x < point.x - self.window).count();
        self.bins.drain(..expired);
        if self.bins.len() == BINS {
            self.widen();
        }
        self.fit();
    }

    /// Two bins become one, or the oldest goes where they are as wide as they get.
    fn widen(&mut self) {
        if self.width >= self.window / BINS as f64 {
            self.bins.remove(0);
            return;
        }
        self.width *= 2.0;
        for k in 0..BINS / 2 {
            let (a, b) = (self.bins[2 * k], self.bins[2 * k + 1]);
            self.bins[k] = if self.line.below(b) < self.line.below(a) { b } else { a };
        }
        self.bins.truncate(BINS / 2);
    }

    fn fit(&mut self) {
        self.fit_skew();
        let open = self.open.into_iter();
        self.line = Line::supporting(self.skew.now, self.bins.iter().copied().chain(open));
        // Until there are bins enough, a law that was lowered keeps what was said of it then.
        if let Some(distance) = eighth(&self.bins, self.line) {
            self.noise = Some(distance);
        }
    }

    /// What the window says of the skew, and how well: two ends that are each known to the eighth distance.
    fn fit_skew(&mut self) {
        let Some(slope) = slope_below(&self.bins, &mut self.hull) else {
            return;
        };
        let line = Line::supporting(slope, self.bins.iter().copied());
        let Some(distance) = eighth(&self.bins, line) else {
            return;
        };
        let sigma = SKEW_FACTOR * (distance + RESOLUTION_NS) / (self.span() / 2.0);
        self.skew
            .see(slope, sigma, self.newest.x, (self.window, self.skew_bound));
    }

    fn span(&self) -> f64 {
        self.bins.first().map_or(0.0, |oldest| self.newest.x - oldest.x)
    }

    /// Whether the law may be used.
    pub(super) fn has_settled(&self) -> bool {
        self.noise.is_some() && self.age().0 >= SETTLE_NS
    }

    /// How far the line may lie above the least delay, nanoseconds.
    pub(super) fn noise(&self) -> f64 {
        self.noise.unwrap_or(f64::INFINITY)
    }

    /// How far the law may be from the capture plus the least delay, nanoseconds: above it by the noise and what the skew's deviation
    /// makes of it from the middle of the window to its end, below it by no more than the floor.
    pub(super) fn uncertain(&self) -> f64 {
        OFFSET_FACTOR * self.noise() + self.skew.sigma * self.span() / 2.0 + self.floor() + RESOLUTION_NS
    }

    /// The least lateness of the last half second: were the law too early, all frames would be late by that at least.
    pub(super) fn floor(&self) -> f64 {
        let late = self.slots.iter().flatten().map(|&p| self.line.below(p).max(0.0));
        late.fold(f64::INFINITY, f64::min)
    }

    /// By how much more a frame with this stamp would be delayed by this law than by `other`'s, nanoseconds.
    pub(super) fn above(&self, other: &Self, device_ns: i64) -> i128 {
        let at = |law: &Self| {
            let (device_base, offset_base) = law.base.unwrap_or_default();
            let x = (i128::from(device_ns) - i128::from(device_base)) as f64;
            offset_base + law.line.at(x).round() as i128
        };
        at(self) - at(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Many frames, at 4 kHz and at 10 Hz.
    #[test]
    fn a_law_takes_its_memory_once() {
        for period_ns in [250_000, 100_000_000] {
            let mut law = Envelope::new(20_000_000_000, 200e-6);
            let before = [law.bins.capacity(), law.hull.capacity()];
            for k in 1..40_000 {
                law.push(k * period_ns, k * period_ns + k * 7919 % 1_000_000);
            }
            assert_eq!([law.bins.capacity(), law.hull.capacity()], before);
            assert!(law.bins.len() > BINS / 4);
        }
    }

    #[test]
    fn the_law_lies_below_every_frame_of_its_window_that_it_keeps() {
        let mut law = Envelope::new(20_000_000_000, 200e-6);
        for k in 1..5000 {
            law.push(k * 16_000_000, k * 16_000_000 + k * 7919 % 1_000_000);
            assert!(law.bins.iter().chain(&law.open).all(|&p| law.line.below(p) >= -1e-3));
        }
    }
}
