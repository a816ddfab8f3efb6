//! The command `calib base`.

use std::path::PathBuf;

use calib::base::{Drawing, Located, Options, Refused, locate};
use clap::{Args, ValueEnum};
use geometry::{Frame, Reference, Tracker};

use super::drawing::Drawn;
use super::report::{record, text};
use super::touches::Touches;
use crate::bounds::Bounds;
use crate::calibration::{CalibrationFile, Gate, Kind, Recorded, SeatDrawing};
use crate::commands::common::{CommandError, OutArgs, Outcome, OwnError, verdict_text};
use crate::live::touched_in;
use crate::scene_context::{SceneArgs, SceneContext};
use crate::values::{Name, Positive};

pub(crate) const BASE_HELP: &str = "\
TOUCHES.csv holds where the pointer's tip was, a touch a line, in mm. Rows of one name in the column `on` are a group. The \
name says what was touched, or is any other where that is to be found; without that column the touches are sorted out \
altogether, which takes ten touches or more in each groove:

  on,x,y,z
  plane,112.41,-38.02,-1822.10
  groove 0,131.20,-12.75,-1840.66

With the columns cxx,cxy,cxz,cyy,cyz,czz (mm^2) each touch has a covariance of its own, and weighs accordingly. u1x to u3z, as \
calib touch writes them, say which part of it all touches share, the error of the tip's calibration: what three normal numbers \
of deviation 1, the same for all touches, move each by (mm). It stays in the error of the base however many touches there are; \
without these columns touches count as independent, and the error told is too small.

--drawing is the base as drawn, TOML; the normal points to the side that is touched, a groove is the line along its bottom, \
the seat is where the tool sits, its origin at the tip:

  [plane]
  at_mm = [0, 0, 0]
  normal = [0, 0, 1]
  [[groove]]                    # three of them, not all parallel
  start_mm = [15, 0, -4]
  end_mm = [60, 0, -4]
  half_angle_deg = 45
  [seat]
  quaternion = [1, 0, 0, 0]     # w, x, y, z
  translation_mm = [0, 0, 80]
  sigma_mm = 0.05               # how well the tool sits, and is drawn
  sigma_deg = 0.02

Refused: grooves that leave the base free to slide, touches that fit no place or two, groups touched in another order than \
said, with the order that fits. With a gate (--max-rms-mm, --max-noise-ratio, --max-rejected, --max-condition, \
--min-touches) that is not kept nothing is written and the exit code is 1; with --live or --scene max_rms_mm and \
max_condition of the scene's [tracker.calibration.gates] hold where the command line gives none.

Examples:
  calib base touches.csv --drawing base.toml --out base.json
  calib base touches.csv --drawing base.toml --in reference --tip-radius-mm 1 --sigma-mm 0.2 --max-noise-ratio 1.5
  calib base touches.csv --drawing base.toml --live default --out base.json     touches of calib touch
  calib seat --base base.json --poses seated.csv --out tool.json";

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Of {
    /// The localizer: the base stands still until the tool has sat in it
    Tracker,
    /// The marker on the base: it may be moved
    Reference,
}

#[derive(Debug, Args)]
pub(crate) struct BaseArgs {
    /// Where the tip was at each touch
    #[arg(value_name = "TOUCHES.csv")]
    touches: PathBuf,
    /// The base as drawn
    #[arg(long, value_name = "BASE.toml")]
    drawing: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    /// The frame of the touches [default: as their file says, else tracker]
    #[arg(long = "in", value_enum)]
    of: Option<Of>,
    /// Radius of the ball at the pointer's tip, whose centre was calibrated; 0 for a sharp tip
    #[arg(long, value_name = "MM", default_value = "0", allow_hyphen_values = true)]
    tip_radius_mm: f64,
    /// Standard deviation of a touch along each axis
    #[arg(long, value_name = "MM", default_value = "0.2", allow_hyphen_values = true)]
    sigma_mm: Positive,
    /// Accept at most this root mean square distance
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_rms_mm: Option<Positive>,
    /// Accept at most residuals of so many times the noise given; above 2 none are
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    max_noise_ratio: Option<Positive>,
    /// Accept at most this share of touches left out, 0 to 1; above 0.2 none are
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    max_rejected: Option<Positive>,
    /// Accept at most this ratio of the largest deviation to the least
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    max_condition: Option<Positive>,
    /// Accept at least so many touches
    #[arg(long, value_name = "COUNT")]
    min_touches: Option<u32>,
    #[command(flatten)]
    out: OutArgs,
}

impl Of {
    fn name(self) -> Name {
        Name::told(match self {
            Self::Tracker => "tracker",
            Self::Reference => "reference",
        })
    }
}

/// Why touches that were read well give no place of the base.
#[derive(Debug, thiserror::Error)]
#[error("the calibration base from the {touches} touches of {path}: {refused}{}. {}", groups(.names, .refused), advice(.refused))]
pub(crate) struct NoBase {
    touches: usize,
    path: PathBuf,
    names: Vec<String>,
    refused: Box<Refused>,
}

impl OwnError for NoBase {}

