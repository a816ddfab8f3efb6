//! One cell: its second derivative.

use super::{GROUP, Lane, Material, Table, Work, columns, of_points, points, prepare, pressure, product, write};

/// Nodes whose blocks are summed at once: nine sums are kept in registers.
const TOGETHER: usize = 3;

/// The packed lower triangle; false where the law has no energy.
#[inline(always)]
pub(in crate::space::lanes) fn stiffness<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[f64],
    packed: &mut Vec<f64>,
) -> bool {
    let regular = prepare(proof, work, table, u);
    let unknowns = 3 * table.nodes();
    // Each entry is written below: no need to clear.
    packed.resize(unknowns * (unknowns + 1) / 2, 0.0);
    // As for four cells; lanes are the entries of a vector here, one of four idle.
    images(proof, work, table);
    changes(proof, work, table);
    let cell = Cell { table, material };
    for n in 0..table.nodes() {
        weigh(proof, work, &cell, n);
        let mut m = 0;
        while m <= n {
            // A group must not reach beyond the diagonal: the nodes that do not fill one are done one by one.
            if m + TOGETHER <= n + 1 {
                cell.blocks::<W, TOGETHER>(proof, work, [n, m], packed);
                m += TOGETHER;
            } else {
                cell.blocks::<W, 1>(proof, work, [n, m], packed);
                m += 1;
            }
        }
    }
    regular
}

/// `a_n = (cof F) Q_n` for each node and point, node by node.
#[inline(always)]
fn images<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table) {
    let (count, one) = (table.points(), W::splat(proof, 1.0));
    work.images.clear();
    work.images.resize(table.nodes() * count, W::splat(proof, 0.0));
    for (group, at) in work.groups.iter().enumerate() {
        let mut whole = at.cofactor;
        for entry in [0, 4, 8] {
            whole[entry] = whole[entry].plus(one);
        }
        // Out of the lanes once for each group: so far lanes are points, from here on entries of a vector.
        let whole = whole.map(W::lanes);
        for (lane, point) in points(table, group).enumerate() {
            let columns = columns(proof, &whole, lane);
            for (n, q) in table.slopes_at(point).iter().enumerate() {
                work.images[n * count + point] = product(proof, &columns, q);
            }
        }
    }
}

/// Derivatives of the means of `theta` times the volume, mode by mode.
#[inline(always)]
fn changes<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table) {
    let (count, nodes) = (table.points(), table.nodes());
    work.changes.clear();
    work.changes.resize(nodes * table.mode_count, W::splat(proof, 0.0));
    for (mode, changes) in work.changes.chunks_exact_mut(nodes).enumerate() {
        for point in 0..count {
            let j = work.groups[point / GROUP].j.lanes()[point % GROUP];
            let part = W::splat(proof, table.weights[point] * table.modes_at(point)[mode] / j);
            for (n, change) in changes.iter_mut().enumerate() {
                *change = change.plus(part.times(work.images[n * count + point]));
            }
        }
    }
}

/// `w (mu - p) / J^2 a_n` of one node at each point and, where nothing is projected, `w lambda / J^2 a_n` behind them.
#[inline(always)]
fn weigh<W: Lane>(proof: W::Proof, work: &mut Work<W>, cell: &Cell<'_>, n: usize) {
    let table = cell.table;
    let (lambda, mu) = (cell.material.lame.lambda, cell.material.lame.mu);
    let mut weighted = std::mem::take(&mut work.weighted);
    weighted.clear();
    // Factors of four points at once; images one by one.
    let images = &work.images[n * table.points()..(n + 1) * table.points()];
    // Where theta is projected its stiffness comes with the pressures: a second part would count it twice.
    for part in 0..if table.mode_count == 0 { 2 } else { 1 } {
        for (group, at) in work.groups.iter().enumerate() {
            let factor = of_points(table, group, |point| {
                let factor = if part == 0 {
                    mu - pressure(work, table, lambda, point)
                } else {
                    lambda
                };
                table.weights[point] * factor
            });
            let factor = W::of(proof, factor).over(at.j.times(at.j)).lanes();
            for (lane, point) in points(table, group).enumerate() {
                weighted.push(W::splat(proof, factor[lane]).times(images[point]).lanes());
            }
        }
    }
    work.weighted = weighted;
}

/// An element of a material.
struct Cell<'a> {
    table: &'a Table,
    material: &'a Material,
}

impl Cell<'_> {
    /// Writes the blocks of a node `n` and of `M` nodes from `m` on.
    #[inline(always)]
    fn blocks<W: Lane, const M: usize>(&self, proof: W::Proof, work: &Work<W>, [n, m]: [usize; 2], packed: &mut [f64]) {
        let mut blocks = sums::<W, M>(proof, work, self.table.points(), m);
        // The pressures eliminated, after the points as for four cells: the order of a sum is part of its bits.
        let factor = W::splat(proof, self.material.lame.lambda / self.table.volume());
        for changes in work.changes.chunks_exact(self.table.nodes()) {
            let scaled = factor.times(changes[n]);
            for (block, change) in blocks.iter_mut().zip(&changes[m..]) {
                for (column, change) in block.iter_mut().zip(change.lanes()) {
                    *column = column.plus(scaled.times(W::splat(proof, change)));
                }
            }
        }
        let evens = &self.table.laplacian[n * (n + 1) / 2 + m..];
        for (block, even) in blocks.iter_mut().zip(evens) {
            // Numbers beside the diagonal stay as they are: a sum of products from 0 on is never -0.
            let even = self.material.lame.mu * even;
            for (axis, column) in block.iter_mut().enumerate() {
                let mut unit = [0.0; 4];
                unit[axis] = even;
                *column = column.plus(W::of(proof, unit));
            }
        }
        write(&blocks, [n, m], packed);
    }
}

/// The sums over the points, column by column of each block.
#[inline(always)]
fn sums<W: Lane, const M: usize>(proof: W::Proof, work: &Work<W>, count: usize, m: usize) -> [[W; 3]; M] {
    let mut blocks = [[W::splat(proof, 0.0); 3]; M];
    let images: [&[W]; M] = std::array::from_fn(|k| &work.images[(m + k) * count..(m + k + 1) * count]);
    let (turned, straight) = work.weighted.split_at(count);
    for (point, weighted) in turned.iter().enumerate() {
        for (block, images) in blocks.iter_mut().zip(&images) {
            // One image serves three sums, one weight three nodes.
            let image = images[point];
            for (column, weighted) in block.iter_mut().zip(weighted) {
                *column = column.plus(W::splat(proof, *weighted).times(image));
            }
        }
    }
    // Only where nothing is projected: there theta of each point has a stiffness of its own.
    for (point, weighted) in straight.iter().enumerate() {
        let weighted = W::of(proof, *weighted);
        for (block, images) in blocks.iter_mut().zip(&images) {
            let image = images[point].lanes();
            for (column, image) in block.iter_mut().zip(image) {
                *column = column.plus(weighted.times(W::splat(proof, image)));
            }
        }
    }
    blocks
}
