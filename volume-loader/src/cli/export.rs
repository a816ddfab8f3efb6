//! `volume-loader export`.

use std::path::{Path, PathBuf};

use bus::message::Marks;
use clap::{Args, ValueEnum};
use geometry::VolumeGrid;

use super::input;
use crate::dicom_out::{self, ExportError, Options, Syntax};
use crate::source::{Conversion, VoxelSource};
use crate::{WriteError, WriteOptions, metaimage, nifti, nrrd};

/// In front of a folder's name, where its ending says something else.
const DICOM_PREFIX: &str = "dicom:";

/// What to export, and where to.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    volume-loader export patient.nii.gz series/\n  \
    volume-loader export phantom dicom:series.2 --syntax rle\n  \
    volume-loader export series/ patient.nii.gz\n\n\
    The format is told by the name of OUT: .nii and .nii.gz are NIfTI, .nrrd and .nhdr NRRD, .mha and .mhd MetaImage, and a name without \
    an ending, or after `dicom:`, is a folder for a DICOM series, which must be absent or empty. Voxels are not changed, and \
    not resampled but where --regrid or --downsample asks for it. What a DICOM series says of the patient is empty.")]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    input: input::Input,
    /// The file, or the folder of a DICOM series.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Replaces a file of this name.
    #[arg(long)]
    overwrite: bool,
    /// The format, where the name of OUT does not tell.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Compresses without loss, where the format can.
    #[arg(long)]
    compress: bool,
    /// DICOM: the transfer syntax.
    #[arg(long, value_enum, conflicts_with = "compress")]
    syntax: Option<SyntaxName>,
    /// DICOM: file names and instance numbers in a random order of this seed, to try readers with.
    #[arg(long, value_name = "SEED")]
    shuffle_names: Option<u64>,
    /// Writes a CT put on an even grid, although no file says so: images of it bear no mark, and its holes are air. Writes what is no CT as a
    /// DICOM series of one.
    #[arg(long)]
    unmarked: bool,
}

/// The formats that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Nifti,
    Nrrd,
    Mha,
    Dicom,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SyntaxName {
    ExplicitLittle,
    ImplicitLittle,
    ExplicitBig,
    Rle,
}

impl From<SyntaxName> for Syntax {
    fn from(name: SyntaxName) -> Self {
        match name {
            SyntaxName::ExplicitLittle => Self::ExplicitLittle,
            SyntaxName::ImplicitLittle => Self::ImplicitLittle,
            SyntaxName::ExplicitBig => Self::ExplicitBig,
            SyntaxName::Rle => Self::Rle,
        }
    }
}

