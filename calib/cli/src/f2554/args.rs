//! The command.

use std::path::{Path, PathBuf};

use calib::f2554::{Phantom, Refused, Report, Sample, Simulation, measure, phantom};
use clap::Args;
use geometry::Point;
use picture::PngError;

use super::report::{Record, text};
use super::{chart, data};
use crate::calibration::Gate;
use crate::commands::common::{CommandError, Outcome, OwnError, broken, gate, verdict_text};
use crate::input_files::columns::TableError;
use crate::store::{self, StoreError};
use crate::values::Positive;

pub(crate) const F2554_HELP: &str = "\
Measures how well a tracked pointer locates points, by the procedure of ASTM F2554. DATA.csv holds places of the tip in the \
tracker, mm, a sample a line; place numbers the places of the working volume, angle_deg is the pointer's turn:

  place,test,divot,angle_deg,x,y,z
  0,single,7,0,12.31,-4.05,-1998.72
  0,roll,7,-180,12.34,-4.11,-1998.60
  0,distance,0,0,-87.60,-79.02,-1999.11

test is single (one divot, again and again), roll, pitch or yaw (turned about the tip in one divot), or distance (every \
divot of the phantom; its first sample at a place is the first round). --phantom has the divots as drawn, numbered from 0:

  divot,x,y,z
  0,-100,-75,0

--simulate SEED runs the whole procedure on a simulated localizer with a phantom of 20 divots instead, and says what a real \
one of that noise would show. With a gate (--max-single-mm, --max-turn-mm, --max-distance-mm) that is not kept the exit code \
is 1; the report is written all the same.

Examples:
  calib f2554 data.csv --phantom phantom.csv --out report.json --png turns.png
  calib f2554 --simulate 1 --sigma-mm 0.1 --depth-sigma-mm 0.15 --tip-error-mm 0.3 --png turns.png
  calib f2554 --simulate 1 --data simulated.csv --max-distance-mm 2";

