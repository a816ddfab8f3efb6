//! Four cells: their points.

use super::points::{Point, deformation};
use super::{CELLS, Lane, Table};
use crate::space::element::MODES;

/// Memory for four cells, kept from call to call.
#[derive(Debug, Clone)]
pub(super) struct Work<W> {
    /// Displacements, node by node.
    pub(super) u: Vec<W>,
    pub(super) points: Vec<Point<W>>,
    /// Coefficients of the projected `theta`.
    pub(super) means: [W; MODES],
    /// Forces, or what a stiffness needs.
    pub(super) forces: Vec<W>,
    pub(super) images: Vec<[W; 3]>,
    pub(super) weighted: Vec<[W; 3]>,
    pub(super) changes: Vec<W>,
    pub(super) rows: Vec<W>,
}

impl<W: Lane<Proof = ()>> Default for Work<W> {
    fn default() -> Self {
        Self::new(())
    }
}

impl<W: Lane> Work<W> {
    pub(super) fn new(proof: W::Proof) -> Self {
        Self {
            u: Vec::new(),
            points: Vec::new(),
            means: [W::splat(proof, 0.0); MODES],
            forces: Vec::new(),
            images: Vec::new(),
            weighted: Vec::new(),
            changes: Vec::new(),
            rows: Vec::new(),
        }
    }
}

/// Fills `work.u`, `work.points` and `work.means`; tells which cells have `J > 0` at all points.
#[inline(always)]
pub(super) fn prepare<W: Lane>(proof: W::Proof, work: &mut Work<W>, table: &Table, u: &[&[f64]]) -> [bool; CELLS] {
    let zero = W::splat(proof, 0.0);
    work.u.clear();
    for entry in 0..3 * table.nodes() {
        // From cell by cell to number by number: below, one instruction serves four cells.
        let mut lanes = [0.0; CELLS];
        for (lane, u) in lanes.iter_mut().zip(u) {
            *lane = u[entry];
        }
        work.u.push(W::of(proof, lanes));
    }
    work.points.clear();
    work.means = [zero; MODES];
    let mut regular = [true; CELLS];
    for (point, weight) in table.weights.iter().enumerate() {
        let g = gradient(proof, &work.u, table.slopes_at(point));
        let at = deformation(proof, g);
        // A cell without an energy goes on with what numbers it has: its lane disturbs no other.
        for (regular, j) in regular.iter_mut().zip(at.j.lanes()) {
            *regular &= j > 0.0 && j.is_finite();
        }
        let part = W::splat(proof, weight / table.volume()).times(at.theta);
        for (mean, mode) in work.means.iter_mut().zip(table.modes_at(point)) {
            *mean = mean.plus(part.times(W::splat(proof, *mode)));
        }
        work.points.push(at);
    }
    regular
}

/// `G_iJ = sum_n u_ni Q_nJ`.
#[inline(always)]
fn gradient<W: Lane>(proof: W::Proof, u: &[W], slopes: &[[f64; 3]]) -> [W; 9] {
    let mut g = [W::splat(proof, 0.0); 9];
    // Nine sums in registers, one pass over the nodes.
    for (u, q) in u.as_chunks::<3>().0.iter().zip(slopes) {
        for (column, q) in g.as_chunks_mut::<3>().0.iter_mut().zip(q) {
            let q = W::splat(proof, *q);
            for (g, u) in column.iter_mut().zip(u) {
                *g = g.plus(u.times(q));
            }
        }
    }
    g
}

/// `lambda theta` at a point, projected where it is.
#[inline(always)]
pub(super) fn pressure<W: Lane>(proof: W::Proof, work: &Work<W>, table: &Table, lambda: f64, point: usize) -> W {
    let lambda = W::splat(proof, lambda);
    if table.mode_count == 0 {
        return lambda.times(work.points[point].theta);
    }
    let mut sum = W::splat(proof, 0.0);
    for (mean, mode) in work.means.iter().zip(table.modes_at(point)) {
        sum = sum.plus(mean.times(W::splat(proof, *mode)));
    }
    lambda.times(sum)
}
