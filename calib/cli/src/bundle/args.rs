//! The command.

use std::path::{Path, PathBuf};

use calib::bundle::{Bundle, Gauge, Localizer, Options, calibrate};
use clap::Args;

use super::drawing::Drawing;
use super::frames::Frames;
use super::refusal::{NoMarker, numbered};
use super::report::{self, record};
use super::scene;
use crate::calibration::{CalibrationFile, Gate, Kind, MarkerRecord, Recorded};
use crate::commands::common::{CommandError, OutArgs, Outcome, OwnError, gate, verdict_text};
use crate::rom::{self, Rom};
use crate::values::Positive;

pub(crate) const MARKER_HELP: &str = "\
FRAMES.csv holds what the localizer saw while the marker was turned slowly in front of it, an emitter of a frame a line; \
numbers of frames and emitters are whole, emitters count from 0, lengths are in mm; a line that begins with # is a comment:

  frame,emitter,x,y,z
  0,0,12.31,-4.05,-1998.72
  0,3,40.88,2.10,-2003.15

With the columns cxx,cxy,cxz,cyy,cyz,czz (mm^2) each sighting has a covariance of its own. Turn the marker through all \
sides in small steps: views hang together by three emitters or more. 100 frames of a ball of 24 diodes with 0.1 mm of noise \
give the places to 0.03 mm.

The marker's frame has its origin at the mean of the emitters and its axes along their spread, which is as steady as the \
shape is uneven. --drawing lays the result in the frame of a marker known already, which checks it too: emitters that are \
exchanged, a mirror image and one that has moved are named.

Refused: no three emitters off a line, emitters seen too seldom, views that do not hang together, exchanged numbers, mirror \
images. With a gate (--max-rms-mm, --max-noise-ratio, --max-rejected, --max-error-mm, --min-views) that is not kept nothing \
is written and the exit code is 1.

Examples:
  calib marker frames.csv --sigma-mm 0.1 --marker ball --out ball.json
  calib marker frames.csv --drawing ball.json --tolerance-mm 0.3
  calib marker frames.csv --sigma-mm 0.1 --depth-sigma-mm 0.15 --max-noise-ratio 1.5 --toml
  calib marker --rom 8700340.rom --out probe.json";

#[derive(Debug, Args)]
pub(crate) struct MarkerArgs {
    /// What the localizer saw
    #[arg(value_name = "FRAMES.csv", required_unless_present = "rom")]
    frames: Option<PathBuf>,
    /// Take the marker from an NDI tool definition instead
    #[arg(long, value_name = "FILE.rom", conflicts_with_all = ["frames", "drawing"])]
    rom: Option<PathBuf>,
    /// Standard deviation of a sighting along x and y of the localizer
    #[arg(long, value_name = "MM", default_value = "0.1", allow_hyphen_values = true)]
    sigma_mm: Positive,
    /// The same along z, the localizer's depth [default: --sigma-mm]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    depth_sigma_mm: Option<Positive>,
    /// How many emitters the marker has [default: those of the drawing, or the largest number seen and 1]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(3..=32))]
    emitters: Option<u8>,
    /// Lay the result in the frame of this marker: a calibration (.json) or an NDI tool definition (.rom)
    #[arg(long, value_name = "FILE")]
    drawing: Option<PathBuf>,
    /// The largest distance of an emitter from its place in the drawing
    #[arg(
        long,
        value_name = "MM",
        default_value = "0.5",
        requires = "drawing",
        allow_hyphen_values = true
    )]
    tolerance_mm: Positive,
    /// The fewest views in which each emitter must be seen
    #[arg(long, value_name = "COUNT", default_value = "3", value_parser = clap::value_parser!(u16).range(1..))]
    needed_views: u16,
    /// Leave out emitters that are seen in fewer
    #[arg(long)]
    allow_missing: bool,
    /// Accept at most this root mean square residual, as lengths
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_rms_mm: Option<Positive>,
    /// Accept at most residuals of so many times the noise given
    #[arg(long, value_name = "RATIO", allow_hyphen_values = true)]
    max_noise_ratio: Option<Positive>,
    /// Accept at most this share of sightings left out, 0 to 1
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    max_rejected: Option<Positive>,
    /// Accept at most this root mean square error of the places, by their covariance
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_error_mm: Option<Positive>,
    /// Accept at least so many views that give a pose
    #[arg(long, value_name = "COUNT")]
    min_views: Option<u16>,
    /// Print the table [tracker.room.marker] of a scene and nothing else
    #[arg(long, conflicts_with = "json")]
    toml: bool,
    #[command(flatten)]
    out: OutArgs,
}

/// Why there is no marker.
#[derive(Debug, thiserror::Error)]
enum MarkerError {
    #[error("no table for a scene: emitters {missing:?} have no place; record frames that show them")]
    NoTable { missing: Vec<usize> },
    #[error("give a file of frames, or --rom")]
    NoInput,
}

impl OwnError for MarkerError {}

