//! Rows of `cargo xtask bench trade`: what each setting of a dial takes, and how near it comes to the truth.
//!
//! Each benchmark that measures dials has this file as a module. Where the environment names a file in `TROCAR_TRADE`, it measures its
//! dials instead of its own table, and appends a line of CSV for each setting; `TROCAR_TRADE_QUICK` asks for few rounds. All lines have
//! the columns of [`HEADER`].

#![allow(dead_code, reason = "each benchmark uses its part")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

use rustix::time::{ClockId, clock_gettime};

/// Columns. `chosen` is 1 for the setting that `ratio`, of the times in the same run, is over; `against` says what the error is one of.
pub(crate) const HEADER: &str = "dial,setting,chosen,time,time_unit,ratio,error,error_unit,against";

/// Where rows go.
pub(crate) struct Trade {
    file: PathBuf,
    /// Few rounds: the numbers mean little.
    pub(crate) is_quick: bool,
}

/// What is the same for all rows of a dial.
pub(crate) struct Dial {
    pub(crate) name: &'static str,
    /// The setting that times are over: the default, where there is one.
    pub(crate) chosen: String,
    pub(crate) time_unit: &'static str,
    pub(crate) error_unit: &'static str,
    /// What the error is held against. No commas.
    pub(crate) against: &'static str,
}

/// A setting with its median time and its error.
pub(crate) type Row = (String, f64, f64);

impl Trade {
    /// `None` where the benchmark is to print its own table.
    pub(crate) fn wanted() -> Option<Self> {
        Some(Self {
            file: std::env::var_os("TROCAR_TRADE")?.into(),
            is_quick: std::env::var_os("TROCAR_TRADE_QUICK").is_some(),
        })
    }

    /// One of two numbers: of a quick run, or of another.
    pub(crate) fn rounds(&self, quick: usize, full: usize) -> usize {
        if self.is_quick { quick } else { full }
    }

    pub(crate) fn write(&self, dial: &Dial, rows: &[Row]) {
        let chosen = rows.iter().find(|(setting, ..)| *setting == dial.chosen).unwrap().1;
        let mut file = OpenOptions::new().create(true).append(true).open(&self.file).unwrap();
        for (setting, time, error) in rows {
            let texts = [dial.name, setting, dial.time_unit, dial.error_unit, dial.against];
            assert!(texts.iter().all(|t| !t.contains([',', '\n'])), "{texts:?}");
            let (is_chosen, ratio) = (u8::from(*setting == dial.chosen), time / chosen);
            let [name, setting, time_unit, error_unit, against] = texts;
            writeln!(
                file,
                "{name},{setting},{is_chosen},{time:e},{time_unit},{ratio:e},{error:e},{error_unit},{against}"
            )
            .unwrap();
        }
    }
}

/// Seconds that this thread had a processor for.
pub(crate) fn processor_s() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

/// The median seconds of processor of each of `count` contestants, who take turns so that a busy machine treats them alike.
pub(crate) fn turns(rounds: usize, count: usize, mut work: impl FnMut(usize)) -> Vec<f64> {
    let mut times = vec![Vec::new(); count];
    for _ in 0..rounds.max(1) {
        for (contestant, times) in times.iter_mut().enumerate() {
            let began = processor_s();
            work(contestant);
            times.push(processor_s() - began);
        }
    }
    times.into_iter().map(median).collect()
}

/// NaN where there is none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The root of the mean of the squares.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    f64::sqrt(sum / count)
}
