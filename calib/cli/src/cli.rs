//! The command line.

use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Parser, Subcommand};

use crate::base::{BASE_HELP, BaseArgs, SEAT_HELP, SeatArgs};
use crate::beads::{
    BEADS_HELP, BeadsArgs, CHECK_HELP, CheckArgs, LoadLabels, LoadVolume, MATCH_HELP, MatchArgs, ReadLabelNames,
};
use crate::bone::{BONE_HELP, BoneArgs, Readers};
use crate::bundle::{MARKER_HELP, MarkerArgs};
use crate::camera::{CAMERA_HELP, CameraArgs};
use crate::commands::probe::{LAG_HELP, LagArgs, PROBE_HELP, ProbeArgs};
use crate::commands::{Outcome, PIVOT_HELP, PivotArgs, SPIN_HELP, SpinArgs, TOOL_HELP, ToolArgs};
use crate::f2554::{F2554_HELP, F2554Args};
use crate::foreign::{EXPORT_HELP, ExportArgs, IMPORT_HELP, ImportArgs, MESH_HELP, MeshArgs};
use crate::grid::discs::{DISCS_HELP, DiscsArgs};
use crate::grid::{GRID_HELP, GridArgs};
use crate::live::{FollowMarkers, LiveArgs, TOUCH_HELP, TouchArgs, Watch};
use crate::register::args::{REGISTER_HELP, RegisterArgs};
use crate::rom::{ROM_HELP, RomArgs};
use crate::steps::{STEPS_HELP, StepsArgs};
use crate::surface::{BONE_LINE_HELP, BoneLineArgs, SURFACE_HELP, SWEEP_HELP, SurfaceArgs, SweepArgs};

/// Calibrates and registers from measured points.
#[derive(Debug, Parser)]
#[command(name = "calib", version, after_help = TOP_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
}

const TOP_HELP: &str = "\
Examples:
  calib register --pairs pairs.csv --out registration.json
  calib pivot --poses pivot.csv --out tip.json
  calib spin --poses spin.csv --tip tip.json --out axis.json
  calib tool --pivot tip.json --spin axis.json --out tool.json
  calib marker frames.csv --marker ball --out ball.json
  calib base touches.csv --drawing base.toml --out base.json
  calib seat --base base.json --poses seated.csv --out tool.json
  calib f2554 --simulate 1 --png turns.png
  calib rom info 8700340.rom
  calib import PlusDeviceSet.xml --from StylusTip --to Stylus --shaft x --tip-error-mm 0.5 --axis-error-deg 1 --out tool.json
  calib export registration.json --holds slicer-node --out TrackerToRas.tfm
  calib mesh pelvis.vtk --frame lps
  calib surface --bone bone.ply --points touched.csv --target 10,-20,95.5 --out registration.json
  calib bone-line --sequence sweep.mha --probe probe.json --to seen.csv --picture lines.png
  calib camera grids.json --out camera.toml
  calib beads ct-folder --out beads.json --png beads.png
  calib bone ct.nii.gz --labels organs.nii.gz --label hip_left --out hip.ply --png hip.png
  calib match beads.json touched.txt --out registration.json
  calib check registration.json --known 10,-20,95.5 --touched 101.2,-33,1890.4
  calib probe --points points.json --sequence sweep.mha --config PlusDeviceSet.xml --phantom-error-mm 0.3 \
--phantom-error-deg 0.5 --out probe.json
  calib lag --signal rows.csv --sequence tank.mha
  calib pivot --live default --axis scene --out tool.json
  calib touch bead-1 --live default --to touched.csv
  calib seat --base base.json --live default --out tool.json";

