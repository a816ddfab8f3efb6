//! One cell of any law: its stiffness from tangents of 9 x 9.

use super::{Lane, Table, Work, write};
use crate::space::law::Tangent;

/// Nodes whose blocks are summed at once: nine sums are kept in registers.
const TOGETHER: usize = 3;
/// Columns of a tangent times the axes of its rows.
const COLUMNS: usize = 27;

/// `K_(ni)(mk) = sum_p Q_nJ A_(iJ)(kL) Q_mL` of weighted tangents of the points, point by point; and `factor c c^T` for each
/// of the vectors `changes`, one behind the other.
#[inline(always)]
pub(in crate::space::lanes) fn contract<W: Lane>(
    proof: W::Proof,
    work: &mut Work<W>,
    table: &Table,
    tangents: &[Tangent],
    (factor, changes): (f64, &[f64]),
    packed: &mut Vec<f64>,
) {
    let unknowns = 3 * table.nodes();
    // Each entry is written below, so that what was there before does not matter.
    packed.resize(unknowns * (unknowns + 1) / 2, 0.0);
    work.images.clear();
    for a in tangents {
        // Column by column, the three rows `i` of an axis `J` in one register.
        let triples = a.as_slice().as_chunks::<3>().0.iter();
        work.images
            .extend(triples.map(|[x, y, z]| W::of(proof, [*x, *y, *z, 0.0])));
    }
    work.changes.clear();
    let triples = changes.as_chunks::<3>().0.iter();
    work.changes
        .extend(triples.map(|[x, y, z]| W::of(proof, [*x, *y, *z, 0.0])));
    for n in 0..table.nodes() {
        halves(proof, work, table, n);
        let mut m = 0;
        while m <= n {
            if m + TOGETHER <= n + 1 {
                blocks::<W, TOGETHER>(proof, work, table, factor, [n, m], packed);
                m += TOGETHER;
            } else {
                blocks::<W, 1>(proof, work, table, factor, [n, m], packed);
                m += 1;
            }
        }
    }
}

/// `sum_J Q_nJ A_(iJ)(kL)` of one node: nine columns `(k, L)` for each point.
#[inline(always)]
fn halves<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table, n: usize) {
    // Taken out, as the tangents are read while the halves are written.
    let mut halves = std::mem::take(&mut work.halves);
    halves.clear();
    // One side of each tangent is contracted once for a node, not once for each pair that it is in.
    for (point, a) in work.images.chunks_exact(COLUMNS).enumerate() {
        let [x, y, z] = table.slopes_at(point)[n].map(|q| W::splat(proof, q));
        let columns = a.as_chunks::<3>().0.iter();
        halves.extend(columns.map(|[a, b, c]| a.times(x).plus(b.times(y)).plus(c.times(z))));
    }
    work.halves = halves;
}

/// Writes the blocks of a node `n` and of `M` nodes from `m` on.
#[inline(always)]
fn blocks<W: Lane, const M: usize>(
    proof: W::Proof,
    work: &Work<W>,
    table: &Table,
    factor: f64,
    [n, m]: [usize; 2],
    packed: &mut [f64],
) {
    let mut blocks = [[W::splat(proof, 0.0); 3]; M];
    for (point, half) in work.halves.as_chunks::<9>().0.iter().enumerate() {
        let slopes = &table.slopes_at(point)[m..m + M];
        for axis in 0..3 {
            // The same three columns serve all nodes of the group.
            for (block, q) in blocks.iter_mut().zip(slopes) {
                let q = W::splat(proof, q[axis]);
                for (column, half) in block.iter_mut().zip(&half[3 * axis..3 * axis + 3]) {
                    *column = column.plus(half.times(q));
                }
            }
        }
    }
    let factor = W::splat(proof, factor);
    for changes in work.changes.chunks_exact(table.nodes()) {
        let scaled = factor.times(changes[n]);
        for (block, change) in blocks.iter_mut().zip(&changes[m..]) {
            for (column, change) in block.iter_mut().zip(change.lanes()) {
                *column = column.plus(scaled.times(W::splat(proof, change)));
            }
        }
    }
    write(&blocks, [n, m], packed);
}