impl MarkerArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        self.out.check()?;
        match (&self.rom, &self.frames) {
            (Some(rom), _) => self.of_rom(rom),
            (None, Some(frames)) => self.of_frames(frames),
            (None, None) => Err(MarkerError::NoInput.into()),
        }
    }

    fn of_rom(&self, path: &Path) -> Result<Outcome, CommandError> {
        let rom = Rom::read(path)?;
        let record = rom::marker(path, &rom)?;
        let text = format!("{} emitters of the NDI tool {}\n", record.emitters.len(), rom.part);
        let cone = Some(f64::from(rom.max_angle_deg));
        let recorded = recorded(path, 752, rom.blake3, [0, 0, 0]);
        self.finish(text, (record, cone), recorded, (Vec::new(), Vec::new()), &[path])
    }

    fn of_frames(&self, path: &Path) -> Result<Outcome, CommandError> {
        let drawing = self.drawing.as_deref();
        let drawing = drawing.map(|d| Drawing::read(d, self.out.marker())).transpose()?;
        let frames = Frames::read(path)?;
        let found = self.solve(&frames, drawing.as_ref()).map_err(|refused| NoMarker {
            frames: frames.views.len(),
            path: path.to_owned(),
            refused: Box::new(numbered(refused, &frames.numbers)),
        })?;
        let frame = self
            .drawing
            .as_ref()
            .map_or("principal axes".to_owned(), |d| d.display().to_string());
        let record = record(&found, &frames.numbers, frame);
        let gates = self.gates(&found, record.views);
        let text = report::text(&frames, &found, &record, drawing.as_ref()) + &verdict_text(&gates);
        let counts = [frames.views.len(), record.views, record.rejected.len()];
        let recorded = recorded(path, frames.source.bytes, frames.source.blake3.clone(), counts);
        let from = drawing.and_then(|d| d.id).into_iter().collect();
        let mut inputs = vec![path];
        inputs.extend(self.drawing.as_deref());
        self.finish(text, (record, None), recorded, (gates, from), &inputs)
    }

    fn solve(&self, frames: &Frames, drawing: Option<&Drawing>) -> Result<Bundle, calib::bundle::Refused> {
        let (across_mm, depth) = (self.sigma_mm.0, self.depth_sigma_mm);
        let even = Localizer::Depth {
            across_mm,
            depth_mm: depth.map_or(across_mm, |mm| mm.0),
        };
        let gauge = drawing.map_or(Gauge::PrincipalAxes, |d| Gauge::Design {
            places: d.places(),
            tolerance_mm: self.tolerance_mm.0,
        });
        let drawn = drawing.map_or(0, |d| d.marker.emitters.len());
        let emitters = self.emitters.map_or(drawn.max(frames.emitters), usize::from);
        let options = Options {
            gauge,
            needed_views: usize::from(self.needed_views),
            allow_missing: self.allow_missing,
            ..Options::new(frames.noise.clone().unwrap_or(even))
        };
        calibrate(&frames.views, emitters, &options)
    }

    fn gates(&self, found: &Bundle, views: usize) -> Vec<Gate> {
        let limit = |gate: Option<Positive>| gate.map(|limit| limit.0);
        let rejected = found.reached().rejected.unwrap_or(1.0);
        // Without freedom residuals say nothing; JSON has no NaN.
        let ratio = Some(found.noise_ratio).filter(|r| r.is_finite()).unwrap_or(f64::MAX);
        let least = self.min_views.map(f64::from);
        let gates = [
            gate("max-rms-mm", limit(self.max_rms_mm), found.rms_mm, false),
            gate("max-noise-ratio", limit(self.max_noise_ratio), ratio, false),
            gate("max-rejected", limit(self.max_rejected), rejected, false),
            gate(
                "max-error-mm",
                limit(self.max_error_mm),
                found.predicted_rms_mm(),
                false,
            ),
            gate("min-views", least, views as f64, true),
        ];
        gates.into_iter().flatten().collect()
    }

    /// Writes the file, or prints the table of a scene.
    fn finish(
        &self,
        mut text: String,
        (record, cone): (MarkerRecord, Option<f64>),
        recorded: Recorded,
        (gates, computed_from): (Vec<Gate>, Vec<String>),
        inputs: &[&Path],
    ) -> Result<Outcome, CommandError> {
        let scene = scene::table(&record, self.out.marker(), cone);
        match &scene {
            Ok(table) => text = text + "\nfor a scene:\n\n" + table,
            Err(missing) => text.push_str(&format!("\nno table for a scene: emitters {missing:?} have no place\n")),
        }
        let file = CalibrationFile {
            recorded: Some(recorded),
            computed_from,
            marker_body: Some(record),
            ..CalibrationFile::new(Kind::Marker, self.out.tool(), self.out.marker(), gates)
        };
        let outcome = self.out.finish(file, text, inputs)?;
        if !self.toml {
            return Ok(outcome);
        }
        let text = scene.map_err(|missing| MarkerError::NoTable { missing })?;
        Ok(Outcome { text, ..outcome })
    }
}

/// What the file rests on; the counts are frames, those used, and sightings left out.
fn recorded(path: &Path, bytes: u64, source_blake3: String, [frames, poses, invalid]: [usize; 3]) -> Recorded {
    Recorded {
        path: path.to_string_lossy().into_owned(),
        bytes,
        source_blake3,
        transform: None,
        frames,
        poses,
        invalid,
        repeated: 0,
        backwards: 0,
        same_time: 0,
        matrix_off: 0.0,
    }
}