#[derive(Debug, Subcommand)]
enum Command {
    /// Find the rigid transform between two frames from paired points
    #[command(after_help = REGISTER_HELP)]
    Register(Box<RegisterArgs>),
    /// Find the tip of an instrument from poses while it pivots about it
    #[command(after_help = PIVOT_HELP)]
    Pivot(Box<PivotArgs>),
    /// Find the axis of an instrument's shaft from poses while it spins about it
    #[command(after_help = SPIN_HELP)]
    Spin(Box<SpinArgs>),
    /// Make the tool's frame in its marker from a tip and an axis
    #[command(after_help = TOOL_HELP)]
    Tool(Box<ToolArgs>),
    /// Find a regular grid of discs in images
    #[command(after_help = GRID_HELP)]
    Grid(Box<GridArgs>),
    /// Calibrate a camera from grids seen in several views
    #[command(after_help = CAMERA_HELP)]
    Camera(Box<CameraArgs>),
    /// Find all discs in an image
    #[command(after_help = DISCS_HELP)]
    Discs(Box<DiscsArgs>),
    /// Find the places of a marker's emitters from many views of it
    #[command(after_help = MARKER_HELP)]
    Marker(Box<MarkerArgs>),
    /// Find the calibration base from touches on its plane and its grooves
    #[command(after_help = BASE_HELP)]
    Base(Box<BaseArgs>),
    /// Find the tool's frame in its marker from the tool in its seat on the base
    #[command(after_help = SEAT_HELP)]
    Seat(Box<SeatArgs>),
    /// Report how well a pointer locates points, measured or simulated (ASTM F2554)
    #[command(after_help = F2554_HELP)]
    F2554(Box<F2554Args>),
    /// Read NDI tool definitions
    #[command(after_help = ROM_HELP)]
    Rom(Box<RomArgs>),
    /// Take a tool's frame from a device set of PLUS or a transform of ITK or 3D Slicer
    #[command(after_help = IMPORT_HELP)]
    Import(Box<ImportArgs>),
    /// Write a tool's frame or a registration for ITK, 3D Slicer or PLUS
    #[command(after_help = EXPORT_HELP)]
    Export(Box<ExportArgs>),
    /// Read a surface (STL, PLY, OBJ, VTK), and write it in another format or frame
    #[command(after_help = MESH_HELP)]
    Mesh(Box<MeshArgs>),
    /// Register the patient by points of the bone's surface, without knowing which point of the bone each is
    #[command(after_help = SURFACE_HELP)]
    Surface(Box<SurfaceArgs>),
    /// Glide over the bone with the pointer of a run that is going, and be told what is still missing
    #[command(after_help = SWEEP_HELP)]
    Sweep(Box<SweepArgs>),
    /// Find bone in the images of a recorded sequence of a tracked ultrasound probe, as points for calib surface
    #[command(name = "bone-line", after_help = BONE_LINE_HELP)]
    BoneLine(Box<BoneLineArgs>),
    /// Find the metal beads of a CT
    #[command(after_help = BEADS_HELP)]
    Beads(Box<BeadsArgs>),
    /// Take the surface of a bone from a CT
    #[command(after_help = BONE_HELP)]
    Bone(Box<BoneArgs>),
    /// Register the patient: find which bead each touched point is
    #[command(after_help = MATCH_HELP)]
    Match(Box<MatchArgs>),
    /// Find where the image of a tracked ultrasound probe lies in its marker
    #[command(after_help = PROBE_HELP)]
    Probe(Box<ProbeArgs>),
    /// Find how late poses are behind images, from a motion that both show
    #[command(after_help = LAG_HELP)]
    Lag(Box<LagArgs>),
    /// Touch a point with the pointer of a run that is going
    #[command(after_help = TOUCH_HELP)]
    Touch(Box<TouchArgs>),
    /// Hold the error at a known point against the prediction
    #[command(after_help = CHECK_HELP)]
    Check(Box<CheckArgs>),
    /// Serve a run whose scene has [steps]: calibration, registration and check, step by step
    #[command(after_help = STEPS_HELP)]
    Steps(Box<StepsArgs>),
}

impl Cli {
    /// While the command listens to a run, this one is told.
    pub(crate) fn watch(&mut self, watch: &Watch) {
        if let Some(live) = self.command.live() {
            live.watch = watch.clone();
        }
    }
}

impl Command {
    /// How the command listens to a run, where it does.
    fn live(&mut self) -> Option<&mut LiveArgs> {
        match self {
            Self::Pivot(args) => Some(args.live()),
            Self::Spin(args) => Some(args.live()),
            Self::Seat(args) => Some(args.live()),
            Self::Touch(args) => Some(&mut args.live),
            Self::Check(args) => Some(&mut args.live),
            Self::Sweep(args) => Some(&mut args.live),
            _ => None,
        }
    }
}

/// What the binary hands in, as this crate knows neither formats of volumes nor the tracker's chain.
#[derive(Debug, Clone, Copy)]
pub struct Hands {
    /// Reads a volume.
    pub load: LoadVolume,
    /// Reads a label map.
    pub labels: LoadLabels,
    /// Reads the names of its structures.
    pub label_names: ReadLabelNames,
    /// Follows the markers of a run.
    pub follow: FollowMarkers,
}

