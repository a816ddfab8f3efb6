//! Fewer points with the same integrals.
//!
//! Of any number of weighted points as many are kept as there are polynomials of a degree, with positive weights and the same
//! moments (Tchakaloff; found as Litterer and Lyons 2012 do: groups of points are thinned before single ones).

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Vector3};

use super::rule::Inside;
use crate::space::element::Order;

/// Points with the same integrals of all products of a linear function and a derivative of a shape function, at most as
/// many as such products are independent: 17 for 8 nodes, 51 for 27. A state of linear stress then does the exact work on
/// every displacement, which is what the order of convergence rests on. (Polynomials of total degree 4, 35 points, do not
/// even pass a patch test: `d(x^2 y^2 z^2)` has degree 5.)
pub(super) fn recombine(mut points: Vec<Inside>, [low, high]: &[Vector3<f64>; 2], order: Order) -> Vec<Inside> {
    let powers = powers(order);
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let moments = |p: &Inside| {
        let local = (p.at - centre).component_div(&half);
        legendre(&local, &powers)
    };
    // Every round halves the number of groups, and with it that of points, at least.
    while points.len() > powers.len() {
        let groups = (2 * powers.len()).min(points.len());
        let bounds: Vec<usize> = (0..=groups).map(|g| g * points.len() / groups).collect();
        let mut sums = DMatrix::zeros(powers.len(), groups);
        for (g, pair) in bounds.windows(2).enumerate() {
            for point in &points[pair[0]..pair[1]] {
                let each = moments(point);
                (0..powers.len()).for_each(|k| sums[(k, g)] += point.weight * each[k]);
            }
        }
        let shares = thinned(sums);
        let mut kept = Vec::with_capacity(points.len() / 2);
        for (g, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let group = &points[bounds[g]..bounds[g + 1]];
            kept.extend(group.iter().map(|p| Inside {
                weight: p.weight * share,
                ..*p
            }));
        }
        // Nothing left to drop: as many independent moments as points.
        if kept.len() == points.len() {
            break;
        }
        points = kept;
    }
    points
}

/// Exponents of the products: of a derivative along one axis of `x^i y^j z^k`, all up to the order, times 1, x, y or z.
fn powers(order: Order) -> Vec<[usize; 3]> {
    let most: usize = match order {
        Order::Linear => 1,
        Order::Quadratic => 2,
    };
    let mut powers = BTreeSet::new();
    for n in 0..(most + 1).pow(3) {
        let shape = [n % (most + 1), n / (most + 1) % (most + 1), n / (most + 1).pow(2)];
        for axis in (0..3).filter(|k| shape[*k] > 0) {
            let mut slope = shape;
            slope[axis] -= 1;
            powers.insert(slope);
            for times in 0..3 {
                let mut product = slope;
                product[times] += 1;
                powers.insert(product);
            }
        }
    }
    powers.into_iter().collect()
}

/// Products of Legendre polynomials: powers of a place would be nearly dependent.
fn legendre(at: &Vector3<f64>, powers: &[[usize; 3]]) -> Vec<f64> {
    let one = |x: f64| [1.0, x, 1.5 * x * x - 0.5, x * (2.5 * x * x - 1.5)];
    let values = [one(at.x), one(at.y), one(at.z)];
    powers
        .iter()
        .map(|p| values[0][p[0]] * values[1][p[1]] * values[2][p[2]])
        .collect()
}

/// Factors, none below zero and no more above it than rows, with `sums * factors = sums * 1`.
fn thinned(sums: DMatrix<f64>) -> Vec<f64> {
    let mut shares = vec![1.0; sums.ncols()];
    let mut null = null_vectors(sums);
    while let Some(v) = null.pop() {
        // As far along the null vector as no factor falls below zero: one becomes zero there.
        let first = (0..v.len())
            .filter(|j| v[*j] > 0.0)
            .min_by(|i, j| (shares[*i] / v[*i]).total_cmp(&(shares[*j] / v[*j])));
        let Some(first) = first else { continue };
        let step = shares[first] / v[first];
        for (share, by) in shares.iter_mut().zip(&v) {
            *share = (*share - step * by).max(0.0);
        }
        shares[first] = 0.0;
        for other in &mut null {
            let part = other[first] / v[first];
            other.iter_mut().zip(&v).for_each(|(o, by)| *o -= part * by);
            other[first] = 0.0;
        }
    }
    shares
}

/// A basis of the vectors that a matrix takes to zero, by elimination with complete pivoting.
fn null_vectors(mut a: DMatrix<f64>) -> Vec<Vec<f64>> {
    let (rows, columns) = a.shape();
    let mut order: Vec<usize> = (0..columns).collect();
    let (mut rank, scale) = (0, a.amax());
    while rank < rows.min(columns) {
        let part = a.view((rank, rank), (rows - rank, columns - rank));
        let (i, j) = part.iamax_full();
        // What rounding leaves of a dependent row: a moment that the points cannot tell.
        if part[(i, j)].abs() <= 1e-13 * scale {
            break;
        }
        a.swap_rows(rank, rank + i);
        a.swap_columns(rank, rank + j);
        order.swap(rank, rank + j);
        let pivot = a[(rank, rank)];
        for column in rank..columns {
            a[(rank, column)] /= pivot;
        }
        for row in (0..rows).filter(|row| *row != rank) {
            let by = a[(row, rank)];
            for column in rank..columns {
                let above = a[(rank, column)];
                a[(row, column)] -= by * above;
            }
        }
        rank += 1;
    }
    let vector = |free: usize| {
        let mut v = vec![0.0; columns];
        v[order[free]] = 1.0;
        (0..rank).for_each(|row| v[order[row]] = -a[(row, free)]);
        v
    };
    (rank..columns).map(vector).collect()
}
