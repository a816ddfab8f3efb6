//! The points at the tube, and how forces on them move one another: the compliance of tissue that contact is solved by.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::touch::Touches;
use crate::sparse::Ldl;

/// So many points say what the mean compliance is where none has pressed yet.
const SAMPLES: usize = 4;

/// The points that may press in a step, and what they are measured by.
#[derive(Debug, Clone, Default)]
pub(super) struct Near {
    /// Ascending.
    points: Vec<usize>,
    mean: f64,
}

impl Near {
    /// These points, in ascending order, with the mean compliance that [`Active::mean`] has.
    pub(super) fn new(points: Vec<usize>, mean: f64) -> Self {
        Self { points, mean }
    }

    /// The points.
    pub(super) fn points(&self) -> &[usize] {
        &self.points
    }

    /// The number of a point among them.
    pub(super) fn index(&self, point: usize) -> Option<usize> {
        self.points.binary_search(&point).ok()
    }

    /// By what a unit of force moves its own point, in the mean of some points and directions.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }
}

/// How tissue gives way: a factor, and the points that its columns are of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tissue<'a> {
    pub(super) ldl: &'a Ldl,
    pub(super) touches: &'a Touches,
}

impl Tissue<'_> {
    /// By what unit forces on a point along the axes move the nodes of its solid that carry points, one after the other.
    fn column(&self, point: usize) -> Vec<f64> {
        let (touches, mut column) = (self.touches, Vec::new());
        let (mut all, mut own) = (vec![0.0; self.ldl.order().len()], Vec::new());
        for direction in 0..3 {
            // Forces on the nodes that carry the point, as it is the sum of theirs.
            all.fill(0.0);
            for (unknown, weight) in touches.combination(point, direction) {
                all[unknown as usize] += weight;
            }
            self.ldl.solve(&mut all);
            touches.take(&all, &mut own);
            column.extend_from_slice(&own[touches.part(point)]);
        }
        column
    }
}

/// Those of the points near the tube that press or have pressed, with their blocks of `W = B A^-1 B^T`, with `A` the matrix of a factor and the points'
/// displacements for the rows of `B`: made as points come to press. Of hundreds of points near the tube few press at once, and three solutions for each
/// of these are less than the compliance of all.
#[derive(Debug, Clone, Default)]
pub(super) struct Active {
    /// Which of the points near, in the order in which they came.
    points: Vec<usize>,
    /// The number of each point near here, one more than that; 0 where it is not here.
    numbers: Vec<u32>,
    columns: Vec<Arc<Vec<f64>>>,
    /// The lower triangle, row by row.
    w: Vec<Vec<Matrix3<f64>>>,
    /// By point, of this factor: whoever presses again after other points have come near is not solved for again.
    known: BTreeMap<usize, Arc<Vec<f64>>>,
}

impl Active {
    /// Other points are near, by the same factor.
    pub(super) fn clear(&mut self) {
        self.truncate(0);
        self.numbers.clear();
    }

    /// The column of a point.
    pub(super) fn column(&mut self, tissue: &Tissue<'_>, point: usize) -> Arc<Vec<f64>> {
        let column = self
            .known
            .entry(point)
            .or_insert_with(|| Arc::new(tissue.column(point)));
        Arc::clone(column)
    }

    /// By what a unit of force moves its own point, in the mean of those whose columns are known, or else of some of `points`; 0 where nothing moves any.
    pub(super) fn mean(&mut self, tissue: &Tissue<'_>, points: &[usize]) -> f64 {
        let own = |point: usize, column: &[f64]| Self::moved_by(tissue.touches, point, (point, column)).trace() / 3.0;
        let mean = |all: &BTreeMap<usize, Arc<Vec<f64>>>| {
            let sum: f64 = all.iter().map(|(point, column)| own(*point, column)).sum();
            sum / all.len().max(1) as f64
        };
        let known = mean(&self.known);
        if known > 0.0 {
            return known;
        }
        // Where none of those says anything, any other may.
        let step = points.len().div_ceil(SAMPLES).max(1);
        let some = points.iter().step_by(step).chain(points);
        for (k, point) in some.enumerate() {
            self.column(tissue, *point);
            if k + 1 >= SAMPLES.min(points.len()) && mean(&self.known) > 0.0 {
                break;
            }
        }
        mean(&self.known)
    }

