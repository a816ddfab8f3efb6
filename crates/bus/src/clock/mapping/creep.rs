//! A law that is lowered step by step, and the one that was there before another began.

/// How long a link lets go of what it held: 1 s. What takes longer is a skew.
const LASTS_NS: i64 = 1_000_000_000;

/// What frames lowered the law by, one soon after another. Where a busy link lets go of the frames it held, each is a little less late than
/// the one before, and a clock that was set forward meanwhile shows by no frame alone.
#[derive(Debug, Clone, Default)]
pub(super) struct Creep(Option<Lowered>);

#[derive(Debug, Clone, Copy)]
struct Lowered {
    since_ns: i64,
    by: f64,
    /// What the law kept before the first of them, nanoseconds.
    tolerance: f64,
}

impl Creep {
    /// A frame that arrived at `arrival_ns` lowers a law of this tolerance. Gives the sum once it is more than a law may be lowered by.
    pub(super) fn lower(&mut self, by: f64, tolerance: f64, arrival_ns: i64) -> Option<f64> {
        let before = self.0.filter(|l| arrival_ns.saturating_sub(l.since_ns) <= LASTS_NS);
        let begun = before.unwrap_or(Lowered {
            since_ns: arrival_ns,
            by: 0.0,
            tolerance,
        });
        let sum = begun.by + by;
        self.0 = Some(Lowered { by: sum, ..begun });
        (sum > begun.tolerance).then_some(sum)
    }

    pub(super) fn forget(&mut self) {
        self.0 = None;
    }
}

/// By how much a clock was found to be set, ns; forward is positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) by_ns: i64,
    /// What the law was moved by of it before it was found.
    pub(super) counted_ns: i64,
    /// It is more than what the clocks, or the law, may have gone otherwise.
    pub(super) is_told: bool,
}

/// A law that another has begun in the place of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Before {
    /// A stamp, and when its frame had arrived by that law.
    pub(super) device_ns: i64,
    pub(super) arrival_ns: i64,
    /// What is less than a step between the two.
    pub(super) least_ns: i64,
    /// What it was moved by of the step before it ended.
    pub(super) counted_ns: i64,
}

impl Before {
    fn arrival_of(&self, device_ns: i64) -> i64 {
        let since_ns = device_ns.saturating_sub(self.device_ns);
        self.arrival_ns.saturating_add(since_ns)
    }

    /// How late a frame is by it, ns; 0 where no step is told from that.
    pub(super) fn late(&self, device_ns: i64, arrival_ns: i64) -> i64 {
        let late_ns = arrival_ns.saturating_sub(self.arrival_of(device_ns));
        if late_ns > self.least_ns { late_ns } else { 0 }
    }

    /// The step between it and the one that has settled, by which a frame of this stamp arrives at `by_new_law_ns`.
    pub(super) fn step(&self, device_ns: i64, by_new_law_ns: i64) -> Step {
        let by_ns = self.arrival_of(device_ns).saturating_sub(by_new_law_ns);
        Step {
            by_ns,
            counted_ns: self.counted_ns,
            is_told: by_ns.saturating_abs() > self.least_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn small_lowerings_add_up_unless_they_are_far_apart() {
        let mut creep = Creep::default();
        // What the law kept before the first counts: each makes it less certain.
        let sums: Vec<_> = (0..4)
            .map(|k| creep.lower(1e6, 2.5e6 * (1.0 + k as f64), k * MS))
            .collect();
        assert_eq!(sums, [None, None, Some(3e6), Some(4e6)]);
        assert_eq!(creep.lower(1e6, 2.5e6, 1001 * MS), None);
        creep.forget();
        assert_eq!(creep.lower(2e6, 2.5e6, 1002 * MS), None);
    }
}
