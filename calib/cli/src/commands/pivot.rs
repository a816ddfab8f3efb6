//! `calib pivot`: poses of a pivoting instrument to its tip.

use calib::pivot::{Method, Options, Pivot, PoseNoise, Refused, calibrate, calibrate_each};
use clap::{Args, ValueEnum};
use geometry::{Marker, Tracker, Uncertain};

use super::common::{CommandError, OutArgs, Outcome, PosesArgs, gate, left_out, recorded};
use super::pivot_report;
use crate::calibration::{CalibrationFile, CoverageRecord, Gate, Kind, PivotRecord};
use crate::cli::Positive;
use crate::poses::Recording;

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

Refused: fewer than 3 poses, poses without rotation or about one axis only, cones below 2 degrees, poses of which less \
than a half agree. With a gate (--max-rms-mm, --max-tip-error-mm, --min-cone-deg) that is not kept nothing is written \
and the exit code is 1.

Examples:
  calib pivot --poses recording.csv --out tip.json
  calib pivot --poses recording.igs.mha --transform StylusToTracker --max-rms-mm 0.5 --min-cone-deg 20
  calib pivot --poses folder --method algebraic --json";

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
    /// Accept at least this half opening of the cone of poses
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    min_cone_deg: Option<Positive>,
    #[command(flatten)]
    out: OutArgs,
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

/// A method's result.
pub(crate) type Solution = Result<Pivot<Tracker, Marker>, Refused>;

impl PivotArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let recording = self.poses.read()?;
        let noise = PoseNoise {
            sigma_mm: self.sigma_mm.0,
            sigma_rad: self.sigma_deg.0.to_radians(),
        };
        let each = uncertain(&recording);
        let solve = |method| match (&each, method) {
            (Some(each), Method::ErrorsInVariables) => calibrate_each(each),
            _ => calibrate(&recording.poses, &Options { method, noise }),
        };
        let all: Vec<(Method, Solution)> = Method::ALL.iter().map(|m| (*m, solve(*m))).collect();
        let chosen = solve(self.method.0).map_err(|refused| CommandError::Pivot {
            poses: recording.poses.len(),
            path: recording.path.clone(),
            left_out: left_out(&recording),
            refused: Box::new(refused),
        })?;
        let used = each.is_some() && self.method.0 == Method::ErrorsInVariables;
        let record = self.record(&chosen, noise, used);
        let gates = self.gates(&chosen);
        let text = pivot_report::text(&recording, &chosen, &all, &record, &gates);
        let file = CalibrationFile {
            recorded: Some(recorded(&recording)),
            pivot: Some(record),
            ..CalibrationFile::new(Kind::Pivot, self.out.tool.as_str(), self.out.marker.as_str(), gates)
        };
        self.out.finish(file, text, &[&recording.path])
    }

    fn gates(&self, found: &Pivot<Tracker, Marker>) -> Vec<Gate> {
        let limit = |gate: Option<Positive>| gate.map(|limit| limit.0);
        // A method without a covariance keeps no bound of it; JSON has no infinity.
        let error = found.tip_error_rms_mm().unwrap_or(f64::MAX);
        let cone = found.coverage.cone_rad().to_degrees();
        let gates = [
            gate("max-rms-mm", limit(self.max_rms_mm), found.rms_mm, false),
            gate("max-tip-error-mm", limit(self.max_tip_error_mm), error, false),
            gate("min-cone-deg", limit(self.min_cone_deg), cone, true),
        ];
        gates.into_iter().flatten().collect()
    }

    fn record(&self, found: &Pivot<Tracker, Marker>, noise: PoseNoise, each: bool) -> PivotRecord {
        let needed = self.min_cone_deg.map_or(GOOD_CONE_DEG, |gate| gate.0);
        let advice = found
            .coverage
            .advice(needed.to_radians())
            .map(|advice| advice.to_string());
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
        }
    }
}
