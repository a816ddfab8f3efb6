//! The command `calib seat`: frames of the tool in its seat to its frame in its marker.

use std::path::{Path, PathBuf};

use calib::base::{Refused, Seated, seated, seen_from_marker};
use calib::coverage::Coverage;
use clap::Args;
use geometry::uncertain::CovarianceError;
use geometry::{Base, Frame, Marker, Point, Reference, Rigid, Tool, Tracker, Uncertain, checked};
use nalgebra::{Matrix6, Vector6};

use crate::bounds::Bounds;
use crate::calibration::{BaseRecord, CalibrationFile, EMITTERS, Gate, Kind, SeatDrawing, SeatRecord, ToolRecord};
use crate::commands::common::{
    Asked, CommandError, OutArgs, Outcome, OwnError, PosesArgs, recorded, recorded_text, verdict_text,
};
use crate::live::{Against, FollowMarkers, Lacks, LiveArgs, Run};
use crate::poses::Recording;
use crate::scene_context::SceneContext;
use crate::values::Positive;

pub(crate) const SEAT_HELP: &str = "\
The tool sits in the base as drawn; --poses holds poses of its marker there, as `calib pivot` reads them, with their \
covariances where the file has the columns c0 to c20, else with the noise of --sigma-mm and --sigma-deg about the marker. \
Where the base was located in its reference marker, --reference holds that marker's poses in the same frames.

--live listens to a run that is going for 3 s instead, in the frame that the base was touched in: the localizer's, or that of \
the run's second marker, which must then not move against the base.

Frames are averaged by their covariances; a frame far from the mean is refused: the tool moved. With a gate (--max-rms-mm, \
--max-tip-error-mm, --max-condition, --max-noise-ratio, --min-frames) that is not kept nothing is written and the exit code is \
1; where the command line gives none, the [tracker.calibration.gates] of --scene or of the run hold.

Examples:
  calib seat --base base.json --poses seated.csv --out tool.json
  calib seat --base base.json --live default --out tool.json
  calib seat --base base.json --poses ball.csv --reference plate.csv --tool scope --marker ball --max-tip-error-mm 0.3";

#[derive(Debug, Args)]
pub(crate) struct SeatArgs {
    /// Where the base is, by `calib base`, of a drawing with a seat
    #[arg(long, value_name = "FILE.json")]
    base: PathBuf,
    /// Poses of the tool's marker while the tool sits in the base
    #[command(flatten)]
    poses: PosesArgs,
    /// Poses of the base's reference marker in the same frames
    #[arg(long, value_name = "PATH", conflicts_with = "live")]
    reference: Option<PathBuf>,
    /// Which transform of a sequence is the reference marker
    #[arg(long, value_name = "NAME", requires = "reference")]
    reference_transform: Option<String>,
    /// Standard deviation of a marker's place along each axis
    #[arg(long, value_name = "MM", default_value = "0.1", allow_hyphen_values = true)]
    sigma_mm: Positive,
    /// Standard deviation of a marker's turn about each axis
    #[arg(long, value_name = "DEG", default_value = "0.1", allow_hyphen_values = true)]
    sigma_deg: Positive,
    /// The largest distance of a frame from the mean, in its deviations
    #[arg(long, value_name = "SIGMAS", default_value = "6", allow_hyphen_values = true)]
    gate: Positive,
    /// Accept at most this root mean square error of the tip by its covariance
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_tip_error_mm: Option<Positive>,
    /// Accept at most this root mean square distance of the tip at single frames from the mean
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_rms_mm: Option<Positive>,
    /// Accept at most this ratio of the largest deviation of the frames' mean to the least
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    max_condition: Option<Positive>,
    /// Accept at most a scatter of so many times the frames' covariances
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    max_noise_ratio: Option<Positive>,
    /// Accept at least so many frames
    #[arg(long, value_name = "COUNT")]
    min_frames: Option<u32>,
    #[command(flatten)]
    out: OutArgs,
}

/// Why there is no tool in the seat.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoSeat {
    #[error("{path}: the base was drawn without a table [seat]; add it and locate the base anew")]
    Undrawn { path: PathBuf },
    #[error("{path}: the base is located in {found}; {advice}")]
    Frame {
        path: PathBuf,
        found: String,
        advice: &'static str,
    },
    #[error(
        "{poses} has {found} valid poses and {reference} {expected}, repeats left out: record both markers in the same \
         frames, and only frames that show both"
    )]
    Unmatched {
        poses: PathBuf,
        reference: PathBuf,
        found: usize,
        expected: usize,
    },
    #[error("the tool in its seat from the {frames} frames of {path}: {refused}")]
    Refused {
        frames: usize,
        path: PathBuf,
        refused: Box<Refused>,
    },
    #[error(
        "{of} ask for a cone of {deg:.0} degrees, which a tool in its seat does not turn through: no tracker of the scene would \
         read the file. Take min_cone_deg out of the scene, or calibrate by pivoting"
    )]
    Cone { of: String, deg: f64 },
    #[error("the covariance of a pose or of the base: {0}")]
    Covariance(#[from] CovarianceError),
    #[error("{path}: a pose of the file is no rigid transform")]
    Pose { path: PathBuf },
}

