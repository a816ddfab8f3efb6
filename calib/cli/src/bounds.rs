//! The bounds that a result must keep: those of the command line, and where it gives none, those of a scene.

use calib::file::{FileError, ToolFile};
use geometry::Point;
use scene::tracking::RegistrationGates;

use crate::calibration::{CalibrationFile, Gate};
use crate::live::LiveError;
use crate::register::file::RegistrationFile;
use crate::scene_context::SceneContext;
use crate::values::Positive;

const CALIBRATION: &str = "tracker.calibration.gates";
const REGISTRATION: &str = "tracker.registration.gates";

/// Bounds with what was found.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    of: Option<String>,
    gates: Vec<Gate>,
}

/// Why a file cannot be held against a scene's gates.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NotJudged {
    #[error("{gates} are for what a tracker reads, and it would refuse this {what}: {source}")]
    Refused {
        gates: String,
        what: &'static str,
        source: FileError,
    },
    #[error(transparent)]
    Live(#[from] Box<LiveError>),
    #[error("writing the result as JSON: {0}")]
    Encode(#[from] std::io::Error),
}

impl Bounds {
    /// None yet, those of a scene being of its table for calibrations.
    pub(crate) fn calibration(scened: Option<&SceneContext>) -> Self {
        Self::of(scened, CALIBRATION)
    }

    fn of(scened: Option<&SceneContext>, table: &str) -> Self {
        Self {
            of: scened.map(|scened| scened.table(table)),
            gates: Vec::new(),
        }
    }

    /// `found` must be at most what is given, else at most what the scene says.
    pub(crate) fn most(self, name: &str, given: Option<Positive>, scene: Option<f64>, found: f64) -> Self {
        let given = given.map(|limit| limit.0);
        self.with(name, (given, scene), found, |found, limit| found <= limit)
    }

    /// `found` must be at least what is given, else at least what the scene says.
    pub(crate) fn least(self, name: &str, given: Option<f64>, scene: Option<f64>, found: f64) -> Self {
        self.with(name, (given, scene), found, |found, limit| found >= limit)
    }

    fn with(
        mut self,
        name: &str,
        (given, scene): (Option<f64>, Option<f64>),
        found: f64,
        kept: fn(f64, f64) -> bool,
    ) -> Self {
        let Some(limit) = given.or(scene) else { return self };
        self.gates.push(Gate {
            name: name.to_owned(),
            limit,
            found,
            // What was not measured is not a number, and keeps no bound.
            kept: kept(found, limit),
            of: self.of.clone().filter(|_| given.is_none()),
        });
        self
    }

    /// All of them.
    pub(crate) fn done(self) -> Vec<Gate> {
        self.gates
    }
}

/// The scene's gates on a tool, as the tracker applies them to its file; `given` bounds the error of its tip in the place of
/// the scene.
pub(crate) fn on_tool(
    file: &CalibrationFile,
    scened: &SceneContext,
    given: Option<Positive>,
) -> Result<Vec<Gate>, NotJudged> {
    let read = ToolFile::parse(&file.clone().sealed()?.to_json()?).map_err(|source| NotJudged::Refused {
        gates: scened.table(CALIBRATION),
        what: "tool",
        source,
    })?;
    let (limits, reached) = (scened.calibration_gates(), read.reached);
    let (tip, cone) = (
        measured(reached.tip_error_mm),
        measured(reached.coverage_rad).to_degrees(),
    );
    let least = limits.min_cone_rad.map(f64::to_degrees);
    let bounds = Bounds::calibration(Some(scened))
        .most("max-rms-mm", None, limits.max_rms_mm, measured(reached.rms_mm))
        .most("max-tip-error-mm", given, limits.max_tip_error_mm, tip)
        .most("max-condition", None, limits.max_condition, measured(reached.condition))
        .least("min-cone-deg", None, least, cone);
    Ok(bounds.done())
}

/// The scene's gates on a registration, as the tracker applies them to its file. Without a target in the scene and without
/// its volume the error counts at the centre of the registered points.
pub(crate) fn on_registration(file: &RegistrationFile, scened: &SceneContext) -> Result<Vec<Gate>, NotJudged> {
    let limits = scened.registration().map(|link| link.gates).unwrap_or_default();
    if limits == RegistrationGates::default() {
        return Ok(Vec::new());
    }
    let not = |source| NotJudged::Refused {
        gates: scened.table(REGISTRATION),
        what: "registration",
        source,
    };
    let read = calib::file::RegistrationFile::parse(&file.to_json()?).map_err(not)?;
    let [x, y, z] = file.centre_mm;
    let at = scened.target().map_err(Box::new)?.unwrap_or(Point::new(x, y, z));
    let reached = read.reached(at);
    let bounds = Bounds::of(Some(scened), REGISTRATION)
        .most("max-fre-mm", None, limits.max_fre_mm, measured(reached.rms_mm))
        .most("max-condition", None, limits.max_condition, measured(reached.condition))
        .most("max-tre-mm", None, limits.max_tre_mm, measured(reached.target_mm));
    Ok(bounds.done())
}

fn measured(x: Option<f64>) -> f64 {
    x.unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_goes_before_the_scene_and_what_was_not_measured_keeps_no_bound() {
        let bounds = Bounds {
            of: Some("tracker.calibration.gates of run or".to_owned()),
            gates: Vec::new(),
        };
        let gates = bounds
            .most("max-rms-mm", Some(Positive(0.5)), Some(0.1), 0.5)
            .most("max-condition", None, Some(9.0), 9.5)
            .least("min-cone-deg", None, Some(20.0), f64::NAN)
            .most("max-tip-error-mm", None, None, 1.0)
            .done();
        let told: Vec<String> = gates
            .iter()
            .map(|gate| format!("{}: {} {}", gate.words(), gate.found_words(), gate.kept))
            .collect();
        assert_eq!(
            told,
            [
                "--max-rms-mm 0.5: found 0.5000 true",
                "max_condition 9 (tracker.calibration.gates of run or): found 9.5000 false",
                "min_cone_deg 20 (tracker.calibration.gates of run or): not measured false",
            ]
        );
    }
}
