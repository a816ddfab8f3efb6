//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use bus::process::{Membership, exit};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Parser, Subcommand, ValueEnum};
use geometry::checked;
use scene::{
    BackEnd, Filter, GpuWeights, Minify, Plane, Render, Sampling, Slab, SlabMode, Surface, THICKNESS_MM, VolumeSource,
    VolumeSpec, WindowLevel,
};

use crate::overview::{LoadLabels, LoadVolume};
use crate::run;
use crate::snapshot::{At, LoadRecorded, OfRecording, Snapshot, SnapshotError, recorded, snapshot};

/// A pose typed by hand has a few digits; its quaternion is normalised.
const TYPED_TOLERANCE: f64 = 1e-3;

/// Draws CT planes at the tip of a tube.
#[derive(Debug, Parser)]
#[command(
    name = "slice-view-proc",
    version,
    after_help = "Examples:\n  \
    slice-view-proc snapshot --volume ct.nii.gz --view axial --pose 1,0,0,0,12,-30,140 --out axial.png\n  \
    slice-view-proc snapshot --volume phantom --view perpendicular --pose 0.7071,0.7071,0,0,0,0,0 \\\n    \
    --size 512x512 --pixel-mm 0.2 --filter linear --out p.png --hu p.mha\n  \
    slice-view-proc snapshot --volume phantom --view surface --from left --pose 1,0,0,0,0,0,0 --pixel-mm 0.8 --out s.png\n  \
    slice-view-proc snapshot --recording out/session.mcap --at 9.4s --view frontal --out f.png\n\n\
    Within a run the pilot starts one of these for each plane direction of the scene."
)]
struct Cli {
    #[command(subcommand)]
    command: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Renders one plane direction of a run (started by the pilot).
    #[command(after_help = "Example:\n  slice-view-proc run --run-dir /run/user/1000/trocar/default --plane axial")]
    Run {
        /// The run's folder.
        #[arg(long)]
        run_dir: PathBuf,
        /// The pilot's process; this one ends with it.
        #[arg(long)]
        parent: Option<u32>,
        /// The plane direction.
        #[arg(long)]
        plane: PlaneArg,
    },
    /// Draws one image of a file, or of an instant of a recording.
    #[command(
        after_help = "Examples:\n  slice-view-proc snapshot --volume ct.nii.gz --view axial --pose 1,0,0,0,12,-30,140 --out axial.png\n  \
        slice-view-proc snapshot --recording out/session.mcap --seq 188 --view frontal --out f.png"
    )]
    Snapshot(Box<SnapshotArgs>),
}

