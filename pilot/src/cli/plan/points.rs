//! Targets and entries from files of 3D Slicer into a plan, and out of it.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use exchange::fcsv::{self, FcsvError, Fiducials};
use exchange::markups::{self, Markup, MarkupKind, Markups, MarkupsError};
use exchange::{LengthUnit, PatientAxes, Said};
use guidance::plan::{Editor, Plan};
use scene::file::{OpenError, read_text};

use crate::planning::{PointsError, Taken, points_of, take_points};

#[derive(Debug, Args)]
pub(crate) struct PointsArgs {
    /// Takes targets and their entries from a file of 3D Slicer, .mrk.json or .fcsv; a point `NAME entry` is the entry
    /// of `NAME`.
    #[arg(long, value_name = "FILE")]
    import: Vec<PathBuf>,
    /// The axes of the imported files, where they do not say them.
    #[arg(long, value_name = "AXES", requires = "import")]
    frame: Option<Axes>,
    /// The unit of the imported files: metres, or millimetres though everything lies within 2 mm of the origin.
    #[arg(long, value_name = "UNIT", requires = "import")]
    unit: Option<Unit>,
    /// Writes the targets and entries into such a file, the kind by its ending.
    #[arg(long, value_name = "FILE")]
    export: Option<PathBuf>,
    /// Replace the exported file if it exists.
    #[arg(long, requires = "export")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Axes {
    /// To the patient's left, back and head.
    Lps,
    /// To the patient's right, front and head.
    Ras,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Unit {
    /// Millimetres.
    Mm,
    /// Metres.
    M,
}

/// Why points were not taken in, or not written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FileError {
    #[error("reading {path}: {source}")]
    Open { path: PathBuf, source: OpenError },
    #[error("reading {path}: {source}. Nothing was written")]
    Markups { path: PathBuf, source: Box<MarkupsError> },
    #[error("reading {path}: {source}. Nothing was written")]
    Fcsv { path: PathBuf, source: Box<FcsvError> },
    #[error("{path}: {source}. Nothing was written")]
    Points { path: PathBuf, source: Box<PointsError> },
    #[error("{path}: the kind of file is told by its ending; .mrk.json and .fcsv are known")]
    Ending { path: PathBuf },
    #[error("writing {path}: there is a file of this name; give another name, or --overwrite to replace it")]
    Exists { path: PathBuf },
    #[error("writing {path}: {source}")]
    Write { path: PathBuf, source: io::Error },
    #[error("writing {path}: {source}")]
    Unwritable { path: PathBuf, source: Box<FcsvError> },
}

/// The two kinds of files.
enum Format {
    Markups,
    Fcsv,
}

impl Format {
    fn of(path: &Path) -> Result<Self, FileError> {
        let name = path.to_string_lossy().to_ascii_lowercase();
        match (name.ends_with(".mrk.json"), name.ends_with(".fcsv")) {
            (true, _) => Ok(Self::Markups),
            (_, true) => Ok(Self::Fcsv),
            _ => Err(FileError::Ending { path: path.to_owned() }),
        }
    }
}

impl PointsArgs {
    /// Whether anything is taken in.
    pub(super) fn is_import(&self) -> bool {
        !self.import.is_empty()
    }

    /// Takes the files in, in their order.
    pub(super) fn take(&self, editor: &mut Editor) -> Result<(), FileError> {
        let said = Said {
            axes: self.frame.map(|axes| match axes {
                Axes::Lps => PatientAxes::Lps,
                Axes::Ras => PatientAxes::Ras,
            }),
            unit: self.unit.map(|unit| match unit {
                Unit::Mm => LengthUnit::Millimetre,
                Unit::M => LengthUnit::Metre,
            }),
        };
        for path in &self.import {
            let markups = read(path, said)?;
            let owned = || path.to_owned();
            let taken = take_points(editor, &markups).map_err(|source| FileError::Points {
                path: owned(),
                source: Box::new(source),
            })?;
            tell(path, &markups, &taken);
        }
        Ok(())
    }

