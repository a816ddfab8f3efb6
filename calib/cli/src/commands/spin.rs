//! `calib spin`: poses of a spinning instrument to the axis of its shaft.

use std::fmt::Write;
use std::path::PathBuf;

use bus::message::StepMotionKind;
use calib::coverage::Coverage;
use calib::motion::spun;
use calib::spin::{Limits, Spin, calibrate};
use clap::Args;
use geometry::{Direction, Marker, Rigid, Tracker, Vector};
use nalgebra::Matrix3;

use super::common::{
    Asked, CommandError, OutArgs, Outcome, OwnError, PosesArgs, left_out, recorded, recorded_text, verdict_text,
};
use super::told::told;
use crate::bounds::Bounds;
use crate::calibration::{CalibrationFile, CoverageRecord, Gate, Kind, SpinRecord};
use crate::live::{FollowMarkers, Lacks, LiveArgs};
use crate::poses::Recording;
use crate::scene_context::SceneContext;
use crate::values::{Positive, Target};

pub(crate) const SPIN_HELP: &str = "\
Spin the instrument about its shaft in a bearing or a divot, the shaft keeping its direction. --poses reads what `calib \
pivot` reads. The axis points along --towards, or from the marker to the tip of --tip.

Poses at which the shaft slipped out of its bearing are left out and listed, up to a half of all (--all-poses uses them); \
poses at which it moved aside are left out of its place only.

Refused: a turn of less than 30 degrees, or one that a few poses alone make, an axis that wobbles by more than 2 \
degrees, a direction across the axis. With a gate (--max-axis-error-deg, --max-rms-mm, --max-condition) that is not \
kept nothing is written and the exit code is 1; where the command line gives none, max_rms_mm and max_condition of the \
[tracker.calibration.gates] of --scene or of the run hold.

Examples:
  calib spin --poses spin.csv --towards 0,0,1 --out axis.json
  calib spin --poses spin.csv --tip tip.json --max-axis-error-deg 0.1
  calib spin --live default --tip tip.json --out axis.json";

/// Twice the root mean square turn about the shaft that is enough: half a turn, evenly.
const GOOD_TURN_DEG: f64 = 100.0;

#[derive(Debug, Args)]
pub(crate) struct SpinArgs {
    #[command(flatten)]
    poses: PosesArgs,
    /// Roughly the direction from the handle to the tip, in the marker
    #[arg(
        long,
        value_name = "x,y,z",
        allow_hyphen_values = true,
        required_unless_present = "tip"
    )]
    towards: Option<Target>,
    /// A pivot calibration: the direction from the marker's origin to its tip
    #[arg(long, value_name = "FILE.json", conflicts_with = "towards")]
    tip: Option<PathBuf>,
    /// Use all poses; else those at which the shaft slipped are left out
    #[arg(long)]
    all_poses: bool,
    /// Accept at most this root mean square error of the axis by its covariance
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    max_axis_error_deg: Option<Positive>,
    /// Accept at most this root mean square distance of the axis from its place
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_rms_mm: Option<Positive>,
    /// Accept at most this condition: the error of the axis per error of the mean direction
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    max_condition: Option<Positive>,
    #[command(flatten)]
    out: OutArgs,
}

/// The upper triangle by rows.
fn upper(c: &Matrix3<f64>) -> [f64; 6] {
    [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]]
}

/// Why there is no axis.
#[derive(Debug, thiserror::Error)]
enum SpinError {
    #[error("spin calibration from the {poses} poses of {path}{left_out}: {refused}")]
    Refused {
        poses: usize,
        path: PathBuf,
        left_out: String,
        refused: Box<calib::spin::Refused>,
    },
    #[error("--towards: the direction must not be 0,0,0")]
    NoDirection,
}

impl OwnError for SpinError {}

impl SpinArgs {
    /// How it listens to a run.
    pub(crate) const fn live(&mut self) -> &mut LiveArgs {
        &mut self.poses.live
    }