/// Why nothing was exported.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    /// The name does not tell a format.
    #[error(
        "{}: the ending .{ending} is of no format that can be written; name it .nii, .nii.gz, .nrrd or .mha, or put \
         `{DICOM_PREFIX}` in front of a folder's name, or say --format",
        path.display()
    )]
    Ending {
        /// The path.
        path: PathBuf,
        /// What is behind the last point.
        ending: String,
    },
    /// NIfTI's name says whether it is compressed.
    #[error("{}: --compress, but the name does not end in .gz; name it .nii.gz", path.display())]
    Uncompressed {
        /// The path.
        path: PathBuf,
    },
    /// An option of DICOM with another format.
    #[error("{}: {option} is for DICOM series only; leave it out", path.display())]
    DicomOnly {
        /// The path.
        path: PathBuf,
        /// The option.
        option: &'static str,
    },
    /// Who reads it would take it for what the scanner measured.
    #[error(
        "{}: the slices were put on an even grid (REGRIDDED), and the file would not say so: images of it would bear no mark, and holes \
         without measurement be air; export slices that are even, or say --unmarked",
        path.display()
    )]
    Unmarked {
        /// The path.
        path: PathBuf,
    },
    /// The series would call it a CT.
    #[error(
        "{}: the examination is not a CT but of the modality {modality}, and what is written is a CT series whose numbers are HU: they would \
         be taken for it; export to another format, or say --unmarked",
        path.display()
    )]
    NotCt {
        /// The path.
        path: PathBuf,
        /// The modality, by DICOM's word.
        modality: String,
    },
    /// Somebody's file.
    #[error("{}: there is a file of this name; give another name, or --overwrite to replace it", path.display())]
    Exists {
        /// The path.
        path: PathBuf,
    },
    /// The voxels beside the header would replace another file.
    #[error("{}: there is a file of this name, which may hold the voxels of another header: they would be replaced. Give another name, or \
             remove it", path.display())]
    Voxels {
        /// The path.
        path: PathBuf,
    },
    /// The examination was refused.
    #[error(transparent)]
    Input(#[from] input::InputError),
    /// A file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The DICOM series was not written.
    #[error(transparent)]
    Dicom(#[from] ExportError),
}

/// What is written, and where.
#[derive(Debug, PartialEq)]
enum Writer {
    Nifti(PathBuf),
    Nrrd(PathBuf, WriteOptions),
    MetaImage(PathBuf, WriteOptions),
    Dicom(PathBuf, Options),
}

impl Writer {
    fn new(args: &ExportArgs) -> Result<Self, RunError> {
        let (told, path) = by_name(&args.output);
        let format = args.format.or(told).ok_or_else(|| RunError::Ending {
            path: path.clone(),
            ending: ending(&path),
        })?;
        let dicom_only = [
            ("--syntax", args.syntax.is_some()),
            ("--shuffle-names", args.shuffle_names.is_some()),
        ];
        let wrong = dicom_only
            .into_iter()
            .find(|(_, given)| *given && format != Format::Dicom);
        if let Some((option, _)) = wrong {
            return Err(RunError::DicomOnly { path, option });
        }
        let compressed = WriteOptions {
            compress: args.compress,
        };
        Ok(match format {
            Format::Nifti if args.compress && ending(&path) != "gz" => return Err(RunError::Uncompressed { path }),
            Format::Nifti => Self::Nifti(path),
            Format::Nrrd => Self::Nrrd(path, compressed),
            Format::Mha => Self::MetaImage(path, compressed),
            Format::Dicom => Self::Dicom(path, options(args)),
        })
    }

    fn write(&self, source: &mut dyn VoxelSource) -> Result<Conversion, RunError> {
        match self {
            Self::Nifti(path) => Ok(nifti::write(path, source)?),
            Self::Nrrd(path, options) => Ok(nrrd::write(path, source, *options)?),
            Self::MetaImage(path, options) => Ok(metaimage::write(path, source, *options)?),
            Self::Dicom(path, options) => Ok(dicom_out::write(path, source, options)?),
        }
    }

    /// What other programs will not do with the file.
    fn warning(&self, grid: &VolumeGrid) -> Option<&'static str> {
        let sheared = matches!(self, Self::Nifti(_)) && nifti::is_sheared(grid);
        sheared.then_some(
            "the axes are not at right angles (a tilted gantry?), and programs built on ITK (SimpleITK, 3D Slicer, ITK-SNAP) refuse \
             such NIfTI files: write NRRD (.nrrd) for them",
        )
    }

    /// The voxels' file, where it is another than the header's.
    fn voxels(&self) -> Option<PathBuf> {
        let (path, own, [plain, compressed], compress) = match self {
            Self::Nrrd(path, options) => (path, "nhdr", ["raw", "raw.gz"], options.compress),
            Self::MetaImage(path, options) => (path, "mhd", ["raw", "zraw"], options.compress),
            Self::Nifti(_) | Self::Dicom(..) => return None,
        };
        let is_beside = path.extension().is_some_and(|ending| ending == own);
        is_beside.then(|| path.with_extension(if compress { compressed } else { plain }))
    }

    /// Refuses to replace a file that nobody said may go. Voxels go with their own header alone, also where that may go: those of another
    /// header would be another patient's under it.
    fn keep(&self, overwrite: bool) -> Result<(), RunError> {
        let is_there = |path: &Path| path.symlink_metadata().is_ok();
        let path = self.path();
        if !overwrite && is_there(path) {
            let path = path.to_owned();
            return Err(RunError::Exists { path });
        }
        let headers = ["mhd", "nhdr"].map(|ending| path.with_extension(ending));
        let is_anothers = !is_there(path) || headers.iter().any(|header| header != path && is_there(header));
        match self.voxels() {
            Some(path) if is_there(&path) && is_anothers => Err(RunError::Voxels { path }),
            _ => Ok(()),
        }
    }

    fn path(&self) -> &Path {
        match self {
            Self::Nifti(path) | Self::Nrrd(path, _) | Self::MetaImage(path, _) | Self::Dicom(path, _) => path,
        }
    }
}

fn options(args: &ExportArgs) -> Options {
    let compressed = if args.compress { Syntax::Rle } else { Syntax::default() };
    Options {
        syntax: args.syntax.map_or(compressed, Syntax::from),
        shuffle_names: args.shuffle_names,
    }
}

/// The format that a name tells, and the path without a prefix.
fn by_name(output: &Path) -> (Option<Format>, PathBuf) {
    let folder = output.to_str().and_then(|text| text.strip_prefix(DICOM_PREFIX));
    if let Some(folder) = folder {
        return (Some(Format::Dicom), PathBuf::from(folder));
    }
    let name = output
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let format = match ending(output).as_str() {
        "nii" => Some(Format::Nifti),
        "gz" if name.ends_with(".nii.gz") => Some(Format::Nifti),
        "nrrd" | "nhdr" => Some(Format::Nrrd),
        "mha" | "mhd" => Some(Format::Mha),
        "" => Some(Format::Dicom),
        _ if output.is_dir() => Some(Format::Dicom),
        _ => None,
    };
    (format, output.to_owned())
}

/// What is behind the last point, in small letters.
fn ending(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}

