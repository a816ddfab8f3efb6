//! The inside of an organ on a lattice: where each of its places goes, and what a picture shows there.

use nalgebra::{Matrix3, Vector3};
use organs::body::{Body, displacement};
use organs::raw::RawSpaceField;
use simulation::space::cells::Field;
use simulation::space::law::Material;

use super::skin::Samples;

/// Free nodes, with weights, whose weighted displacements are a place's.
type Row = Vec<(u32, f64)>;

/// An organ on a lattice of places.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    pub(super) samples: Samples,
    /// Of each place the field: below 0 inside.
    pub(super) values: Vec<f64>,
    /// Cells with a corner inside, by the number of their first corner.
    pub(super) cells: Vec<usize>,
    /// Corners of cells, with what moves them; `None` where a corner lies outside all cubes.
    nodes: Vec<(usize, Option<Row>)>,
    material: Material,
}

/// A state of the lattice.
#[derive(Debug, Clone)]
pub(super) struct Moved {
    /// Displacements, of places that are corners of cells.
    pub(super) by: Vec<Vector3<f64>>,
    /// What is shown there; NaN where it is not known.
    pub(super) shown: Vec<f64>,
}

impl Lattice {
    pub(super) fn new(body: &Body, material: Material, samples: Samples) -> Self {
        let values: Vec<f64> = (0..samples.len())
            .map(|n| body.field.value(&samples.place(n)))
            .collect();
        let mut cells = Vec::new();
        let mut wanted = vec![false; samples.len()];
        for n in 0..samples.len() {
            let at = samples.at(n);
            if (0..3).any(|k| at[k] + 1 >= samples.size[k]) {
                continue;
            }
            let corners = corners(&samples, n);
            if corners.iter().any(|c| values[*c] < 0.0) {
                cells.push(n);
                corners.iter().for_each(|c| wanted[*c] = true);
            }
        }
        let nodes = (0..samples.len()).filter(|n| wanted[*n]);
        let nodes = nodes.map(|n| (n, body.mesh.row(&samples.place(n)))).collect();
        Self {
            samples,
            values,
            cells,
            nodes,
            material,
        }
    }

    /// The lattice in a state, with what `field` is there.
    pub(super) fn moved(&self, body: &Body, part: &[f64], field: RawSpaceField) -> Moved {
        let mut by = vec![Vector3::zeros(); self.samples.len()];
        let mut known = vec![false; self.samples.len()];
        for (n, row) in &self.nodes {
            if let Some(row) = row {
                by[*n] = displacement(row, part);
                known[*n] = true;
            }
        }
        for (n, row) in &self.nodes {
            if row.is_none() {
                by[*n] = self.beyond(*n, &by, &known);
            }
        }
        let mut shown = vec![f64::NAN; self.samples.len()];
        for (n, row) in &self.nodes {
            shown[*n] = match field {
                RawSpaceField::Displacement => by[*n].norm(),
                RawSpaceField::VonMises if row.is_some() => self.von_mises(body, *n, part),
                RawSpaceField::VonMises => f64::NAN,
            };
        }
        if field == RawSpaceField::VonMises {
            let inside = shown.clone();
            for (n, row) in &self.nodes {
                if row.is_none() {
                    let near: Vec<f64> = self.around(*n).map(|m| inside[m]).filter(|v| v.is_finite()).collect();
                    shown[*n] = near.iter().sum::<f64>() / near.len() as f64;
                }
            }
        }
        Moved { by, shown }
    }

    /// The displacement of a corner outside all cubes: linearly beyond two places along an axis, or as its neighbours'.
    fn beyond(&self, n: usize, by: &[Vector3<f64>], known: &[bool]) -> Vector3<f64> {
        let at = self.samples.at(n);
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let place = |steps: i64| {
                let mut to = at;
                to[axis] = usize::try_from(at[axis] as i64 + sign * steps).ok()?;
                let there = (to[axis] < self.samples.size[axis]).then(|| self.samples.number(to))?;
                known[there].then(|| by[there])
            };
            if let (Some(one), Some(two)) = (place(1), place(2)) {
                sum += one * 2.0 - two;
                count += 1.0;
            }
        }
        if count == 0.0 {
            for m in self.around(n).filter(|m| known[*m]) {
                sum += by[m];
                count += 1.0;
            }
        }
        if count == 0.0 { sum } else { sum / count }
    }

    /// The places around one, those of its cells.
    fn around(&self, n: usize) -> impl Iterator<Item = usize> + '_ {
        let at = self.samples.at(n).map(|x| x as i64);
        (0..27).filter_map(move |s: i64| {
            let to = [at[0] + s % 3 - 1, at[1] + s / 3 % 3 - 1, at[2] + s / 9 - 1];
            let inside = (0..3).all(|k| to[k] >= 0 && to[k] < self.samples.size[k] as i64);
            inside.then(|| self.samples.number(to.map(|x| x as usize)))
        })
    }

    /// Of Cauchy's stress. Pressures do not enter it, so that those of the elements' own dilatations are not needed where the law
    /// makes pressures of volumes alone.
    fn von_mises(&self, body: &Body, n: usize, part: &[f64]) -> f64 {
        let Some(slopes) = body.mesh.slopes_at(&self.samples.place(n)) else {
            return f64::NAN;
        };
        let mut gradient = Matrix3::zeros();
        for (node, slope) in slopes {
            let first = 3 * node as usize;
            gradient += Vector3::new(part[first], part[first + 1], part[first + 2]) * slope.transpose();
        }
        let deformation = Matrix3::identity() + gradient;
        let Some((_, stress)) = self.material.stress(&gradient) else {
            return f64::NAN;
        };
        let first_piola = Matrix3::from_column_slice(stress.as_slice());
        let cauchy = first_piola * deformation.transpose() / deformation.determinant();
        let deviator = cauchy - Matrix3::identity() * (cauchy.trace() / 3.0);
        (1.5_f64).sqrt() * deviator.norm()
    }
}

/// The corners of a cell, of its first one.
pub(super) fn corners(samples: &Samples, first: usize) -> [usize; 8] {
    let (x, y, z) = (1, samples.size[0], samples.size[0] * samples.size[1]);
    [0, x, y, x + y, z, x + z, y + z, x + y + z].map(|by| first + by)
}

/// The six tetrahedra of a cell about its diagonal, which meet those of its neighbours edge to edge (Freudenthal).
pub(super) const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 1, 5, 7],
    [0, 2, 3, 7],
    [0, 2, 6, 7],
    [0, 4, 5, 7],
    [0, 4, 6, 7],
];
