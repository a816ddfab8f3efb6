//! `calib rom`: NDI tool definitions as markers.

mod file;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use calib::pose::{Body, BodyError};
use clap::{Args, Subcommand};
use geometry::{Marker, Point};

use crate::bundle::table;
use crate::calibration::{EmitterRecord, MarkerRecord};
use crate::commands::common::{CommandError, Outcome, OwnError};

pub(crate) use file::{Rom, RomError};

pub(crate) const ROM_HELP: &str = "\
Examples:
  calib rom info 8700340.rom
  calib marker --rom 8700340.rom --toml >> scene.toml";

#[derive(Debug, Args)]
pub(crate) struct RomArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Show what a tool definition holds: emitters, normals, faces, and the table of a scene
    #[command(after_help = "Example:\n  calib rom info 8700340.rom")]
    Info {
        /// The tool definition
        #[arg(value_name = "FILE.rom")]
        file: PathBuf,
    },
}

/// Why a tool definition is no marker.
#[derive(Debug, thiserror::Error)]
#[error(
    "the tool {part} of {path} cannot be tracked by its emitters alone: {refused}. Trocar needs all six degrees of freedom; \
     take a tool with an emitter off that line"
)]
pub(crate) struct NoTool {
    path: PathBuf,
    part: String,
    refused: Box<BodyError>,
}

impl OwnError for NoTool {}

impl RomArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        let What::Info { file } = &self.what;
        let rom = Rom::read(file)?;
        let mut text = report(file, &rom);
        let refused = match marker(file, &rom) {
            Ok(found) => {
                // Every emitter has a place.
                let scene = table(&found, &rom.part, Some(f64::from(rom.max_angle_deg)));
                text = text + "\n" + &scene.unwrap_or_default();
                None
            }
            Err(refused) => Some(refused.to_string()),
        };
        Ok(Outcome { text, refused })
    }
}

/// The tool's emitters as a marker, where they determine a pose.
pub(crate) fn marker(path: &Path, rom: &Rom) -> Result<MarkerRecord, NoTool> {
    let place = |[x, y, z]: [f64; 3]| Point::<Marker>::new(x, y, z);
    let places: Vec<Point<Marker>> = rom.markers.iter().map(|m| place(m.at_mm)).collect();
    Body::of_points(&places).map_err(|refused| NoTool {
        path: path.to_owned(),
        part: rom.part.clone(),
        refused: Box::new(refused),
    })?;
    let emitter = |m: &file::RomMarker| EmitterRecord {
        at_mm: m.at_mm,
        normal: m.normal,
        covariance_upper_mm2: None,
        sightings: 0,
        rms_mm: None,
        worst_mm: None,
    };
    Ok(MarkerRecord {
        emitters: rom.markers.iter().map(emitter).map(Some).collect(),
        frame: format!("NDI tool {}", rom.part),
        views: 0,
        rms_mm: None,
        noise_ratio: None,
        sigma_mm: None,
        condition: None,
        predicted_rms_mm: None,
        rejected: Vec::new(),
    })
}

fn report(path: &Path, rom: &Rom) -> String {
    let mut text = format!(
        "{}: tool {} by {}, {} markers, at least {} for a pose, seen within {} degrees, errors up to {} mm\n\n\
         marker         x          y          z mm        normal                     faces\n",
        crate::text::shown(&path.display().to_string()),
        rom.part,
        rom.maker,
        rom.markers.len(),
        rom.min_markers,
        rom.max_angle_deg,
        rom.max_error_mm,
    );
    for (i, m) in rom.markers.iter().enumerate() {
        let [x, y, z] = m.at_mm;
        let normal = m
            .normal
            .map_or("-".to_owned(), |[x, y, z]| format!("{x:.3}, {y:.3}, {z:.3}"));
        let faces: Vec<String> = m.faces.iter().map(usize::to_string).collect();
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{i:>6}  {x:>10.3} {y:>10.3} {z:>10.3}           {normal:<26} {}",
            faces.join(", ")
        );
    }
    for (face, [x, y, z]) in &rom.faces {
        let _ = writeln!(text, "face {face} looks along ({x:.3}, {y:.3}, {z:.3})");
    }
    text
}
