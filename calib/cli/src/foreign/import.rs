//! `calib import`: a tool's calibration of another program.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use calib::file::ToolFile;
use clap::{Args, ValueEnum};
use exchange::{LengthUnit, Said, itk, plus};
use geometry::{Direction, Marker, Point, Rigid, Tool};
use nalgebra::{Matrix3, Vector3};

use super::holds::Holds;
use super::{ForeignError, Format, bytes};
use crate::bounds::on_tool;
use crate::calibration::{CalibrationFile, ImportedRecord, Kind, ToolRecord};
use crate::commands::common::{CommandError, OutArgs, Outcome, broken, verdict_text};
use crate::scene_context::{SceneArgs, SceneContext};

pub(crate) const IMPORT_HELP: &str = "\
The frame of a tool in its marker, from a device set of the PLUS toolkit (.xml) or a transform of ITK or 3D Slicer (.tfm, .txt, .h5).
A transform of ITK does not say what it maps (--holds), and neither format says which axis of the tool is its shaft (--shaft) or how
large its error is: the number that PLUS calls Error is the residual of its own pivoting. So a person says the error, and the result
says who did; without it nothing is written, as a tracker promises an error with every pose.

Examples:
  calib import PlusDeviceSet.xml --from StylusTip --to Stylus --shaft x --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json
  calib import PlusDeviceSet.xml --from StylusTip --to Stylus --backwards --shaft x --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json
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
    /// The device set has the way from the marker to the tool alone, and it is to be turned round
    #[arg(long, requires = "from")]
    backwards: bool,
    /// What a transform of ITK maps
    #[arg(long, conflicts_with = "from")]
    holds: Option<Holds>,
    /// The axis of the file's tool that runs along the shaft from the handle to the tip
    #[arg(long, allow_hyphen_values = true)]
    shaft: Shaft,
    /// Root mean square error of the tip in the marker, as you know it, 0.001 to 20
    #[arg(long, value_name = "MM", value_parser = tip_error)]
    tip_error_mm: f64,
    /// Error of the shaft's direction about each axis across it, as you know it, 0.001 to 10
    #[arg(long, value_name = "DEG", value_parser = axis_error)]
    axis_error_deg: f64,
    /// The unit of the file: m, or mm though the tip is within 2 mm of the marker's origin [default: mm]
    #[arg(long, value_name = "mm|m")]
    unit: Option<LengthUnit>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    out: OutArgs,
}

/// The errors that may be said. Below the least no localizer of this world sees, and a covariance of next to nothing would be a promise that
/// gates believe. Above the most nobody can aim: 20 mm beside the tip is another organ, and a covariance is a tilt's first order, whose sine is
/// half a percent off at 10 degrees.
const TIP_MM: RangeInclusive<f64> = 0.001..=20.0;
const AXIS_DEG: RangeInclusive<f64> = 0.001..=10.0;
/// What putting the file's matrix right may change, as a part of the error that is said: a tenth makes that half a percent larger.
const SMALL: f64 = 0.1;

fn tip_error(text: &str) -> Result<f64, String> {
    within(text, TIP_MM, "mm")
}

fn axis_error(text: &str) -> Result<f64, String> {
    within(text, AXIS_DEG, "degrees")
}

fn within(text: &str, allowed: RangeInclusive<f64>, unit: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|found| allowed.contains(found));
    found.ok_or_else(|| format!("expected {} to {} {unit}", allowed.start(), allowed.end()))
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
    /// By how much putting its matrix right moved the tip, mm.
    moved_mm: f64,
    record: ImportedRecord,
}

/// A transform of a file, in its unit.
struct Transform {
    marker_from_tool: Rigid<Marker, Tool>,
    /// How far its matrix was from the rotation that was taken for it, and by how much that moved the tip.
    off: f64,
    moved: f64,
    /// What the file calls its error.
    error: Option<f64>,
    /// The transform in words.
    words: String,
}

