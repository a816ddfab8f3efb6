//! `volume-loader labels`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bus::volume::{OwnedVolume, VolumeView};
use clap::Args;
use geometry::VolumeGrid;
use guidance::safety::{GridMatch, LabelNames, MapError, Structures};
use scene::{VolumeSource, VolumeSpec};
use serde_json::json;

use crate::dicom_out::derived::{Context, DerivedError, segmentation};
use crate::load::names::{LabelNamesError, label_names};
use crate::load::{labels_in, open, open_labels};
use crate::nrrd::{self, Segment};
use crate::{LoadError, WriteError, WriteOptions};

/// Which label map, and what to make of it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    volume-loader labels organs.dcm --of series/\n  \
    volume-loader labels organs.dcm --of series/ --out organs.seg.nrrd\n  \
    volume-loader labels organs.seg.nrrd --of series/ --out organs.dcm\n  \
    volume-loader labels organs.nii.gz --json\n\n\
    A label map is a DICOM segmentation (BINARY, LABELMAP, or FRACTIONAL without a voxel in between), or a volume of whole numbers (NIfTI, \
    NRRD, MetaImage) with names in its header or beside it. A DICOM segmentation is refused where its frame of reference is not that of \
    --of, where both say a patient and not the same, and where its ApprovalStatus is REJECTED. The file of --out is read by 3D Slicer with the names, and by a scene as `[plan] labels`. One that ends in .dcm is a DICOM \
    segmentation (BINARY) of --of, a DICOM series whose voxels those of the map must lie on; segments count from 1 there without a gap.")]
pub(crate) struct LabelsArgs {
    /// The label map.
    #[arg(value_name = "IN")]
    path: PathBuf,
    /// The examination that it is of.
    #[arg(long, value_name = "CT")]
    of: Option<PathBuf>,
    /// Which series of a folder it is, from 1.
    #[arg(long, value_name = "N", requires = "of", value_parser = clap::value_parser!(u32).range(1..))]
    series: Option<u32>,
    /// Writes the labels with their names as NRRD (.seg.nrrd, .nrrd), or as a segmentation of --of (.dcm).
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace the file of --out if it exists.
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Prints the structures as JSON.
    #[arg(long)]
    json: bool,
}

/// Why there is no list.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LabelsError {
    /// The map was refused.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// It is no label map.
    #[error("{}: {source}", path.display())]
    Map {
        /// The file.
        path: PathBuf,
        /// Why.
        source: MapError,
    },
    /// There is a file already.
    #[error("{}: there is a file of this name; give another name, or --overwrite to replace it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The label map or the examination would be replaced.
    #[error("{}: this is the label map or lies in the examination; give another name", path.display())]
    Own {
        /// The file.
        path: PathBuf,
    },
    /// Its names were refused.
    #[error(transparent)]
    Names(#[from] LabelNamesError),
    /// The file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The segmentation was not written.
    #[error("{}: not written: {source}", path.display())]
    Derived {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<DerivedError>,
    },
    /// Of what the segmentation would be is not said.
    #[error("{}: a DICOM segmentation is of a series; name it by --of", path.display())]
    OfWhat {
        /// The file.
        path: PathBuf,
    },
    /// The file would say that the map is of the examination, and that is not known.
    #[error("{}: not written: a segmentation says that it is of the series, and {lies}", path.display())]
    Elsewhere {
        /// The file.
        path: PathBuf,
        /// How the map lies.
        lies: GridMatch,
    },
    /// The list was not put into JSON.
    #[error("the structures as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// Lists the structures, and writes the map.
///
/// # Errors
/// [`LabelsError`]; nothing is left of the output then.
pub(crate) fn run(args: &LabelsArgs) -> Result<(), LabelsError> {
    check_output(args)?;
    let examination = args.of.as_ref().map(|of| examination(of, args.series));
    let (source, belongs) = open_labels(&args.path, examination.as_ref(), 1)?;
    for warning in source.facts().warnings {
        bus::stderr_line!("volume-loader: warning: {}: {warning}", args.path.display());
    }
    let volume = labels_in(source)?;
    let mut place = None;
    if let Some(examination) = &examination {
        // Opened, so that a name that leads nowhere is no comparison.
        let ct = *open(examination, phantom::DEFAULT_SEED)?.grid();
        let lies = GridMatch::of(&volume.grid, &ct).known(belongs.is_in_its_frame);
        place = Some((examination, ct, lies));
        let frame = match belongs.is_in_its_frame {
            true => "it is in the frame of reference of the examination",
            false => "its frame of reference could not be compared with the examination's",
        };
        bus::stderr_line!("volume-loader: {}: {frame}; {lies}", args.path.display());
    }
    let structures = volume.structures().map_err(|source| LabelsError::Map {
        path: args.path.clone(),
        source,
    })?;
    let names = label_names(&args.path)?;
    if let Some(out) = &args.out {
        let segments: Vec<Segment> = structures
            .list()
            .iter()
            .map(|one| Segment {
                label: one.label(),
                name: names.get(one.label()).map(str::to_owned),
                extent: one.extent(),
            })
            .collect();
        if is_dicom(out) {
            write_segmentation(out, &volume, place, &segments)?;
        } else {
            let (mut source, _) = open_labels(&args.path, examination.as_ref(), 1)?;
            nrrd::write_labels(out, source.as_mut(), WriteOptions { compress: true }, &segments)?;
        }
        bus::stderr_line!("volume-loader: wrote {}: {} structures", out.display(), segments.len());
    }
    let words = match args.json {
        true => serde_json::to_string_pretty(&rows(&structures, &names))?,
        false => table(&args.path, &structures, &names),
    };
    // Where nobody reads it any more, there is nobody to tell.
    let _ = writeln!(io::stdout(), "{words}");
    Ok(())
}

fn is_dicom(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("dcm"))
}

