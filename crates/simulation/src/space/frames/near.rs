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
        let mut combinations = Combinations::default();
        for point in &points {
            (0..3).for_each(|k| combinations.push(touches.combination(*point, k)));
        }
        Self {
            w: ldl.compliance(&combinations),
            points,
        }
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
        for (f, column) in f.iter().zip(self.w.column_iter()).filter(|(f, _)| **f != 0.0) {
            moved.iter_mut().zip(column.iter()).for_each(|(m, w)| *m += w * f);
        }
        moved
    }
}
