//! Normal and curvature of a surface of triangles at each corner: a quadric through the corners around it.

use nalgebra::{Matrix2, Matrix6, SymmetricEigen, Vector2, Vector3, Vector6};

/// Corners that a quadric is laid through at most.
const MOST_AROUND: usize = 80;
/// The greatest curvature, 1/mm: no bone's outer surface is sharper than a radius of 2 mm over the reach of a patch.
const MOST_CURVATURE: f64 = 0.5;
/// A corner whose normal is turned by more from that in the middle belongs to another side of the bone.
const LEAST_COSINE: f64 = 0.3;

/// A surface near one of its corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quadric {
    /// A place on it, mm.
    pub(crate) foot: Vector3<f64>,
    /// Outwards, of length 1.
    pub(crate) normal: Vector3<f64>,
    /// Directions of the principal curvatures.
    pub(crate) axes: [Vector3<f64>; 2],
    /// Principal curvatures, 1/mm: above 0 where it bends away from the normal, as a ball does.
    pub(crate) curvature: [f64; 2],
}

/// Corners that share an edge, of each corner, in one list.
pub(crate) struct Adjacent {
    first: Vec<u32>,
    others: Vec<u32>,
}

impl Adjacent {
    pub(crate) fn new(corners: usize, triangles: &[[u32; 3]]) -> Self {
        let mut pairs: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|[a, b, c]| [(*a, *b), (*b, *a), (*b, *c), (*c, *b), (*c, *a), (*a, *c)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut first = vec![0_u32; corners + 1];
        for (from, _) in &pairs {
            first[*from as usize + 1] += 1;
        }
        for i in 0..corners {
            first[i + 1] += first[i];
        }
        Self {
            first,
            others: pairs.into_iter().map(|(_, to)| to).collect(),
        }
    }

    pub(crate) fn of(&self, corner: usize) -> &[u32] {
        &self.others[self.first[corner] as usize..self.first[corner + 1] as usize]
    }

    /// The corner itself and those within `reach` mm that hang together with it, the nearest rings first.
    pub(crate) fn around(&self, corners: &[Vector3<f64>], corner: usize, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        found.push(corner as u32);
        let mut next = 0;
        while next < found.len() && found.len() < MOST_AROUND {
            for other in self.of(found[next] as usize) {
                // At most 80: a search through them is quicker than any set.
                let near = (corners[*other as usize] - corners[corner]).norm() <= reach;
                if near && !found.contains(other) {
                    found.push(*other);
                }
            }
            next += 1;
        }
    }
}

/// Normals of corners: the sum of the triangles' around, by area.
pub(crate) fn normals(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); corners.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| corners[i as usize]);
        let across = (b - a).cross(&(c - a));
        t.iter().for_each(|i| normals[*i as usize] += across);
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    }
    normals
}

/// The quadric of least squares at a corner; `None` where too few corners are around it. Corners count by a Gaussian of 0.6 of the reach.
pub(crate) fn quadric(
    corners: &[Vector3<f64>],
    normals: &[Vector3<f64>],
    adjacent: &Adjacent,
    corner: usize,
    reach: f64,
    found: &mut Vec<u32>,
) -> Option<Quadric> {
    adjacent.around(corners, corner, reach, found);
    let middle = corners[corner];
    // The mean of the normals around: a corner's own is as rough as its triangles.
    let mean: Vector3<f64> = found
        .iter()
        .map(|i| normals[*i as usize])
        .filter(|n| n.dot(&normals[corner]) > LEAST_COSINE)
        .sum();
    let up = mean.try_normalize(1e-12)?;
    let side = if up.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let u = up.cross(&side).try_normalize(0.0)?;
    let v = up.cross(&u);
    let (mut matrix, mut right, mut count) = (Matrix6::zeros(), Vector6::zeros(), 0);
    for i in found.iter().map(|i| *i as usize) {
        if normals[i].dot(&up) < LEAST_COSINE {
            continue;
        }
        let d = corners[i] - middle;
        let (x, y, z) = (d.dot(&u), d.dot(&v), d.dot(&up));
        let weight = (-0.5 * (x * x + y * y) / (0.6 * reach).powi(2)).exp();
        let row = Vector6::new(1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y);
        matrix += weight * row * row.transpose();
        right += weight * z * row;
        count += 1;
    }
    if count < 8 {
        return None;
    }
    let c = matrix.cholesky()?.solve(&right);
    // Of a graph with slope the curvature is the second derivative over (1 + slope^2)^(3/2), to first order in the slope's square.
    let slope = 1.0 + c[1] * c[1] + c[2] * c[2];
    let normal = (up - u * c[1] - v * c[2]).try_normalize(0.0)?;
    let bend = SymmetricEigen::new(-Matrix2::new(c[3], c[4], c[4], c[5]) / slope.sqrt());
    let e: Vector2<f64> = bend.eigenvectors.column(0).into();
    let raw = u * e.x + v * e.y;
    let first = (raw - normal * raw.dot(&normal)).try_normalize(0.0)?;
    Some(Quadric {
        foot: middle + up * c[0],
        normal,
        axes: [first, normal.cross(&first)],
        curvature: [0, 1].map(|k| bend.eigenvalues[k].clamp(-MOST_CURVATURE, MOST_CURVATURE)),
    })
}
