//! What commands made, and what a person is shown of it.

use bus::message::{StepFigure, StepGate, StepPoint};
use geometry::{Ct, Point, UncertainPoint};

use super::course::Said;
use crate::beads::uncertain;
use crate::calibration::{CalibrationFile, Gate};
use crate::register::file::{Noise, PairResult, RegistrationFile};

/// A calibration as a command made it: its file, and why it is not accepted where it is not.
#[derive(Debug, Clone)]
pub(super) struct Calibrated {
    pub(super) file: CalibrationFile,
    pub(super) text: String,
    pub(super) refused: Option<String>,
}

/// The same of a registration.
#[derive(Debug, Clone)]
pub(super) struct Registered {
    pub(super) file: RegistrationFile,
    pub(super) text: String,
    pub(super) refused: Option<String>,
}

/// Of three numbers of one deviation the length is below so many of it in 95 of 100 cases: the root of 7.815.
const LENGTH_95: f64 = 2.7955;
/// A point whose distance under the registration of all others is beyond so many times what is expected was touched elsewhere.
const OFF: f64 = 1.5;

impl Calibrated {
    /// Of what a command printed with `--json`.
    pub(super) fn of(said: Said) -> Result<Self, String> {
        let outcome = said?;
        let file = serde_json::from_str(&outcome.text);
        let file = file.map_err(|error| unread(outcome.refused.as_deref(), &error))?;
        Ok(Self {
            file,
            text: outcome.text,
            refused: outcome.refused,
        })
    }

    /// Whether the next step may rest on it.
    pub(super) const fn is_accepted(&self) -> bool {
        self.refused.is_none()
    }

    pub(super) fn gates(&self) -> Vec<StepGate> {
        self.file.gates.iter().map(gate).collect()
    }

    /// What else is known of it, a line each.
    pub(super) fn figures(&self) -> Vec<StepFigure> {
        let mut lines = Vec::new();
        if let Some(pivot) = &self.file.pivot {
            lines.push(format!(
                "tip: {} poses agree to {:.2} mm (root mean square), the worst to {:.2}",
                pivot.inliers, pivot.rms_mm, pivot.worst_mm
            ));
            if let Some(c) = pivot.covariance_upper_mm2 {
                lines.push(format!(
                    "tip error {:.2} mm (root mean square, by its covariance)",
                    (c[0] + c[6] + c[11]).max(0.0).sqrt()
                ));
            }
            lines.extend(pivot.coverage.advice.clone());
            if let Some(apart) = &pivot.disagreement {
                lines.push(format!("METHODS DISAGREE: {apart}"));
            }
        }
        if let Some(spin) = &self.file.spin {
            lines.push(format!(
                "shaft: turned by {:.0} degrees; the axis strays by {:.2} degrees and {:.2} mm",
                spin.range_deg, spin.wobble_rms_deg, spin.rms_mm
            ));
        }
        if let Some(tool) = &self.file.tool_frame {
            lines.push(format!("tip off the shaft {:.2} mm", tool.tip_off_axis_mm));
        }
        lines.iter().map(|line| StepFigure::new(line)).collect()
    }
}

impl Registered {
    /// Of what a command printed with `--json`.
    pub(super) fn of(said: Said) -> Result<Self, String> {
        let outcome = said?;
        let file = serde_json::from_str(&outcome.text);
        let file = file.map_err(|error| unread(outcome.refused.as_deref(), &error))?;
        Ok(Self {
            file,
            text: outcome.text,
            refused: outcome.refused,
        })
    }

    pub(super) fn gates(&self) -> Vec<StepGate> {
        self.file.gates.iter().map(gate).collect()
    }

    pub(super) fn figures(&self) -> Vec<StepFigure> {
        let file = &self.file;
        let residuals = format!(
            "residuals {:.2} mm (root mean square), the largest {:.2} mm",
            file.fre_rms_mm, file.fre_max_mm
        );
        let noise = file.noise.as_ref().map(|noise| {
            let origin = match (noise.estimated, noise.touches) {
                (true, _) => "as the residuals suggest",
                (false, Some(_)) => "by their file, the hand and the CT",
                (false, None) => "the least that a hand and a CT err by",
            };
            format!("error of a touch {:.2} mm along each axis, {origin}", noise.sigma_mm)
        });
        let lines = std::iter::once(residuals).chain(noise);
        lines.map(|line| StepFigure::new(&line)).collect()
    }

    /// A pair of the registration, on the point of the screen that it is of.
    pub(super) fn on_point(&self, pair: &PairResult, point: StepPoint) -> StepPoint {
        // What all touches share leaves no residual, and would hide a point that was touched elsewhere.
        let own_mm = |noise: &Noise| match noise.touches {
            Some(parts) => parts.own_mm.hypot(parts.hand_mm).hypot(parts.bead_mm),
            None => noise.sigma_mm,
        };
        let expected_mm = LENGTH_95 * self.file.noise.as_ref().map_or(f64::NAN, own_mm);
        let left_out_mm = pair.leave_one_out_mm.unwrap_or(f64::NAN);
        let off = if left_out_mm > OFF * expected_mm {
            StepPoint::OFF
        } else {
            0
        };
        StepPoint {
            residual_mm: pair.fre_mm,
            left_out_mm,
            expected_mm,
            flags: StepPoint::TOUCHED | off,
            ..point
        }
    }

    /// Where the registration places what it takes for `target`, with its covariance; `None` where the points determine none.
    pub(super) fn at(&self, target: Point<Ct>) -> Option<UncertainPoint<Ct>> {
        let ct_from = uncertain(std::path::Path::new("the registration"), &self.file).ok()?;
        Some(ct_from * (ct_from.transform().inverse() * target))
    }
}

fn unread(refused: Option<&str>, error: &serde_json::Error) -> String {
    refused.map_or_else(|| format!("the result cannot be read: {error}"), str::to_owned)
}

fn gate(gate: &Gate) -> StepGate {
    StepGate::new(&gate.name.replace('-', "_"), gate.limit, gate.found, gate.kept)
}
