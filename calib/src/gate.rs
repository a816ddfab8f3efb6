//! When a calibration is good enough: limits, and a verdict with its numbers.
//!
//! The same limits serve every calibration: a pivot, a spin, a marker, a base or a registration. A limit that is not set
//! is not tested; a limit that is set for something that was not measured, or is not a number, refuses.

use std::fmt;

/// The largest or least values accepted; `None` is not tested.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gates {
    /// Root mean square residual, mm, at most.
    pub max_rms_mm: Option<f64>,
    /// Standard deviation of the tip's place in its worst direction, mm, at most.
    pub max_tip_sigma_mm: Option<f64>,
    /// Root mean square error of the tip by its covariance, mm, at most.
    pub max_tip_error_mm: Option<f64>,
    /// Error predicted at the target, 95 %, mm, at most.
    pub max_target_mm: Option<f64>,
    /// Condition of the normal equations, without unit, at most.
    pub max_condition: Option<f64>,
    /// Residuals in units of the noise given, at most.
    pub max_noise_ratio: Option<f64>,
    /// Share of the measurements left out, 0 to 1, at most.
    pub max_rejected: Option<f64>,
    /// Angle that the motion covers, radians, at least.
    pub min_coverage_rad: Option<f64>,
    /// Measurements that took part, at least.
    pub min_count: Option<usize>,
}

/// What a calibration reached; `None` where it does not apply.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reached {
    /// Root mean square residual, mm.
    pub rms_mm: Option<f64>,
    /// Standard deviation of the tip's place in its worst direction, mm.
    pub tip_sigma_mm: Option<f64>,
    /// Root mean square error of the tip by its covariance, mm.
    pub tip_error_mm: Option<f64>,
    /// Error predicted at the target, 95 %, mm.
    pub target_mm: Option<f64>,
    /// Condition of the normal equations, without unit.
    pub condition: Option<f64>,
    /// Residuals in units of the noise given.
    pub noise_ratio: Option<f64>,
    /// Share of the measurements left out, 0 to 1.
    pub rejected: Option<f64>,
    /// Angle that the motion covers, radians.
    pub coverage_rad: Option<f64>,
    /// Measurements that took part.
    pub count: Option<usize>,
}

/// One limit that was passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reason {
    /// What was measured, with its unit.
    pub what: &'static str,
    /// The value found; `None` where it was not measured.
    pub found: Option<f64>,
    /// The limit.
    pub limit: f64,
    /// Whether the limit is a least value.
    pub least: bool,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.least { "at least" } else { "at most" };
        match self.found {
            Some(found) => write!(f, "{}: {found:.4}, {side} {:.4} is accepted", self.what, self.limit),
            None => write!(f, "{}: not measured, {side} {:.4} is accepted", self.what, self.limit),
        }
    }
}

/// What the gates say.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// Every limit that is set is kept.
    Accepted,
    /// Some are not; in the order of [`Gates`].
    Refused(Vec<Reason>),
}

impl Verdict {
    /// True where accepted.
    pub const fn is_accepted(&self) -> bool {
        matches!(self, Self::Accepted)
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Accepted => write!(f, "accepted"),
            Self::Refused(reasons) => {
                let reasons: Vec<String> = reasons.iter().map(Reason::to_string).collect();
                write!(f, "refused: {}", reasons.join("; "))
            }
        }
    }
}

impl Gates {
    /// Holds what a calibration reached against the limits. A value equal to its limit is accepted.
    pub fn judge(&self, reached: &Reached) -> Verdict {
        let degrees = |x: Option<f64>| x.map(f64::to_degrees);
        let number = |x: Option<usize>| x.map(|n| n as f64);
        // All that falls short, not the first alone: a person puts it right at once.
        let reasons: Vec<Reason> = [
            most("root mean square residual, mm", reached.rms_mm, self.max_rms_mm),
            most("deviation of the tip, mm", reached.tip_sigma_mm, self.max_tip_sigma_mm),
            most("error of the tip, mm", reached.tip_error_mm, self.max_tip_error_mm),
            most(
                "error predicted at the target (95 %), mm",
                reached.target_mm,
                self.max_target_mm,
            ),
            most("condition", reached.condition, self.max_condition),
            most(
                "residuals over the noise given",
                reached.noise_ratio,
                self.max_noise_ratio,
            ),
            most("share left out", reached.rejected, self.max_rejected),
            least(
                "motion covered, degrees",
                degrees(reached.coverage_rad),
                degrees(self.min_coverage_rad),
            ),
            least("measurements", number(reached.count), number(self.min_count)),
        ]
        .into_iter()
        .flatten()
        .collect();
        if reasons.is_empty() {
            return Verdict::Accepted;
        }
        Verdict::Refused(reasons)
    }
}

fn most(what: &'static str, found: Option<f64>, limit: Option<f64>) -> Option<Reason> {
    let limit = limit?;
    // A NaN, found or set, is not within.
    let within = found.is_some_and(|x| x <= limit);
    (!within).then_some(Reason {
        what,
        found,
        limit,
        least: false,
    })
}

fn least(what: &'static str, found: Option<f64>, limit: Option<f64>) -> Option<Reason> {
    let limit = limit?;
    let within = found.is_some_and(|x| x >= limit);
    (!within).then_some(Reason {
        what,
        found,
        limit,
        least: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GATES: Gates = Gates {
        max_rms_mm: Some(0.5),
        max_tip_sigma_mm: None,
        max_tip_error_mm: Some(0.4),
        max_target_mm: None,
        max_condition: Some(100.0),
        max_noise_ratio: None,
        max_rejected: Some(0.1),
        min_coverage_rad: Some(0.5),
        min_count: Some(20),
    };
    const GOOD: Reached = Reached {
        rms_mm: Some(0.5),
        tip_sigma_mm: None,
        tip_error_mm: Some(0.4),
        target_mm: Some(1e9),
        condition: Some(99.0),
        noise_ratio: Some(1e9),
        rejected: Some(0.0),
        coverage_rad: Some(0.5),
        count: Some(20),
    };

    #[test]
    fn limits_are_kept_or_named() {
        assert_eq!(GATES.judge(&GOOD), Verdict::Accepted);
        assert_eq!(Gates::default().judge(&Reached::default()), Verdict::Accepted);
        let bad = Reached {
            rms_mm: Some(0.51),
            coverage_rad: Some(0.1),
            count: Some(19),
            ..GOOD
        };
        let verdict = GATES.judge(&bad);
        let Verdict::Refused(reasons) = &verdict else {
            panic!("{verdict}")
        };
        let found: Vec<_> = reasons.iter().map(|r| (r.found.unwrap(), r.limit, r.least)).collect();
        assert_eq!(found[0], (0.51, 0.5, false));
        assert_eq!(found[1], (0.1_f64.to_degrees(), 0.5_f64.to_degrees(), true));
        assert_eq!(found[2], (19.0, 20.0, true));
        assert!(
            verdict.to_string().contains("5.7296, at least 28.6479 is accepted"),
            "{verdict}"
        );
    }

    #[test]
    fn what_is_not_a_number_or_not_measured_is_refused() {
        for (rms_mm, condition) in [(Some(f64::NAN), Some(1.0)), (None, Some(1.0)), (Some(0.1), None)] {
            let bad = Reached {
                rms_mm,
                condition,
                ..GOOD
            };
            assert!(!GATES.judge(&bad).is_accepted(), "{bad:?}");
        }
    }
}
