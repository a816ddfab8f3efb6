//! Points of the region's surface, and what moves them.

use nalgebra::Vector3;

use super::mesh::Mesh;
use super::parts::SurfacePoint;
use super::rule::gauss;
use crate::space::gap::gap_of;

impl Mesh {
    /// Free nodes, with weights, whose weighted displacements are that of a point of the surface.
    pub fn surface_row(&self, point: &SurfacePoint) -> Vec<(u32, f64)> {
        self.row_in(point.cell as usize, &point.at)
    }
}

/// Points of the faces of whole cubes that no cube lies beyond: where the region ends with the grid.
pub(super) fn faces(mesh: &Mesh, whole: &[bool]) -> Vec<SurfacePoint> {
    let numbers = (0..mesh.cells.len()).filter(|k| whole[*k]);
    numbers.flat_map(|number| faces_of(mesh, number, 1)).collect()
}

/// The same of one cube, each face in so many parts along its sides.
pub(super) fn faces_of(mesh: &Mesh, number: usize, parts: usize) -> Vec<SurfacePoint> {
    let (cell, mut points) = (&mesh.cells[number], Vec::new());
    let [low, high] = mesh.grid.corners(cell);
    for (axis, up) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
        let mut beyond = cell.corner;
        beyond[axis] += if up { cell.span } else { -1 };
        if mesh.grid.cell_at(beyond).is_none() && !any_smaller(mesh, beyond, axis, cell.span) {
            for [low, high] in squares([low, high], axis, parts) {
                points.extend(face(number, &low, &high, axis, up));
            }
        }
    }
    points
}

/// A box in so many parts along both axes but one.
fn squares([low, high]: [Vector3<f64>; 2], axis: usize, parts: usize) -> Vec<[Vector3<f64>; 2]> {
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    let part = |n: usize| {
        let (mut from, mut to) = (low, high);
        for (k, number) in [(a, n % parts), (b, n / parts)] {
            let at = |i: usize| low[k] + (high[k] - low[k]) * (i as f64 / parts as f64);
            (from[k], to[k]) = (at(number), at(number + 1));
        }
        [from, to]
    };
    (0..parts * parts).map(part).collect()
}

/// Whether smaller cubes lie behind a face of which the first step beyond is given.
fn any_smaller(mesh: &Mesh, beyond: [i32; 3], axis: usize, span: i32) -> bool {
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    [[0, 0], [1, 0], [0, 1], [1, 1]].iter().any(|part| {
        let mut at = beyond;
        at[a] += part[0] * span / 2;
        at[b] += part[1] * span / 2;
        mesh.grid.cell_at(at).is_some()
    })
}

fn face(cell: usize, low: &Vector3<f64>, high: &Vector3<f64>, axis: usize, up: bool) -> Vec<SurfacePoint> {
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    let side = high - low;
    let mut normal = Vector3::zeros();
    normal[axis] = if up { 1.0 } else { -1.0 };
    let mut points = Vec::new();
    for (x, wx) in gauss(4) {
        for (y, wy) in gauss(4) {
            let mut at = if up { *high } else { *low };
            at[a] = low[a] + side[a] * x;
            at[b] = low[b] + side[b] * y;
            let area = side[a] * side[b] * wx * wy;
            points.push(SurfacePoint {
                cell: cell as u32,
                at,
                normal,
                area,
                gap: gap_of(area),
            });
        }
    }
    points
}
