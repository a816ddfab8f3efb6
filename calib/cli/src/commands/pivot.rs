//! `calib pivot`: poses of a pivoting instrument to its tip.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use bus::message::StepMotionKind;
use calib::coverage::Coverage;
use calib::motion::pivoted;
use calib::pivot::{Method, Options, Pivot, PoseNoise, calibrate, calibrate_each};
use clap::{Args, ValueEnum};
use geometry::{Direction, Marker, Point, Rigid, Tracker, Uncertain, Vector};
use nalgebra::{Matrix3, Vector3};

use super::common::{Asked, CommandError, OutArgs, Outcome, OwnError, PosesArgs, left_out, recorded};
use super::pivot_report::{self, Solution};
use super::told::told;
use super::tool::tool_frame;
use crate::bounds::Bounds;
use crate::calibration::{CalibrationFile, CoverageRecord, EMITTERS, Gate, Kind, PivotRecord, ToolRecord};
use crate::live::{FollowMarkers, Lacks, LiveArgs, Run};
use crate::poses::Recording;
use crate::scene_context::SceneContext;
use crate::values::{Positive, Target};

pub(crate) const PIVOT_HELP: &str = "\
Keep the tip in a divot and turn the instrument about it, to all sides. The tip x in the marker and the pivot c in the \
tracker satisfy R x + t = c for every pose (R, t).

--poses reads
  a folder of text files, each a 4 x 4 matrix by rows in mm, named by their time in ns: 1378476417807806000.txt
  comma-separated values, a frame a line, the columns named by the first line (status may be absent; only OK counts):
    t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm,status
    0.00,1,0,0,0,12.5,-3.1,1800.2,OK
    with the columns c0 to c20 each pose has a covariance, the upper triangle by rows of (rotation vector in rad, translation \
in mm) in the tracker, turning about its origin, which errors-in-variables takes in the place of --sigma-mm and --sigma-deg
  a sequence of the PLUS toolkit (.mha), of which --transform names the transform

algebraic, two-step and sphere use all poses. robust and errors-in-variables forget poses that slipped; \
errors-in-variables moreover is not drawn to the marker by noise of the rotations, which counts on small cones. Its \
weights need the ratio of --sigma-mm and --sigma-deg; the size of the noise is measured from the residuals.

Where two methods lie further apart than their errors allow, a warning says so: the tip slipped or its divot gives way, or the \
noise is not as was assumed; the errors then say too little. That all agree does not say that the tip stayed in place.

--live listens to a run that is going, says every second what the motion covers, and takes the names, the gates and the \
noise of the emitters from its scene. With --axis scene the file is one that the run's [tracker.calibration] reads.

Refused: fewer than 3 poses, poses without rotation or about one axis only, cones below 2 degrees or 8 times the noise of the rotations, poses of which less \
than a half agree. With a gate (--max-rms-mm, --max-tip-error-mm, --min-cone-deg) that is not kept nothing is written \
and the exit code is 1.

Examples:
  calib pivot --poses recording.csv --out tip.json
  calib pivot --poses recording.igs.mha --transform StylusToTracker --max-rms-mm 0.5 --min-cone-deg 20
  calib pivot --poses folder --method algebraic --json
  calib pivot --live default --out tip.json
  calib pivot --live default --axis scene --out tool.json --overwrite";

/// The cone that is asked for where no gate says.
const GOOD_CONE_DEG: f64 = 20.0;

#[derive(Debug, Args)]
pub(crate) struct PivotArgs {
    #[command(flatten)]
    poses: PosesArgs,
    /// Which solution is the result; all are shown
    #[arg(long, value_enum, default_value = "errors-in-variables")]
    method: MethodArg,
    /// Standard deviation of a pose's translation along each axis
    #[arg(long, value_name = "MM", default_value = "0.1", allow_hyphen_values = true)]
    sigma_mm: Positive,
    /// Standard deviation of a pose's rotation about each axis
    #[arg(long, value_name = "DEG", default_value = "0.1", allow_hyphen_values = true)]
    sigma_deg: Positive,
    /// Accept at most this root mean square residual of the inliers, mm (as lengths)
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_rms_mm: Option<Positive>,
    /// Accept at most this root mean square error of the tip by its covariance
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_tip_error_mm: Option<Positive>,
    /// Accept at most this condition of the equations
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    max_condition: Option<Positive>,
    /// Write the tool's whole frame, which a tracker reads: with this direction from the handle to the tip in the marker, or
    /// with --live that of the `scene`
    #[arg(long, value_name = "x,y,z|scene", allow_hyphen_values = true)]
    axis: Option<AxisArg>,
    /// How far that direction may be off, a standard deviation about each axis
    #[arg(long, value_name = "DEG", default_value = "1", allow_hyphen_values = true)]
    axis_error_deg: Positive,
    /// Accept at least this half opening of the cone of poses
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    min_cone_deg: Option<Positive>,
    #[command(flatten)]
    out: OutArgs,
}