#[derive(Debug, Args)]
pub(crate) struct F2554Args {
    /// What was measured
    #[arg(value_name = "DATA.csv", required_unless_present = "simulate", requires = "phantom")]
    samples: Option<PathBuf>,
    /// The divots as drawn
    #[arg(long, value_name = "PHANTOM.csv")]
    phantom: Option<PathBuf>,
    /// Simulate instead of measuring; the same seed gives the same report
    #[arg(long, value_name = "SEED", conflicts_with_all = ["samples", "phantom"])]
    simulate: Option<u64>,
    /// Noise of a diode across the line of sight at 2 m
    #[arg(long, value_name = "MM", default_value = "0.1", requires = "simulate")]
    sigma_mm: Positive,
    /// The same along it
    #[arg(long, value_name = "MM", default_value = "0.15", requires = "simulate")]
    depth_sigma_mm: Positive,
    /// Error of the tip's calibration along each axis
    #[arg(
        long,
        value_name = "MM",
        default_value = "0.1",
        requires = "simulate",
        allow_hyphen_values = true
    )]
    tip_error_mm: f64,
    /// Write the simulated samples here
    #[arg(long, value_name = "DATA.csv", requires = "simulate")]
    data: Option<PathBuf>,
    /// Accept at most this distance of a single-point sample from its mean
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_single_mm: Option<Positive>,
    /// Accept at most this distance of a turned tip from its mean
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_turn_mm: Option<Positive>,
    /// Accept at most this error of a distance
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_distance_mm: Option<Positive>,
    /// Write the report here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Write a chart of the turns here
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long)]
    overwrite: bool,
    /// Print the report as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub(crate) enum F2554Error {
    #[error(transparent)]
    Table(#[from] TableError),
    #[error("point localization of {what}: {refused}")]
    Refused { what: String, refused: Box<Refused> },
    #[error(transparent)]
    Png(#[from] PngError),
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl OwnError for F2554Error {}

/// Samples, the phantom, and where they are from.
struct Measured {
    samples: Vec<Sample>,
    phantom: Vec<Point<Phantom>>,
    lost: usize,
    what: String,
    id: String,
}

impl F2554Args {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        for path in [&self.out, &self.png, &self.data].into_iter().flatten() {
            store::check(path, self.overwrite)?;
        }
        let measured = self.measured()?;
        let refused = |refused| F2554Error::Refused {
            what: measured.what.clone(),
            refused: Box::new(refused),
        };
        let report = measure(&measured.phantom, &measured.samples).map_err(refused)?;
        self.told(&measured, &report)
    }

    fn measured(&self) -> Result<Measured, F2554Error> {
        match (&self.samples, &self.phantom) {
            (Some(path), Some(drawn)) => {
                let (samples, source) = data::samples(path)?;
                let (phantom, _) = data::phantom(drawn)?;
                let (what, id) = (path.display().to_string(), source.blake3[..16].to_owned());
                Ok(Measured {
                    samples,
                    phantom,
                    lost: 0,
                    what,
                    id,
                })
            }
            _ => self.simulated(),
        }
    }

    fn simulated(&self) -> Result<Measured, F2554Error> {
        let simulation = Simulation {
            seed: self.simulate.unwrap_or_default(),
            across_mm: self.sigma_mm.0,
            depth_mm: self.depth_sigma_mm.0,
            tip_error_mm: self.tip_error_mm,
            ..Simulation::default()
        };
        let what = format!("a simulation of seed {}", simulation.seed);
        let (samples, lost) = simulation.samples().map_err(|refused| F2554Error::Refused {
            what: what.clone(),
            refused: Box::new(refused),
        })?;
        let text = data::text(&samples);
        let id = blake3::hash(text.as_bytes()).to_hex()[..16].to_owned();
        if let Some(path) = &self.data {
            store::write(path, Ok(text), std::iter::empty())?;
        }
        Ok(Measured {
            samples,
            phantom: phantom(),
            lost,
            what,
            id,
        })
    }

    fn told(&self, measured: &Measured, report: &Report) -> Result<Outcome, CommandError> {
        let gates = self.gates(report);
        let counts = [measured.samples.len(), measured.lost];
        let record = Record::new(report, measured.id.clone(), measured.what.clone(), counts, gates);
        let mut words = text(report, &record) + &verdict_text(&record.gates);
        let encoded = serde_json::to_string_pretty(&record).map_err(std::io::Error::from)? + "\n";
        if let Some(path) = &self.out {
            let inputs = [&self.samples, &self.phantom].into_iter().flatten();
            store::write(path, Ok(encoded.clone()), inputs.map(|p| p.as_path()))?;
            words.push_str(&written(path));
        }
        if let Some(path) = &self.png {
            let title = format!("The tip while the pointer turns about it: {}", measured.what);
            chart::write(path, &measured.samples, &title).map_err(F2554Error::Png)?;
            words.push_str(&written(path));
        }
        let refused = broken(&record.gates);
        let text = if self.json { encoded } else { words };
        Ok(Outcome { text, refused })
    }

    fn gates(&self, report: &Report) -> Vec<Gate> {
        let limit = |gate: Option<Positive>| gate.map(|limit| limit.0);
        // What was not measured keeps no bound; JSON has no infinity.
        let found = |x: Option<f64>| x.unwrap_or(f64::MAX);
        let distance = report.distances.map(|d| d.max_mm);
        let gates = [
            gate(
                "max-single-mm",
                limit(self.max_single_mm),
                found(report.single_max_mm),
                false,
            ),
            gate("max-turn-mm", limit(self.max_turn_mm), found(report.turn_max_mm), false),
            gate("max-distance-mm", limit(self.max_distance_mm), found(distance), false),
        ];
        gates.into_iter().flatten().collect()
    }
}

fn written(path: &Path) -> String {
    format!("written to {}\n", path.display())
}
