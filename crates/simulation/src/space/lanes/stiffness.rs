//! Four cells: second derivatives.

use super::four::{Work, prepare, pressure};
use super::{CELLS, Lane, Material, Table};

/// Packed lower triangles of the cells; false where the law has no energy.
#[inline(always)]
pub(super) fn stiffness<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    material: &Material,
    u: &[&[f64]],
    packed: &mut [Vec<f64>],
) -> [bool; CELLS] {
    let regular = prepare(proof, work, table, u);
    let unknowns = 3 * table.nodes();
    for packed in packed.iter_mut() {
        // Each entry is written below: no need to clear.
        packed.resize(unknowns * (unknowns + 1) / 2, 0.0);
    }
    // Once for each node and point; each is used by as many pairs as there are nodes.
    images(proof, work, table);
    changes(proof, work, table);
    let mut rows = std::mem::take(&mut work.rows);
    rows.clear();
    rows.resize(3 * unknowns, W::splat(proof, 0.0));
    for n in 0..table.nodes() {
        weigh(proof, work, table, material, n);
        for m in 0..=n {
            let block = block(proof, work, table, material, [n, m]);
            for (k, entry) in block.into_iter().enumerate() {
                rows[unknowns * (k / 3) + 3 * m + k % 3] = entry;
            }
        }
        // Rows are gathered four wide, then each cell's copy is written in one run.
        for i in 0..3 {
            let (row, length) = (3 * n + i, 3 * n + i + 1);
            let (start, from) = (row * (row + 1) / 2, &rows[unknowns * i..unknowns * i + length]);
            for (lane, packed) in packed.iter_mut().enumerate() {
                let to = &mut packed[start..start + length];
                to.iter_mut().zip(from).for_each(|(to, from)| *to = from.lanes()[lane]);
            }
        }
    }
    work.rows = rows;
    regular
}

/// `a_n = (cof F) Q_n` for each node and point, node by node.
#[inline(always)]
fn images<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table) {
    let points = table.points();
    let zero = W::splat(proof, 0.0);
    work.images.clear();
    work.images.resize(table.nodes() * points, [zero; 3]);
    let one = W::splat(proof, 1.0);
    for (point, at) in work.points.iter().enumerate() {
        // The I is added only now: products with slopes follow, and no difference that it would spoil.
        let mut c = at.cofactor;
        for entry in [0, 4, 8] {
            c[entry] = c[entry].plus(one);
        }
        for (n, q) in table.slopes_at(point).iter().enumerate() {
            let [x, y, z] = q.map(|q| W::splat(proof, q));
            let image = &mut work.images[n * points + point];
            for (i, image) in image.iter_mut().enumerate() {
                *image = c[i].times(x).plus(c[i + 3].times(y)).plus(c[i + 6].times(z));
            }
        }
    }
}

/// Derivatives of the means of `theta` times the volume: `sum_p w_p b_k(p) a_n / J`, mode by mode.
#[inline(always)]
fn changes<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table) {
    let (points, unknowns) = (table.points(), 3 * table.nodes());
    work.changes.clear();
    work.changes.resize(unknowns * table.mode_count, W::splat(proof, 0.0));
    for (mode, changes) in work.changes.chunks_exact_mut(unknowns.max(1)).enumerate() {
        for (point, at) in work.points.iter().enumerate() {
            let weight = table.weights[point] * table.modes_at(point)[mode];
            // Theta is `ln J` in this law: the J below is that of its derivative.
            let part = W::splat(proof, weight).over(at.j);
            for (n, change) in changes.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let image = &work.images[n * points + point];
                for (change, image) in change.iter_mut().zip(image) {
                    *change = change.plus(part.times(*image));
                }
            }
        }
    }
}

/// `w (mu - p) / J^2 a_n` of one node at each point and, where nothing is projected, `w lambda / J^2 a_n` behind them.
#[inline(always)]
fn weigh<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table, material: &Material, n: usize) {
    let points = table.points();
    let (lambda, mu) = (material.lame.lambda, W::splat(proof, material.lame.mu));
    // Taken out, as images and points are read while weighted ones are written.
    let mut weighted = std::mem::take(&mut work.weighted);
    weighted.clear();
    let parts = if table.mode_count == 0 { 2 } else { 1 };
    for part in 0..parts {
        for (point, at) in work.points.iter().enumerate() {
            let factor = if part == 0 {
                mu.minus(pressure(proof, work, table, lambda, point))
            } else {
                W::splat(proof, lambda)
            };
            let factor = W::splat(proof, table.weights[point])
                .times(factor)
                .over(at.j.times(at.j));
            weighted.push(work.images[n * points + point].map(|a| factor.times(a)));
        }
    }
    work.weighted = weighted;
}

/// The block of two nodes, row by row.
#[inline(always)]
fn block<W: Lane>(proof: W::Proof, work: &Work<W>, table: &Table, material: &Material, [n, m]: [usize; 2]) -> [W; 9] {
    let points = table.points();
    let images = &work.images[m * points..(m + 1) * points];
    let (turned, straight) = work.weighted.split_at(points);
    let mut block = [W::splat(proof, 0.0); 9];
    // Nine sums stay in registers while the points pass by: the order of loops that reads and writes least.
    for (weighted, image) in turned.iter().zip(images) {
        for i in 0..3 {
            for k in 0..3 {
                block[3 * i + k] = block[3 * i + k].plus(weighted[k].times(image[i]));
            }
        }
    }
    // No round at all where theta is projected: there is no second part then.
    for (weighted, image) in straight.iter().zip(images) {
        for i in 0..3 {
            for k in 0..3 {
                block[3 * i + k] = block[3 * i + k].plus(weighted[i].times(image[k]));
            }
        }
    }
    // The pressures eliminated, as in the table: the same sum, a pair at a time.
    let factor = W::splat(proof, material.lame.lambda / table.volume());
    for changes in work.changes.chunks_exact(3 * table.nodes()) {
        for i in 0..3 {
            let scaled = factor.times(changes[3 * n + i]);
            for k in 0..3 {
                block[3 * i + k] = block[3 * i + k].plus(scaled.times(changes[3 * m + k]));
            }
        }
    }
    // What does not depend on the state was summed with the table.
    let even = W::splat(proof, material.lame.mu * table.laplacian[n * (n + 1) / 2 + m]);
    for entry in [0, 4, 8] {
        block[entry] = block[entry].plus(even);
    }
    block
}