    /// How forces on one point move another; not at all, one of another solid.
    fn moved_by(touches: &Touches, point: usize, (by, column): (usize, &[f64])) -> Matrix3<f64> {
        // No factor has an entry between two solids.
        let part = touches.part(by);
        if touches.part(point) != part {
            return Matrix3::zeros();
        }
        let each: Vec<_> = column
            .chunks_exact(part.len())
            .map(|one| touches.displacement_in(point, one))
            .collect();
        Matrix3::from_columns(&each)
    }

    /// The number of a point near among these; it is taken in if it is not yet.
    pub(super) fn take(&mut self, tissue: &Tissue<'_>, near: &Near, k: usize) -> usize {
        // Numbers begin at 1, so that what was just added says that it is not here.
        self.numbers.resize(near.points.len(), 0);
        if self.numbers[k] == 0 {
            let point = near.points[k];
            let column = self.column(tissue, point);
            self.points.push(k);
            self.numbers[k] = self.points.len() as u32;
            self.columns.push(column);
            let each = self.points.iter().zip(&self.columns);
            let blocks = each.map(|(by, column)| Self::moved_by(tissue.touches, point, (near.points[*by], column)));
            let blocks = blocks.collect();
            self.w.push(blocks);
        }
        self.numbers[k] as usize - 1
    }

    /// How many these are.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Those that came first, so many, as if no others had come.
    pub(super) fn truncate(&mut self, count: usize) {
        // Those that came later stand behind, and no block of an earlier one is of them.
        self.points.drain(count..).for_each(|k| self.numbers[k] = 0);
        self.columns.truncate(count);
        self.w.truncate(count);
    }

    /// Which of the points near these are, by their numbers.
    pub(super) fn points(&self) -> &[usize] {
        &self.points
    }

    /// What forces on one move another by.
    pub(super) fn block(&self, i: usize, j: usize) -> Matrix3<f64> {
        // Forces and displacements of two points are reciprocal (Betti): one triangle holds both.
        if j <= i { self.w[i][j] } else { self.w[j][i].transpose() }
    }

    /// Of forces on all points near, three each, those on these.
    pub(super) fn of_all(&self, f: &[f64]) -> Vec<Vector3<f64>> {
        let each = self.points.iter();
        each.map(|k| Vector3::from_column_slice(&f[3 * k..3 * k + 3])).collect()
    }

    /// How forces on these move these.
    pub(super) fn moved(&self, forces: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut moved = vec![Vector3::zeros(); self.points.len()];
        for (j, force) in pushed(forces) {
            for (i, moved) in moved.iter_mut().enumerate() {
                *moved += self.block(i, j) * force;
            }
        }
        moved
    }

    /// How they move all points near, three numbers each: `W f`.
    pub(super) fn moved_all(&self, touches: &Touches, near: &Near, forces: &[Vector3<f64>]) -> Vec<f64> {
        // Through what carries the points: of few forces that is less than a block for each pair.
        let mut carried = vec![0.0; touches.unknowns()];
        for (j, force) in pushed(forces) {
            let part = touches.part(near.points[self.points[j]]);
            for (column, force) in self.columns[j].chunks_exact(part.len()).zip(force.iter()) {
                let carried = &mut carried[part.clone()];
                carried.iter_mut().zip(column).for_each(|(c, u)| *c += u * force);
            }
        }
        let each = near.points.iter();
        each.flat_map(|point| touches.displacement(*point, &carried).data.0[0])
            .collect()
    }
}

/// Most points do not press any more.
fn pushed(forces: &[Vector3<f64>]) -> impl Iterator<Item = (usize, &Vector3<f64>)> {
    forces
        .iter()
        .enumerate()
        .filter(|(_, force)| **force != Vector3::zeros())
}
