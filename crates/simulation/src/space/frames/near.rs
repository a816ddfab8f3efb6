//! The points at the tube, and how forces on them move one another: the compliance of tissue that contact is solved by.

use nalgebra::DMatrix;

use super::touch::Touches;
use crate::sparse::{Combinations, Ldl};

/// Some of the points, and `W = B A^-1 B^T` with their displacements for the rows of `B`, three each, and `A` the matrix of a factor.
#[derive(Debug, Clone)]
pub(super) struct Near {
    /// Ascending.
    points: Vec<usize>,
    w: DMatrix<f64>,
}

impl Default for Near {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            w: DMatrix::zeros(0, 0),
        }
    }
}

impl Near {
    /// These points, in ascending order, by a factor.
    pub(super) fn new(ldl: &Ldl, touches: &Touches, points: Vec<usize>) -> Self {
        let nodes = touches.nodes_of(&points);
        let mut combinations = Combinations::default();
        // By the fewer of the two: several points of a face share its nodes, a point of a cut cube has all of them.
        let by_nodes = nodes.len() < points.len();
        if by_nodes {
            let each = nodes.iter().flat_map(|node| (0..3).map(|k| touches.unknown(*node, k)));
            each.for_each(|unknown| combinations.push(unknown.into_iter()));
        } else {
            let each = points
                .iter()
                .flat_map(|point| (0..3).map(|k| touches.combination(*point, k)));
            each.for_each(|combination| combinations.push(combination));
        }
        let found = ldl.compliance(&combinations);
        let w = match by_nodes {
            true => of_points(&found, touches, &points, &nodes),
            false => found,
        };
        Self { points, w }
    }

    /// The points.
    pub(super) fn points(&self) -> &[usize] {
        &self.points
    }

    /// The number of a point among them.
    pub(super) fn index(&self, point: usize) -> Option<usize> {
        self.points.binary_search(&point).ok()
    }

    /// Displacements by forces, three of each point.
    pub(super) fn compliance(&self) -> &DMatrix<f64> {
        &self.w
    }

    /// `W f`, where most of `f` is zero.
    pub(super) fn moved(&self, f: &[f64]) -> Vec<f64> {
        let mut moved = vec![0.0; f.len()];
        // Few points press at once, of many that are near.
        for (f, column) in f.iter().zip(self.w.column_iter()).filter(|(f, _)| **f != 0.0) {
            moved.iter_mut().zip(column.iter()).for_each(|(m, w)| *m += w * f);
        }
        moved
    }
}

/// The compliance of points by that of the nodes which move them.
fn of_points(c: &DMatrix<f64>, touches: &Touches, points: &[usize], nodes: &[u32]) -> DMatrix<f64> {
    let (size, mut w) = (3 * points.len(), DMatrix::zeros(3 * points.len(), 3 * points.len()));
    // Rows of points, with nodes numbered as in `c`.
    let number = |node: u32| nodes.partition_point(|n| *n < node);
    let row = |point: &usize| touches.row(*point).iter().map(|(n, w)| (number(*n), *w)).collect();
    let rows: Vec<Vec<(usize, f64)>> = points.iter().map(row).collect();
    let mut pushed = vec![0.0; c.nrows()];
    for column in 0..size {
        // Forces on a point reach its nodes by its weights, and these move all others.
        pushed.fill(0.0);
        for (node, weight) in &rows[column / 3] {
            let c = c.column(3 * node + column % 3);
            pushed.iter_mut().zip(c.iter()).for_each(|(p, c)| *p += weight * c);
        }
        // The lower triangle is enough: what one moves another by is mutual.
        for line in column..size {
            let each = rows[line / 3]
                .iter()
                .map(|(node, weight)| weight * pushed[3 * node + line % 3]);
            w[(line, column)] = each.sum();
        }
    }
    w.fill_upper_triangle_with_lower_triangle();
    w
}
