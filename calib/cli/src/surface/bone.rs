//! The bone: its surface, and what `calib bone` says of it in the file beside.

use std::path::{Path, PathBuf};

use exchange::{LengthUnit, PatientAxes, Said};
use serde::Deserialize;
use surface_registration::{Field, Spacing, Surface};

use super::error::SurfaceCommandError;
use crate::bone::{BONE_FORMAT, BONE_VERSION};
use crate::foreign::{bytes, read_mesh};
use crate::register::file::InputFile;
use crate::register::solve::To;

/// The longest such file, bytes.
const MAX_RECORD: usize = 16 << 20;
/// The largest deviation, mm.
const MOST_MM: f64 = 10.0;

/// A bone that was read and checked.
pub(super) struct Bone {
    pub(super) path: PathBuf,
    /// Where the file of calib bone lies, or would lie.
    pub(super) beside: PathBuf,
    pub(super) surface: Surface<To>,
    pub(super) field: Field,
    pub(super) corners: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) record: Option<Record>,
    pub(super) inputs: Vec<InputFile>,
}

/// What `calib bone` says of a bone, as far as a registration asks.
#[derive(Debug, Deserialize)]
pub(super) struct Record {
    format: String,
    version: u32,
    frame: String,
    pub(super) ct_hash: Option<String>,
    surface_blake3: String,
    /// Deviation of the surface from place to place, mm.
    pub(super) surface_sigma_mm: f64,
    /// Deviation of what all of it is off by, mm.
    pub(super) surface_shared_sigma_mm: f64,
}

impl Bone {
    /// Reads a bone; axes and unit are said where the file does not.
    pub(super) fn read(
        path: &Path,
        axes: Option<PatientAxes>,
        unit: Option<LengthUnit>,
    ) -> Result<Self, SurfaceCommandError> {
        let beside = path.with_extension("json");
        let facts = match beside.exists() {
            true => Some(bytes(&beside, MAX_RECORD)?),
            false => None,
        };
        let record = facts.as_ref().map(|facts| Record::read(&beside, facts)).transpose()?;
        let said = Said {
            axes: axes.or_else(|| record.as_ref().and_then(|record| record.frame.parse().ok())),
            unit,
        };
        let (mesh, bytes) = read_mesh(path, said)?;
        let mut inputs = vec![input("bone", path, &bytes)];
        if let (Some(record), Some(facts)) = (&record, &facts) {
            record.of(&beside, path, &inputs[0].blake3)?;
            inputs.push(input("facts of the bone", &beside, facts));
        }
        let corners: Vec<[f64; 3]> = mesh.points.iter().map(|point| point.mm()).collect();
        let surface = Surface::new(&corners, &mesh.triangles).map_err(|source| SurfaceCommandError::Surface {
            path: path.to_owned(),
            source,
        })?;
        let field = Field::new(&surface, Spacing::default()).map_err(|source| SurfaceCommandError::Field {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            beside,
            surface,
            field,
            corners,
            triangles: mesh.triangles,
            record,
            inputs,
        })
    }
}

impl Record {
    fn read(path: &Path, bytes: &[u8]) -> Result<Self, SurfaceCommandError> {
        let wrong = |what: &dyn std::fmt::Display| SurfaceCommandError::record(path, what);
        let record: Self = serde_json::from_slice(bytes).map_err(|error| wrong(&error))?;
        if record.format != BONE_FORMAT || record.version != BONE_VERSION {
            let (format, version) = (&record.format, record.version);
            return Err(wrong(&format!(
                "found format {format:?}, version {version}; expected {BONE_FORMAT:?}, {BONE_VERSION}"
            )));
        }
        if let Err(expected) = record.frame.parse::<PatientAxes>() {
            return Err(wrong(&format!("its frame is {:?}, {expected}", record.frame)));
        }
        for (key, sigma) in [
            ("surface_sigma_mm", record.surface_sigma_mm),
            ("surface_shared_sigma_mm", record.surface_shared_sigma_mm),
        ] {
            // A bone that is off by more is none that anybody registers to.
            if !(0.0..=MOST_MM).contains(&sigma) {
                return Err(wrong(&format!("{key} is {sigma}; 0 to {MOST_MM} mm is allowed")));
            }
        }
        Ok(record)
    }

    /// Refuses facts of another surface.
    fn of(&self, path: &Path, bone: &Path, found: &str) -> Result<(), SurfaceCommandError> {
        if self.surface_blake3 == found {
            return Ok(());
        }
        Err(SurfaceCommandError::OtherBone {
            path: path.to_owned(),
            bone: bone.to_owned(),
            told: self.surface_blake3.chars().take(16).collect(),
            found: found.chars().take(16).collect(),
        })
    }
}

pub(super) fn input(role: &str, path: &Path, bytes: &[u8]) -> InputFile {
    InputFile {
        role: role.to_owned(),
        path: path.to_string_lossy().into_owned(),
        bytes: bytes.len() as u64,
        blake3: blake3::hash(bytes).to_hex().to_string(),
    }
}
