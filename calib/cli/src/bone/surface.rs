//! The surface as a file, with what is known of each corner: PLY (binary) and VTK's legacy PolyData (text).

use std::fmt::Write;
use std::path::Path;

use bone::{Bone, Place, Sight};

/// The format of a surface's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Ply,
    Vtk,
}

impl Format {
    /// By the ending of a name.
    pub(super) fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "vtk" => Some(Self::Vtk),
            _ => None,
        }
    }
}

/// What is known of a corner, by its name.
type Known = (&'static str, fn(&Place) -> f64);

const KNOWN: [Known; 6] = [
    ("deviation_mm", |p| p.deviation_mm),
    ("shared_deviation_mm", |p| p.shared_mm),
    ("cortex_mm", |p| p.thickness_mm),
    ("cortex_log_deviation", |p| p.thickness_log_deviation),
    ("cortex_gain", |p| p.contrast.by_all),
    ("cortex_seen", |p| f64::from(u8::from(p.sight == Sight::Cortex))),
];

/// The bytes of the file: left, posterior, superior in mm, which its comment says as 3D Slicer does. Corners where cortex is not seen are
/// of no triangle: whatever program reads the surface registers to none of them.
pub(super) fn bytes(bone: &Bone, format: Format) -> Vec<u8> {
    match format {
        Format::Ply => ply(bone),
        Format::Vtk => vtk(bone).into_bytes(),
    }
}

fn ply(bone: &Bone) -> Vec<u8> {
    let properties: String = KNOWN
        .iter()
        .map(|(name, _)| format!("property float {name}\n"))
        .collect();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment SPACE=LPS\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         {properties}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        bone.places.len(),
        bone.triangles.len()
    )
    .into_bytes();
    for place in &bone.places {
        bytes.extend(place.mm.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(KNOWN.iter().flat_map(|(_, of)| (of(place) as f32).to_le_bytes()));
    }
    for corners in &bone.triangles {
        bytes.push(3);
        bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

fn vtk(bone: &Bone) -> String {
    let (count, faces) = (bone.places.len(), bone.triangles.len());
    let mut text = format!("# vtk DataFile Version 3.0\nSPACE=LPS\nASCII\nDATASET POLYDATA\nPOINTS {count} double\n");
    // Writing to a string does not fail.
    for place in &bone.places {
        let _ = writeln!(text, "{} {} {}", place.mm.x, place.mm.y, place.mm.z);
    }
    let _ = writeln!(text, "POLYGONS {faces} {}", 4 * faces);
    for [a, b, c] in &bone.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    let _ = writeln!(text, "POINT_DATA {count}");
    for (name, of) in KNOWN {
        let _ = writeln!(text, "SCALARS {name} float 1\nLOOKUP_TABLE default");
        for place in &bone.places {
            let _ = writeln!(text, "{}", of(place) as f32);
        }
    }
    text
}
