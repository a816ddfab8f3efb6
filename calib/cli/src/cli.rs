//! The command line.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use calib::registration::Method;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::base::{BASE_HELP, BaseArgs, SEAT_HELP, SeatArgs};
use crate::beads::{BEADS_HELP, BeadsArgs, CHECK_HELP, CheckArgs, LoadVolume, MATCH_HELP, MatchArgs};
use crate::bundle::{MARKER_HELP, MarkerArgs};
use crate::commands::{Outcome, PIVOT_HELP, PivotArgs, SPIN_HELP, SpinArgs, TOOL_HELP, ToolArgs};
use crate::discs::{DISCS_HELP, DiscsArgs};
use crate::f2554::{F2554_HELP, F2554Args};
use crate::grid::{GRID_HELP, GridArgs};
use crate::input::From;
use crate::register::{Request, register};
use crate::rom::{ROM_HELP, RomArgs};
use crate::solve::{Options, method_name};

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
  calib beads ct-folder --out beads.json --png beads.png
  calib match beads.json touched.txt --out registration.json
  calib check registration.json --known 10,-20,95.5 --touched 101.2,-33,1890.4";

const REGISTER_HELP: &str = "\
--pairs reads one pair a line. The first line names the columns, in any order; weight and label may be absent; a line \
that begins with # is a comment; lengths in mm, with a point for the decimals:

  from_x,from_y,from_z,to_x,to_y,to_z,weight,label
  0,0,0,5,0,-7,1,left eye
  60,0,0,5,60,-7,1,right eye
  0,80,0,-75,0,-7,0.5,chin
  0,0,50,5,0,43,1,vertex

--to-points and --from-points read a file each, three numbers a line with blanks or commas between them, paired line \
by line.

The transform TO_from_FROM maps a point of FROM to its place in TO: p_to = R p_from + t. `residual` is a pair's \
distance after registration, `left out` its distance under the transform of all the others. Deviations and predicted \
TRE are for the noise given, or for the noise that the residuals suggest.

Refused with line and column: rows that are ragged or not numbers, NaN, pairs and points that occur twice, weights \
that are negative or all zero. Refused with singular values: points that coincide, lie on a line or mirror each other.

Examples:
  calib register --pairs pairs.csv
  calib register --pairs pairs.csv --to ct --from tracker --target 10,-20,95.5 --out registration.json
  calib register --pairs pairs.csv --weights --noise-mm 0.2
  calib register --pairs pairs.csv --robust 1.5
  calib register --to-points in_ct.txt --from-points in_tracker.txt --scale";

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
    /// Find the metal beads of a CT
    #[command(after_help = BEADS_HELP)]
    Beads(Box<BeadsArgs>),
    /// Register the patient: find which bead each touched point is
    #[command(after_help = MATCH_HELP)]
    Match(Box<MatchArgs>),
    /// Hold the error at a known point against the prediction
    #[command(after_help = CHECK_HELP)]
    Check(Box<CheckArgs>),
}

#[derive(Debug, Args)]
struct RegisterArgs {
    /// Pairs as comma-separated values, mm
    #[arg(long, value_name = "FILE.csv", required_unless_present = "to_points")]
    pairs: Option<PathBuf>,
    /// Points in TO, three numbers a line, mm
    #[arg(long, value_name = "FILE", requires = "from_points", conflicts_with_all = ["pairs", "weights"])]
    to_points: Option<PathBuf>,
    /// The same points in FROM
    #[arg(long, value_name = "FILE", requires = "to_points")]
    from_points: Option<PathBuf>,
    /// How the rotation is found; all find the same optimum
    #[arg(long, value_enum, default_value = "newton")]
    method: MethodArg,
    /// Use the column weight: proportional to the inverse of the variance of a pair
    #[arg(long)]
    weights: bool,
    /// Fit a scale too, for points in different units
    #[arg(long, conflicts_with = "robust")]
    scale: bool,
    /// Use the largest set of pairs that agree within this distance; the others are outliers
    #[arg(long, value_name = "TOLERANCE_MM", allow_hyphen_values = true)]
    robust: Option<PositiveMm>,
    /// The fewest pairs that must agree [default: more than half]
    #[arg(long, value_name = "COUNT", requires = "robust", value_parser = clap::value_parser!(u16).range(3..))]
    min_inliers: Option<u16>,
    /// Standard deviation of a pair's error along each axis [default: estimated from the residuals]
    #[arg(long, value_name = "SIGMA_MM", allow_hyphen_values = true)]
    noise_mm: Option<PositiveMm>,
    /// Where to predict the error, in TO, mm; may be given several times
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    target: Vec<Target>,
    /// Name of the frame that is mapped into
    #[arg(long, default_value = "to")]
    to: Name,
    /// Name of the frame that is mapped from
    #[arg(long, default_value = "from")]
    from: Name,
    /// Hash of the CT volume that the points of TO are of, to be checked when the file is used
    #[arg(long, value_name = "HASH")]
    ct_hash: Option<Name>,
    /// Name of the marker that the points of FROM are seen by, to be checked when the file is used
    #[arg(long, value_name = "NAME")]
    marker: Option<Name>,
    /// Write the result here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Replace that file if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Accept pairs and points that occur twice
    #[arg(long)]
    allow_duplicates: bool,
    /// List every pair, however many there are
    #[arg(long)]
    all: bool,
}