/// Writes a segmentation of the examination, on whose voxels the map must lie: its places would be said to be in its frame of reference.
fn write_segmentation(
    out: &Path,
    volume: &OwnedVolume,
    place: Option<(&VolumeSpec, VolumeGrid, GridMatch)>,
    segments: &[Segment],
) -> Result<(), LabelsError> {
    let path = || out.to_owned();
    let (examination, ct, lies) = place.ok_or_else(|| LabelsError::OfWhat { path: path() })?;
    if lies.is_doubtful() {
        return Err(LabelsError::Elsewhere { path: path(), lies });
    }
    // The series' own numbers, where the map has them to the digits that its format holds.
    let grid = if lies == GridMatch::Same { ct } else { volume.grid };
    let map = VolumeView {
        grid: &grid,
        ..volume.view()
    };
    let context = Context::of(examination);
    let written = context.and_then(|context| segmentation::write(out, &map, volume.hash, &context, segments));
    written.map_err(|source| LabelsError::Derived {
        path: path(),
        source: Box::new(source),
    })?;
    for (number, segment) in (1..).zip(segments).filter(|(number, segment)| *number != segment.label) {
        let label = segment.label;
        bus::stderr_line!(
            "volume-loader: {}: label {label} is segment {number} there, as segments count from 1 without a gap",
            out.display()
        );
    }
    Ok(())
}

fn examination(path: &Path, series: Option<u32>) -> VolumeSpec {
    let mut spec = VolumeSpec::of_path(path.to_owned());
    if let VolumeSource::File(file) = &mut spec.source {
        file.series = series;
    }
    spec
}

/// Refuses an output that would replace something unasked, or an input at all.
fn check_output(args: &LabelsArgs) -> Result<(), LabelsError> {
    let Some(out) = &args.out else { return Ok(()) };
    let path = out.clone();
    let place = out.canonicalize().ok();
    let lies_in = |input: &Path| {
        let input = input.canonicalize().ok();
        place
            .as_ref()
            .zip(input)
            .is_some_and(|(out, input)| out.starts_with(input))
    };
    if lies_in(&args.path) || args.of.as_deref().is_some_and(lies_in) {
        return Err(LabelsError::Own { path });
    }
    match out.symlink_metadata().is_ok() && !args.overwrite {
        true => Err(LabelsError::Exists { path }),
        false => Ok(()),
    }
}

fn volume_ml(structures: &Structures, voxels: u64) -> f64 {
    structures.grid().ct_from_voxel().determinant().abs() * voxels as f64 / 1000.0
}

fn rows(structures: &Structures, names: &LabelNames) -> serde_json::Value {
    let row = |one: &guidance::safety::Structure| {
        let (first, last) = one.extent();
        json!({
            "label": one.label(),
            "name": names.get(one.label()),
            "voxels": one.voxels(),
            "volume_ml": volume_ml(structures, one.voxels()),
            "first_voxel": first,
            "last_voxel": last,
        })
    };
    structures.list().iter().map(row).collect()
}

fn table(path: &Path, structures: &Structures, names: &LabelNames) -> String {
    let [nx, ny, nz] = structures.grid().dims();
    let [sx, sy, sz] = structures.grid().spacing_mm();
    let mut lines = vec![format!(
        "{}: {} structures in {nx} x {ny} x {nz} voxels of {sx:.3} x {sy:.3} x {sz:.3} mm",
        path.display(),
        structures.list().len()
    )];
    lines.extend(structures.list().iter().map(|one| {
        format!(
            "  {:5}  {:9} voxels  {:9.2} ml  {}",
            one.label(),
            one.voxels(),
            volume_ml(structures, one.voxels()),
            names.get(one.label()).unwrap_or("(no name)")
        )
    }));
    lines.join("\n")
}