impl OwnError for NoSeat {}

impl SeatArgs {
    /// How it listens to a run.
    pub(crate) const fn live(&mut self) -> &mut LiveArgs {
        &mut self.poses.live
    }

    /// Does what is asked.
    pub(crate) fn run(&self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.poses.live.of)?;
        let out = self.out.of(scened.as_ref())?;
        let file = CalibrationFile::read(&self.base, Kind::Base)?;
        file.of_tool(&self.base, "command line", out.tool())?;
        let none = || NoSeat::Undrawn {
            path: self.base.clone(),
        };
        let base = file.base.ok_or_else(none)?;
        let seat = base.base_from_tool.clone().ok_or_else(none)?;
        let gated = scened
            .as_ref()
            .and_then(|scened| scened.calibration_gates().min_cone_rad);
        if let (Some(cone), Some(scened)) = (gated, &scened) {
            let of = scened.table("tracker.calibration.gates");
            return Err(NoSeat::Cone {
                of,
                deg: cone.to_degrees(),
            }
            .into());
        }
        let mut run = self.poses.open(scened.as_ref(), follow)?;
        if let Some(run) = &mut run {
            run.against = self.against(run, &base.of_frame)?;
        }
        let recording = self.poses.read(run.as_mut(), &SEATED, |recording| {
            let coverage = Coverage::<Marker>::of(recording.poses.iter().map(Rigid::rotation));
            let [a, ..] = coverage.map_or([0.0; 3], |coverage| coverage.angles_deg());
            let words = format!("turned by {a:.2} degrees; leave the tool in its seat");
            Lacks { words, motion: None }
        })?;
        let found = match (base.of_frame.as_str(), &self.reference) {
            // What is heard of a run is in the frame of the base already.
            _ if run.is_some() => self.still(&recording, &base, &seat)?,
            ("tracker", None) => self.still(&recording, &base, &seat)?,
            ("reference", Some(path)) => self.with_reference(&recording, path, &base, &seat)?,
            (found, reference) => {
                let advice = if reference.is_some() { NOT_NEEDED } else { NEEDED };
                let (path, found) = (self.base.clone(), found.chars().take(40).collect());
                return Err(NoSeat::Frame { path, found, advice }.into());
            }
        };
        self.finish(&recording, &found, (file.id, base.condition), (&out, scened.as_ref()))
    }

    /// What the poses of a run are to be in: what the base was located in.
    fn against(&self, run: &Run<'_>, of_frame: &str) -> Result<Against, NoSeat> {
        let refused = |advice| NoSeat::Frame {
            path: self.base.clone(),
            found: of_frame.chars().take(40).collect(),
            advice,
        };
        let found = match (of_frame, run.follow.has_reference()) {
            ("tracker", _) => Against::Tracker,
            ("reference", true) => Against::Reference,
            ("reference", false) => return Err(refused(UNSEEN)),
            _ => return Err(refused(UNKNOWN)),
        };
        match self.poses.live.against {
            Some(asked) if asked.name() != found.name() => Err(refused(OTHER)),
            _ => Ok(found),
        }
    }

    /// The base stood still.
    fn still(&self, recording: &Recording, base: &BaseRecord, seat: &SeatDrawing) -> Result<Seated, NoSeat> {
        let markers: Vec<Uncertain<Tracker, Marker>> = self.uncertain(recording)?;
        let frames: Vec<Uncertain<Marker, Tracker>> = markers.iter().map(Uncertain::inverse).collect();
        self.solved(&frames, &recording.path, base, seat)
    }

    /// The base may have moved; its marker tells.
    fn with_reference(
        &self,
        recording: &Recording,
        path: &Path,
        base: &BaseRecord,
        seat: &SeatDrawing,
    ) -> Result<Seated, CommandError> {
        let reference = Recording::read(path, self.reference_transform.as_deref(), false)?;
        let (found, expected) = (recording.poses.len(), reference.poses.len());
        if found != expected {
            let (poses, reference) = (recording.path.clone(), path.to_owned());
            return Err(NoSeat::Unmatched {
                poses,
                reference,
                found,
                expected,
            }
            .into());
        }
        let markers: Vec<Uncertain<Tracker, Marker>> = self.uncertain(recording)?;
        // The file calls every marker's frame the marker's.
        let plates: Vec<Uncertain<Tracker, Reference>> = self.uncertain(&reference)?;
        let frames = markers.iter().zip(&plates).map(|(m, r)| seen_from_marker(m, r));
        let frames: Vec<Uncertain<Marker, Reference>> = frames.collect();
        Ok(self.solved(&frames, &recording.path, base, seat)?)
    }

    fn solved<F: Frame>(
        &self,
        frames: &[Uncertain<Marker, F>],
        poses: &Path,
        base: &BaseRecord,
        seat: &SeatDrawing,
    ) -> Result<Seated, NoSeat> {
        let bad = || NoSeat::Pose {
            path: self.base.clone(),
        };
        let place: Rigid<F, Base> =
            checked::rigid(base.quaternion_wxyz, base.translation_mm, 1e-9).map_err(|_| bad())?;
        let drawn: Rigid<Base, Tool> =
            checked::rigid(seat.quaternion_wxyz, seat.translation_mm, 1e-9).map_err(|_| bad())?;
        let place = Uncertain::from_upper(place, base.covariance_upper)?;
        let drawn = Uncertain::from_upper(drawn, seat.covariance_upper)?;
        seated(frames, &place, &drawn, self.gate.0).map_err(|refused| NoSeat::Refused {
            frames: frames.len(),
            path: poses.to_owned(),
            refused: Box::new(refused),
        })
    }

    /// The poses with their covariances, or with the noise given about the marker.
    fn uncertain<M: Frame>(&self, recording: &Recording) -> Result<Vec<Uncertain<Tracker, M>>, NoSeat> {
        let (turn, shift) = (self.sigma_deg.0.to_radians().powi(2), self.sigma_mm.0.powi(2));
        let even = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
        let one = |(i, pose): (usize, &Rigid<Tracker, Marker>)| {
            let [x, y, z] = pose.translation_mm();
            let pose: Rigid<Tracker, M> = Rigid::from_parts(pose.rotation(), geometry::Vector::new(x, y, z));
            Ok(match recording.covariances.get(i) {
                Some(upper) => Uncertain::from_upper(pose, *upper)?,
                None => Uncertain::from_covariance_about(Point::new(x, y, z), pose, even)?,
            })
        };
        recording.poses.iter().enumerate().map(one).collect()
    }

    fn finish(
        &self,
        recording: &Recording,
        found: &Seated,
        (base_id, base_condition): (String, f64),
        (out, scened): (&OutArgs, Option<&SceneContext>),
    ) -> Result<Outcome, CommandError> {
        let tool = found.marker_from_tool;
        let tip_error = (tool * Point::<Tool>::new(0.0, 0.0, 0.0)).rms_mm();
        let gates = self.gates(found, tip_error, scened);
        let ([w, x, y, z], [a, b, c]) = (tool.transform().quaternion(), tool.transform().translation_mm());
        let text = format!(
            "{}\nmarker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
             frames           {}, scatter {:.2} times their covariances, the farthest {:.1} deviations off\n\
             residuals        {:.4} mm rms of the tip at single frames\n\
             condition        {:.1} of the frames, {base_condition:.1} of the base\n\
             tip error        {tip_error:.4} mm rms, with the base's and the seat's\n\
             emitters         {EMITTERS}\n\n{}",
            recorded_text(recording),
            found.frames,
            found.ratio,
            found.worst,
            found.rms_mm,
            found.condition,
            verdict_text(&gates)
        );
        let file = CalibrationFile {
            recorded: Some(recorded(recording)),
            computed_from: vec![base_id],
            tool_frame: Some(ToolRecord {
                quaternion_wxyz: [w, x, y, z],
                translation_mm: [a, b, c],
                covariance_upper: tool.upper(),
                roll_by: "seat".to_owned(),
                tip_off_axis_mm: 0.0,
            }),
            seat: Some(SeatRecord {
                frames: found.frames,
                noise_ratio: Some(found.ratio).filter(|r| r.is_finite()),
                worst_deviations: found.worst,
                rms_mm: found.rms_mm,
                condition: found.condition,
                emitters: Some(EMITTERS.to_owned()),
            }),
            ..CalibrationFile::new(Kind::Tool, out.tool(), out.marker(), gates)
        };
        let mut inputs = self.poses.inputs();
        inputs.push(&self.base);
        inputs.extend(self.reference.as_deref());
        out.finish(file, text, &inputs)
    }

    fn gates(&self, found: &Seated, tip_error: f64, scened: Option<&SceneContext>) -> Vec<Gate> {
        let scene = scened.map(SceneContext::calibration_gates).unwrap_or_default();
        // A single frame has no scatter; JSON has no NaN.
        let ratio = Some(found.ratio).filter(|r| r.is_finite()).unwrap_or(f64::MAX);
        let (tip, least) = (scene.max_tip_error_mm, self.min_frames.map(f64::from));
        let bounds = Bounds::calibration(scened)
            .most("max-rms-mm", self.max_rms_mm, scene.max_rms_mm, found.rms_mm)
            .most("max-tip-error-mm", self.max_tip_error_mm, tip, tip_error)
            .most(
                "max-condition",
                self.max_condition,
                scene.max_condition,
                found.condition,
            )
            .most("max-noise-ratio", self.max_noise_ratio, None, ratio)
            .least("min-frames", least, None, found.frames as f64);
        bounds.done()
    }
}

/// What the person at the base is asked for.
const SEATED: Asked = Asked {
    seconds: 3.0,
    what: "leave the tool in its seat",
};

const UNSEEN: &str = "the run's scene has no second marker to see it by";
const UNKNOWN: &str = "a run sees the tracker's frame and the reference's only";
const OTHER: &str = "leave --against out: the poses are taken in that frame";
const NEEDED: &str = "give the poses of its reference marker with --reference";
const NOT_NEEDED: &str =
    "leave --reference out, or locate the base in its reference marker (calib base --in reference)";