/// Exports and says what was written.
///
/// # Errors
/// [`RunError`]; nothing is left of the output then.
pub(crate) fn run(args: &ExportArgs) -> Result<(), RunError> {
    let writer = Writer::new(args)?;
    // A folder is judged by who writes into it.
    let is_file = !matches!(writer, Writer::Dicom(..));
    if is_file {
        writer.keep(args.overwrite)?;
    }
    let mut source = args.input.open()?;
    if source.marks().has(Marks::REGRIDDED) && !args.unmarked {
        let path = writer.path().to_owned();
        return Err(RunError::Unmarked { path });
    }
    let facts = source.facts();
    let modality = facts.extra.get("modality").and_then(|word| word.as_str());
    if let Some(modality) = modality.filter(|word| *word != "CT" && !is_file && !args.unmarked) {
        let path = writer.path().to_owned();
        let modality = modality.to_owned();
        return Err(RunError::NotCt { path, modality });
    }
    let conversion = writer.write(&mut source)?;
    let (path, what) = (writer.path().display(), source.describe());
    bus::stderr_line!("volume-loader: wrote {path}: {what}");
    if let Some(warning) = writer.warning(source.grid()) {
        bus::stderr_line!("volume-loader: warning: {path}: {warning}");
    }
    // Who reads the file does not hear it again.
    for remark in facts.warnings.into_iter().chain(source.remarks()) {
        bus::stderr_line!("volume-loader: warning: {path} does not say: {remark}");
    }
    if conversion != Conversion::default() {
        let Conversion {
            clamped_low,
            clamped_high,
            not_finite,
            rounded,
        } = conversion;
        bus::stderr_line!(
            "volume-loader: voxels changed to fit 16 bits: {clamped_low} held to -32768 HU, {clamped_high} to 32767 HU, \
             {not_finite} not numbers and made padding, {rounded} rounded"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        args: ExportArgs,
    }

    fn writer(arguments: &str) -> Result<Writer, String> {
        let line = Line::try_parse_from(arguments.split(' ')).map_err(|e| e.to_string())?;
        Writer::new(&line.args).map_err(|e| e.to_string())
    }

    #[test]
    fn the_name_tells_the_format() {
        assert_eq!(writer("x a b.nii"), Ok(Writer::Nifti("b.nii".into())));
        assert_eq!(writer("x a b.NII.GZ --compress"), Ok(Writer::Nifti("b.NII.GZ".into())));
        assert_eq!(
            writer("x a b.nrrd"),
            Ok(Writer::Nrrd("b.nrrd".into(), WriteOptions::default()))
        );
        assert_eq!(
            writer("x a b.c --format mha"),
            Ok(Writer::MetaImage("b.c".into(), WriteOptions::default()))
        );
        assert_eq!(writer("x a b/"), Ok(Writer::Dicom("b/".into(), Options::default())));
        assert_eq!(writer("x a /tmp"), Ok(Writer::Dicom("/tmp".into(), Options::default())));
        let rle = Options {
            syntax: Syntax::Rle,
            shuffle_names: Some(3),
        };
        let folder = PathBuf::from("b.2");
        assert_eq!(
            writer("x a dicom:b.2 --compress --shuffle-names 3"),
            Ok(Writer::Dicom(folder.clone(), rle))
        );
        assert_eq!(
            writer("x a dicom:b.2 --syntax rle --shuffle-names 3"),
            Ok(Writer::Dicom(folder, rle))
        );
    }

    #[test]
    fn a_sheared_volume_as_nifti_is_warned_of() {
        use crate::raster::test_files::{SHEARED, TURNED, given};
        for (name, sheared) in [("b.nii", true), ("b.nii.gz", true), ("b.nrrd", false), ("b/", false)] {
            let writer = writer(&format!("x a {name}")).unwrap();
            let warning = writer.warning(&given(SHEARED).grid);
            assert_eq!(warning.is_some_and(|words| words.contains("ITK")), sheared, "{name}");
            assert!(TURNED.iter().all(|rows| writer.warning(&given(*rows).grid).is_none()));
            let hardly = given([[0.7, 0.0, 0.0, 0.0], [0.0, 0.7, 9e-5, 0.0], [0.0, 0.0, 1.0, 0.0]]);
            assert!(writer.warning(&hardly.grid).is_none());
        }
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        for (arguments, words) in [
            ("x a b.tif", "b.tif: the ending .tif"),
            ("x a b.gz", "the ending .gz"),
            ("x a b.nii --compress", "name it .nii.gz"),
            ("x a b.nii --syntax rle", "--syntax is for DICOM"),
            ("x a b.nrrd --shuffle-names 3", "--shuffle-names is for DICOM"),
            ("x a b --syntax rle --compress", "cannot be used with"),
        ] {
            let said = writer(arguments).unwrap_err();
            assert!(said.contains(words), "{arguments}: {said}");
        }
    }
}
