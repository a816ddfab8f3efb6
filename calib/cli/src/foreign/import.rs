//! `calib import`: a tool's calibration of another program.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use exchange::{LengthUnit, Said, itk, plus};
use geometry::{Direction, Marker, Point, Rigid, Tool};
use nalgebra::{Matrix3, Vector3};

use super::holds::Holds;
use super::{ForeignError, Format, Unit, bytes};
use crate::bounds::on_tool;
use crate::calibration::{CalibrationFile, ImportedRecord, Kind, ToolRecord};
use crate::commands::common::{CommandError, OutArgs, Outcome, verdict_text};
use crate::scene_context::{SceneArgs, SceneContext};
use crate::values::Positive;

pub(crate) const IMPORT_HELP: &str = "\
The frame of a tool in its marker, from a device set of the PLUS toolkit (.xml) or a transform of ITK or 3D Slicer (.tfm, .txt, .h5).
A transform of ITK does not say what it maps (--holds), and neither format says which axis of the tool is its shaft (--shaft) or how
large its error is: the number that PLUS calls Error is the residual of its own pivoting. So a person says the error, and the result
says who did; without it nothing is written, as a tracker promises an error with every pose.

Examples:
  calib import PlusDeviceSet.xml --from StylusTip --to Stylus --shaft x --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json
  calib import tip.tfm --holds marker-from-tool --shaft z --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json
  calib import StylusTipToStylus.h5 --holds slicer-node --shaft=-z --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json";

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// The file of the other program
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The tool's frame in a device set of PLUS, for instance StylusTip
    #[arg(long, value_name = "FRAME", requires = "to")]
    from: Option<String>,
    /// The marker's frame in it, for instance Stylus
    #[arg(long, value_name = "FRAME", requires = "from")]
    to: Option<String>,
    /// What a transform of ITK maps
    #[arg(long, conflicts_with = "from")]
    holds: Option<Holds>,
    /// The axis of the file's tool that runs along the shaft from the handle to the tip
    #[arg(long, allow_hyphen_values = true)]
    shaft: Shaft,
    /// Root mean square error of the tip in the marker, as you know it
    #[arg(long, value_name = "MM")]
    tip_error_mm: Positive,
    /// Error of the shaft's direction about each axis across it, as you know it
    #[arg(long, value_name = "DEG")]
    axis_error_deg: Positive,
    /// The unit of the file: metres, or millimetres though the tip is within 2 mm of the marker's origin
    #[arg(long)]
    unit: Option<Unit>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    out: OutArgs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Shaft {
    X,
    #[value(name = "-x")]
    MinusX,
    Y,
    #[value(name = "-y")]
    MinusY,
    Z,
    #[value(name = "-z")]
    MinusZ,
}

impl Shaft {
    fn direction(self) -> Direction<Tool> {
        match self {
            Self::X => Direction::X,
            Self::MinusX => -Direction::X,
            Self::Y => Direction::Y,
            Self::MinusY => -Direction::Y,
            Self::Z => Direction::Z,
            Self::MinusZ => -Direction::Z,
        }
    }
}

/// What a file holds.
struct Read {
    marker_from_tool: Rigid<Marker, Tool>,
    record: ImportedRecord,
}