/// The names of the groups, where the refusal goes by their order.
fn groups(names: &[String], refused: &Refused) -> String {
    let by_group = matches!(
        refused,
        Refused::WrongOrder { .. } | Refused::NoFit { .. } | Refused::Ambiguous { .. } | Refused::TooFew { .. }
    );
    if !by_group || names.is_empty() {
        return String::new();
    }
    let list: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(i, name)| format!("{i} {name:?}"))
        .collect();
    format!(" (groups: {})", list.join(", "))
}

fn advice(refused: &Refused) -> &'static str {
    match refused {
        Refused::WrongOrder { .. } => "Correct the names in the column `on`, or leave them to be found",
        Refused::NoFit { .. } => {
            "Check that the drawing is of this base, that the tip's radius and calibration are right, and touch what is far off again"
        }
        Refused::Ambiguous { .. } => "Name the groups in the column `on`",
        Refused::Unsolvable { .. } => "Touch the plane and the grooves over their whole extent",
        Refused::TooFew { .. } | Refused::GroupCount { .. } | Refused::NoLine { .. } => {
            "Touch the plane and each of the three grooves ten times or more"
        }
        Refused::BadOption { .. } => "Give --tip-radius-mm and --sigma-mm a usable number",
        _ => "Check that row in the file",
    }
}

impl BaseArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let drawn = Drawn::read(&self.drawing)?;
        let scened = SceneContext::open(&self.scene)?;
        let of = touched_in(&self.touches, self.of.map(Of::name).as_ref())?;
        match of.as_ref().map(Name::as_str) {
            Some("reference") => self.located::<Reference>(&drawn, "reference", scened.as_ref()),
            _ => self.located::<Tracker>(&drawn, "tracker", scened.as_ref()),
        }
    }

    fn located<F: Frame>(
        &self,
        drawn: &Drawn,
        frame: &str,
        scened: Option<&SceneContext>,
    ) -> Result<Outcome, CommandError> {
        let out = self.out.of(scened)?;
        let options = Options {
            tip_radius_mm: self.tip_radius_mm,
            ..Options::new(self.sigma_mm.0)
        };
        let refused = |touches: usize, names: Vec<String>, refused: Refused| NoBase {
            touches,
            path: self.touches.clone(),
            names,
            refused: Box::new(refused),
        };
        let touches = Touches::<F>::read(&self.touches, options.gate * options.sigma_mm)?;
        let touches = touches.map_err(|why| refused(0, Vec::new(), why))?;
        let found = self.solve(&drawn.drawing, &touches, &options);
        let found = found.map_err(|why| refused(touches.count, touches.names.clone(), why))?;
        let gates = self.gates(&found, scened);
        let mut record = record(&touches, &found, frame, self.tip_radius_mm);
        record.base_from_tool = drawn.base_from_tool.as_ref().map(|seat| SeatDrawing {
            quaternion_wxyz: seat.transform().quaternion(),
            translation_mm: seat.transform().translation_mm(),
            covariance_upper: seat.upper(),
        });
        let text = text(&touches, &found, &record) + &verdict_text(&gates);
        let file = CalibrationFile {
            recorded: Some(self.recorded(&touches, record.rejected.len())),
            base: Some(record),
            ..CalibrationFile::new(Kind::Base, out.tool(), out.marker(), gates)
        };
        out.finish(file, text, &[&self.touches, &self.drawing])
    }

    fn solve<F: Frame>(
        &self,
        drawing: &Drawing,
        touches: &Touches<F>,
        options: &Options,
    ) -> Result<Located<F>, Refused> {
        locate(drawing, &touches.groups, options)
    }

    /// The scene's bounds of residuals and condition hold for the base too; those of a tip and of a cone do not apply.
    fn gates<F: Frame>(&self, found: &Located<F>, scened: Option<&SceneContext>) -> Vec<Gate> {
        let scene = scened.map(SceneContext::calibration_gates).unwrap_or_default();
        let reached = found.reached();
        let rejected = reached.rejected.unwrap_or(1.0);
        let touches = reached.count.unwrap_or(0) as f64;
        let bounds = Bounds::calibration(scened)
            .most("max-rms-mm", self.max_rms_mm, scene.max_rms_mm, found.rms_mm)
            .most("max-noise-ratio", self.max_noise_ratio, None, found.noise_ratio)
            .most("max-rejected", self.max_rejected, None, rejected)
            .most(
                "max-condition",
                self.max_condition,
                scene.max_condition,
                found.condition,
            )
            .least("min-touches", self.min_touches.map(f64::from), None, touches);
        bounds.done()
    }

    fn recorded<F: Frame>(&self, touches: &Touches<F>, rejected: usize) -> Recorded {
        Recorded {
            path: self.touches.to_string_lossy().into_owned(),
            bytes: touches.source.bytes,
            source_blake3: touches.source.blake3.clone(),
            transform: None,
            frames: touches.count,
            poses: touches.count - rejected,
            invalid: 0,
            repeated: 0,
            backwards: 0,
            same_time: 0,
            matrix_off: 0.0,
        }
    }
}
