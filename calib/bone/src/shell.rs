//! The threshold's surface of one body: topology, and where it is no bone's own surface.

use nalgebra::Vector3;
use surface::nets::{Lattice, extract};

use crate::error::Refused;
use crate::voxels::Crop;

/// Triangles at most: as many as are drawn and registered with.
pub const MOST_TRIANGLES: usize = surface::MOST_TRIANGLES;

/// Triangles, anticlockwise seen from outside.
pub(crate) struct Shell {
    /// mm.
    pub(crate) corners: Vec<Vector3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether the CT, or the region, ends at a corner.
    pub(crate) edge: Vec<Edge>,
    /// Triangles of cavities that the filling left, which are not in `triangles`.
    pub(crate) inner: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edge {
    /// Bone beside what is none.
    None,
    /// The CT ends.
    End,
    /// What is as bright as bone goes on: it belongs to something else.
    Cut,
    /// Bone is nearly all around before it.
    Inner,
}

/// The outer surfaces of what is 1 in `mask`.
pub(crate) fn shell(crop: &Crop, mask: &[u8], level: f64) -> Result<Shell, Refused> {
    let [nx, ny, nz] = crop.dims;
    let lattice = Lattice {
        dims: crop.dims.map(|n| n as u32),
        ct_from_sample: geometry::Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
        level: level as f32,
        most: MOST_TRIANGLES,
    };
    let mesh = extract(&lattice, |z, values, _| {
        let first = z as usize * nx * ny;
        for (i, value) in values.iter_mut().enumerate() {
            let hu = f32::from(crop.hu[first + i]);
            let is_bright = f64::from(crop.hu[first + i]) >= level;
            *value = match (mask[first + i] == 1, is_bright) {
                (true, true) | (false, false) => hu,
                // Marrow is inside whatever its HU; what else is bright is outside. Neither says where between the two a surface lies.
                (true, false) => f32::INFINITY,
                (false, true) => f32::NAN,
            };
        }
        Ok(())
    })?;
    debug_assert!(nz > 0);
    let edge: Vec<Edge> = mesh.points().iter().map(|p| edge(crop, mask, level, *p)).collect();
    let corners: Vec<Vector3<f64>> = mesh
        .points()
        .iter()
        .map(|p| crop.mm(Vector3::from(p.map(f64::from))))
        .collect();
    // The surface was made in indices; a grid that is left-handed mirrors it.
    let is_mirrored = crop.steps.determinant() < 0.0;
    let triangles = mesh
        .triangles()
        .iter()
        .map(|[a, b, c]| if is_mirrored { [*a, *c, *b] } else { [*a, *b, *c] });
    let triangles: Vec<[u32; 3]> = triangles.collect();
    let edge = widened(&edge, &triangles);
    outer(corners, triangles, edge)
}

/// Corners beside an end belong to it as well: half of what would tell how the surface lies there is missing.
fn widened(edge: &[Edge], triangles: &[[u32; 3]]) -> Vec<Edge> {
    let mut wide = edge.to_vec();
    for t in triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
            let end = edge[t[from] as usize];
            let slot = &mut wide[t[to] as usize];
            if end != Edge::None && *slot == Edge::None {
                *slot = end;
            }
        }
    }
    wide
}

/// What the cell of a corner touches.
fn edge(crop: &Crop, mask: &[u8], level: f64, point: [f32; 3]) -> Edge {
    let base = point.map(|x| x.floor() as i64);
    let mut cut = false;
    for corner in 0..8_usize {
        let at = [0, 1, 2].map(|k| base[k] + (corner >> k & 1) as i64);
        let is_beyond =
            |k: usize| (at[k] < 0 && crop.is_end[k][0]) || (at[k] >= crop.dims[k] as i64 && crop.is_end[k][1]);
        if (0..3).any(is_beyond) {
            return Edge::End;
        }
        if (0..3).all(|k| at[k] >= 0 && at[k] < crop.dims[k] as i64) {
            let offset = crop.offset(at.map(|k| k as usize));
            if crop.is_gap(offset) {
                return Edge::End;
            }
            cut |= mask[offset] == 0 && f64::from(crop.hu[offset]) >= level;
        }
    }
    if cut { Edge::Cut } else { Edge::None }
}

/// Parts that enclose something, and not those that are the walls of cavities.
fn outer(corners: Vec<Vector3<f64>>, triangles: Vec<[u32; 3]>, edge: Vec<Edge>) -> Result<Shell, Refused> {
    let mut parent: Vec<u32> = (0..corners.len() as u32).collect();
    for t in &triangles {
        for pair in [[t[0], t[1]], [t[1], t[2]]] {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut volume = vec![0.0; corners.len()];
    let middle = corners.first().copied().unwrap_or_else(Vector3::zeros);
    for t in &triangles {
        let [a, b, c] = t.map(|i| corners[i as usize] - middle);
        volume[root(&mut parent, t[0]) as usize] += a.dot(&b.cross(&c)) / 6.0;
    }
    let keep: Vec<bool> = (0..corners.len() as u32)
        .map(|i| volume[root(&mut parent, i) as usize] > 0.0)
        .collect();
    let before = triangles.len();
    let kept: Vec<[u32; 3]> = triangles.into_iter().filter(|t| keep[t[0] as usize]).collect();
    let mut new_of = vec![u32::MAX; corners.len()];
    let (mut places, mut edges) = (Vec::new(), Vec::new());
    for i in 0..corners.len() {
        if keep[i] {
            new_of[i] = places.len() as u32;
            places.push(corners[i]);
            edges.push(edge[i]);
        }
    }
    Ok(Shell {
        corners: places,
        inner: before - kept.len(),
        triangles: kept.into_iter().map(|t| t.map(|i| new_of[i as usize])).collect(),
        edge: edges,
    })
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}
