//! `calib tool`: a tip and an axis to the tool's frame in its marker.

use std::path::{Path, PathBuf};

use calib::spin::{Refused, marker_from_tool};
use clap::Args;
use geometry::{Direction, Marker, Point, Vector};
use nalgebra::Matrix3;

use super::common::{CommandError, OutArgs, Outcome, OwnError, gate, verdict_text};
use crate::bounds::on_tool;
use crate::calibration::{CalibrationFile, Kind, PivotRecord, SpinRecord, ToolRecord};
use crate::scene_context::{SceneArgs, SceneContext};
use crate::values::Positive;

pub(crate) const TOOL_HELP: &str = "\
The frame of an instrument of revolution: origin at the tip, +z along the shaft from the handle to the tip. Its roll is \
free: the x axis is as near to the marker's x axis as it can be, or to its y axis where x lies within 45 degrees of the \
shaft. Both files must be of the marker and the tool named, and must not have been changed. With --live or --scene the \
result must keep the scene's [tracker.calibration.gates], as its tracker asks of it.

Examples:
  calib tool --pivot tip.json --spin axis.json --out tool.json
  calib tool --pivot tip.json --spin axis.json --tool mediastinoscope --marker ball --max-off-axis-mm 1";

#[derive(Debug, Args)]
pub(crate) struct ToolArgs {
    /// The pivot calibration
    #[arg(long, value_name = "FILE.json")]
    pivot: PathBuf,
    /// The spin calibration
    #[arg(long, value_name = "FILE.json")]
    spin: PathBuf,
    /// Accept at most this distance of the tip from the axis
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_off_axis_mm: Option<Positive>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// Why there is no frame.
#[derive(Debug, thiserror::Error)]
enum ToolError {
    #[error("the tool's frame from {pivot} and {spin}: {refused}")]
    Refused {
        pivot: PathBuf,
        spin: PathBuf,
        refused: Box<Refused>,
    },
    #[error("{path}: the pivot calibration has no covariance (method {method}); make it by errors-in-variables")]
    NoCovariance { path: PathBuf, method: String },
    #[error("--towards: the direction must not be 0,0,0")]
    NoDirection,
}

impl OwnError for ToolError {}

impl ToolArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.scene)?;
        let out = self.out.of(scened.as_ref())?;
        let (pivot_id, pivot) = read(&self.pivot, Kind::Pivot, &out)?;
        let (spin_id, spin) = read(&self.spin, Kind::Spin, &out)?;
        // A file that was read has the part of its kind.
        let (Some(pivot), Some(spin)) = (pivot.pivot, spin.spin) else {
            return Err(ToolError::NoDirection.into());
        };
        let record = self.solve(&pivot, &spin)?;
        let limit = self.max_off_axis_mm.map(|limit| limit.0);
        let gates = gate("max-off-axis-mm", limit, record.tip_off_axis_mm, false);
        let text = report(&record);
        let file = CalibrationFile {
            computed_from: vec![pivot_id, spin_id],
            // How good both were, for whoever holds the file against gates.
            pivot: Some(pivot),
            spin: Some(spin),
            tool_frame: Some(record),
            ..CalibrationFile::new(Kind::Tool, out.tool(), out.marker(), Vec::new())
        };
        let scene = scened.map(|scened| on_tool(&file, &scened, None)).transpose()?;
        let file = file.with_gates(gates.into_iter().chain(scene.unwrap_or_default()).collect());
        let text = text + &verdict_text(&file.gates);
        out.finish(file, text, &[&self.pivot, &self.spin])
    }

    fn solve(&self, pivot: &PivotRecord, spin: &SpinRecord) -> Result<ToolRecord, CommandError> {
        let [x, y, z] = spin.axis;
        let axis = Vector::new(x, y, z).direction().ok_or(ToolError::NoDirection)?;
        let tilts = symmetric(spin.axis_covariance_upper_rad2);
        let [a, b, c] = spin.point_mm;
        let refused = |refused| {
            let (pivot, spin, refused) = (self.pivot.clone(), self.spin.clone(), Box::new(refused));
            ToolError::Refused { pivot, spin, refused }.into()
        };
        tool_frame(pivot, &self.pivot, (axis, tilts), Point::new(a, b, c), refused)
    }
}

fn read(path: &Path, kind: Kind, out: &OutArgs) -> Result<(String, CalibrationFile), CommandError> {
    let file = CalibrationFile::read(path, kind)?;
    file.of_marker(path, "command line", out.marker())?;
    file.of_tool(path, "command line", out.tool())?;
    Ok((file.id.clone(), file))
}

/// The frame of a tool from its tip, of the file `path`, and from its axis with the covariance of that, through `point`.
pub(super) fn tool_frame(
    pivot: &PivotRecord,
    path: &Path,
    axis: (Direction<Marker>, Matrix3<f64>),
    point: Point<Marker>,
    refused: impl FnOnce(Refused) -> CommandError,
) -> Result<ToolRecord, CommandError> {
    let c = pivot.covariance_upper_mm2.ok_or_else(|| ToolError::NoCovariance {
        path: path.to_owned(),
        method: pivot.method.clone(),
    })?;
    // Rows of six, five and four numbers: the first three of each row are the tip's.
    let tips = symmetric([c[0], c[1], c[2], c[6], c[7], c[11]]);
    let [x, y, z] = pivot.tip_mm;
    let tool = marker_from_tool((Point::new(x, y, z), tips), axis, point).map_err(refused)?;
    let frame = tool.marker_from_tool.transform();
    Ok(ToolRecord {
        quaternion_wxyz: frame.quaternion(),
        translation_mm: frame.translation_mm(),
        covariance_upper: tool.marker_from_tool.upper(),
        roll_by: tool.roll_by.to_owned(),
        tip_off_axis_mm: tool.tip_off_axis_mm,
    })
}

/// A symmetric matrix from its upper triangle by rows.
fn symmetric([a, b, c, d, e, f]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(a, b, c, b, d, e, c, e, f)
}

fn report(record: &ToolRecord) -> String {
    let ([w, x, y, z], [a, b, c]) = (record.quaternion_wxyz, record.translation_mm);
    format!(
        "marker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
         roll             the tool's x axis is as near to the marker's {} axis as it can be\n\
         tip off the axis {:.3} mm\n\n",
        record.roll_by, record.tip_off_axis_mm
    )
}
