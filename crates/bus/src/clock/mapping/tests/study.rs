//! A link, mapped.

use super::super::{Event, Mapping, Settings};
use super::links::Link;

/// What a mapping made of a link.
pub(super) struct Study {
    /// Truth of each frame, s, and error, ns.
    errors: Vec<(f64, f64)>,
    /// Frames after the first 2 s that were mapped, and those of them whose error was covered.
    pub(super) mapped: usize,
    pub(super) covered: usize,
    pub(super) in_the_future: usize,
    pub(super) backwards: usize,
    /// When steps were told, s, and their sizes.
    pub(super) steps: Vec<(f64, i64)>,
}

pub(super) fn ns(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

impl Study {
    pub(super) fn of(link: &Link, settings: Settings) -> Self {
        let mut mapping = Mapping::new(settings);
        let mut study = Self {
            errors: Vec::new(),
            mapped: 0,
            covered: 0,
            in_the_future: 0,
            backwards: 0,
            steps: Vec::new(),
        };
        let mut last = i64::MIN;
        for ((&device, &arrival), &truth) in link.device.iter().zip(&link.arrival).zip(&link.truth) {
            let mapped = mapping.map(ns(device), ns(arrival));
            let error = mapped.capture_ns as f64 - truth * 1e9;
            study.errors.push((truth, error));
            study.in_the_future += usize::from(mapped.capture_ns > ns(arrival));
            study.backwards += usize::from(mapped.capture_ns < last);
            last = mapped.capture_ns;
            if let Some(uncertain) = mapped.uncertain_ns.filter(|_| truth > 2.0) {
                study.mapped += 1;
                study.covered += usize::from(error.abs() <= uncertain as f64);
            }
            if let Some(Event::Step { by_ns }) = mapped.event {
                study.steps.push((arrival, by_ns));
            }
        }
        study
    }

    /// A quantile of the errors' sizes from a time on, ns.
    pub(super) fn error_quantile(&self, q: f64, from_s: f64) -> f64 {
        self.error_quantile_within(q, from_s, f64::INFINITY)
    }

    pub(super) fn error_quantile_within(&self, q: f64, from_s: f64, to_s: f64) -> f64 {
        let chosen = self.errors.iter().filter(|(t, _)| (from_s..to_s).contains(t));
        let mut sizes: Vec<f64> = chosen.map(|(_, error)| error.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        sizes[((sizes.len() - 1) as f64 * q).round() as usize]
    }
}
