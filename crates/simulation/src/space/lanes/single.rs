//! One cell: three of four lanes are the entries of a vector, or four lanes are four points.
//!
//! Sums run over nodes and points as they do for four cells: so do the bits.

mod general;
mod stiffness;

pub(super) use general::contract;
pub(super) use stiffness::stiffness;

use super::points::{Point, deformation, stress};
use super::{CELLS, Lane, Material, Table};
use crate::space::element::MODES;

/// How many points there are in a group.
const GROUP: usize = CELLS;

/// Memory for one cell, kept from call to call.
#[derive(Debug, Clone)]
pub(super) struct Work<W> {
    /// The displacement of each node.
    u: Vec<W>,
    /// Four points at a time.
    groups: Vec<Point<W>>,
    means: [f64; MODES],
    /// The force on each node.
    forces: Vec<W>,
    images: Vec<W>,
    weighted: Vec<[f64; 4]>,
    changes: Vec<W>,
    halves: Vec<W>,
}

impl<W> Default for Work<W> {
    fn default() -> Self {
        Self {
            u: Vec::new(),
            groups: Vec::new(),
            means: [0.0; MODES],
            forces: Vec::new(),
            images: Vec::new(),
            weighted: Vec::new(),
            changes: Vec::new(),
            halves: Vec::new(),
        }
    }
}

/// The energy, `None` where the law has none.
#[inline(always)]
pub(super) fn energy<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[f64],
) -> Option<f64> {
    let regular = prepare(proof, work, table, u);
    told(regular, sum(work, table, material))
}

/// The same, and forces added.
#[inline(always)]
pub(super) fn gradient<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[f64],
    forces: &mut [f64],
) -> Option<f64> {
    let regular = prepare(proof, work, table, u);
    let energy = told(regular, sum(work, table, material))?;
    work.forces.clear();
    work.forces.resize(table.nodes(), W::splat(proof, 0.0));
    let mu = W::splat(proof, material.lame.mu);
    for (group, at) in work.groups.iter().enumerate() {
        // What is done point by point is done for four points at once.
        let lanes = |of: &dyn Fn(usize) -> f64| W::of(proof, of_points(table, group, of));
        let pressure = lanes(&|point| pressure(work, table, material.lame.lambda, point));
        let slope = mu.times(at.x).plus(pressure).over(at.j);
        let weight = lanes(&|point| table.weights[point]);
        let stress = stress(proof, at, mu, slope, weight).map(W::lanes);
        for (lane, point) in points(table, group).enumerate() {
            let columns = columns(proof, &stress, lane);
            // Point after point, as the order of a sum is part of its bits.
            scatter(proof, &columns, table.slopes_at(point), &mut work.forces);
        }
    }
    for (force, own) in forces.as_chunks_mut::<3>().0.iter_mut().zip(&work.forces) {
        force.iter_mut().zip(own.lanes()).for_each(|(f, own)| *f += own);
    }
    Some(energy)
}

fn told(regular: bool, energy: f64) -> Option<f64> {
    (regular && energy.is_finite()).then_some(energy)
}

/// The points of a group.
#[inline(always)]
fn points(table: &Table, group: usize) -> std::ops::Range<usize> {
    GROUP * group..table.points().min(GROUP * (group + 1))
}

/// A number of each point of a group; 0 where there are no more.
#[inline(always)]
fn of_points(table: &Table, group: usize, of: impl Fn(usize) -> f64) -> [f64; GROUP] {
    let mut numbers = [0.0; GROUP];
    for (number, point) in numbers.iter_mut().zip(points(table, group)) {
        *number = of(point);
    }
    numbers
}

/// The columns of the tensor of one point out of those of a group.
#[inline(always)]
fn columns<W: Lane>(proof: W::Proof, tensors: &[[f64; GROUP]; 9], lane: usize) -> [W; 3] {
    [0, 3, 6].map(|k| {
        let [x, y, z] = [tensors[k][lane], tensors[k + 1][lane], tensors[k + 2][lane]];
        W::of(proof, [x, y, z, 0.0])
    })
}

