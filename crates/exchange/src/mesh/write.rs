//! From a surface to the bytes of a file.

use std::fmt::Write;

use super::{Mesh, MeshError, MeshFormat};
use crate::PatientAxes;

/// The bytes of a file of this format whose coordinates are along these axes, in mm, which its comment says as 3D Slicer does. STL and
/// PLY are binary, with 32 and 64 bits a coordinate; OBJ and VTK are text, each number with the digits that bring back every bit. So
/// STL alone rounds: at 1000 mm to 3e-5 mm.
///
/// # Errors
/// [`MeshError::Unwritable`].
pub fn write(mesh: &Mesh, format: MeshFormat, axes: PatientAxes) -> Result<Vec<u8>, MeshError> {
    let count = mesh.points.len();
    let is_in = |corner: &u32| (*corner as usize) < count;
    if let Some(place) = mesh.triangles.iter().position(|corners| !corners.iter().all(is_in)) {
        return Err(MeshError::Unwritable {
            triangle: place + 1,
            count,
        });
    }
    let points: Vec<[f64; 3]> = mesh.points.iter().map(|point| axes.turned(point.mm())).collect();
    let space = format!("SPACE={}", axes.name());
    Ok(match format {
        MeshFormat::Stl => stl(mesh, &points, &space),
        MeshFormat::Ply => ply(mesh, &points, &space),
        MeshFormat::Obj => obj(mesh, &points, &space).into_bytes(),
        MeshFormat::Vtk => vtk(mesh, &points, &space).into_bytes(),
    })
}

fn stl(mesh: &Mesh, points: &[[f64; 3]], space: &str) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    // Not `solid`: readers that look at the first word alone would take it for text.
    let words = format!("trocar {space}");
    bytes[..words.len()].copy_from_slice(words.as_bytes());
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in &mesh.triangles {
        let corners = corners.map(|corner| points[corner as usize]);
        for number in normal(corners).into_iter().chain(corners.into_iter().flatten()) {
            bytes.extend((number as f32).to_le_bytes());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// Of unit length, by the order of the corners; zeros where they have no area, as the format has it.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|corner| [0, 1, 2].map(|i| corner[i] - a[i]));
    let across = [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] - u[k] * v[j]
    });
    let length = across.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        across.map(|x| x / length)
    } else {
        [0.0; 3]
    }
}

fn ply(mesh: &Mesh, points: &[[f64; 3]], space: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {space}\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    bytes.extend(points.iter().flatten().flat_map(|number| number.to_le_bytes()));
    for corners in &mesh.triangles {
        bytes.push(3);
        bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

fn obj(mesh: &Mesh, points: &[[f64; 3]], space: &str) -> String {
    let mut text = format!("# {space}\n");
    // Writing to a string does not fail.
    for [x, y, z] in points {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in mesh
        .triangles
        .iter()
        .map(|corners| corners.map(|corner| u64::from(corner) + 1))
    {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

fn vtk(mesh: &Mesh, points: &[[f64; 3]], space: &str) -> String {
    let (count, faces) = (points.len(), mesh.triangles.len());
    let mut text = format!("# vtk DataFile Version 3.0\n{space}\nASCII\nDATASET POLYDATA\nPOINTS {count} double\n");
    for [x, y, z] in points {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    let _ = writeln!(text, "POLYGONS {faces} {}", 4 * faces);
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}
