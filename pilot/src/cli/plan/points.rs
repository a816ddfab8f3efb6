//! Targets and entries from files of 3D Slicer and from DICOM structure sets into a plan, and out of it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use exchange::fcsv::{self, FcsvError, Fiducials};
use exchange::markups::{self, Markup, MarkupKind, Markups, MarkupsError};
use exchange::{ControlPoint, LengthUnit, PatientAxes, Said};
use geometry::Point;
use guidance::plan::{Editor, Plan};
use scene::file::{OpenError, Part, PartError, read_text};

use super::StructureSet;
use crate::planning::{PointsError, Taken, points_of, take_points};

#[derive(Debug, Args)]
pub(crate) struct PointsArgs {
    /// Takes targets and their entries from a file of 3D Slicer, .mrk.json or .fcsv, or the points of a DICOM structure
    /// set; a point `NAME entry` is the entry of `NAME`.
    #[arg(long, value_name = "FILE")]
    import: Vec<PathBuf>,
    /// The axes of the imported files, where they do not say them.
    #[arg(long, value_name = "lps|ras", requires = "import")]
    frame: Option<PatientAxes>,
    /// The unit of the imported files: m, or mm though everything lies within 2 mm of the origin [default: mm]
    #[arg(long, value_name = "mm|m", requires = "import")]
    unit: Option<LengthUnit>,
    /// Writes the targets and entries into such a file, the kind by its ending; .dcm is a structure set of the examination, which
    /// must be DICOM too.
    #[arg(long, value_name = "FILE")]
    export: Option<PathBuf>,
    /// Replace the exported file if it exists.
    #[arg(long, requires = "export")]
    overwrite: bool,
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
    #[error("{path}: {source}. Nothing was written")]
    StructureSet {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    #[error("{path}: places in DICOM are LPS and mm; leave --frame and --unit out")]
    Told { path: PathBuf },
    #[error("{path}: found no structure set of DICOM, expected one by its name. Nothing was written")]
    NotASet { path: PathBuf },
    #[error("{path}: none of its {others} regions of interest is a point. Nothing was written")]
    NoPoint { path: PathBuf, others: usize },
    #[error(
        "{path}: the kind of file is told by its ending; .mrk.json and .fcsv are known, and structure sets of DICOM (.dcm)"
    )]
    Ending { path: PathBuf },
    #[error("writing {path}: there is a file of this name; give another name, or --overwrite to replace it")]
    Exists { path: PathBuf },
    #[error("writing {path}: this is {what}, which it would replace; give another name")]
    Own { path: PathBuf, what: &'static str },
    #[error("writing {path}: this is a folder; give the name of a file")]
    Folder { path: PathBuf },
    #[error("writing {path}: there is no folder {folder}")]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error(
        "writing {path}: {part} lies beside it, through which it is written; it is yours, or of a command that did not end. Look at it and \
         remove it"
    )]
    Left { path: PathBuf, part: PathBuf },
    #[error("writing {path}: {source}. Nothing was written")]
    Write { path: PathBuf, source: PartError },
    #[error("writing {path}: {source}. The plan was written, and this was not")]
    Rename { path: PathBuf, source: io::Error },
    #[error("writing {path}: {source}")]
    Unwritable { path: PathBuf, source: Box<FcsvError> },
    #[error("writing {path}: {source}. Nothing was written")]
    NotDerived {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// Reads a structure set of the examination that is planned on; `None` of what is none.
pub(super) type ReadStructureSet<'a> = &'a dyn Fn(&Path) -> super::Read<Option<StructureSet>>;

/// Points by name and place, LPS mm, as a structure set of the examination that is planned on.
pub(super) type StructureSetBytes<'a> = &'a dyn Fn(&[super::NamedPlace]) -> super::Read<Vec<u8>>;

/// The kinds of files that are told by their ending.
enum Format {
    Markups,
    Fcsv,
    /// Written by this ending; read whatever its name is.
    Dicom,
}

impl Format {
    fn of(path: &Path) -> Result<Self, FileError> {
        let name = path.to_string_lossy().to_ascii_lowercase();
        let formats = [
            (".mrk.json", Self::Markups),
            (".fcsv", Self::Fcsv),
            (".dcm", Self::Dicom),
        ];
        let format = formats.into_iter().find(|(ending, _)| name.ends_with(ending));
        format.map_or_else(
            || Err(FileError::Ending { path: path.to_owned() }),
            |(_, format)| Ok(format),
        )
    }
}

impl PointsArgs {
    /// Whether anything is taken in.
    pub(super) fn is_import(&self) -> bool {
        !self.import.is_empty()
    }

    /// Takes the files in, in their order.
    pub(super) fn take(&self, editor: &mut Editor, structure_set: ReadStructureSet<'_>) -> Result<(), FileError> {
        let said = Said {
            axes: self.frame,
            unit: self.unit,
        };
        for path in &self.import {
            let owned = || path.to_owned();
            let set = structure_set(path).map_err(|source| FileError::StructureSet { path: owned(), source })?;
            let file = match &set {
                Some(_) if said.axes.is_some() || said.unit.is_some() => return Err(FileError::Told { path: owned() }),
                Some(set) => of_structure_set(path, set)?,
                None => read(path, said)?,
            };
            let taken = take_points(editor, &file.markups).map_err(|source| FileError::Points {
                path: owned(),
                source: Box::new(source),
            })?;
            tell(path, &file, &taken, set.as_ref());
        }
        Ok(())
    }

    /// Refuses an export that could not be written, or that would replace what is worked on, before anything is.
    pub(super) fn check(&self, plan: &Path) -> Result<(), FileError> {
        let Some(path) = &self.export else { return Ok(()) };
        let owned = || path.to_owned();
        Format::of(path)?;
        // By where they lie and not by their names: `./plan.json` is the plan too, and a link to it.
        let place = |path: &Path| fs::canonicalize(path).or_else(|_| std::path::absolute(path)).ok();
        let is = |other: &Path| place(other).is_some_and(|other| place(path) == Some(other));
        let inputs = self.import.iter().map(|import| (import.as_path(), "an imported file"));
        if let Some((_, what)) = [(plan, "the plan")]
            .into_iter()
            .chain(inputs)
            .find(|(other, _)| is(other))
        {
            return Err(FileError::Own { path: owned(), what });
        }
        match path.symlink_metadata() {
            Ok(about) if about.is_dir() => return Err(FileError::Folder { path: owned() }),
            Ok(_) if !self.overwrite => return Err(FileError::Exists { path: owned() }),
            _ => {}
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let folder = folder.to_owned();
            return Err(FileError::NoFolder { path: owned(), folder });
        }
        let part = Part::place(path);
        match part.symlink_metadata() {
            Ok(_) => Err(FileError::Left { path: owned(), part }),
            Err(_) => Ok(()),
        }
    }

    /// The export, where one is asked for, all of it on the disk but not yet under its name: so a disk that is full is known before the
    /// plan is written.
    pub(super) fn prepare(
        &self,
        plan: &Plan,
        structure_set: StructureSetBytes<'_>,
    ) -> Result<Option<Export>, FileError> {
        let Some((path, bytes)) = self.bytes(plan, structure_set)? else {
            return Ok(None);
        };
        let write = || {
            // Names may tell who the patient is.
            let mut part = Part::lock(&path, 0o600)?;
            part.write(&bytes)?;
            Ok(part)
        };
        match write() {
            Ok(part) => Ok(Some(Export { part, path })),
            Err(source) => Err(FileError::Write { path, source }),
        }
    }

    /// What is exported, where that is asked for.
    fn bytes(
        &self,
        plan: &Plan,
        structure_set: StructureSetBytes<'_>,
    ) -> Result<Option<(PathBuf, Vec<u8>)>, FileError> {
        let Some(path) = &self.export else { return Ok(None) };
        let owned = || path.to_owned();
        let markups = points_of(&plan.targets).map_err(|source| FileError::Points {
            path: owned(),
            source: Box::new(source),
        })?;
        let bytes = match Format::of(path)? {
            Format::Markups => {
                let left_out_keys = Vec::new();
                markups::write(&Markups { markups, left_out_keys }, PatientAxes::Lps).into_bytes()
            }
            Format::Dicom => {
                let all = || markups.iter().flat_map(|markup| &markup.points);
                let points: Vec<_> = all().map(|point| (point.label.clone(), point.position.mm())).collect();
                if all().any(|point| !point.description.is_empty()) {
                    bus::stderr_line!(
                        "pilot: {}: diameters and stop distances are not in it, as a point of DICOM has none",
                        path.display()
                    );
                }
                structure_set(&points).map_err(|source| FileError::NotDerived { path: owned(), source })?
            }
            Format::Fcsv => {
                let points = markups.into_iter().flat_map(|markup| markup.points).collect();
                let left_out = Vec::new();
                // As readers that do not look at the head take it.
                fcsv::write(&Fiducials { points, left_out }, PatientAxes::Ras)
                    .map_err(|source| FileError::Unwritable {
                        path: owned(),
                        source: Box::new(source),
                    })?
                    .into_bytes()
            }
        };
        let measures = plan.measures.len();
        if measures > 0 {
            bus::stderr_line!(
                "pilot: {}: {measures} measures of the plan are not in it",
                path.display()
            );
        }
        Ok(Some((path.clone(), bytes)))
    }
}

/// An export that is written and has not its name yet.
pub(super) struct Export {
    part: Part,
    path: PathBuf,
}

impl Export {
    /// Gives it its name.
    pub(super) fn finish(self) -> Result<(), FileError> {
        let path = self.path;
        self.part.rename().map_err(|source| FileError::Rename { path, source })
    }
}

fn read(path: &Path, said: Said) -> Result<Markups, FileError> {
    let owned = || path.to_owned();
    let format = Format::of(path)?;
    let text = |most: usize| read_text(path, most as u64).map_err(|source| FileError::Open { path: owned(), source });
    match format {
        Format::Dicom => Err(FileError::NotASet { path: owned() }),
        Format::Markups => {
            let text = text(markups::MAX_BYTES)?;
            let file = markups::read(text.as_bytes(), said);
            file.map_err(|source| FileError::Markups {
                path: owned(),
                source: Box::new(source),
            })
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
            Ok(Markups {
                markups: vec![markup],
                left_out_keys: Vec::new(),
            })
        }
    }
}

/// The points of a structure set, as one list.
fn of_structure_set(path: &Path, set: &StructureSet) -> Result<Markups, FileError> {
    if set.points.is_empty() {
        let (path, others) = (path.to_owned(), set.others.len());
        return Err(FileError::NoPoint { path, others });
    }
    let point = |(name, [x, y, z]): &(String, [f64; 3])| ControlPoint::new(name, Point::new(*x, *y, *z));
    let points = set.points.iter().map(point).collect();
    Ok(Markups {
        markups: vec![Markup::new(MarkupKind::Fiducial, "", points)],
        left_out_keys: Vec::new(),
    })
}

/// What was taken, what was not, and what nobody can know of such a file.
fn tell(path: &Path, file: &Markups, taken: &Taken, set: Option<&StructureSet>) {
    let path = path.display();
    let Taken {
        targets,
        entries,
        measures,
        descriptions,
    } = taken;
    let whose = match set {
        Some(set) if set.is_in_its_frame => "It is in the frame of reference of the examination",
        Some(_) => "Its frame of reference could not be compared, as the examination says none",
        _ => "Such a file does not say of which examination it is",
    };
    bus::stderr_line!(
        "pilot: {path}: {targets} targets, {entries} entries and {measures} measures. {whose}: look at each of them on the images"
    );
    for warning in set.map(|set| set.warnings.as_slice()).unwrap_or_default() {
        bus::stderr_line!("pilot: {path}: warning: {warning}");
    }
    if let Some(others) = set.map(|set| &set.others).filter(|others| !others.is_empty()) {
        let count = others.len();
        bus::stderr_line!("pilot: {path}: {count} regions of interest are no points and were left out: {others:?}");
    }
    let empty: Vec<String> = file
        .markups
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
    if !file.left_out_keys.is_empty() {
        let keys = &file.left_out_keys;
        bus::stderr_line!("pilot: {path}: the keys {keys:?} of its markups are not known here and were left out");
    }
}