/// Fills `work.u`, `work.groups` and `work.means`; tells whether `J > 0` at all points.
#[inline(always)]
fn prepare<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table, u: &[f64]) -> bool {
    let nodes = u.as_chunks::<3>().0.iter();
    work.u.clear();
    work.u.extend(nodes.map(|[x, y, z]| W::of(proof, [*x, *y, *z, 0.0])));
    work.groups.clear();
    let mut means = W::splat(proof, 0.0);
    let mut regular = true;
    for group in 0..table.points().div_ceil(GROUP) {
        // Lanes without a point stay at rest, which every law survives.
        let mut tensors = [[0.0; GROUP]; 9];
        for (lane, point) in points(table, group).enumerate() {
            let columns = displacement_gradient(proof, &work.u, table.slopes_at(point)).map(W::lanes);
            for (entry, tensor) in tensors.iter_mut().enumerate() {
                tensor[lane] = columns[entry / 3][entry % 3];
            }
        }
        let at = deformation(proof, tensors.map(|t| W::of(proof, t)));
        let (j, theta) = (at.j.lanes(), at.theta.lanes());
        for (lane, point) in points(table, group).enumerate() {
            regular &= j[lane] > 0.0 && j[lane].is_finite();
            // The same products in the same order as for four cells.
            let part = table.weights[point] / table.volume() * theta[lane];
            let modes = W::of(proof, *table.modes_at(point));
            means = means.plus(W::splat(proof, part).times(modes));
        }
        work.groups.push(at);
    }
    work.means = means.lanes();
    regular
}

/// Its columns `sum_n u_n Q_nJ`.
#[inline(always)]
fn displacement_gradient<W: Lane>(proof: W::Proof, u: &[W], slopes: &[[f64; 3]]) -> [W; 3] {
    let mut columns = [W::splat(proof, 0.0); 3];
    for (u, q) in u.iter().zip(slopes) {
        for (column, q) in columns.iter_mut().zip(q) {
            *column = column.plus(u.times(W::splat(proof, *q)));
        }
    }
    columns
}

/// `lambda theta` at a point, projected where it is.
#[inline(always)]
fn pressure<W: Lane>(work: &Work<W>, table: &Table, lambda: f64, point: usize) -> f64 {
    if table.mode_count == 0 {
        return lambda * work.groups[point / GROUP].theta.lanes()[point % GROUP];
    }
    let products = work
        .means
        .iter()
        .zip(table.modes_at(point))
        .map(|(mean, mode)| mean * mode);
    // A fold from 0, as the sum of four cells begins: `sum` may begin with -0.
    lambda * products.fold(0.0, |sum, product| sum + product)
}

/// As for four cells.
#[inline(always)]
fn sum<W: Lane>(work: &Work<W>, table: &Table, material: &Material) -> f64 {
    let (mut shear, mut square) = (0.0, 0.0);
    for (group, at) in work.groups.iter().enumerate() {
        let [q, rest, theta] = [at.q, at.rest, at.theta].map(W::lanes);
        for (lane, point) in points(table, group).enumerate() {
            let weight = table.weights[point];
            shear += weight * (0.5 * q[lane] + rest[lane]);
            square += weight * (theta[lane] * theta[lane]);
        }
    }
    if table.mode_count > 0 {
        square = work.means.iter().fold(0.0, |sum, mean| sum + mean * mean);
        square *= table.volume();
    }
    material.lame.mu * shear + 0.5 * material.lame.lambda * square
}

/// `f_n += P Q_n`, from the columns of `P`.
#[inline(always)]
fn scatter<W: Lane>(proof: W::Proof, p: &[W; 3], slopes: &[[f64; 3]], forces: &mut [W]) {
    for (force, q) in forces.iter_mut().zip(slopes) {
        *force = force.plus(product(proof, p, q));
    }
}

/// A matrix, by its columns, times a vector.
#[inline(always)]
fn product<W: Lane>(proof: W::Proof, columns: &[W; 3], q: &[f64; 3]) -> W {
    let [x, y, z] = q.map(|q| W::splat(proof, q));
    columns[0].times(x).plus(columns[1].times(y)).plus(columns[2].times(z))
}

/// Writes the blocks of a node `n` and of others from `m` on, column by column, to the lower triangle row by row.
#[inline(always)]
fn write<W: Lane, const M: usize>(blocks: &[[W; 3]; M], [n, m]: [usize; 2], packed: &mut [f64]) {
    for (offset, block) in blocks.iter().enumerate() {
        for (k, entries) in block.iter().enumerate() {
            for (i, entry) in entries.lanes().iter().take(3).enumerate() {
                let (row, column) = (3 * n + i, 3 * (m + offset) + k);
                // Blocks on the diagonal are written by half.
                if column <= row {
                    packed[row * (row + 1) / 2 + column] = *entry;
                }
            }
        }
    }
}
