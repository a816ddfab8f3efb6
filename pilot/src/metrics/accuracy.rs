//! How well the tool was followed: the predicted errors at the tip, and why there were none. In bounded memory, however long
//! a run goes on.

use std::collections::BTreeMap;

use bus::clock;
use bus::message::{Lost, ToolPose};
use serde::Serialize;

use fit::Histogram;

/// Predicted errors from `LEAST_MM` to `MOST_MM` are told apart.
const LEAST_MM: f64 = 1e-3;
const MOST_MM: f64 = 1e3;

/// Fed with each sample.
#[derive(Debug, Clone)]
pub(crate) struct AccuracyBook {
    /// Poses by their predicted error at the tip.
    tips: Histogram,
    valid: u64,
    outside: u64,
    with_outliers: u64,
    outliers: u64,
    longest_delay_ns: i64,
    lost: BTreeMap<&'static str, u64>,
}

impl Default for AccuracyBook {
    fn default() -> Self {
        Self {
            tips: Histogram::new(LEAST_MM, MOST_MM),
            valid: 0,
            outside: 0,
            with_outliers: 0,
            outliers: 0,
            longest_delay_ns: 0,
            lost: BTreeMap::new(),
        }
    }
}

/// The same for the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct AccuracyReport {
    /// Valid poses whose error at the tip was predicted.
    pub(crate) tip_known: u64,
    /// Predicted error at the tip (95 %), mm, over these, to 1 %; `null` without any.
    pub(crate) tip_95_mm: Option<TipReport>,
    /// Share of the valid poses whose tip was outside the examination.
    pub(crate) outside_share: f64,
    /// Valid poses for which an emitter that was seen was left out.
    pub(crate) poses_with_outliers: u64,
    /// How many emitters that were.
    pub(crate) outliers: u64,
    /// Samples without a pose, by reason.
    pub(crate) lost: BTreeMap<&'static str, u64>,
    /// The delay of smoothing, ms; 0: poses were not smoothed.
    pub(crate) smoothing_delay_ms: f64,
}

/// Predicted errors at the tip, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TipReport {
    pub(crate) median: f64,
    pub(crate) p95: f64,
    pub(crate) max: f64,
}

impl AccuracyBook {
    /// A sample with a pose, whose tip is `outside` the examination or not.
    pub(crate) fn valid(&mut self, pose: &ToolPose, outside: bool) {
        self.valid += 1;
        self.outside += u64::from(outside);
        let outliers = u64::from(pose.visible.saturating_sub(pose.used));
        // A source of poses without emitters uses none.
        if pose.used > 0 && outliers > 0 {
            self.with_outliers += 1;
            self.outliers += outliers;
        }
        self.longest_delay_ns = self.longest_delay_ns.max(pose.delay_ns);
        if let Some(mm) = pose.tip_95_mm() {
            self.tips.add(mm);
        }
    }

    /// A sample without one.
    pub(crate) fn lost(&mut self, reason: Lost) {
        *self.lost.entry(reason.words()).or_default() += 1;
    }

    /// How many samples had no pose for this reason.
    pub(crate) fn lost_by(&self, reason: Lost) -> u64 {
        self.lost.get(reason.words()).copied().unwrap_or(0)
    }

    pub(crate) fn report(&self) -> AccuracyReport {
        let tip_known = self.tips.count();
        AccuracyReport {
            tip_known,
            tip_95_mm: (tip_known > 0).then(|| TipReport {
                median: self.tips.quantile(0.5),
                p95: self.tips.quantile(0.95),
                max: self.tips.most(),
            }),
            outside_share: self.outside as f64 / self.valid.max(1) as f64,
            poses_with_outliers: self.with_outliers,
            outliers: self.outliers,
            lost: self.lost.clone(),
            smoothing_delay_ms: clock::ms(self.longest_delay_ns),
        }
    }
}

impl AccuracyReport {
    /// A line for people.
    pub(crate) fn line(&self) -> String {
        let tip = match &self.tip_95_mm {
            Some(tip) => format!(
                "error predicted at the tip (95 %): median {:.2} mm, p95 {:.2} mm, max {:.2} mm",
                tip.median, tip.p95, tip.max
            ),
            None => "the error at the tip is not known".to_owned(),
        };
        let outside = format!("tip outside the CT in {:.1} % of the poses", 100.0 * self.outside_share);
        let lost = self.lost.iter().map(|(reason, count)| format!("{reason} {count}"));
        let lost: Vec<String> = lost.collect();
        let lost = if lost.is_empty() {
            String::new()
        } else {
            format!("; lost: {}", lost.join(", "))
        };
        format!("{tip}; {outside}{lost}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(tip_mm: f64) -> ToolPose {
        ToolPose {
            tip_mm,
            flags: ToolPose::TIP_KNOWN,
            visible: 7,
            used: 7,
            ..ToolPose::EMPTY
        }
    }

    #[test]
    fn quantiles_are_those_of_the_samples_to_one_percent() {
        let mut book = AccuracyBook::default();
        for i in 1..=1000 {
            book.valid(&pose(f64::from(i) / 500.0), false);
        }
        let tip = book.report().tip_95_mm.unwrap();
        for (found, truth) in [(tip.median, 1.0), (tip.p95, 1.9), (tip.max, 2.0)] {
            assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
        }
        for odd in [0.0, 1e-9, 1e3] {
            let mut book = AccuracyBook::default();
            book.valid(&pose(odd), false);
            let tip = book.report().tip_95_mm.unwrap();
            assert!(tip.median <= odd && tip.max == odd, "{tip:?}");
        }
    }

    #[test]
    fn what_is_not_known_is_null_and_shares_are_of_the_valid() {
        let mut book = AccuracyBook::default();
        assert_eq!(book.report().tip_95_mm, None);
        let outlying = ToolPose {
            visible: 9,
            used: 7,
            ..ToolPose::EMPTY
        };
        book.valid(&outlying, true);
        book.valid(&ToolPose::EMPTY, false);
        book.lost(Lost::NotSeen);
        book.lost(Lost::NotSeen);
        let report = book.report();
        assert_eq!(
            (report.tip_known, report.tip_95_mm, report.outside_share),
            (0, None, 0.5)
        );
        assert_eq!((report.poses_with_outliers, report.outliers), (1, 2));
        assert_eq!(report.lost, BTreeMap::from([("marker not seen", 2)]));
    }
}