/// The command line, for manual pages and completions.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Runs the `calib` command line of this process.
pub fn main(hands: Hands) -> ExitCode {
    let refused = match carry_out(Cli::parse(), hands) {
        Ok(Outcome { text, refused }) => {
            // Where nobody reads stdout any more, there is nobody to tell.
            let _ = std::io::stdout().write_all(text.as_bytes());
            refused
        }
        Err(error) => Some(error),
    };
    match refused {
        None => ExitCode::SUCCESS,
        Some(error) => {
            bus::stderr_line!("calib: error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What the `calib` command line answers to some words, the first of which is its name: its report, or why there is none.
///
/// # Errors
/// The words for stderr, also where a result was written but is refused.
pub fn answer<W>(words: impl IntoIterator<Item = W>, hands: Hands) -> Result<String, String>
where
    W: Into<std::ffi::OsString> + Clone,
{
    let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
    let Outcome { text, refused } = carry_out(cli, hands)?;
    refused.map_or(Ok(text), Err)
}

/// [`carry_out`] without a run.
#[cfg(test)]
pub(crate) fn run(cli: Cli, load: LoadVolume) -> Result<Outcome, String> {
    let follow: FollowMarkers = |_| Err("no run is followed here".into());
    let labels: LoadLabels = |_, _| Err("no label map is read here".into());
    let label_names: ReadLabelNames = |_| Ok(guidance::safety::LabelNames::default());
    carry_out(
        cli,
        Hands {
            load,
            labels,
            label_names,
            follow,
        },
    )
}

/// Does what a command line asks.
pub(crate) fn carry_out(cli: Cli, hands: Hands) -> Result<Outcome, String> {
    let Hands { load, follow, .. } = hands;
    match cli.command {
        Command::Register(args) => told(args.run(load)),
        Command::Pivot(args) => told(args.run(follow)),
        Command::Spin(args) => told(args.run(follow)),
        Command::Tool(args) => told(args.run()),
        Command::Grid(args) => told(args.run()),
        Command::Camera(args) => told(args.run()),
        Command::Discs(args) => told(args.run()),
        Command::Marker(args) => told(args.run()),
        Command::Base(args) => told(args.run()),
        Command::Seat(args) => told(args.run(follow)),
        Command::F2554(args) => told(args.run()),
        Command::Rom(args) => told(args.run()),
        Command::Import(args) => told(args.run()),
        Command::Export(args) => told(args.run()),
        Command::Mesh(args) => told(args.run()),
        Command::Surface(args) => told(args.run(load)),
        Command::Sweep(args) => told(args.run(follow)),
        Command::BoneLine(args) => told(args.run()),
        Command::Beads(args) => told(args.run(load)),
        Command::Bone(args) => told(args.run(&Readers {
            load,
            labels: hands.labels,
            label_names: hands.label_names,
        })),
        Command::Match(args) => told(args.run(load)),
        Command::Probe(args) => told(args.run()),
        Command::Lag(args) => told(args.run()),
        Command::Touch(args) => told(args.run(follow)),
        Command::Check(args) => told(args.run(follow)),
        Command::Steps(args) => {
            let commands = move |words: &[String], watch: &Watch| {
                let mut cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
                cli.watch(watch);
                carry_out(cli, hands)
            };
            let nothing = |()| Outcome {
                text: String::new(),
                refused: None,
            };
            args.run(Arc::new(commands))
                .map(nothing)
                .map_err(|error| error.to_string())
        }
    }
}

fn told(outcome: Result<Outcome, impl std::error::Error>) -> Result<Outcome, String> {
    outcome.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent_and_shows_examples() {
        let mut command = Cli::command();
        command.clone().debug_assert();
        let help = command
            .find_subcommand_mut("register")
            .unwrap()
            .render_help()
            .to_string();
        assert!(help.contains("Examples:") && help.contains("from_x,from_y"), "{help}");
    }

    #[test]
    fn what_is_typed_wrong_is_refused() {
        let parse = |line: &str| Cli::try_parse_from(line.split(' ')).map_err(|error| error.to_string());
        assert!(parse("calib register --pairs p.csv --method svd --target -1,2,3 --target 4,5,6").is_ok());
        for (line, words) in [
            ("calib register", "--pairs"),
            ("calib register --to-points a", "--from-points"),
            (
                "calib register --pairs p --to-points a --from-points b",
                "cannot be used with",
            ),
            ("calib register --pairs p --robust 0", "above 0"),
            ("calib register --pairs p --noise-mm nan", "NaN is not a finite number"),
            ("calib register --pairs p --target 1,2", "2 numbers; 3 are needed"),
            ("calib register --pairs p --target 1,2,inf", "finite"),
            ("calib register --pairs p --method arun", "horn-quaternion"),
            ("calib register --pairs p --min-inliers 5", "--robust"),
            ("calib register --pairs p --robust 1 --min-inliers 2", "2 is not in 3.."),
            ("calib register --pairs p --robust 1 --scale", "cannot be used with"),
            ("calib register --pairs p --to a/b", "1 to 64 of the characters"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.contains(words), "{line}: {error}");
        }
    }
}