/// Where the direction of the tool comes from.
#[derive(Debug, Clone, Copy)]
enum AxisArg {
    Scene,
    Given(Target),
}

impl FromStr for AxisArg {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "scene" => Ok(Self::Scene),
            _ => text.parse().map(Self::Given),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct MethodArg(Method);

impl ValueEnum for MethodArg {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [MethodArg; 5] = [
            MethodArg(Method::Algebraic),
            MethodArg(Method::TwoStep),
            MethodArg(Method::Sphere),
            MethodArg(Method::Robust),
            MethodArg(Method::ErrorsInVariables),
        ];
        &ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.0.name()))
    }
}

/// The poses with their covariances, where the recording has them.
fn uncertain(recording: &Recording) -> Option<Vec<Uncertain<Tracker, Marker>>> {
    let both = recording.poses.iter().zip(&recording.covariances);
    let each = both.map(|(pose, upper)| Uncertain::from_upper(*pose, *upper).ok());
    (!recording.covariances.is_empty()).then(|| each.collect()).flatten()
}

/// What a method finds.
fn solve(
    recording: &Recording,
    each: Option<&[Uncertain<Tracker, Marker>]>,
    (method, noise): (Method, PoseNoise),
) -> Solution {
    match (each, method) {
        (Some(each), Method::ErrorsInVariables) => calibrate_each(each),
        _ => calibrate(&recording.poses, &Options { method, noise }),
    }
}

/// All results, and the one that counts.
type Solved = (Vec<(Method, Solution)>, Pivot<Tracker, Marker>);

/// Why there is no tip.
#[derive(Debug, thiserror::Error)]
enum PivotError {
    #[error("pivot calibration from the {poses} poses of {path}{left_out}: {refused}")]
    Refused {
        poses: usize,
        path: PathBuf,
        left_out: String,
        refused: Box<calib::pivot::Refused>,
    },
    #[error(
        "--axis: give a direction x,y,z other than 0,0,0; `scene` is for --live, where the scene says how the tool sits"
    )]
    NoAxis,
    #[error("--axis: the frame of the tool from its tip and this direction: {0}")]
    Frame(Box<calib::spin::Refused>),
}

impl OwnError for PivotError {}

impl PivotArgs {
    /// How it listens to a run.
    pub(crate) const fn live(&mut self) -> &mut LiveArgs {
        &mut self.poses.live
    }