impl ImportArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.scene)?;
        let out = self.out.of(scened.as_ref())?;
        let read = self.read()?;
        let record = self.frame(&read.marker_from_tool)?;
        let text = report(&read.record, &record);
        let file = CalibrationFile {
            tool_frame: Some(record),
            imported: Some(read.record),
            ..CalibrationFile::new(Kind::Tool, out.tool(), out.marker(), Vec::new())
        };
        let gates = scened.map(|scened| on_tool(&file, &scened, None)).transpose()?;
        let file = file.with_gates(gates.unwrap_or_default());
        let text = text + &verdict_text(&file.gates);
        out.finish(file, text, &[&self.file])
    }

    fn read(&self) -> Result<Read, ForeignError> {
        let path = &self.file;
        let format = Format::of(path)?;
        let most = if format == Format::Plus {
            plus::MAX_BYTES
        } else {
            itk::MAX_BYTES
        };
        let bytes = bytes(path, most)?;
        let (transform, off, error, words) = match format {
            Format::Plus => self.of_plus(&bytes)?,
            Format::Itk | Format::Hdf5 => self.of_itk(&bytes)?,
        };
        Ok(Read {
            marker_from_tool: self.in_mm(transform)?,
            record: ImportedRecord {
                path: path.to_string_lossy().into_owned(),
                source_blake3: blake3::hash(&bytes).to_hex().to_string(),
                transform: words,
                source_error: error,
                matrix_off: off,
                said_tip_error_mm: self.tip_error_mm.0,
                said_axis_error_deg: self.axis_error_deg.0,
            },
        })
    }

    fn of_plus(&self, bytes: &[u8]) -> Result<Transform, ForeignError> {
        let (Some(from), Some(to)) = (&self.from, &self.to) else {
            return Err(self.lacks(
                "a device set has several transforms: say the tool's frame with --from and the marker's with --to",
            ));
        };
        let found = plus::read(bytes).and_then(|set| set.find::<Marker, Tool>(from, to));
        let found = found.map_err(|source| ForeignError::Plus {
            path: self.file.clone(),
            source: Box::new(source),
        })?;
        let turned = if found.is_inverse {
            ", which the file has backwards"
        } else {
            ""
        };
        let date = found.date.map_or_else(String::new, |date| format!(", of {date}"));
        let words = format!("{from}To{to}{turned}{date}");
        Ok((found.to_from_from, found.off, found.error, words))
    }

    fn of_itk(&self, bytes: &[u8]) -> Result<Transform, ForeignError> {
        let Some(holds) = self.holds else {
            return Err(self.lacks("a transform of ITK does not say what it maps: say it with --holds"));
        };
        let fail = |source| ForeignError::Itk {
            path: self.file.clone(),
            source: Box::new(source),
        };
        let words = |kinds: &[String]| format!("{} as {}", kinds.join(", "), holds.word());
        let way = holds.way::<Marker, Tool>();
        if way == Some(true) {
            let read = itk::read::<Marker, Tool>(bytes).map_err(fail)?;
            return Ok((read.to_from_from, read.most_off, None, words(&read.kinds)));
        }
        if way.is_none() && holds != Holds::SlicerNode {
            let (path, holds) = (self.file.clone(), holds.word());
            let has = "the frame of a tool in its marker".to_owned();
            return Err(ForeignError::OtherFrames { path, holds, has });
        }
        let read = itk::read::<Tool, Marker>(bytes).map_err(fail)?;
        let marker_from_tool = match holds {
            Holds::SlicerNode => itk::slicer_node(&read.to_from_from),
            _ => read.to_from_from.inverse(),
        };
        Ok((marker_from_tool, read.most_off, None, words(&read.kinds)))
    }

    /// The same with its translation in mm.
    fn in_mm(&self, given: Rigid<Marker, Tool>) -> Result<Rigid<Marker, Tool>, ForeignError> {
        let said = Said {
            axes: None,
            unit: self.unit.map(LengthUnit::from),
        };
        let away = given.translation().norm();
        let scale = said.scale(None, [("the distance of the tip from the marker's origin", away); 2]);
        let scale = scale.map_err(|source| ForeignError::Unsettled {
            path: self.file.clone(),
            source,
        })?;
        Ok(Rigid::from_parts(given.rotation(), given.translation() * scale))
    }

    /// Trocar's own frame of the tool, whose third axis is the shaft, with the error that was said.
    fn frame(&self, given: &Rigid<Marker, Tool>) -> Result<ToolRecord, ForeignError> {
        let axis = *given * self.shaft.direction();
        let tip = *given * Point::<Tool>::new(0.0, 0.0, 0.0);
        let u = Vector3::from(axis.components());
        // About both axes across the shaft alike; the root mean square of the tip's error is the root of the trace.
        let tilts = (Matrix3::identity() - u * u.transpose()) * self.axis_error_deg.0.to_radians().powi(2);
        let places = Matrix3::identity() * (self.tip_error_mm.0.powi(2) / 3.0);
        let tool = calib::spin::marker_from_tool((tip, places), (axis, tilts), tip);
        let tool = tool.map_err(|refused| ForeignError::Frame {
            path: self.file.clone(),
            refused: Box::new(refused),
        })?;
        let frame = tool.marker_from_tool.transform();
        Ok(ToolRecord {
            quaternion_wxyz: frame.quaternion(),
            translation_mm: frame.translation_mm(),
            covariance_upper: tool.marker_from_tool.upper(),
            roll_by: tool.roll_by.to_owned(),
            tip_off_axis_mm: tool.tip_off_axis_mm,
        })
    }

    fn lacks(&self, what: &'static str) -> ForeignError {
        let path: &Path = &self.file;
        ForeignError::Lacks {
            path: path.to_owned(),
            what,
        }
    }
}

/// The transform, how far it was from a rotation, what the file calls its error, and the transform in words.
type Transform = (Rigid<Marker, Tool>, f64, Option<f64>, String);

fn report(imported: &ImportedRecord, record: &ToolRecord) -> String {
    let ([w, x, y, z], [a, b, c]) = (record.quaternion_wxyz, record.translation_mm);
    let error = imported.source_error.map_or_else(
        || "the file has none".to_owned(),
        |error| format!("the file has {error}, without unit or meaning: not used"),
    );
    format!(
        "read             {}: {}\n\
         marker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
         rotation         was off by {:.1e} and was put right\n\
         roll             the tool's x axis is as near to the marker's {} axis as it can be\n\
         error            {error}; you say {} mm of the tip and {} degrees of the shaft. NOBODY MEASURED IT HERE: touch a known point\n\n",
        crate::text::shown(&imported.path),
        imported.transform,
        imported.matrix_off,
        record.roll_by,
        imported.said_tip_error_mm,
        imported.said_axis_error_deg,
    )
}
