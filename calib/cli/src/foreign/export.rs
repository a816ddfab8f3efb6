//! `calib export`: a tool's frame or a registration for other programs.

use std::path::{Path, PathBuf};

use calib::file::{Registered, RegistrationFile, ToolFile};
use clap::Args;
use exchange::plus::{self, Definition, DeviceSet};
use geometry::{Ct, Frame, Marker, Reference, Rigid, Tool, Tracker};

use super::holds::Holds;
use super::{ForeignError, Format, bytes};
use crate::commands::common::{CommandError, Outcome};
use crate::store;
use crate::text::shown;
use crate::values::Name;

pub(crate) const EXPORT_HELP: &str = "\
Writes the transform of a tool's calibration or of a registration as ITK reads it (.tfm, .txt), or a tool's into a device set of the
PLUS toolkit (.xml). A file of ITK does not say what it maps: --holds says what is to be in it. With slicer-node 3D Slicer loads a
transform node that takes the tool to its marker, or the localizer (or the patient's marker), in its own axes, to the patient in RAS.
The covariance is in none of these files. .h5 is not written; one line of SimpleITK makes it of a .tfm:
WriteTransform(ReadTransform(\"a.tfm\"), \"a.h5\").

Examples:
  calib export registration.json --holds slicer-node --out TrackerToRas.tfm
  calib export registration.json --holds ct-from-tracker --out ct_from_tracker.tfm
  calib export tool.json --from StylusTip --to Stylus --out stylus.xml";

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// A tool's calibration or a registration, as calib writes them
    #[arg(value_name = "FILE.json")]
    file: PathBuf,
    /// What the file of ITK is to map
    #[arg(long, conflicts_with = "from")]
    holds: Option<Holds>,
    /// The name of the tool's frame in a device set of PLUS
    #[arg(long, value_name = "FRAME", requires = "to")]
    from: Option<Name>,
    /// The name of the marker's frame in it
    #[arg(long, value_name = "FRAME", requires = "from")]
    to: Option<Name>,
    /// The file to write, its kind by its ending
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replace that file if it exists
    #[arg(long)]
    overwrite: bool,
}

/// What Trocar's file holds.
enum Held {
    Tool(Rigid<Marker, Tool>),
    Fixed(Rigid<Ct, Tracker>),
    Referenced(Rigid<Ct, Reference>),
}

impl ExportArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        store::check(&self.out, self.overwrite)?;
        let text = self.text()?;
        store::write(&self.out, Ok(text), [self.file.as_path()].into_iter())?;
        let [out, file] = [&self.out, &self.file].map(|path| shown(&path.to_string_lossy()));
        Ok(Outcome {
            text: format!("written to {out}; the covariance of {file} is not in it\n"),
            refused: None,
        })
    }

    fn text(&self) -> Result<String, ForeignError> {
        let out = || self.out.clone();
        let held = held(&self.file)?;
        match Format::of(&self.out)? {
            Format::Hdf5 => Err(ForeignError::Ending {
                path: out(),
                more: "; .h5 is read alone: write a .tfm, and with SimpleITK WriteTransform(ReadTransform(\"a.tfm\"), \"a.h5\")",
            }),
            Format::Plus => self.device_set(&held),
            Format::Itk => {
                let what = "a file of ITK does not say what it maps: say what is to be in it with --holds";
                let holds = self.holds.ok_or_else(|| ForeignError::Lacks { path: out(), what })?;
                let written = match &held {
                    Held::Tool(marker_from_tool) => holds.written(marker_from_tool, false),
                    Held::Fixed(ct_from_tracker) => holds.written(ct_from_tracker, true),
                    Held::Referenced(ct_from_reference) => holds.written(ct_from_reference, true),
                };
                written.ok_or_else(|| ForeignError::OtherFrames {
                    path: self.file.clone(),
                    holds: holds.word(),
                    has: held.words(),
                })
            }
        }
    }

    fn device_set(&self, held: &Held) -> Result<String, ForeignError> {
        let lacks = |what| ForeignError::Lacks {
            path: self.out.clone(),
            what,
        };
        let Held::Tool(marker_from_tool) = held else {
            return Err(lacks(
                "a device set of PLUS takes a tool's frame; write a registration as .tfm",
            ));
        };
        let (Some(from), Some(to)) = (&self.from, &self.to) else {
            return Err(lacks(
                "say how PLUS is to call the tool's frame with --from and the marker's with --to",
            ));
        };
        if from.as_str() == to.as_str() {
            return Err(lacks(
                "--from and --to are one name: the tool's frame and the marker's are two",
            ));
        }
        let definitions = vec![Definition::new(from.as_str(), to.as_str(), marker_from_tool)];
        Ok(plus::write(&DeviceSet { definitions }))
    }
}

impl Held {
    fn words(&self) -> String {
        fn of<To: Frame, From: Frame>(_: &Rigid<To, From>) -> String {
            format!("{}_from_{}", To::NAME, From::NAME).to_ascii_lowercase()
        }
        match self {
            Self::Tool(rigid) => of(rigid),
            Self::Fixed(rigid) => of(rigid),
            Self::Referenced(rigid) => of(rigid),
        }
    }
}

/// A tool's frame or a registration; that of a file which a tracker would refuse is refused here too.
fn held(path: &Path) -> Result<Held, ForeignError> {
    let owned = || path.to_owned();
    let bytes = bytes(path, calib::file::MAX_BYTES)?;
    let text = String::from_utf8_lossy(&bytes);
    let fail = |source| ForeignError::Own { path: owned(), source };
    // A calibration says so with a key of its own; everything else is read as a registration, whose errors name its format.
    if text.contains("\"trocar_calibration\"") {
        let tool = ToolFile::parse(&text).map_err(fail)?;
        return Ok(Held::Tool(tool.marker_from_tool.transform()));
    }
    let registration = RegistrationFile::parse(&text).map_err(fail)?;
    Ok(match registration.registered {
        Registered::Fixed(ct_from_tracker) => Held::Fixed(ct_from_tracker.transform()),
        Registered::Referenced(ct_from_reference) => Held::Referenced(ct_from_reference.transform()),
    })
}
