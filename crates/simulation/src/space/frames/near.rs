//! The points at the tube, and how forces on them move one another: the compliance of tissue that contact is solved by.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::touch::Touches;
use crate::sparse::{Combinations, Ldl};

/// Some of the points, and `W = B A^-1 B^T` with their displacements for the rows of `B`, three each, and `A` the matrix of a factor.
///
/// Not `W` itself is kept but the compliance `C` of what carries the points, by which `W = R C R^T`: of hundreds of points on the faces of some
/// cubes few press at once, and [`Active`] makes the blocks of `W` of these alone.
#[derive(Debug, Clone)]
pub(super) struct Near {
    /// Ascending.
    points: Vec<usize>,
    /// What carries a point, and its weights; where those of a point begin.
    rows: Vec<(u32, f64)>,
    starts: Vec<usize>,
    c: DMatrix<f64>,
    mean: f64,
}

impl Default for Near {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            rows: Vec::new(),
            starts: vec![0],
            c: DMatrix::zeros(0, 0),
            mean: 0.0,
        }
    }
}

impl Near {
    /// These points, in ascending order, by a factor.
    pub(super) fn new(ldl: &Ldl, touches: &Touches, points: Vec<usize>) -> Self {
        let nodes = touches.nodes_of(&points);
        let mut combinations = Combinations::default();
        let (mut rows, mut starts) = (Vec::new(), vec![0]);
        // By the fewer of the two: several points of a face share its nodes, a point of a cut cube has all of them.
        if nodes.len() < points.len() {
            let each = nodes.iter().flat_map(|node| (0..3).map(|k| touches.unknown(*node, k)));
            each.for_each(|unknown| combinations.push(unknown.into_iter()));
            let number = |node: u32| nodes.partition_point(|n| *n < node) as u32;
            for point in &points {
                rows.extend(touches.row(*point).iter().map(|(n, w)| (number(*n), *w)));
                starts.push(rows.len());
            }
        } else {
            let each = points
                .iter()
                .flat_map(|point| (0..3).map(|k| touches.combination(*point, k)));
            each.for_each(|combination| combinations.push(combination));
            rows.extend((0..points.len()).map(|k| (k as u32, 1.0)));
            starts.extend(1..=points.len());
        }
        let mut near = Self {
            points,
            rows,
            starts,
            c: ldl.compliance(&combinations),
            mean: 0.0,
        };
        near.mean = near.mean_compliance();
        near
    }

    /// The points.
    pub(super) fn points(&self) -> &[usize] {
        &self.points
    }

    /// The number of a point among them.
    pub(super) fn index(&self, point: usize) -> Option<usize> {
        self.points.binary_search(&point).ok()
    }

    /// By what a unit of force moves its own point, in the mean of points and directions.
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    fn row(&self, k: usize) -> &[(u32, f64)] {
        &self.rows[self.starts[k]..self.starts[k + 1]]
    }

    fn mean_compliance(&self) -> f64 {
        // Only traces of the 3 x 3 blocks are asked for: they are summed once, not for each point.
        let carriers = self.c.nrows() / 3;
        let traces = DMatrix::from_fn(carriers, carriers, |i, j| {
            (0..3).map(|k| self.c[(3 * i + k, 3 * j + k)]).sum::<f64>()
        });
        let own = |k: usize| {
            let row = self.row(k);
            let each = row.iter().map(|(j, w)| {
                let column = traces.column(*j as usize);
                w * row.iter().map(|(i, w)| w * column[*i as usize]).sum::<f64>()
            });
            each.sum::<f64>()
        };
        (0..self.points.len()).map(own).sum::<f64>() / (3 * self.points.len()).max(1) as f64
    }

    /// `C R^T` of a point's three directions, one column after the other.
    fn column(&self, k: usize) -> Vec<f64> {
        let size = self.c.nrows();
        let mut column = vec![0.0; 3 * size];
        // `C` is symmetric: columns are read where rows are meant, as these lie together in memory.
        for (carrier, weight) in self.row(k) {
            for (direction, own) in column.chunks_exact_mut(size).enumerate() {
                let c = self.c.column(3 * *carrier as usize + direction);
                own.iter_mut().zip(c.iter()).for_each(|(o, c)| *o += weight * c);
            }
        }
        column
    }

    /// How a point is moved as carriers are.
    fn place(&self, k: usize, carried: &[f64]) -> Vector3<f64> {
        let mut at = Vector3::zeros();
        for (carrier, weight) in self.row(k) {
            let u = &carried[3 * *carrier as usize..3 * *carrier as usize + 3];
            (0..3).for_each(|k| at[k] += weight * u[k]);
        }
        at
    }
}

/// Those of the points near the tube that press or have pressed, with their blocks of `W`: made as points come to press.
#[derive(Debug, Clone, Default)]
pub(super) struct Active {
    /// Which of the points near, in the order in which they came.
    points: Vec<usize>,
    /// The number of each point near here, one more than that; 0 where it is not here.
    numbers: Vec<u32>,
    columns: Vec<Vec<f64>>,
    /// The lower triangle, row by row.
    w: Vec<Vec<Matrix3<f64>>>,
}

impl Active {
    /// The number of a point near among these; it is taken in if it is not yet.
    pub(super) fn take(&mut self, near: &Near, k: usize) -> usize {
        // Numbers begin at 1, so that what was just added says that it is not here.
        self.numbers.resize(near.points.len(), 0);
        if self.numbers[k] == 0 {
            self.points.push(k);
            self.numbers[k] = self.points.len() as u32;
            self.columns.push(near.column(k));
            let size = near.c.nrows();
            let block = |column: &Vec<f64>| {
                let each: Vec<_> = column.chunks_exact(size).map(|one| near.place(k, one)).collect();
                Matrix3::from_columns(&each)
            };
            self.w.push(self.columns.iter().map(block).collect());
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
    pub(super) fn moved_all(&self, near: &Near, forces: &[Vector3<f64>]) -> Vec<f64> {
        // Through what carries the points: of few forces that is less than a block for each pair.
        let size = near.c.nrows();
        let mut carried = vec![0.0; size];
        for (j, force) in pushed(forces) {
            for (column, force) in self.columns[j].chunks_exact(size).zip(force.iter()) {
                carried.iter_mut().zip(column).for_each(|(c, u)| *c += u * force);
            }
        }
        let each = (0..near.points.len()).flat_map(|k| near.place(k, &carried).data.0[0]);
        each.collect()
    }
}

/// Most points do not press any more.
fn pushed(forces: &[Vector3<f64>]) -> impl Iterator<Item = (usize, &Vector3<f64>)> {
    forces
        .iter()
        .enumerate()
        .filter(|(_, force)| **force != Vector3::zeros())
}
