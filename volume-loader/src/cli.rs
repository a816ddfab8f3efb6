//! The command line.

mod export;
mod input;
mod inspect;
mod labels;
mod receive;

use std::path::PathBuf;
use std::process::ExitCode;

use bus::process::{Membership, exit};
use clap::{Parser, Subcommand};
use geometry::GridError;

use crate::nifti::{self, WriteError};
use crate::phantom_source::PhantomSource;
use crate::run;
use crate::source::VoxelSource;

/// Reads an examination and puts it once into shared memory.
#[derive(Debug, Parser)]
#[command(
    name = "volume-loader",
    version,
    after_help = "Examples:\n  \
    volume-loader phantom --out patient.nii.gz\n  \
    volume-loader phantom --seed 7 --spacing-mm 1.0 --out patient.nii\n  \
    volume-loader inspect patient.nii.gz --png patient.png\n  \
    volume-loader export patient.nii.gz series/\n  \
    volume-loader labels organs.dcm --of series/\n  \
    volume-loader receive --out incoming --aet TROCAR --from ORTHANC\n\n\
    Within a run the pilot starts `volume-loader run`; the scene's [volume] table names the examination. Whose it is goes to the \
    bus alone, as the examination says it or the scene's [identity] table."
)]
struct Cli {
    #[command(subcommand)]
    command: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Loads the volume of a run and keeps it in shared memory (started by the pilot).
    #[command(after_help = "Example:\n  volume-loader run --run-dir /run/user/1000/trocar/default")]
    Run {
        /// The run's folder.
        #[arg(long)]
        run_dir: PathBuf,
        /// The pilot's process; this one ends with it.
        #[arg(long)]
        parent: Option<u32>,
    },
    /// Writes the generated patient as NIfTI (.nii, .nii.gz).
    #[command(after_help = "Example:\n  volume-loader phantom --seed 7 --out patient.nii.gz")]
    Phantom {
        /// Varies the anatomy.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Voxel spacing, mm.
        #[arg(long, default_value_t = phantom::DEFAULT_SPACING_MM[0])]
        spacing_mm: f64,
        /// The file.
        #[arg(long)]
        out: PathBuf,
    },
    /// Says what an examination is, without loading it: place, HU, doubts; with --png three planes as a picture.
    Inspect(inspect::InspectArgs),
    /// Writes an examination in another format: NIfTI, NRRD, MetaImage, or a DICOM series.
    Export(export::ExportArgs),
    /// Lists the structures of a label map, such as a DICOM segmentation; with --out writes it as NRRD.
    Labels(labels::LabelsArgs),
    /// Receives examinations from a PACS (DICOM C-STORE), and inspects each series that came.
    Receive(receive::ReceiveArgs),
}

#[derive(Debug, thiserror::Error)]
enum PhantomError {
    #[error("--spacing-mm: {0}")]
    Spacing(#[from] GridError),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary.
pub fn main() -> ExitCode {
    match Cli::parse().command {
        Verb::Run { run_dir, parent } => exit("volume-loader", run::run(&Membership { run_dir, parent })),
        Verb::Phantom { seed, spacing_mm, out } => exit("volume-loader", write_phantom(seed, spacing_mm, &out)),
        Verb::Inspect(args) => exit("volume-loader", inspect::run(&args)),
        Verb::Labels(args) => exit("volume-loader", labels::run(&args)),
        Verb::Export(args) => exit("volume-loader", export::run(&args)),
        Verb::Receive(args) => exit("volume-loader", receive::run(&args)),
    }
}

fn write_phantom(seed: u64, spacing_mm: f64, out: &std::path::Path) -> Result<(), PhantomError> {
    let mut source = PhantomSource::new(seed, [spacing_mm; 3])?;
    nifti::write(out, &mut source)?;
    bus::stderr_line!("volume-loader: wrote {}: {}", out.display(), source.describe());
    for target in source.phantom().targets() {
        let [x, y, z] = target.centre.mm();
        bus::stderr_line!("volume-loader: target {}: {x:.2} {y:.2} {z:.2} mm LPS", target.name);
    }
    Ok(())
}
