//! A law that is lowered step by step.

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
