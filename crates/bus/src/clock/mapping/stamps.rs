//! Whether a device's stamp may be used at all, by itself and beside those before it.

use super::quality::Reason;

/// The first nanosecond that OpenIGTLink's 32 bits of seconds since 1970 cannot say.
const END_NS: i64 = (1 << 32) * 1_000_000_000;
/// A stamp that has stood still for this long, and for so many frames, is called frozen.
const FROZEN_NS: i64 = 500_000_000;
const FROZEN_FRAMES: u32 = 3;
/// Over which time of arrivals the speed of stamps is taken, and how often in a row it must be wrong: a link that stalls gives one wrong
/// speed, and then the opposite one.
const SPEED_NS: i64 = 2_000_000_000;
const WRONG_SPEEDS: u32 = 3;

/// No device counts in more than seconds.
const COARSEST_NS: i64 = 1_000_000_000;

/// What is remembered of the stamps before.
#[derive(Debug, Clone)]
pub(super) struct Stamps {
    last_ns: Option<i64>,
    /// When the last stamp came first, and how often it came again.
    since_ns: i64,
    repeats: u32,
    speed: Speed,
    grain_ns: i64,
}

impl Default for Stamps {
    fn default() -> Self {
        Self {
            last_ns: None,
            since_ns: 0,
            repeats: 0,
            speed: Speed::default(),
            grain_ns: COARSEST_NS,
        }
    }
}

impl Stamps {
    /// The greatest power of ten, nanoseconds, of which all stamps were multiples: what a device that cuts its stamps off cuts them to.
    pub(super) fn grain_ns(&self) -> i64 {
        self.grain_ns
    }

    /// The next stamp comes over another connection: that it is one of before says nothing.
    pub(super) fn reconnected(&mut self) {
        *self = Self {
            grain_ns: self.grain_ns,
            ..Self::default()
        };
    }

    /// Why this stamp says nothing, or `None`.
    pub(super) fn judge(&mut self, device_ns: i64, arrival_ns: i64) -> Option<Reason> {
        if device_ns == 0 {
            return Some(Reason::NoStamp);
        }
        if !(0..END_NS).contains(&device_ns) {
            return Some(Reason::OutOfRange);
        }
        let last = self.last_ns.replace(device_ns);
        // Stamps come as 2^-32 s, a quarter of a nanosecond: a multiple may be off by one.
        while self.grain_ns > 1 && (device_ns + 1) % self.grain_ns > 2 {
            self.grain_ns /= 10;
        }
        let wrong_speed = self.speed.is_wrong(device_ns, arrival_ns);
        if last == Some(device_ns) {
            return Some(self.repeated(arrival_ns));
        }
        (self.since_ns, self.repeats) = (arrival_ns, 0);
        if last.is_some_and(|last| device_ns < last) {
            self.speed = Speed::default();
            return Some(Reason::Backwards);
        }
        wrong_speed.then_some(Reason::Rate)
    }

    fn repeated(&mut self, arrival_ns: i64) -> Reason {
        self.repeats = self.repeats.saturating_add(1);
        let stood_ns = arrival_ns.saturating_sub(self.since_ns);
        if stood_ns >= FROZEN_NS && self.repeats >= FROZEN_FRAMES {
            Reason::Frozen
        } else {
            Reason::Repeated
        }
    }
}

/// How fast stamps go on, against arrivals.
#[derive(Debug, Clone, Default)]
struct Speed {
    /// Stamp and arrival from which on it is taken.
    from_ns: Option<(i64, i64)>,
    too_slow: u32,
    too_fast: u32,
}

impl Speed {
    fn is_wrong(&mut self, device_ns: i64, arrival_ns: i64) -> bool {
        let (device_from, arrival_from) = *self.from_ns.get_or_insert((device_ns, arrival_ns));
        let by_arrivals = arrival_ns.saturating_sub(arrival_from);
        if by_arrivals >= SPEED_NS {
            self.take(device_ns.saturating_sub(device_from), by_arrivals);
            self.from_ns = Some((device_ns, arrival_ns));
        }
        self.too_slow.max(self.too_fast) >= WRONG_SPEEDS
    }

    fn take(&mut self, by_stamps: i64, by_arrivals: i64) {
        let too_slow = by_stamps < by_arrivals / 2;
        let too_fast = by_stamps / 2 > by_arrivals;
        self.too_slow = if too_slow { self.too_slow + 1 } else { 0 };
        self.too_fast = if too_fast { self.too_fast + 1 } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn stamps_that_no_device_can_mean_are_named() {
        let mut stamps = Stamps::default();
        assert_eq!(stamps.judge(0, 0), Some(Reason::NoStamp));
        for stamp in [-1, i64::MIN, i64::MAX, END_NS] {
            assert_eq!(stamps.judge(stamp, 0), Some(Reason::OutOfRange));
        }
        assert_eq!(stamps.judge(END_NS - 1, 0), None);
        assert_eq!(stamps.judge(1, i64::MAX), Some(Reason::Backwards));
    }

    #[test]
    fn a_stamp_that_stands_still_is_frozen_after_half_a_second() {
        let mut stamps = Stamps::default();
        assert_eq!(stamps.judge(7, 0), None);
        assert_eq!(stamps.judge(7, 490 * MS), Some(Reason::Repeated));
        assert_eq!(stamps.judge(7, 600 * MS), Some(Reason::Repeated));
        assert_eq!(stamps.judge(7, 610 * MS), Some(Reason::Frozen));
        assert_eq!(stamps.judge(8, 620 * MS), None);
    }

    /// Milliseconds taken for seconds, or for microseconds.
    #[test]
    fn another_unit_is_told_by_its_speed() {
        for (step, wrong) in [(MS / 100, true), (10 * MS, false), (10_000 * MS, true)] {
            let mut stamps = Stamps::default();
            let last = (1..1000).map(|k| stamps.judge(k * step, k * 10 * MS)).last().flatten();
            assert_eq!(last, wrong.then_some(Reason::Rate));
        }
    }

    #[test]
    fn a_stall_of_a_minute_is_no_wrong_speed() {
        let mut stamps = Stamps::default();
        for k in 1..20_000 {
            let device = k * 10 * MS;
            let stalled = (60_000..120_000).contains(&(k * 10));
            let arrival = if stalled { 120_000 * MS } else { device };
            assert_eq!(stamps.judge(device, arrival), None, "{k}");
        }
    }
}