    /// Does what is asked.
    pub(crate) fn run(&self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.poses.live.of)?;
        let mut run = self.poses.open(scened.as_ref(), follow)?;
        let axis = self.axis(run.as_ref())?;
        let out = self.out.of(scened.as_ref())?;
        let scene = scened.as_ref().map(SceneContext::calibration_gates).unwrap_or_default();
        let asked = self.min_cone_deg.map(|deg| deg.0.to_radians()).or(scene.min_cone_rad);
        let needed = asked.unwrap_or(GOOD_CONE_DEG.to_radians());
        let noise = PoseNoise {
            sigma_mm: self.sigma_mm.0,
            sigma_rad: self.sigma_deg.0.to_radians(),
        };
        let shaft = axis.or_else(|| run.as_ref().and_then(Run::drawn_axis));
        let lacks = |recording: &Recording| self.lacks(recording, noise, (shaft, needed));
        let recording = self.poses.read(run.as_mut(), &Asked::MOTION, lacks)?;
        let (all, chosen) = self.solved(&recording, noise)?;
        let each = !recording.covariances.is_empty() && self.method.0 == Method::ErrorsInVariables;
        let mut record = record(&chosen, noise, each, needed);
        record.disagreement = pivot_report::disagreement(&all);
        let gates = self.gates(&chosen, scened.as_ref());
        let mut text = pivot_report::text(&recording, &chosen, &all, &record, &gates);
        let (mut kind, mut tool_frame) = (Kind::Pivot, None);
        if let Some(axis) = axis {
            let frame = drawn_frame(&record, axis, self.axis_error_deg.0, &recording.path)?;
            text = pivot_report::frame(&frame) + &text;
            (kind, tool_frame) = (Kind::Tool, Some(frame));
        }
        let file = CalibrationFile {
            recorded: Some(recorded(&recording)),
            pivot: Some(record),
            tool_frame,
            ..CalibrationFile::new(kind, out.tool(), out.marker(), gates)
        };
        out.finish(file, text, &self.poses.inputs())
    }

    /// What the motion covers so far, and what is missing. Nothing is drawn where the shaft's direction is not known.
    fn lacks(
        &self,
        recording: &Recording,
        noise: PoseNoise,
        (shaft, needed_rad): (Option<Direction<Marker>>, f64),
    ) -> Lacks {
        let rotations = recording.poses.iter().map(Rigid::rotation);
        let coverage = Coverage::<Marker>::of(rotations);
        let mut words = coverage.map_or_else(String::new, |coverage| motion(&coverage, needed_rad));
        // A terminal has no picture, and its words are of all poses.
        let shaft = shaft.filter(|_| self.poses.live.watch.is_there());
        let solve = || solve(recording, uncertain(recording).as_deref(), (self.method.0, noise));
        let made = shaft.and_then(|shaft| pivoted(&recording.poses, (shaft, needed_rad), solve));
        if let Some(refused) = made.as_ref().and_then(|made| made.refused.as_ref()) {
            words = refused.to_string();
        }
        Lacks {
            words,
            motion: made.map(|made| told(StepMotionKind::Pivot, &made.seen)),
        }
    }

    /// What each method finds, and the one asked for.
    fn solved(&self, recording: &Recording, noise: PoseNoise) -> Result<Solved, CommandError> {
        let each = uncertain(recording);
        let solve = |method| solve(recording, each.as_deref(), (method, noise));
        let all = Method::ALL.iter().map(|m| (*m, solve(*m))).collect();
        let chosen = solve(self.method.0).map_err(|refused| PivotError::Refused {
            poses: recording.poses.len(),
            path: recording.path.clone(),
            left_out: left_out(recording),
            refused: Box::new(refused),
        })?;
        Ok((all, chosen))
    }

    /// The direction that the tool's frame gets, where one is asked for.
    fn axis(&self, run: Option<&Run<'_>>) -> Result<Option<Direction<Marker>>, CommandError> {
        let Some(axis) = &self.axis else { return Ok(None) };
        let direction = match (axis, run) {
            (AxisArg::Scene, run) => run.and_then(Run::drawn_axis),
            (AxisArg::Given(Target([x, y, z])), _) => Vector::new(*x, *y, *z).direction(),
        };
        direction.map(Some).ok_or(PivotError::NoAxis.into())
    }

    fn gates(&self, found: &Pivot<Tracker, Marker>, scened: Option<&SceneContext>) -> Vec<Gate> {
        let scene = scened.map(SceneContext::calibration_gates).unwrap_or_default();
        // A method without a covariance keeps no bound of it; JSON has no infinity.
        let error = found.tip_error_rms_mm().unwrap_or(f64::MAX);
        let cone = found.coverage.cone_rad().to_degrees();
        let (least, scene_deg) = (
            self.min_cone_deg.map(|deg| deg.0),
            scene.min_cone_rad.map(f64::to_degrees),
        );
        let bounds = Bounds::calibration(scened)
            .most("max-rms-mm", self.max_rms_mm, scene.max_rms_mm, found.rms_mm)
            .most("max-tip-error-mm", self.max_tip_error_mm, scene.max_tip_error_mm, error)
            .most(
                "max-condition",
                self.max_condition,
                scene.max_condition,
                found.condition,
            )
            .least("min-cone-deg", least, scene_deg, cone);
        bounds.done()
    }
}

/// What the motion covers so far, and what is missing.
fn motion(coverage: &Coverage<Marker>, needed_rad: f64) -> String {
    let [a, b, c] = coverage.angles_deg();
    let turned = format!("turned by {a:.1}, {b:.1} and {c:.1} degrees");
    match coverage.advice(needed_rad) {
        Some(advice) => format!("{turned}; {advice}"),
        None => format!("{turned}, wide enough"),
    }
}

/// The tool's frame from its tip and a direction that is known from its drawing.
fn drawn_frame(
    pivot: &PivotRecord,
    axis: Direction<Marker>,
    error_deg: f64,
    path: &Path,
) -> Result<ToolRecord, CommandError> {
    let u = Vector3::from(axis.components());
    let tilts = (Matrix3::identity() - u * u.transpose()) * error_deg.to_radians().powi(2);
    let [x, y, z] = pivot.tip_mm;
    let refused = |refused| PivotError::Frame(Box::new(refused)).into();
    tool_frame(pivot, path, (axis, tilts), Point::new(x, y, z), refused)
}

fn record(found: &Pivot<Tracker, Marker>, noise: PoseNoise, each: bool, needed_rad: f64) -> PivotRecord {
    let advice = found.coverage.advice(needed_rad).map(|advice| advice.to_string());
    PivotRecord {
        method: found.method.name().to_owned(),
        tip_mm: found.tip.mm(),
        pivot_mm: found.pivot.mm(),
        inliers: found.inliers,
        rms_mm: found.rms_mm,
        rms_scalar_mm: found.rms_scalar_mm,
        rms_all_mm: found.rms_all_mm,
        worst_mm: found.worst_mm,
        covariance_upper_mm2: found.covariance.map(|c| {
            let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
            let mut upper = [0.0; 21];
            upper.iter_mut().zip(places).for_each(|(x, place)| *x = c[place]);
            upper
        }),
        pose_covariances: each,
        noise_ratio: found.noise_ratio,
        condition: found.condition,
        noise_assumed: noise.into(),
        noise_estimated: found.estimated.into(),
        coverage: CoverageRecord::new(&found.coverage, advice),
        emitters: Some(EMITTERS.to_owned()),
        disagreement: None,
    }
}