    /// Does what is asked.
    pub(crate) fn run(&self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.poses.live.of)?;
        let mut run = self.poses.open(scened.as_ref(), follow)?;
        let out = self.out.of(scened.as_ref())?;
        let (hint, from) = self.hint(&out)?;
        let limits = Limits {
            robust: !self.all_poses,
            ..Limits::default()
        };
        let lacks = |recording: &Recording| self.lacks(recording, hint, limits);
        let recording = self.poses.read(run.as_mut(), &Asked::MOTION, lacks)?;
        let found = calibrate(&recording.poses, hint, limits);
        let found = found.map_err(|refused| SpinError::Refused {
            poses: recording.poses.len(),
            path: recording.path.clone(),
            left_out: left_out(&recording),
            refused: Box::new(refused),
        })?;
        let gates = self.gates(&found, scened.as_ref());
        let text = report(&recording, &found) + &verdict_text(&gates);
        let file = CalibrationFile {
            recorded: Some(recorded(&recording)),
            computed_from: from.into_iter().collect(),
            spin: Some(record(&found)),
            ..CalibrationFile::new(Kind::Spin, out.tool(), out.marker(), gates)
        };
        let mut inputs = self.poses.inputs();
        inputs.extend(self.tip.as_deref());
        out.finish(file, text, &inputs)
    }

    /// What the motion covers so far.
    fn lacks(&self, recording: &Recording, hint: Direction<Marker>, limits: Limits) -> Lacks {
        let coverage = Coverage::<Marker>::of(recording.poses.iter().map(Rigid::rotation));
        let mut words = coverage.map_or_else(String::new, |coverage| motion(&coverage));
        if !self.poses.live.watch.is_there() {
            return Lacks { words, motion: None };
        }
        let made = spun(&recording.poses, (hint, GOOD_TURN_DEG.to_radians()), limits);
        if let Some(refused) = made.as_ref().and_then(|made| made.refused.as_ref()) {
            words = refused.to_string();
        }
        Lacks {
            words,
            motion: made.map(|made| told(StepMotionKind::Spin, &made.seen)),
        }
    }

    /// The direction of the tip, and the id of the calibration that it is from.
    fn hint(&self, out: &OutArgs) -> Result<(Direction<Marker>, Option<String>), CommandError> {
        let mut from = None;
        let mut towards = self.towards.map_or([0.0; 3], |target| target.0);
        if let Some(path) = &self.tip {
            let file = CalibrationFile::read(path, Kind::Pivot)?;
            file.of_marker(path, "command line", out.marker())?;
            file.of_tool(path, "command line", out.tool())?;
            towards = file.pivot.map_or(towards, |pivot| pivot.tip_mm);
            from = Some(file.id);
        }
        let [x, y, z] = towards;
        let hint = Vector::new(x, y, z).direction().ok_or(SpinError::NoDirection)?;
        Ok((hint, from))
    }

    /// The scene's bounds of residuals and condition hold for a spinning too; those of a tip and of a cone do not apply.
    fn gates(&self, found: &Spin<Tracker, Marker>, scened: Option<&SceneContext>) -> Vec<Gate> {
        let scene = scened.map(SceneContext::calibration_gates).unwrap_or_default();
        let error = found.axis_error_rms_rad().to_degrees();
        let bounds = Bounds::calibration(scened)
            .most("max-axis-error-deg", self.max_axis_error_deg, None, error)
            .most("max-rms-mm", self.max_rms_mm, scene.max_rms_mm, found.rms_mm)
            .most(
                "max-condition",
                self.max_condition,
                scene.max_condition,
                found.condition,
            );
        bounds.done()
    }
}

/// What the motion covers so far.
fn motion(coverage: &Coverage<Marker>) -> String {
    let [a, b, _] = coverage.angles_deg();
    let advice = if a < GOOD_TURN_DEG {
        "; turn it further about its shaft"
    } else {
        ""
    };
    format!("turned by {a:.1} degrees about one axis and {b:.1} across it{advice}")
}

fn record(found: &Spin<Tracker, Marker>) -> SpinRecord {
    SpinRecord {
        axis: found.axis.components(),
        point_mm: found.point.mm(),
        wobble_rms_deg: found.wobble_rms_rad.to_degrees(),
        rms_mm: found.rms_mm,
        inliers: found.inliers,
        place_inliers: found.place_inliers,
        range_deg: found.range_rad.to_degrees(),
        axis_covariance_upper_rad2: upper(&found.axis_covariance),
        point_covariance_upper_mm2: upper(&found.point_covariance),
        condition: found.condition,
        coverage: CoverageRecord::new(&found.coverage, None),
    }
}

fn report(recording: &Recording, found: &Spin<Tracker, Marker>) -> String {
    let mut text = recorded_text(recording) + "\n";
    let ([x, y, z], [a, b, c]) = (found.axis.components(), found.point.mm());
    let (wobble, range) = (found.wobble_rms_rad.to_degrees(), found.range_rad.to_degrees());
    let error = found.axis_error_rms_rad().to_degrees();
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "axis             ({x:.6}, {y:.6}, {z:.6}) in the marker, from the handle to the tip\n\
         point            ({a:.3}, {b:.3}, {c:.3}) mm, the nearest to the marker's origin\n\
         residuals        wobble {wobble:.3} deg rms, {:.3} mm rms across the axis\n\
         axis error       {error:.4} deg rms\n\
         coverage         turned by {range:.1} degrees\n\
         condition        {:.1}\n",
        found.rms_mm, found.condition
    );
    slipped(&mut text, "slipped ", &found.weights);
    // What is left out by its direction is told above.
    let aside = found.place_weights.iter().zip(&found.weights);
    let aside: Vec<f64> = aside.map(|(p, w)| if *w > 0.0 { *p } else { 1.0 }).collect();
    slipped(&mut text, "aside   ", &aside);
    text
}

/// The poses of weight 0, counted from 1.
fn slipped(text: &mut String, what: &str, weights: &[f64]) {
    let list: Vec<usize> = (0..weights.len()).filter(|i| weights[*i] == 0.0).collect();
    if list.is_empty() {
        return;
    }
    let shown: Vec<String> = list.iter().take(10).map(|i| (i + 1).to_string()).collect();
    let more = if list.len() > 10 { " ..." } else { "" };
    let _ = writeln!(
        text,
        "{what}         {} poses were left out: {}{more}",
        list.len(),
        shown.join(", ")
    );
}
