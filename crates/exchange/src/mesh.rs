//! Surfaces of triangles: STL, PLY, OBJ and VTK's legacy PolyData.
//!
//! None of these formats has a word for its frame or its unit. 3D Slicer writes `SPACE=RAS` or `SPACE=LPS` into the comment of what it
//! saves, other programs `1 unit = 1.000000 mm`, and that is read; else whoever hands a file over says it ([`Said`]). A surface whose largest
//! side is at most [`METRES_BELOW`](crate::METRES_BELOW) looks like metres and is refused until its unit is said.
//!
//! Normals, colours, textures and other data of a file are left out: normals are the triangles' own, by the order of their corners. A
//! turn from RAS to LPS keeps that order right, as it is no mirror.

mod bytes;
mod error;
mod obj;
mod ply;
mod raw;
mod stl;
mod vtk;
mod words;
mod write;

pub use error::MeshError;
pub use write::write;

use geometry::{Ct, Point};

use crate::points::{largest, position};
use crate::{PatientAxes, Said};
use raw::Raw;

/// The longest file, bytes.
pub const MAX_BYTES: usize = 1 << 30;
/// Most points, and most triangles.
pub const MAX_COUNT: usize = 50_000_000;

/// A format, as the ending of a file's name tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// `.stl`, as text or binary.
    Stl,
    /// `.ply`, as text or binary, least or most significant byte first.
    Ply,
    /// `.obj`.
    Obj,
    /// `.vtk`, legacy PolyData, as text or binary.
    Vtk,
}

impl MeshFormat {
    /// All.
    pub const ALL: [Self; 4] = [Self::Stl, Self::Ply, Self::Obj, Self::Vtk];

    /// The ending, without a dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Vtk => "vtk",
        }
    }

    /// By the ending of a name, in whatever case.
    pub fn of_ending(ending: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|format| format.ending().eq_ignore_ascii_case(ending))
    }
}

/// A surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Its points, in the order of the file; of STL, each triangle has its own three.
    pub points: Vec<Point<Ct>>,
    /// Its triangles by the places of their corners among the points, from 0; larger polygons are cut into fans.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a file of this format.
///
/// # Errors
/// Each variant of [`MeshError`] but the last. What a head promises is held against the bytes that are there before anything is held
/// for it.
pub fn read(bytes: &[u8], format: MeshFormat, said: Said) -> Result<Mesh, MeshError> {
    if bytes.len() > MAX_BYTES {
        return Err(MeshError::TooLong { bytes: bytes.len() });
    }
    let raw = match format {
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::Ply => ply::read(bytes),
        MeshFormat::Obj => obj::read(crate::unmarked(bytes)),
        MeshFormat::Vtk => vtk::read(bytes),
    }?;
    settled(raw, said)
}

/// The surface in the patient.
fn settled(raw: Raw, said: Said) -> Result<Mesh, MeshError> {
    let bad = raw.points.iter().position(|point| !point.iter().all(|x| x.is_finite()));
    if let Some(place) = bad {
        let found = format!("{:?}", raw.points[place]);
        return Err(MeshError::NotFinite {
            point: place + 1,
            found,
        });
    }
    let count = raw.points.len();
    let is_in = |corner: &u32| (*corner as usize) < count;
    if let Some(place) = raw.triangles.iter().position(|corners| !corners.iter().all(is_in)) {
        let corners = raw.triangles[place];
        return Err(MeshError::Corner {
            triangle: place + 1,
            corners,
            count,
        });
    }
    if raw.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    let axes: PatientAxes = said.axes_beside(raw.axes, &raw.named)?;
    said.unit_beside(raw.unit, &raw.units)?;
    let sides = [0, 1, 2].map(|i| {
        let least = raw.points.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min);
        raw.points.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max) - least
    });
    let side = sides.into_iter().fold(0.0, f64::max);
    let most = largest(raw.points.iter());
    let scale = said.scale(
        raw.unit,
        [
            ("the largest coordinate", most),
            ("the longest side of the surface", side),
        ],
    )?;
    let points = raw.points.iter().filter_map(|point| position(axes, scale, *point));
    Ok(Mesh {
        points: points.collect(),
        triangles: raw.triangles,
    })
}