impl ImportArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        let scened = SceneContext::open(&self.scene)?;
        let out = self.out.of(scened.as_ref())?;
        let read = self.read()?;
        let record = self.frame(&read.marker_from_tool)?;
        let text = report(&read, &record);
        let file = CalibrationFile {
            tool_frame: Some(record),
            imported: Some(read.record),
            ..CalibrationFile::new(Kind::Tool, out.tool(), out.marker(), Vec::new())
        };
        let gates = scened.map(|scened| on_tool(&file, &scened, None)).transpose()?;
        let file = file.with_gates(gates.unwrap_or_default());
        let text = text + &verdict_text(&file.gates);
        self.is_readable(&file)?;
        out.finish(file, text, &[&self.file])
    }

    /// Refuses what a tracker would refuse, before it is written; what gates refuse is told as that.
    fn is_readable(&self, file: &CalibrationFile) -> Result<(), CommandError> {
        if broken(&file.gates).is_some() {
            return Ok(());
        }
        let path = self.file.clone();
        match ToolFile::parse(&file.clone().sealed()?.to_json()?) {
            Ok(_) => Ok(()),
            Err(source) => Err(ForeignError::Unreadable { path, source }.into()),
        }
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
        let found = match format {
            Format::Plus => self.of_plus(&bytes)?,
            Format::Itk | Format::Hdf5 => self.of_itk(&bytes)?,
        };
        let (marker_from_tool, scale) = self.in_mm(&found.marker_from_tool)?;
        let moved_mm = found.moved * scale;
        self.is_as_said(moved_mm, found.off)?;
        Ok(Read {
            marker_from_tool,
            moved_mm,
            record: ImportedRecord {
                path: path.to_string_lossy().into_owned(),
                source_blake3: blake3::hash(&bytes).to_hex().to_string(),
                transform: found.words,
                source_error: found.error,
                matrix_off: found.off,
                said_tip_error_mm: self.tip_error_mm,
                said_axis_error_deg: self.axis_error_deg,
            },
        })
    }

    /// Refuses a matrix whose being put right changes more than a small part of the errors that are said.
    fn is_as_said(&self, moved_mm: f64, off: f64) -> Result<(), ForeignError> {
        let refused = |what, moved, said| {
            let path = self.file.clone();
            Err(ForeignError::Moved {
                path,
                what,
                moved,
                said,
            })
        };
        // A NaN is within nothing. A rotation that is off by so much turns no axis by more.
        let is_small = |found: f64, said: f64| (0.0..=SMALL * said).contains(&found);
        let (degrees, [tip, axis]) = (off.to_degrees(), [self.tip_error_mm, self.axis_error_deg]);
        if !is_small(moved_mm, tip) {
            return refused("tip", format!("{moved_mm:.4} mm"), format!("{tip} mm"));
        }
        if !is_small(degrees, axis) {
            return refused(
                "shaft",
                format!("up to {degrees:.4} degrees"),
                format!("{axis} degrees"),
            );
        }
        Ok(())
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
        // Which of two frames is the tool's nothing in the file says: names that were exchanged would give the way back, untold.
        let path = || self.file.clone();
        match (found.is_inverse, self.backwards) {
            (true, false) => {
                let (has, from, to) = (format!("{to}To{from}"), from.clone(), to.clone());
                return Err(ForeignError::Back {
                    path: path(),
                    has,
                    from,
                    to,
                });
            }
            (false, true) => {
                let has = format!("{from}To{to}");
                return Err(ForeignError::There { path: path(), has });
            }
            _ => {}
        }
        let turned = if found.is_inverse {
            ", which the file has backwards and was turned round"
        } else {
            ""
        };
        let moved = found.moved(TIP);
        let date = found.date.map_or_else(String::new, |date| format!(", of {date}"));
        Ok(Transform {
            marker_from_tool: found.to_from_from,
            off: found.off,
            moved,
            error: found.error,
            words: format!("{from}To{to}{turned}{date}"),
        })
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
            return Ok(Transform {
                marker_from_tool: read.to_from_from,
                off: read.most_off,
                moved: read.moved(TIP),
                error: None,
                words: words(&read.kinds),
            });
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
        Ok(Transform {
            marker_from_tool,
            off: read.most_off,
            // The file takes the tip to the tool's origin.
            moved: read.moved(read.to_from_from.inverse() * TIP),
            error: None,
            words: words(&read.kinds),
        })
    }

    /// The same with its translation in mm, and how many of these the file's unit has.
    fn in_mm(&self, given: &Rigid<Marker, Tool>) -> Result<(Rigid<Marker, Tool>, f64), ForeignError> {
        let said = Said {
            axes: None,
            unit: self.unit,
        };
        let away = given.translation().norm();
        let scale = said.scale(None, [("the distance of the tip from the marker's origin", away); 2]);
        let scale = scale.map_err(|source| ForeignError::Unsettled {
            path: self.file.clone(),
            source,
        })?;
        Ok((Rigid::from_parts(given.rotation(), given.translation() * scale), scale))
    }

    /// Trocar's own frame of the tool, whose third axis is the shaft, with the error that was said.
    fn frame(&self, given: &Rigid<Marker, Tool>) -> Result<ToolRecord, ForeignError> {
        let axis = *given * self.shaft.direction();
        let tip = *given * TIP;
        let u = Vector3::from(axis.components());
        // About both axes across the shaft alike; the root mean square of the tip's error is the root of the trace.
        let tilts = (Matrix3::identity() - u * u.transpose()) * self.axis_error_deg.to_radians().powi(2);
        let places = Matrix3::identity() * (self.tip_error_mm.powi(2) / 3.0);
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

/// Of every file, in the tool's own frame.
const TIP: Point<Tool> = Point::new(0.0, 0.0, 0.0);

fn report(read: &Read, record: &ToolRecord) -> String {
    let imported = &read.record;
    let ([w, x, y, z], [a, b, c]) = (record.quaternion_wxyz, record.translation_mm);
    let error = imported.source_error.map_or_else(
        || "the file has none".to_owned(),
        |error| format!("the file has {error}, without unit or meaning: not used"),
    );
    format!(
        "read             {}: {}\n\
         marker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
         rotation         was off by {:.1e} and was put right, which moved the tip by {:.1e} mm\n\
         roll             the tool's x axis is as near to the marker's {} axis as it can be\n\
         error            {error}; you say {} mm of the tip and {} degrees of the shaft. NOBODY MEASURED IT HERE: touch a known point\n\n",
        crate::text::shown(&imported.path),
        imported.transform,
        imported.matrix_off,
        read.moved_mm,
        record.roll_by,
        imported.said_tip_error_mm,
        imported.said_axis_error_deg,
    )
}
