//! Forward and back substitution column by column, in the factor as it was eliminated.
//!
//! For the small matrices of solids in the plane; large ones are stored anew for it ([`super::packed`]).

use std::ops::Range;

use super::symbolic::Symbolic;

/// `L x = b`, then `D x = b`, of some fronts, in the order of elimination.
pub(super) fn forward(symbolic: &Symbolic, fronts: Range<usize>, factor: &[f64], x: &mut [f64]) {
    let mut below = Vec::new();
    for front in &symbolic.fronts[fronts] {
        let (panel, size) = (&factor[front.panel()], front.size());
        let rows = &symbolic.rows[front.rows..front.rows + front.height];
        below.clear();
        // Summed up for the whole front: scattered rows are met once, not once for each column.
        below.resize(front.height, 0.0);
        let (own, width) = (&mut x[front.first..front.first + front.width], front.width);
        for k in 0..width {
            let (value, column) = (own[k], &panel[k * size..(k + 1) * size]);
            own[k + 1..]
                .iter_mut()
                .zip(&column[k + 1..width])
                .for_each(|(x, l)| *x -= l * value);
            below
                .iter_mut()
                .zip(&column[width..])
                .for_each(|(x, l)| *x += l * value);
            // The pivot on the diagonal; `L` itself has ones there.
            own[k] = value / column[k];
        }
        rows.iter().zip(&below).for_each(|(row, by)| x[*row as usize] -= by);
    }
}

/// `L^T x = b` of some fronts, in the order of elimination.
pub(super) fn back(symbolic: &Symbolic, fronts: Range<usize>, factor: &[f64], x: &mut [f64]) {
    let mut below = Vec::new();
    for front in symbolic.fronts[fronts].iter().rev() {
        let (panel, size) = (&factor[front.panel()], front.size());
        let rows = &symbolic.rows[front.rows..front.rows + front.height];
        below.clear();
        // Gathered into one piece, so that each column is one product of two vectors.
        below.extend_from_slice(&x[front.first..front.first + front.width]);
        below.extend(rows.iter().map(|row| x[*row as usize]));
        // Backwards: a column needs those after it.
        for k in (0..front.width).rev() {
            let column = &panel[k * size + k + 1..(k + 1) * size];
            let sum: f64 = column.iter().zip(&below[k + 1..]).map(|(l, x)| l * x).sum();
            below[k] -= sum;
        }
        x[front.first..front.first + front.width].copy_from_slice(&below[..front.width]);
    }
}
