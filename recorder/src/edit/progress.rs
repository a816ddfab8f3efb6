//! How far long work has come, for a person who watches a terminal.

use std::io::{IsTerminal, Write, stderr};

use bus::clock::monotonic_ns;

/// Nothing is said about work that takes less.
const PATIENCE_NS: i64 = 1_000_000_000;
/// Between two words.
const EVERY_NS: i64 = 200_000_000;

/// One line on the terminal that is written over. Elsewhere nothing is said.
#[derive(Debug)]
pub(crate) struct Progress {
    what: &'static str,
    next_ns: Option<i64>,
    calls: u32,
    said: bool,
}

impl Progress {
    /// Begins work that is called `what`.
    pub(crate) fn new(what: &'static str) -> Self {
        Self {
            what,
            next_ns: stderr().is_terminal().then(|| monotonic_ns() + PATIENCE_NS),
            calls: 0,
            said: false,
        }
    }

    /// `done` of `all` bytes are done.
    pub(crate) fn at(&mut self, done: u64, all: u64) {
        let Some(next_ns) = self.next_ns else { return };
        self.calls = self.calls.wrapping_add(1);
        // The clock is asked once in a while: there are millions of messages.
        if !self.calls.is_multiple_of(256) || monotonic_ns() < next_ns {
            return;
        }
        self.next_ns = Some(monotonic_ns() + EVERY_NS);
        self.said = true;
        let percent = 100.0 * done as f64 / all.max(1) as f64;
        let _ = write!(stderr(), "\r{}: {percent:3.0} %", self.what);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.said {
            let _ = write!(stderr(), "\r{:width$}\r", "", width = self.what.len() + 8);
        }
    }
}
