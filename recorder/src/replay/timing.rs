//! How well a replay kept time.

use serde::Serialize;

/// The finest step of the distribution, ns.
const STEP_NS: i64 = 10_000;
/// Steps that are told apart; what is later than 1 s falls into the last.
const STEPS: usize = 100_000;

/// How late poses went out, against the clock of the replay. Poses that are due at once after a pause or a jump count too.
#[derive(Debug, Clone)]
pub struct Timing {
    steps: Vec<u32>,
    poses: u64,
    worst_ns: i64,
    within_ms: u64,
    drift_ns: i64,
}

/// The distribution, ms.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize)]
pub struct Lateness {
    /// Poses that were published by the clock.
    pub poses: u64,
    /// Half of them were at most this late.
    pub p50_ms: f64,
    /// 95 of a hundred.
    pub p95_ms: f64,
    /// 99 of a hundred.
    pub p99_ms: f64,
    /// 999 of a thousand.
    pub p999_ms: f64,
    /// The latest.
    pub max_ms: f64,
    /// The share that was within 1 ms.
    pub within_1_ms: f64,
    /// The last pose.
    pub last_ms: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            steps: vec![0; STEPS],
            poses: 0,
            worst_ns: 0,
            within_ms: 0,
            drift_ns: 0,
        }
    }
}

impl Timing {
    /// A pose went out `late_ns` after its time. None goes out early.
    pub fn saw(&mut self, late_ns: i64) {
        let late_ns = late_ns.max(0);
        // Below STEPS.
        let step = (late_ns / STEP_NS).min(STEPS as i64 - 1) as usize;
        self.steps[step] = self.steps[step].saturating_add(1);
        self.poses += 1;
        self.worst_ns = self.worst_ns.max(late_ns);
        self.within_ms += u64::from(late_ns <= 1_000_000);
        self.drift_ns = late_ns;
    }

    /// The distribution; percentiles by nearest rank, rounded up to 10 us and never above the maximum.
    pub fn lateness(&self) -> Lateness {
        let max_ms = bus::clock::ms(self.worst_ns);
        let rank = |p: f64| {
            let wanted = (p * self.poses as f64).ceil() as u64;
            let mut seen = 0;
            let step = self.steps.iter().position(|&count| {
                seen += u64::from(count);
                seen >= wanted
            });
            match step {
                Some(step) if step < STEPS - 1 => bus::clock::ms((step as i64 + 1) * STEP_NS).min(max_ms),
                _ => max_ms,
            }
        };
        Lateness {
            poses: self.poses,
            p50_ms: rank(0.5),
            p95_ms: rank(0.95),
            p99_ms: rank(0.99),
            p999_ms: rank(0.999),
            max_ms,
            within_1_ms: self.within_ms as f64 / self.poses.max(1) as f64,
            last_ms: bus::clock::ms(self.drift_ns),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_rank_and_late_ones_count() {
        let mut timing = Timing::default();
        assert_eq!(timing.lateness(), Lateness::default());
        // 5, 15, 25 ... 985 us, one of 2 ms and one of five seconds.
        (0..99).for_each(|i| timing.saw(i * 10_000 + 5_000));
        timing.saw(5_000_000_000);
        timing.saw(2_000_000);
        let lateness = timing.lateness();
        assert_eq!((lateness.poses, lateness.max_ms, lateness.last_ms), (101, 5000.0, 2.0));
        // The 51st of 101 is 505 us: in the step that ends at 510 us.
        assert_eq!(lateness.p50_ms, 0.51);
        assert_eq!(lateness.p999_ms, 5000.0);
        assert!((lateness.within_1_ms - 99.0 / 101.0).abs() < 1e-12);
    }
}
