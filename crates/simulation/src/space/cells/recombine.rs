//! Fewer points with the same integrals.
//!
//! Of any number of weighted points as many are kept as there are polynomials of a degree, with positive weights and the same
//! moments (Tchakaloff; found as Litterer and Lyons 2012 do: groups of points are thinned before single ones).

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Vector3};

use super::rule::{Inside, Surface};
use crate::space::element::Order;

/// Points inside a cube with the same integrals of all products of a linear function and a derivative of a shape function, at
/// most as many as such products are independent: 17 for 8 nodes, 51 for 27. A state of linear stress then does the exact work
/// on every displacement, which is what the order of convergence rests on. (Polynomials of total degree 4, 35 points, do not
/// even pass a patch test: `d(x^2 y^2 z^2)` has degree 5.)
pub(super) fn inside(points: &[Inside], corners: &[Vector3<f64>; 2], order: Order) -> Vec<Inside> {
    let each = points.iter().map(|p| (p.at, p.weight));
    let kept = recombined(each.collect(), corners, &work_powers(order));
    kept.into_iter()
        .map(|(k, weight)| Inside { weight, ..points[k] })
        .collect()
}

/// Points of the surface in a cube with the same integrals of the shape functions and of all polynomials up to the fourth
/// degree, at most 39: a constant traction does the exact work on every displacement, and of smooth ones little is lost.
pub(super) fn surface(points: &[Surface], corners: &[Vector3<f64>; 2]) -> Vec<Surface> {
    let each = points.iter().map(|p| (p.at, p.area));
    let kept = recombined(each.collect(), corners, &traction_powers());
    kept.into_iter()
        .map(|(k, area)| Surface { area, ..points[k] })
        .collect()
}

/// Of places with weights, those that are kept and their new weights, so that the products of powers keep their sums.
fn recombined(
    points: Vec<(Vector3<f64>, f64)>,
    [low, high]: &[Vector3<f64>; 2],
    powers: &[[usize; 3]],
) -> Vec<(usize, f64)> {
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let mut kept: Vec<(usize, f64)> = points.iter().enumerate().map(|(k, p)| (k, p.1)).collect();
    // Every round halves the number of groups, and with it that of points, at least.
    while kept.len() > powers.len() {
        let groups = (2 * powers.len()).min(kept.len());
        let bounds: Vec<usize> = (0..=groups).map(|g| g * kept.len() / groups).collect();
        let mut sums = DMatrix::zeros(powers.len(), groups);
        for (g, pair) in bounds.windows(2).enumerate() {
            for (k, weight) in &kept[pair[0]..pair[1]] {
                let moments = legendre(&(points[*k].0 - centre).component_div(&half), powers);
                (0..powers.len()).for_each(|row| sums[(row, g)] += weight * moments[row]);
            }
        }
        let shares = thinned(sums);
        let mut next = Vec::with_capacity(kept.len() / 2);
        for (g, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let group = &kept[bounds[g]..bounds[g + 1]];
            next.extend(group.iter().map(|(k, weight)| (*k, weight * share)));
        }
        // Nothing left to drop: as many independent moments as points.
        if next.len() == kept.len() {
            break;
        }
        kept = next;
    }
    kept
}

/// Exponents of the products of shape functions of 27 nodes, and of all polynomials up to the fourth degree.
fn traction_powers() -> Vec<[usize; 3]> {
    let all = (0..125).map(|n| [n % 5, n / 5 % 5, n / 25]);
    all.filter(|p| p.iter().all(|k| *k <= 2) || p.iter().sum::<usize>() <= 4)
        .collect()
}

/// Exponents of the products: of a derivative along one axis of `x^i y^j z^k`, all up to the order, times 1, x, y or z.
fn work_powers(order: Order) -> Vec<[usize; 3]> {
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
    let one = |x: f64| {
        let square = x * x;
        let fourth = (35.0 * square * square - 30.0 * square + 3.0) / 8.0;
        [1.0, x, 1.5 * square - 0.5, x * (2.5 * square - 1.5), fourth]
    };
    let values = [one(at.x), one(at.y), one(at.z)];
    powers
        .iter()
        .map(|p| values[0][p[0]] * values[1][p[1]] * values[2][p[2]])
        .collect()
}

/// Factors, none below zero and no more above it than rows, with `sums * factors = sums * 1`.
fn thinned(sums: DMatrix<f64>) -> Vec<f64> {
    let shares = at_once(&sums);
    // Null vectors are taken off one another: where one is small at the group that it drops, the others lose their digits.
    if error(&sums, &shares) <= MOST_ERROR {
        shares
    } else {
        one_by_one(&sums)
    }
}

/// What moments may change by in a round, beside the largest: a hundred sums of rounded numbers.
const MOST_ERROR: f64 = 1e-12;

/// The largest change of a moment, beside the largest sum of absolute values.
fn error(sums: &DMatrix<f64>, shares: &[f64]) -> f64 {
    let rows = sums.row_iter().map(|row| {
        let change: f64 = row.iter().zip(shares).map(|(m, s)| m * (s - 1.0)).sum();
        (change.abs(), row.iter().map(|m| m.abs()).sum::<f64>())
    });
    let (change, size) = rows.fold((0.0_f64, 0.0_f64), |most, row| (most.0.max(row.0), most.1.max(row.1)));
    change / size
}

/// By one elimination for all groups that are dropped.
fn at_once(sums: &DMatrix<f64>) -> Vec<f64> {
    let mut shares = vec![1.0; sums.ncols()];
    let mut null = null_vectors(sums.clone());
    while let Some(v) = null.pop() {
        let Some(first) = drop_one(&mut shares, &v) else {
            continue;
        };
        for other in &mut null {
            let part = other[first] / v[first];
            other.iter_mut().zip(&v).for_each(|(o, by)| *o -= part * by);
            other[first] = 0.0;
        }
    }
    shares
}

/// By an elimination of what is left for each group that is dropped.
fn one_by_one(sums: &DMatrix<f64>) -> Vec<f64> {
    let mut shares = vec![1.0; sums.ncols()];
    loop {
        let left: Vec<usize> = (0..shares.len()).filter(|k| shares[*k] > 0.0).collect();
        let Some(short) = null_vectors(sums.select_columns(&left)).pop() else {
            return shares;
        };
        let mut v = vec![0.0; shares.len()];
        left.iter().zip(short).for_each(|(k, x)| v[*k] = x);
        if drop_one(&mut shares, &v).is_none() {
            return shares;
        }
    }
}

/// Goes along a null vector as far as no factor falls below zero: one becomes zero there.
fn drop_one(shares: &mut [f64], v: &[f64]) -> Option<usize> {
    let first = (0..v.len())
        .filter(|j| v[*j] > 0.0)
        .min_by(|i, j| (shares[*i] / v[*i]).total_cmp(&(shares[*j] / v[*j])))?;
    let step = shares[first] / v[first];
    for (share, by) in shares.iter_mut().zip(v) {
        *share = (*share - step * by).max(0.0);
    }
    shares[first] = 0.0;
    Some(first)
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
