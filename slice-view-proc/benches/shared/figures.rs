//! Times and errors.

use rustix::time::{ClockId, clock_gettime};

/// CPU time of this thread, ns: what other programs on the machine take is not in it.
pub(crate) fn cpu_ns() -> i64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// CPU time of `work`, ms.
pub(crate) fn cpu_ms(work: impl FnOnce()) -> f64 {
    let began = cpu_ns();
    work();
    (cpu_ns() - began) as f64 / 1e6
}

/// Times of the same work.
#[derive(Debug, Clone, Default)]
pub(crate) struct Times(Vec<f64>);

impl Times {
    pub(crate) fn push(&mut self, ms: f64) {
        self.0.push(ms);
    }

    /// NaN where there is none.
    pub(crate) fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
    }

    #[allow(dead_code, reason = "the other benchmark has a fixed number of rounds")]
    pub(crate) fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    #[allow(dead_code, reason = "the trade-off shows medians only")]
    pub(crate) fn least(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Differences from the truth.
#[derive(Debug, Clone, Default)]
pub(crate) struct Errors(Vec<f64>);

impl Errors {
    pub(crate) fn add(&mut self, values: &[f32], truth: impl IntoIterator<Item = f64>) {
        let differences = values.iter().zip(truth).map(|(v, t)| (f64::from(*v) - t).abs());
        self.0.extend(differences);
    }

    /// Root mean square, the 99th percentile, and the largest.
    pub(crate) fn summary(mut self) -> [f64; 3] {
        self.0.sort_by(f64::total_cmp);
        let count = self.0.len().max(1);
        let square: f64 = self.0.iter().map(|d| d * d).sum();
        let at = |part: f64| self.0.get(((count - 1) as f64 * part) as usize).copied();
        let [p99, largest] = [0.99, 1.0].map(|part| at(part).unwrap_or(0.0));
        [(square / count as f64).sqrt(), p99, largest]
    }
}

/// How busy the machine is: processes that run or want to, over the last minute.
pub(crate) fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let minute = text.split_whitespace().next().unwrap_or("unknown");
    let cpus = std::thread::available_parallelism().map_or(0, usize::from);
    format!("load {minute} on {cpus} CPUs")
}
