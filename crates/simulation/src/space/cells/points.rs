//! Points inside a mesh, and how free nodes move a place.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::eighths::Eighths;
use super::grid::Cell;
use super::mesh::Mesh;
use super::parts::{SurfacePoint, VolumePoint};
use super::shape::{gradients, values};

impl Mesh {
    /// Free nodes, with weights, whose weighted displacements are that of a place. `None` outside all cubes.
    pub fn row(&self, at: &Vector3<f64>) -> Option<Vec<(u32, f64)>> {
        let cell = self.grid.containing(at)?;
        let number = self.cells.binary_search(&cell).ok()?;
        Some(self.row_in(number, at))
    }

    /// Free nodes with the derivatives of their weights in a place's displacement by the reference position. `None` outside all
    /// cubes.
    pub fn slopes_at(&self, at: &Vector3<f64>) -> Option<Vec<(u32, Vector3<f64>)>> {
        let cell = self.grid.containing(at)?;
        let number = self.cells.binary_search(&cell).ok()?;
        Some(self.slopes_in(number, at))
    }

    /// Free nodes with the derivatives of their weights in a point's displacement by the reference position.
    pub fn slopes(&self, point: &VolumePoint) -> Vec<(u32, Vector3<f64>)> {
        self.slopes_in(point.cell as usize, &point.at)
    }

    /// The same of a point of the surface.
    pub fn surface_slopes(&self, point: &SurfacePoint) -> Vec<(u32, Vector3<f64>)> {
        self.slopes_in(point.cell as usize, &point.at)
    }

    fn slopes_in(&self, cell: usize, at: &Vector3<f64>) -> Vec<(u32, Vector3<f64>)> {
        let scale = 2.0 / self.grid.length(self.cells[cell].span);
        let slopes = gradients(self.order, self.grid.local(&self.cells[cell], at));
        let mut sum: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
        for (node, slope) in self.ties.of_cell[cell].iter().zip(slopes) {
            for (free, part) in &self.ties.ties[*node as usize] {
                *sum.entry(*free).or_insert_with(Vector3::zeros) += slope * (scale * part);
            }
        }
        sum.into_iter().collect()
    }

    /// Free nodes with their weights in a point's displacement.
    pub fn point_row(&self, point: &VolumePoint) -> Vec<(u32, f64)> {
        self.row_in(point.cell as usize, &point.at)
    }

    /// The cubes, in the order of their corners: what numbers of cubes count.
    pub fn cubes(&self) -> &[Cell] {
        &self.cells
    }

    /// The displacements at the 27 places of a cube's corners and of the middles between them, in the order of
    /// [`crate::space::element::shape`]; of 8 nodes by their shape functions.
    pub fn nodal(&self, cube: usize, a: &[f64]) -> Vec<[f64; 3]> {
        let one = |node: &u32| {
            let mut sum = [0.0; 3];
            for (free, weight) in &self.ties.ties[*node as usize] {
                (0..3).for_each(|k| sum[k] += weight * a[3 * *free as usize + k]);
            }
            sum
        };
        let own: Vec<[f64; 3]> = self.ties.of_cell[cube].iter().map(one).collect();
        let at = |k: usize| [k % 3, k / 3 % 3, k / 9].map(|i| i as f64 - 1.0);
        let value = |k: usize| {
            let mut sum = [0.0; 3];
            for (u, weight) in own.iter().zip(values(self.order, at(k))) {
                (0..3).for_each(|axis| sum[axis] += weight * u[axis]);
            }
            sum
        };
        (0..27).map(value).collect()
    }

    /// Of each cube whether the surface leaves it alone: its points stand for all of its volume.
    pub(in crate::space) fn whole_cubes(&self) -> Vec<bool> {
        let mut held = vec![0.0; self.cells.len()];
        for point in &self.points {
            held[point.cell as usize] += point.volume;
        }
        let volumes = self.cells.iter().map(|cell| self.grid().length(cell.span).powi(3));
        // Volumes of rules are right to 1e-9; a cut that takes less than a millionth is none that matters.
        volumes
            .zip(held)
            .map(|(all, held)| held >= (1.0 - 1e-6) * all)
            .collect()
    }

    /// Where a cube that the surface cuts holds some of the region; `None` of a whole one.
    pub(in crate::space) fn inside(&self, cube: usize) -> Option<&Eighths> {
        self.inside[cube].as_ref()
    }

    /// Of each cube the points of the surface in it, in the cube's own places from -1 to 1 along each axis.
    pub(in crate::space) fn surface_by_cube(&self) -> Vec<Vec<[f64; 3]>> {
        let mut all = vec![Vec::new(); self.cells.len()];
        for point in &self.surface {
            let cube = point.cell as usize;
            let [low, high] = self.grid.corners(&self.cells[cube]);
            let place = (point.at - low).component_div(&(high - low)) * 2.0;
            all[cube].push(place.add_scalar(-1.0).into());
        }
        all
    }

    /// Where the middle of a cube is moved to.
    pub(in crate::space) fn middle(&self, cube: usize, a: &[f64]) -> Vector3<f64> {
        let [low, high] = self.grid().corners(&self.cells[cube]);
        let mut at = 0.5 * (low + high);
        let weights = values(self.order, [0.0; 3]);
        let moving = self.ties.of_cell[cube].iter().zip(weights).filter(|(_, w)| *w != 0.0);
        for (node, weight) in moving {
            for (free, tied) in &self.ties.ties[*node as usize] {
                (0..3).for_each(|k| at[k] += weight * tied * a[3 * *free as usize + k]);
            }
        }
        at
    }

    /// Of each element its cubes, by number, and its points in the order of its table.
    pub fn parts(&self) -> Vec<(Vec<usize>, Vec<VolumePoint>)> {
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (cube, root) in self.ties.root.iter().enumerate() {
            groups.entry(*root).or_default().push(cube);
        }
        let first = |cube: usize| self.points.partition_point(|p| (p.cell as usize) < cube);
        let points = |cubes: &[usize]| {
            let each = cubes.iter().flat_map(|c| &self.points[first(*c)..first(c + 1)]);
            each.copied().collect()
        };
        groups
            .into_values()
            .map(|cubes| (cubes.clone(), points(&cubes)))
            .collect()
    }

    /// Forces on the unknowns of a force by reference volume.
    pub fn spread(&self, force: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Vec<f64> {
        let mut forces = vec![0.0; self.unknowns()];
        for point in self.points() {
            let force = force(&point.at) * point.volume;
            for (node, weight) in self.point_row(point) {
                (0..3).for_each(|k| forces[3 * node as usize + k] += weight * force[k]);
            }
        }
        forces
    }

    /// Weights of the free nodes at a place by the shape functions of a cube, which the place may lie outside of.
    pub(super) fn row_in(&self, cell: usize, at: &Vector3<f64>) -> Vec<(u32, f64)> {
        let weights = values(self.order, self.grid.local(&self.cells[cell], at));
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (node, weight) in self.ties.of_cell[cell].iter().zip(weights) {
            for (free, part) in &self.ties.ties[*node as usize] {
                *sum.entry(*free).or_insert(0.0) += weight * part;
            }
        }
        sum.into_iter().collect()
    }
}