/// What the scene of a recording says.
const OF_NO_RECORDING: [&str; 14] = [
    "pose",
    "size",
    "pixel_mm",
    "filter",
    "slab_mm",
    "minify",
    "ahead_mm",
    "window",
    "from",
    "bone_hu",
    "back_end",
    "gpu_weights",
    "reference",
    "hu",
];

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("instant"))]
struct SnapshotArgs {
    /// A recording: the image that a view of its run showed of an instant, with the organs where they were recorded. All else is as its
    /// scene says.
    #[arg(long, value_name = "FILE", requires_all = ["instant", "out"], conflicts_with_all = OF_NO_RECORDING)]
    recording: Option<PathBuf>,
    /// The instant: a time from the first pose on, such as 9.4s; the first pose published then or later, but not
    /// later than that by more than `limits.lost_ms` of its scene. stderr says which it is.
    #[arg(long, value_name = "TIME", group = "instant", requires = "recording")]
    at: Option<String>,
    /// The instant: the number of a pose.
    #[arg(long, value_name = "N", group = "instant", requires = "recording")]
    seq: Option<u64>,
    /// The CT: a folder with a DICOM series, a file (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, an Enhanced CT), or
    /// `phantom`; with a recording only where the CT lies elsewhere by now.
    #[arg(long, required_unless_present = "recording")]
    volume: Option<PathBuf>,
    /// Which series of the folder, from 1 in the order that the loader lists.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    series: Option<u32>,
    /// Interpolate slices at uneven places to even ones instead of refusing them; the image says so.
    #[arg(long)]
    regrid: bool,
    /// Take the axes of a file without orientation as left, posterior, superior instead of refusing it.
    #[arg(long)]
    assume_lps: bool,
    /// The plane's direction: axial, frontal, sagittal, perpendicular, surface; of a recording the name of one of its views.
    #[arg(long)]
    view: String,
    /// ct_from_tool: unit quaternion and tip, LPS mm.
    #[arg(
        long,
        value_name = "qw,qx,qy,qz,tx,ty,tz",
        allow_hyphen_values = true,
        required_unless_present = "recording"
    )]
    pose: Option<Numbers<7>>,
    /// Pixels.
    #[arg(long, value_name = "WxH", default_value = "512x512")]
    size: Size,
    /// Side of a pixel, mm.
    #[arg(long, default_value_t = 0.5, allow_hyphen_values = true)]
    pixel_mm: f64,
    /// Interpolation.
    #[arg(long, default_value = "linear", value_parser = filters())]
    filter: Filter,
    /// Thickness of a slab about the plane, mm.
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    slab_mm: Option<f64>,
    /// What becomes of the samples through a slab.
    #[arg(long, default_value = "mean", requires = "slab_mm")]
    slab: SlabArg,
    /// Pixels larger than a voxel: the mean over their area, or the value at their centre.
    #[arg(long, default_value = "area")]
    minify: MinifyArg,
    /// Perpendicular view: the plane this far in front of the tip, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_hyphen_values = true)]
    ahead_mm: f64,
    /// Window: centre and width, HU.
    #[arg(long, value_name = "C,W", default_value = "40,400", allow_hyphen_values = true)]
    window: Window,
    /// Surface view: from where the patient is seen.
    #[arg(long, default_value = "anterior")]
    from: FromArg,
    /// Surface view: voxels of so many HU and more are bone.
    #[arg(long, value_name = "HU", default_value_t = 300.0, allow_hyphen_values = true)]
    bone_hu: f64,
    /// Who samples: auto takes a hardware GPU where there is one; gpu also a software one.
    #[arg(long, default_value = "cpu")]
    back_end: BackEndArg,
    /// How a GPU weighs neighbours: exactly, or by its texture sampler in 8 bits (linear filter).
    #[arg(long, default_value = "exact")]
    gpu_weights: WeightsArg,
    /// Use the f64 reference instead of the fast back ends.
    #[arg(long, action = ArgAction::SetTrue)]
    reference: bool,
    /// The image.
    #[arg(long, required_unless_present = "hu")]
    out: Option<PathBuf>,
    /// The slice in HU: a MetaImage, float32, LPS mm.
    #[arg(long)]
    hu: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PlaneArg {
    Axial,
    Frontal,
    Sagittal,
    Perpendicular,
    Surface,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum FromArg {
    Anterior,
    Left,
    Posterior,
    Right,
    Head,
    Feet,
}

impl From<PlaneArg> for Plane {
    fn from(arg: PlaneArg) -> Self {
        match arg {
            PlaneArg::Axial => Self::Axial,
            PlaneArg::Frontal => Self::Frontal,
            PlaneArg::Sagittal => Self::Sagittal,
            PlaneArg::Perpendicular => Self::Perpendicular,
            PlaneArg::Surface => Self::Surface,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SlabArg {
    Mean,
    Maximum,
    Minimum,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MinifyArg {
    Area,
    Point,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum BackEndArg {
    Auto,
    Gpu,
    Cpu,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum WeightsArg {
    Exact,
    Sampler,
}

/// The names of the filters, as the scene file has them.
fn filters() -> impl TypedValueParser<Value = Filter> {
    let names = PossibleValuesParser::new(Filter::ALL.map(Filter::name));
    names.try_map(|name| Filter::named(&name).ok_or("no such filter"))
}

impl SnapshotArgs {
    fn render(&self) -> Render {
        Render {
            back_end: match self.back_end {
                BackEndArg::Auto => BackEnd::Auto,
                BackEndArg::Gpu => BackEnd::Gpu,
                BackEndArg::Cpu => BackEnd::Cpu,
            },
            gpu_weights: match self.gpu_weights {
                WeightsArg::Exact => GpuWeights::Exact,
                WeightsArg::Sampler => GpuWeights::Sampler,
            },
        }
    }

    fn surface(&self) -> Surface {
        let side = self.from.to_possible_value();
        let named = side.and_then(|side| Surface::from(side.get_name(), self.bone_hu));
        named.unwrap_or_default()
    }

    fn sampling(&self) -> Result<Sampling, SnapshotError> {
        let mode = match self.slab {
            SlabArg::Mean => SlabMode::Mean,
            SlabArg::Maximum => SlabMode::Maximum,
            SlabArg::Minimum => SlabMode::Minimum,
        };
        let slab = self.slab_mm.map(|thickness_mm| Slab { mode, thickness_mm });
        match slab {
            Some(slab) if !THICKNESS_MM.contains(&slab.thickness_mm) => Err(SnapshotError::Slab(slab.thickness_mm)),
            _ => Ok(Sampling {
                filter: self.filter,
                slab,
                minify: match self.minify {
                    MinifyArg::Area => Minify::Area,
                    MinifyArg::Point => Minify::Point,
                },
            }),
        }
    }
}

/// `N` numbers with commas between them.
#[derive(Debug, Clone, Copy)]
struct Numbers<const N: usize>([f64; N]);

impl<const N: usize> FromStr for Numbers<N> {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |part: &str| part.trim().parse::<f64>().map_err(|e| format!("{part:?}: {e}"));
        let numbers: Vec<f64> = text.split(',').map(parse).collect::<Result<_, _>>()?;
        let found = numbers.len();
        let numbers = <[f64; N]>::try_from(numbers);
        numbers
            .map(Self)
            .map_err(|_| format!("{found} numbers; {N} are needed"))
    }
}

/// Centre and width in HU, as the scene file allows them.
#[derive(Debug, Clone, Copy)]
struct Window(WindowLevel);

impl FromStr for Window {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let [centre_hu, width_hu] = text.parse::<Numbers<2>>()?.0;
        let allowed = (-32_768.0..=32_767.0).contains(&centre_hu) && (1.0..=65_536.0).contains(&width_hu);
        let window = WindowLevel { centre_hu, width_hu };
        allowed.then_some(Self(window)).ok_or_else(|| {
            format!("centre {centre_hu}, width {width_hu}; allowed are -32768 to 32767 and 1 to 65536 HU")
        })
    }
}

/// Width and height.
#[derive(Debug, Clone, Copy)]
struct Size([u32; 2]);

impl FromStr for Size {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text
            .split_once('x')
            .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        sides
            .filter(|sides| sides.iter().all(|n| (1..=8192).contains(n)))
            .map(Self)
            .ok_or_else(|| "a size is WxH, for instance 512x512, each side 1 to 8192".to_owned())
    }
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// The binary; `load` reads the files that `snapshot` names, `load_labels` the label map of a scene, `read` recordings.
pub fn main((load, load_labels): (LoadVolume, LoadLabels), read: LoadRecorded) -> ExitCode {
    match Cli::parse().command {
        Verb::Run { run_dir, parent, plane } => {
            let membership = Membership { run_dir, parent };
            exit("slice-view-proc", run::run(plane.into(), &membership, load_labels))
        }
        Verb::Snapshot(args) => exit("slice-view-proc", take(&args, (load, load_labels), read)),
    }
}

fn take(args: &SnapshotArgs, loads: (LoadVolume, LoadLabels), read: LoadRecorded) -> Result<(), SnapshotError> {
    let volume = args.volume.clone().map(|path| {
        let mut volume = VolumeSpec::of_path(path);
        if let VolumeSource::File(file) = &mut volume.source {
            (file.series, file.regrid, file.assume_lps) = (args.series, args.regrid, args.assume_lps);
        }
        volume
    });
    if let (Some(recording), Some(out)) = (&args.recording, &args.out) {
        let what = OfRecording {
            recording,
            at: match (&args.at, &args.seq) {
                (_, Some(seq)) => At::Seq(seq),
                (at, None) => At::Time(at.as_deref().unwrap_or_default()),
            },
            view: &args.view,
            moved_to: volume.map(|volume| volume.source),
            out,
        };
        return recorded(&what, loads, read);
    }
    let plane = PlaneArg::from_str(&args.view, true).map_err(|_| SnapshotError::View(args.view.clone()))?;
    let numbers = args.pose.as_ref().map_or([f64::NAN; 7], |pose| pose.0);
    let [w, x, y, z, tx, ty, tz] = numbers;
    let pose = checked::rigid([w, x, y, z], [tx, ty, tz], TYPED_TOLERANCE).map_err(SnapshotError::Pose)?;
    let sampling = args.sampling()?;
    if !args.ahead_mm.is_finite() {
        return Err(SnapshotError::Ahead(args.ahead_mm));
    }
    let what = Snapshot {
        volume: volume.unwrap_or_else(|| VolumeSpec::of_path(PathBuf::new())),
        plane: plane.into(),
        pose,
        size: args.size.0,
        pixel_mm: args.pixel_mm,
        sampling,
        ahead_mm: args.ahead_mm,
        window: args.window.0,
        surface: args.surface(),
        reference: args.reference,
        render: args.render(),
        out: args.out.clone(),
        hu: args.hu.clone(),
    };
    snapshot(&what, loads.0)
}
