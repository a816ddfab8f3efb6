//! Points of a surface that a tube may touch, as functions of the unknowns of the nodes that move them.

use nalgebra::{DMatrix, Vector3};

use super::settings::NoFrames;
use crate::space::system::System;
use crate::space::tube::{Distance, Tube};

/// A point, its area in the reference configuration, and where its nodes begin.
#[derive(Debug, Clone, Copy)]
struct Touch {
    at: Vector3<f64>,
    area: f64,
    first: usize,
}

/// Points and the nodes that move them: `at + sum of weights times displacements`.
#[derive(Debug, Clone, Default)]
pub(super) struct Touches {
    /// The first unknown of each node; those after it are the next two.
    nodes: Vec<usize>,
    /// 1, or 0 where it is held, of each unknown of the nodes.
    free: Vec<f64>,
    points: Vec<Touch>,
    /// Number of a node among the nodes, and its weight.
    rows: Vec<(u32, f64)>,
}

impl Touches {
    /// Points of a solid for which `wanted(reference place, normal)` holds.
    pub(super) fn new(
        system: &System,
        body: usize,
        wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
    ) -> Result<Self, NoFrames> {
        let (solid, offset) = (system.bodies.solid(body), system.bodies.offset(body));
        let (mut points, mut global) = (Vec::new(), Vec::new());
        for point in 0..solid.points() {
            let (at, normal, area) = solid.reference(point);
            if wanted(&at, &normal) {
                // Weights of zero would tie nodes to the root that nothing moves.
                let row = solid.combination(point).ok_or(NoFrames::NotNodal { body, point })?;
                let first = global.len();
                global.extend(row.iter().filter(|(_, weight)| *weight != 0.0));
                points.push(Touch { at, area, first });
            }
        }
        let mut nodes: Vec<u32> = global.iter().map(|(node, _)| *node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        if points.is_empty() {
            return Err(NoFrames::NoPoint { body });
        }
        // Nodes in ascending order: their unknowns lie in the root as they do in the system.
        let rows = global
            .iter()
            .map(|(node, weight)| (nodes.partition_point(|n| n < node) as u32, *weight));
        let rows = rows.collect();
        let nodes: Vec<usize> = nodes.iter().map(|n| offset + 3 * *n as usize).collect();
        let each = nodes.iter().flat_map(|n| *n..n + 3);
        Ok(Self {
            free: each.map(|i| if system.fixed[i] { 0.0 } else { 1.0 }).collect(),
            nodes,
            points,
            rows,
        })
    }

    /// Some of the points alone, and the nodes (numbered as here) that move them.
    pub(super) fn only(&self, points: &[usize]) -> (Self, Vec<usize>) {
        let rows = points.iter().flat_map(|point| self.row(*point));
        let mut nodes: Vec<usize> = rows.map(|(node, _)| *node as usize).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut only = Self {
            nodes: nodes.iter().map(|n| self.nodes[*n]).collect(),
            free: nodes
                .iter()
                .flat_map(|n| &self.free[3 * n..3 * n + 3])
                .copied()
                .collect(),
            points: Vec::with_capacity(points.len()),
            rows: Vec::new(),
        };
        // Areas and reference places are those of the point, rows those of fewer nodes.
        for point in points {
            let first = only.rows.len();
            let row = self.row(*point).iter();
            only.rows
                .extend(row.map(|(node, weight)| (nodes.partition_point(|n| n < &(*node as usize)) as u32, *weight)));
            only.points.push(Touch {
                first,
                ..self.points[*point]
            });
        }
        (only, nodes)
    }

    /// How many points.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// How many nodes move them.
    pub(super) fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Their unknowns, in the order in which vectors here have them.
    pub(super) fn unknowns(&self) -> Vec<usize> {
        self.nodes.iter().flat_map(|n| *n..n + 3).collect()
    }

    /// These unknowns among all.
    pub(super) fn take(&self, a: &[f64], v: &mut Vec<f64>) {
        v.clear();
        self.nodes.iter().for_each(|n| v.extend_from_slice(&a[*n..n + 3]));
    }

    /// Adds a vector of these unknowns to one of all.
    pub(super) fn add(&self, v: &[f64], all: &mut [f64]) {
        for (n, v) in self.nodes.iter().zip(v.chunks_exact(3)) {
            all[*n..n + 3].iter_mut().zip(v).for_each(|(a, v)| *a += v);
        }
    }

    /// Area of a point, mm^2.
    pub(super) fn area(&self, point: usize) -> f64 {
        self.points[point].area
    }

    /// The mean area of a point.
    pub(super) fn mean_area(&self) -> f64 {
        self.points.iter().map(|p| p.area).sum::<f64>() / self.points.len().max(1) as f64
    }

    fn row(&self, point: usize) -> &[(u32, f64)] {
        let end = self.points.get(point + 1).map_or(self.rows.len(), |next| next.first);
        &self.rows[self.points[point].first..end]
    }

    /// Where a point is.
    pub(super) fn at(&self, point: usize, v: &[f64]) -> Vector3<f64> {
        self.points[point].at + self.displacement(point, v)
    }

    /// How far it is moved.
    pub(super) fn displacement(&self, point: usize, v: &[f64]) -> Vector3<f64> {
        let mut at = Vector3::zeros();
        for (node, weight) in self.row(point) {
            let u = &v[3 * *node as usize..3 * *node as usize + 3];
            (0..3).for_each(|k| at[k] += weight * u[k]);
        }
        at
    }

    /// Its distance to a tube.
    pub(super) fn distance(&self, point: usize, v: &[f64], tube: &Tube) -> Distance {
        tube.signed_distance(&self.at(point, v))
    }

    /// Adds a force on a point to those on its free unknowns.
    pub(super) fn push(&self, point: usize, force: &Vector3<f64>, forces: &mut [f64]) {
        for (node, weight) in self.row(point) {
            let first = 3 * *node as usize;
            (0..3).for_each(|k| forces[first + k] += weight * force[k] * self.free[first + k]);
        }
    }

    /// Adds the stiffness of a point to the lower triangle of a matrix of the unknowns.
    pub(super) fn stiffen(&self, point: usize, stiffness: &nalgebra::Matrix3<f64>, matrix: &mut DMatrix<f64>) {
        // Nodes are in ascending order within a row: blocks with `i >= j` are those on and below the diagonal.
        let row = self.row(point);
        for (i, (node, weight)) in row.iter().enumerate() {
            for (other, by) in &row[..=i] {
                let (node, other) = (3 * *node.max(other) as usize, 3 * *node.min(other) as usize);
                let product = weight * by;
                for l in 0..3 {
                    let product = product * self.free[other + l];
                    for k in 0..3 {
                        matrix[(node + k, other + l)] += product * self.free[node + k] * stiffness[(k, l)];
                    }
                }
            }
        }
    }
}
