//! The command `calib seat`: frames of the tool in its seat to its frame in its marker.

use std::path::{Path, PathBuf};

use calib::base::{Refused, Seated, seated, seen_from_marker};
use clap::Args;
use geometry::uncertain::CovarianceError;
use geometry::{Base, Frame, Marker, Point, Reference, Rigid, Tool, Tracker, Uncertain, door};
use nalgebra::{Matrix6, Vector6};

use crate::calibration::{BaseRecord, CalibrationFile, Gate, Kind, SeatDrawing, SeatRecord, ToolRecord};
use crate::cli::Positive;
use crate::commands::common::{CommandError, OutArgs, Outcome, gate, recorded, recorded_text, verdict_text};
use crate::poses::Recording;

pub(crate) const SEAT_HELP: &str = "\
The tool sits in the base as drawn; --poses holds poses of its marker there, as `calib pivot` reads them, with their \
covariances where the file has the columns c0 to c20, else with the noise of --sigma-mm and --sigma-deg about the marker. \
Where the base was located in its reference marker, --reference holds that marker's poses in the same frames.

Frames are averaged by their covariances; a frame far from the mean is refused: the tool moved. With a gate \
(--max-tip-error-mm, --max-noise-ratio, --min-frames) that is not kept nothing is written and the exit code is 1.

Examples:
  calib seat --base base.json --poses seated.csv --out tool.json
  calib seat --base base.json --poses ball.csv --reference plate.csv --tool scope --marker ball --max-tip-error-mm 0.3";

#[derive(Debug, Args)]
pub(crate) struct SeatArgs {
    /// Where the base is, by `calib base`, of a drawing with a seat
    #[arg(long, value_name = "FILE.json")]
    base: PathBuf,
    /// Poses of the tool's marker while the tool sits in the base
    #[arg(long, value_name = "PATH")]
    poses: PathBuf,
    /// Poses of the base's reference marker in the same frames
    #[arg(long, value_name = "PATH")]
    reference: Option<PathBuf>,
    /// Which transform of a sequence is the tool's marker
    #[arg(long, value_name = "NAME")]
    transform: Option<String>,
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
    #[error("the covariance of a pose or of the base: {0}")]
    Covariance(#[from] CovarianceError),
    #[error("{path}: a pose of the file is no rigid transform")]
    Pose { path: PathBuf },
}

impl SeatArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let file = CalibrationFile::read(&self.base, Kind::Base)?;
        file.of_tool(&self.base, "command line", self.out.tool())?;
        let none = || NoSeat::Undrawn {
            path: self.base.clone(),
        };
        let base = file.base.ok_or_else(none)?;
        let seat = base.base_from_tool.clone().ok_or_else(none)?;
        let recording = Recording::read(&self.poses, self.transform.as_deref(), false)?;
        let found = match (base.of_frame.as_str(), &self.reference) {
            ("tracker", None) => self.still(&recording, &base, &seat)?,
            ("reference", Some(path)) => self.with_reference(&recording, path, &base, &seat)?,
            (found, reference) => {
                let advice = if reference.is_some() { NOT_NEEDED } else { NEEDED };
                let (path, found) = (self.base.clone(), found.chars().take(40).collect());
                return Err(NoSeat::Frame { path, found, advice }.into());
            }
        };
        self.finish(&recording, &found, file.id)
    }

    /// The base stood still.
    fn still(&self, recording: &Recording, base: &BaseRecord, seat: &SeatDrawing) -> Result<Seated, NoSeat> {
        let markers: Vec<Uncertain<Tracker, Marker>> = self.uncertain(recording)?;
        let frames: Vec<Uncertain<Marker, Tracker>> = markers.iter().map(Uncertain::inverse).collect();
        self.solved(&frames, base, seat)
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
            let (poses, reference) = (self.poses.clone(), path.to_owned());
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
        Ok(self.solved(&frames, base, seat)?)
    }

    fn solved<F: Frame>(
        &self,
        frames: &[Uncertain<Marker, F>],
        base: &BaseRecord,
        seat: &SeatDrawing,
    ) -> Result<Seated, NoSeat> {
        let bad = || NoSeat::Pose {
            path: self.base.clone(),
        };
        let place: Rigid<F, Base> = door::rigid(base.quaternion_wxyz, base.translation_mm, 1e-9).map_err(|_| bad())?;
        let drawn: Rigid<Base, Tool> =
            door::rigid(seat.quaternion_wxyz, seat.translation_mm, 1e-9).map_err(|_| bad())?;
        let place = Uncertain::from_upper(place, base.covariance_upper)?;
        let drawn = Uncertain::from_upper(drawn, seat.covariance_upper)?;
        seated(frames, &place, &drawn, self.gate.0).map_err(|refused| NoSeat::Refused {
            frames: frames.len(),
            path: self.poses.clone(),
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

    fn finish(&self, recording: &Recording, found: &Seated, base_id: String) -> Result<Outcome, CommandError> {
        let tool = found.marker_from_tool;
        let tip_error = (tool * Point::<Tool>::new(0.0, 0.0, 0.0)).rms_mm();
        let gates = self.gates(found, tip_error);
        let ([w, x, y, z], [a, b, c]) = (tool.transform().quaternion(), tool.transform().translation_mm());
        let text = format!(
            "{}\nmarker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
             frames           {}, scatter {:.2} times their covariances, the farthest {:.1} deviations off\n\
             tip error        {tip_error:.4} mm rms, with the base's and the seat's\n\n{}",
            recorded_text(recording),
            found.frames,
            found.ratio,
            found.worst,
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
            }),
            ..CalibrationFile::new(Kind::Tool, self.out.tool(), self.out.marker(), gates)
        };
        let mut inputs = vec![self.base.as_path(), self.poses.as_path()];
        inputs.extend(self.reference.as_deref());
        self.out.finish(file, text, &inputs)
    }

    fn gates(&self, found: &Seated, tip_error: f64) -> Vec<Gate> {
        let limit = |gate: Option<Positive>| gate.map(|limit| limit.0);
        // A single frame has no scatter; JSON has no NaN.
        let ratio = Some(found.ratio).filter(|r| r.is_finite()).unwrap_or(f64::MAX);
        let gates = [
            gate("max-tip-error-mm", limit(self.max_tip_error_mm), tip_error, false),
            gate("max-noise-ratio", limit(self.max_noise_ratio), ratio, false),
            gate("min-frames", self.min_frames.map(f64::from), found.frames as f64, true),
        ];
        gates.into_iter().flatten().collect()
    }
}

const NEEDED: &str = "give the poses of its reference marker with --reference";
const NOT_NEEDED: &str =
    "leave --reference out, or locate the base in its reference marker (calib base --in reference)";