#[derive(Debug, Clone, Copy)]
struct MethodArg(Method);

impl ValueEnum for MethodArg {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [MethodArg; Method::ALL.len()] = {
            let mut all = [MethodArg(Method::Newton); Method::ALL.len()];
            let mut i = 0;
            while i < all.len() {
                all[i] = MethodArg(Method::ALL[i]);
                i += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(method_name(self.0)))
    }
}

/// A length above zero.
#[derive(Debug, Clone, Copy)]
struct PositiveMm(f64);

impl FromStr for PositiveMm {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
        let allowed = value.is_finite() && value > 0.0;
        allowed
            .then_some(Self(value))
            .ok_or_else(|| format!("{value} is not a finite number of mm above 0"))
    }
}

/// A number above zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Positive(pub(crate) f64);

impl FromStr for Positive {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
        let allowed = value.is_finite() && value > 0.0;
        allowed
            .then_some(Self(value))
            .ok_or_else(|| format!("{value} is not a finite number above 0"))
    }
}

/// A point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target(pub(crate) [f64; 3]);

impl FromStr for Target {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |part: &str| part.trim().parse::<f64>().map_err(|e| format!("{part:?}: {e}"));
        let numbers: Vec<f64> = text.split(',').map(parse).collect::<Result<_, _>>()?;
        let point: [f64; 3] = numbers
            .try_into()
            .map_err(|n: Vec<f64>| format!("{} numbers; 3 are needed", n.len()))?;
        let finite = point.iter().all(|x| x.is_finite());
        finite
            .then_some(Self(point))
            .ok_or_else(|| "every number must be finite".to_owned())
    }
}

/// The name of a frame, a marker or an instrument.
#[derive(Debug, Clone)]
pub(crate) struct Name(String);

impl Name {
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for Name {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let good = (1..=64).contains(&text.len());
        let good = good && text.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b));
        let wrong = || "a name is 1 to 64 of the characters a-z, A-Z, 0-9, '-' and '_'".to_owned();
        good.then(|| Self(text.to_owned())).ok_or_else(wrong)
    }
}

/// Runs the `calib` command line of this process.
pub fn main(load: LoadVolume) -> ExitCode {
    let refused = match run(Cli::parse(), load) {
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
            bus::say!("calib: error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Does what a command line asks.
pub(crate) fn run(cli: Cli, load: LoadVolume) -> Result<Outcome, String> {
    match cli.command {
        Command::Register(args) => registered(*args),
        Command::Pivot(args) => told(args.run()),
        Command::Spin(args) => told(args.run()),
        Command::Tool(args) => told(args.run()),
        Command::Grid(args) => told(args.run()),
        Command::Discs(args) => told(args.run()),
        Command::Marker(args) => told(args.run()),
        Command::Base(args) => told(args.run()),
        Command::Seat(args) => told(args.run()),
        Command::F2554(args) => told(args.run()),
        Command::Rom(args) => told(args.run()),
        Command::Beads(args) => told(args.run(load)),
        Command::Match(args) => told(args.run(load)),
        Command::Check(args) => told(args.run()),
    }
}

fn registered(args: RegisterArgs) -> Result<Outcome, String> {
    let text = register(&request(args)).map_err(|error| error.to_string())?;
    Ok(Outcome { text, refused: None })
}

fn told(outcome: Result<Outcome, impl std::error::Error>) -> Result<Outcome, String> {
    outcome.map_err(|error| error.to_string())
}

fn request(args: RegisterArgs) -> Request {
    let input = match (args.to_points, args.from_points) {
        (Some(to), Some(from)) => From::Points { to, from },
        // The command line asks for one or the other.
        _ => From::Csv(args.pairs.unwrap_or_default()),
    };
    Request {
        input,
        allow_duplicates: args.allow_duplicates,
        options: Options {
            method: args.method.0,
            weights: args.weights,
            scale: args.scale,
            robust: args.robust.map(|mm| mm.0),
            min_inliers: args.min_inliers.map(usize::from),
            noise_mm: args.noise_mm.map(|mm| mm.0),
        },
        targets: args.target.into_iter().map(|target| target.0).collect(),
        to: args.to.0,
        from: args.from.0,
        ct_hash: args.ct_hash.map(|hash| hash.0),
        marker: args.marker.map(|name| name.0),
        out: args.out,
        overwrite: args.overwrite,
        all: args.all,
    }
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
