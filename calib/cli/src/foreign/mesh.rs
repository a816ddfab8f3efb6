//! `calib mesh`: surfaces of other programs, from one format and frame to another.

use std::path::{Path, PathBuf};

use clap::Args;
use exchange::mesh::{self, Mesh, MeshFormat};
use exchange::{LengthUnit, PatientAxes, Said};

use super::{ForeignError, bytes};
use crate::commands::common::{CommandError, Outcome};
use crate::store;

pub(crate) const MESH_HELP: &str = "\
Reads a surface of triangles (.stl, .ply, .obj, .vtk), says where it lies in the patient, and with --out writes it again. Which axes its
coordinates are along is read from its comment, where 3D Slicer writes SPACE=RAS or SPACE=LPS; else it is said with --frame. Normals,
colours and textures are left out. What is written says its axes, and is in mm.

Examples:
  calib mesh pelvis.vtk --frame lps
  calib mesh bone.stl --frame ras --unit m --out bone.ply --axes lps";

#[derive(Debug, Args)]
pub(crate) struct MeshArgs {
    /// The surface
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The axes of its coordinates, where it does not say them
    #[arg(long, value_name = "lps|ras")]
    frame: Option<PatientAxes>,
    /// Its unit: m, or mm though it is at most 2 mm long [default: what its comment says, else mm]
    #[arg(long, value_name = "mm|m")]
    unit: Option<LengthUnit>,
    /// Write it here, in the format of this ending
    #[arg(long, value_name = "FILE", requires = "axes")]
    out: Option<PathBuf>,
    /// The axes of what is written
    #[arg(long, value_name = "lps|ras", requires = "out")]
    axes: Option<PatientAxes>,
    /// Replace that file if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
}

impl MeshArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CommandError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
            format(out)?;
        }
        let said = Said {
            axes: self.frame,
            unit: self.unit,
        };
        let (mesh, _) = read(&self.file, said)?;
        let mut text = report(&self.file, &mesh);
        if let (Some(out), Some(axes)) = (&self.out, self.axes) {
            let written = mesh::write(&mesh, format(out)?, axes);
            let bytes = written.map_err(|source| mesh_error(out, source))?;
            store::write_bytes(out, Ok(bytes), [self.file.as_path()].into_iter())?;
            text += &format!("written to {}, along {}, in mm\n", shown(out), axes.name());
        }
        Ok(Outcome { text, refused: None })
    }
}

/// A surface as a file has it, and the file's bytes.
pub(crate) fn read(path: &Path, said: Said) -> Result<(Mesh, Vec<u8>), ForeignError> {
    let format = format(path)?;
    let bytes = bytes(path, mesh::MAX_BYTES)?;
    let mesh = mesh::read(&bytes, format, said).map_err(|source| mesh_error(path, source))?;
    Ok((mesh, bytes))
}

fn mesh_error(path: &Path, source: mesh::MeshError) -> ForeignError {
    ForeignError::Mesh {
        path: path.to_owned(),
        source: Box::new(source),
    }
}

fn format(path: &Path) -> Result<MeshFormat, ForeignError> {
    let ending = path
        .extension()
        .and_then(|ending| MeshFormat::of_ending(&ending.to_string_lossy()));
    ending.ok_or_else(|| ForeignError::Surface { path: path.to_owned() })
}

fn shown(path: &Path) -> String {
    crate::text::shown(&path.to_string_lossy())
}

/// How many triangles there are, and between which places of the patient.
fn report(path: &Path, mesh: &Mesh) -> String {
    let bound = |pick: fn(f64, f64) -> f64| {
        let places = mesh.points.iter().map(|point| point.mm());
        let most = places
            .reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i])))
            .unwrap_or_default();
        geometry::Point::<geometry::Ct>::new(most[0], most[1], most[2]).in_words(1)
    };
    format!(
        "{}: {} triangles on {} points\nfrom {}\nto   {}\n",
        shown(path),
        mesh.triangles.len(),
        mesh.points.len(),
        bound(f64::min),
        bound(f64::max)
    )
}