    /// Refuses an export that could not be written, before anything is.
    pub(super) fn check(&self) -> Result<(), FileError> {
        let Some(path) = &self.export else { return Ok(()) };
        Format::of(path)?;
        match path.symlink_metadata().is_ok() && !self.overwrite {
            true => Err(FileError::Exists { path: path.clone() }),
            false => Ok(()),
        }
    }

    /// The text of the export, where one is asked for: made before anything is written.
    pub(super) fn text(&self, plan: &Plan) -> Result<Option<(PathBuf, String)>, FileError> {
        let Some(path) = &self.export else { return Ok(None) };
        let owned = || path.to_owned();
        let markups = points_of(&plan.targets).map_err(|source| FileError::Points {
            path: owned(),
            source: Box::new(source),
        })?;
        let text = match Format::of(path)? {
            Format::Markups => {
                let left_out_keys = Vec::new();
                markups::write(&Markups { markups, left_out_keys }, PatientAxes::Lps)
            }
            Format::Fcsv => {
                let points = markups.into_iter().flat_map(|markup| markup.points).collect();
                let left_out = Vec::new();
                // As readers that do not look at the head take it.
                fcsv::write(&Fiducials { points, left_out }, PatientAxes::Ras).map_err(|source| {
                    FileError::Unwritable {
                        path: owned(),
                        source: Box::new(source),
                    }
                })?
            }
        };
        let measures = plan.measures.len();
        if measures > 0 {
            bus::stderr_line!(
                "pilot: {}: {measures} measures of the plan are not in it",
                path.display()
            );
        }
        Ok(Some((path.clone(), text)))
    }
}

/// Writes through a name beside it, so that a file of this name is always whole.
pub(super) fn write((path, text): &(PathBuf, String)) -> Result<(), FileError> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let written = || {
        let mut options = OpenOptions::new();
        // Names may tell who the patient is.
        let mut file = options
            .write(true)
            .create(true)
            .truncate(true)
            .mode(0o600)
            .open(&part)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    written().map_err(|source| {
        let _ = fs::remove_file(&part);
        let path = path.clone();
        FileError::Write { path, source }
    })
}

fn read(path: &Path, said: Said) -> Result<Vec<Markup>, FileError> {
    let owned = || path.to_owned();
    let format = Format::of(path)?;
    let text = |most: usize| read_text(path, most as u64).map_err(|source| FileError::Open { path: owned(), source });
    match format {
        Format::Markups => {
            let text = text(markups::MAX_BYTES)?;
            let file = markups::read(text.as_bytes(), said);
            let file = file.map_err(|source| FileError::Markups {
                path: owned(),
                source: Box::new(source),
            })?;
            Ok(file.markups)
        }
        Format::Fcsv => {
            let text = text(fcsv::MAX_BYTES)?;
            let file = fcsv::read(text.as_bytes(), said);
            let file = file.map_err(|source| FileError::Fcsv {
                path: owned(),
                source: Box::new(source),
            })?;
            let mut markup = Markup::new(MarkupKind::Fiducial, "", file.points);
            markup.left_out = file.left_out;
            Ok(vec![markup])
        }
    }
}

/// What was taken, what was not, and what nobody can know of such a file.
fn tell(path: &Path, markups: &[Markup], taken: &Taken) {
    let path = path.display();
    let Taken {
        targets,
        entries,
        measures,
        descriptions,
    } = taken;
    bus::stderr_line!(
        "pilot: {path}: {targets} targets, {entries} entries and {measures} measures. Such a file does not say of which examination it is: \
         look at each of them on the images"
    );
    let empty: Vec<String> = markups
        .iter()
        .flat_map(|markup| &markup.left_out)
        .map(|left| format!("{:?} ({})", left.label, left.status))
        .collect();
    if !empty.is_empty() {
        bus::stderr_line!(
            "pilot: {path}: {} points have no place and were left out: {}",
            empty.len(),
            empty.join(", ")
        );
    }
    if !descriptions.is_empty() {
        bus::stderr_line!("pilot: {path}: the descriptions of {descriptions:?} were left out, as a plan has none");
    }
}
