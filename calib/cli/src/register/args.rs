//! `calib register`: its options.

use std::path::PathBuf;
use std::str::FromStr;

use calib::registration::Method;
use clap::{Args, ValueEnum};
use geometry::VolumeGrid;

use crate::beads::{LoadVolume, ReadArgs};
use crate::commands::Outcome;
use crate::live::touched_in;
use crate::register::input::From;
use crate::register::solve::{Options, method_name};
use crate::register::{RegisterError, Request, register};
use crate::scene_context::{SceneArgs, SceneContext};
use crate::values::{Name, Target};

pub(crate) const REGISTER_HELP: &str = "\
--pairs reads one pair a line. The first line names the columns, in any order; weight and label may be absent; a line \
that begins with # is a comment; lengths in mm, with a point for the decimals:

  from_x,from_y,from_z,to_x,to_y,to_z,weight,label
  0,0,0,5,0,-7,1,left eye
  60,0,0,5,60,-7,1,right eye
  0,80,0,-75,0,-7,0.5,chin
  0,0,50,5,0,43,1,vertex

--to-points and --from-points read a file each, three numbers a line with blanks or commas between them, paired line \
by line; a file of calib touch is read too. Where touches state their errors (cxx to czz, u1x to u3z; --pairs takes these columns \
too, of the point in FROM) covariance and predicted TRE are by these, and --noise-mm and --least-noise-mm are of what comes to them: the \
hand, and the point in TO.

The transform TO_from_FROM maps a point of FROM to its place in TO: p_to = R p_from + t. `residual` is a pair's \
distance after registration, `left out` its distance under the transform of all the others. Deviations and predicted \
TRE are for the noise given, or for more than the noise that the residuals suggest, as few of them tell little of it.

--ct reads the CT and writes its hash into the file, as a tracker uses no file that does not say of which CT it is; --ct-hash \
writes a hash that is known (report.json has it under volume.hash).

With --scene the result must keep the [tracker.registration.gates] of that scene, else nothing is written and the exit code is \
1; --live takes the scene of a run that is going, and the hash of its CT too.

Refused with line and column: rows that are ragged or not numbers, NaN, pairs and points that occur twice, weights \
that are negative or all zero; points within 5 mm of one another (unless --scale), and with --ct or --live points outside the CT. Refused \
with singular values: points that coincide or lie on a line. Points in a plane, as three are, fit as well mirrored: that is told, and written \
into the file.

Examples:
  calib register --pairs pairs.csv
  calib register --pairs pairs.csv --to ct --from tracker --ct ct-folder --target 10,-20,95.5 --out registration.json
  calib register --live default --to-points in_ct.txt --from-points touched.csv --out registration.json
  calib register --pairs pairs.csv --weights --noise-mm 0.2
  calib register --pairs pairs.csv --robust 1.5
  calib register --to-points in_ct.txt --from-points in_tracker.txt --scale";

#[derive(Debug, Args)]
pub(crate) struct RegisterArgs {
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
    /// Standard deviation of a pair's error along each axis, of touches that state theirs of what comes to it [default: estimated from the
    /// residuals]
    #[arg(long, value_name = "SIGMA_MM", allow_hyphen_values = true)]
    noise_mm: Option<PositiveMm>,
    /// Let the estimated deviation not fall below this: residuals of few points are small by chance
    #[arg(
        long,
        value_name = "SIGMA_MM",
        conflicts_with = "noise_mm",
        allow_hyphen_values = true
    )]
    least_noise_mm: Option<PositiveMm>,
    /// Where to predict the error, in TO, mm; may be given several times
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    target: Vec<Target>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Name of the frame that is mapped into [default: to, with a scene ct]
    #[arg(long)]
    to: Option<Name>,
    /// Name of the frame that is mapped from [default: that of the touches, else from, with a scene reference or tracker]
    #[arg(long)]
    from: Option<Name>,
    /// The CT volume that the points of TO are of, to be checked when the file is used
    #[arg(long, value_name = "VOLUME", conflicts_with = "ct_hash")]
    ct: Option<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
    /// Its hash instead
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
    /// Print the registration as JSON and nothing else
    #[arg(long)]
    json: bool,
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

impl RegisterArgs {
    /// Does what is asked.
    pub(crate) fn run(self, load: LoadVolume) -> Result<Outcome, RegisterError> {
        let scened = SceneContext::open(&self.scene)?;
        let of = self.of(scened.as_ref(), load)?;
        register(&request(self, of), scened.as_ref())
    }

    /// What the result is of: as the command line says, and as the scene does.
    fn of(&self, scened: Option<&SceneContext>, load: LoadVolume) -> Result<Of, RegisterError> {
        let volume = self.ct.as_ref().map(|path| self.read.load(path, load)).transpose();
        let volume = volume.map_err(|error| RegisterError::Volume(Box::new(error)))?;
        let (mut grid, hash) = match &volume {
            Some(volume) => (Some(volume.0.grid), Some(Name::told(&volume.0.hash.to_string()))),
            None => (None, self.ct_hash.clone()),
        };
        let to = self.to.clone();
        let to = to.unwrap_or_else(|| Name::told(if scened.is_some() { "ct" } else { "to" }));
        if let Some(path) = &self.to_points {
            touched_in(path, Some(&to))?;
        }
        let from = match self.from_points.as_ref().or(self.pairs.as_ref()) {
            Some(path) => touched_in(path, self.from.as_ref())?,
            None => self.from.clone(),
        };
        let Some(scened) = scened else {
            return Ok(Of {
                to,
                from: from.unwrap_or_else(|| Name::told("from")),
                ct_hash: hash,
                marker: self.marker.clone(),
                grid,
            });
        };
        if to.as_str() == "ct" && grid.is_none() {
            grid = scened.examined()?.map(|examined| examined.grid);
        }
        Ok(Of {
            grid,
            to,
            from: from.unwrap_or_else(|| Name::told(scened.registered_from())),
            ct_hash: scened.ct_hash(hash.as_ref())?,
            marker: scened.registered_marker(self.marker.as_ref())?,
        })
    }
}

/// The frames that a registration is between, and what it is for.
struct Of {
    to: Name,
    from: Name,
    ct_hash: Option<Name>,
    marker: Option<Name>,
    /// Of the CT that the points of `to` are of, where it was read.
    grid: Option<VolumeGrid>,
}

fn request(args: RegisterArgs, of: Of) -> Request {
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
            least_noise_mm: args.least_noise_mm.map(|mm| mm.0),
        },
        targets: args.target.into_iter().map(|target| target.0).collect(),
        to: of.to.0,
        from: of.from.0,
        grid: of.grid,
        ct_hash: of.ct_hash.map(|name| name.0),
        marker: of.marker.map(|name| name.0),
        out: args.out,
        overwrite: args.overwrite,
        all: args.all,
        json: args.json,
    }
}
