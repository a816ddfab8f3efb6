//! Meshes of the same region with cubes of another halved, and its state as the first guess there.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::space::cells::{Cell, Field, Grid, Mesh, NoMesh, Settings};

/// The mesh of a region with all cubes of a mesh of it halved, or those of `which`. Neighbours are halved too where sizes
/// would differ by more than one level. Field, box and settings are those that `mesh` was made with.
///
/// # Errors
/// [`NoMesh`], as [`Mesh::new`].
pub fn halved(
    mesh: &Mesh,
    field: &dyn Field,
    corners: [Vector3<f64>; 2],
    settings: &Settings,
    which: Option<&BTreeSet<Cell>>,
) -> Result<Mesh, NoMesh> {
    let grid = mesh.grid();
    let fine = |low: &Vector3<f64>, high: &Vector3<f64>| is_cut(grid, settings.side, low, high, which);
    let settings = Settings {
        levels: settings.levels + 1,
        ..*settings
    };
    Mesh::new(field, corners, &settings, &fine)
}

/// Whether a cube is to be cut so that at last cubes of the grid, or those of `which`, are halved once.
fn is_cut(grid: &Grid, largest: f64, low: &Vector3<f64>, high: &Vector3<f64>, which: Option<&BTreeSet<Cell>>) -> bool {
    let side = high.x - low.x;
    // In the middle of one of its eighths: on no face of what is as large or smaller.
    let old = grid.containing(&(low + (high - low) * 0.25));
    let middle = grid.containing(&((low + high) * 0.5));
    match old.or(middle) {
        // Sides are powers of two apart: 0.75 tells them.
        Some(cell) if grid.length(cell.span) < 0.75 * side => true,
        Some(cell) if grid.length(cell.span) < 1.5 * side => which.is_none_or(|which| which.contains(&cell)),
        Some(_) => false,
        None => which.is_none() && side > 0.75 * largest,
    }
}

/// Displacements of the free nodes of another mesh of the same region by those of this one: the first guess of a search
/// there. Nodes outside all cubes of the first mesh move as the nearest place in one.
pub fn taken_over(from: &Mesh, a: &[f64], to: &Mesh) -> Vec<f64> {
    to.nodes
        .iter()
        .flat_map(|at| <[f64; 3]>::from(displacement(from, a, at)))
        .collect()
}

/// The displacement of a place of the reference configuration, or of the nearest place in a cube.
pub(super) fn displacement(mesh: &Mesh, a: &[f64], at: &Vector3<f64>) -> Vector3<f64> {
    let row = mesh.row(at).or_else(|| mesh.row(&nearest(mesh.grid(), at)));
    let mut sum = Vector3::zeros();
    for (node, weight) in row.into_iter().flatten() {
        (0..3).for_each(|k| sum[k] += weight * a[3 * node as usize + k]);
    }
    sum
}

fn nearest(grid: &Grid, at: &Vector3<f64>) -> Vector3<f64> {
    let mut best = (f64::INFINITY, *at);
    for cell in grid.cells() {
        let [low, high] = grid.corners(&cell);
        // A little inside: on a face rounding might lead out again.
        let inset = (high - low) * 1e-9;
        let place = at.sup(&(low + inset)).inf(&(high - inset));
        // A cube that holds a node of the finer mesh may not exist in the coarser, where it was all but empty.
        let far = (place - at).norm_squared();
        if far < best.0 {
            best = (far, place);
        }
    }
    best.1
}
