//! How long a search took, for people to read.

use std::time::Instant;

/// Runs from the moment it is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stopwatch(Instant);

impl Stopwatch {
    pub(crate) fn start() -> Self {
        #[allow(
            clippy::disallowed_methods,
            reason = "a duration for people; nothing is stamped or decided by it"
        )]
        Self(Instant::now())
    }

    /// Milliseconds so far.
    pub(crate) fn ms(self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}
