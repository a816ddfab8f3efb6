//! How far a long read is: a bar on a terminal, a line now and then elsewhere.

use std::io::{IsTerminal, Write};

use bus::clock::{self, Clock};

/// Between two updates of the bar, and between two lines.
const BAR_NS: i64 = 100_000_000;
const LINE_NS: i64 = 2_000_000_000;

/// Progress on stderr; quiet for reads that take less than a moment.
#[derive(Debug)]
pub(crate) struct Progress {
    clock: Clock,
    began_ns: i64,
    next_ns: i64,
    total: u32,
    terminal: bool,
    shown: bool,
}

impl Progress {
    pub(crate) fn new(clock: Clock, total: u32) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let began_ns = clock.now_ns();
        Self {
            next_ns: began_ns + if terminal { BAR_NS } else { LINE_NS },
            clock,
            began_ns,
            total,
            terminal,
            shown: false,
        }
    }

    /// `done` of the total are read.
    pub(crate) fn at(&mut self, done: u32) {
        let now = self.clock.now_ns();
        if now < self.next_ns || done == 0 {
            return;
        }
        let left = (now - self.began_ns) as f64 * f64::from(self.total - done) / f64::from(done);
        let percent = 100 * u64::from(done) / u64::from(self.total.max(1));
        let text = format!("reading: {percent} %, {:.0} s to go", left / 1e9);
        if self.terminal {
            let filled = (percent / 4) as usize;
            let bar = format!("{}{}", "#".repeat(filled), ".".repeat(25 - filled.min(25)));
            let _ = write!(std::io::stderr(), "\r[{bar}] {text}   ");
            self.shown = true;
        } else {
            bus::stderr_line!("volume-loader: {text}");
        }
        self.next_ns = now + if self.terminal { BAR_NS } else { LINE_NS };
    }

    /// Ends the bar; returns how long it took, s.
    pub(crate) fn finish(self) -> f64 {
        if self.shown {
            bus::stderr_line!("");
        }
        clock::ms(self.clock.now_ns() - self.began_ns) / 1e3
    }
}
