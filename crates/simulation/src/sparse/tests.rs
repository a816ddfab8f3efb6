//! Factorisations against dense algebra.

mod cover;
mod dissection;
mod kept;
mod meshes;
mod single;

use nalgebra::{DMatrix, DVector};

use super::Triplets;
use super::ldl::*;

/// A symmetric matrix of the pattern of a `side` x `side` grid of pairs, diagonal `diagonal`.
fn grid(side: usize, diagonal: f64, seed: u64) -> (Triplets, DMatrix<f64>) {
    let n = 2 * side * side;
    let mut triplets = Triplets::new(n);
    let mut dense = DMatrix::zeros(n, n);
    let mut state = seed;
    for i in 0..n {
        for j in 0..=i {
            let (a, b) = (i / 2, j / 2);
            let near = (a % side).abs_diff(b % side) <= 1 && (a / side).abs_diff(b / side) <= 1;
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            if near {
                let value = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                let value = if i == j { value + diagonal } else { value };
                // In two parts, so that repetitions must add up.
                triplets.add(i, j, 0.25 * value);
                triplets.add(j, i, 0.75 * value);
                dense[(i, j)] = value;
                dense[(j, i)] = value;
            }
        }
    }
    (triplets, dense)
}

#[test]
fn solutions_and_signs_agree_with_dense_algebra() {
    // 20: definite. 0.3 and -2: indefinite, with the signs of the dense eigenvalues.
    for (diagonal, side) in [(20.0, 1), (20.0, 6), (2.0, 7), (-2.0, 5), (-20.0, 6)] {
        let (triplets, dense) = grid(side, diagonal, 42);
        let mut ldl = Ldl::new();
        let inertia = ldl.factor(&triplets, 0.0).unwrap();
        let eigen = dense.clone().symmetric_eigenvalues();
        assert_eq!(inertia.negative, eigen.iter().filter(|v| **v < 0.0).count());
        assert_eq!(inertia.positive + inertia.negative, triplets.size());
        let x = DVector::from_fn(triplets.size(), |i, _| (i as f64).sin());
        let mut b: Vec<f64> = (&dense * &x).as_slice().to_vec();
        assert!((DVector::from_vec(triplets.product(x.as_slice())) - &dense * &x).amax() < 1e-13);
        ldl.solve(&mut b);
        // Rounding times the condition and the growth of a factorisation without pivoting.
        let bound = if diagonal.abs() > 5.0 { 1e-13 } else { 1e-9 };
        assert!((DVector::from_vec(b) - x).amax() < bound, "{diagonal} {side}");
    }
}

#[test]
fn what_is_not_definite_ends_with_a_falling_direction() {
    for (diagonal, side) in [(20.0, 6), (2.0, 7), (0.3, 5), (-20.0, 6)] {
        let (triplets, dense) = grid(side, diagonal, 42);
        let (mut ldl, mut whole) = (Ldl::new(), Ldl::new());
        ldl.take(&triplets);
        for shift in [0.0, 1.0, 30.0] {
            let inertia = whole.factor(&triplets, shift).unwrap();
            assert_eq!(ldl.definite(shift), Ok(inertia.negative == 0), "{diagonal} {shift}");
            let Some(v) = ldl.falling_direction() else {
                assert_eq!(inertia.negative, 0);
                continue;
            };
            assert_eq!(Some(&v), whole.falling_direction().as_ref());
            let v = DVector::from_vec(v);
            let form = v.dot(&(&dense * &v)) + shift * v.norm_squared();
            assert!(form < 0.0, "{diagonal} {shift}: {form}");
        }
    }
}

#[test]
fn dense_parts_of_the_same_unknowns_add_up() {
    let mut parts = Triplets::new(6);
    let mut single = Triplets::new(6);
    for (scale, unknowns) in [(1.0, [4, 1, 3]), (2.0, [4, 1, 3]), (4.0, [1, 4, 3]), (8.0, [4, 1, 3])] {
        let values: Vec<f64> = (0..6).map(|k| scale * (f64::from(k) + 1.0)).collect();
        parts.add_block(unknowns.into_iter(), &values);
        let mut values = values.into_iter();
        for (k, i) in unknowns.iter().enumerate() {
            unknowns[..=k]
                .iter()
                .for_each(|j| single.add(*i, *j, values.next().unwrap()));
        }
    }
    assert_eq!(parts.values.len(), 18);
    let x = [1.0, -2.0, 3.0, 5.0, -7.0, 11.0];
    assert_eq!(parts.product(&x), single.product(&x));
    parts.reset(6);
    parts.add_block([4, 1, 3].into_iter(), &[1.0; 6]);
    assert_eq!((parts.places.len(), parts.values.len()), (6, 6));
}

#[test]
fn a_shift_moves_the_eigenvalues() {
    let (triplets, dense) = grid(4, 0.0, 9);
    for shift in [-1.5, -0.4, 0.4, 1.5] {
        let inertia = Ldl::new().factor(&triplets, shift).unwrap();
        let eigen = dense.clone().symmetric_eigenvalues();
        assert_eq!(
            inertia.negative,
            eigen.iter().filter(|v| **v + shift < 0.0).count(),
            "{shift}"
        );
    }
}

#[test]
fn a_pattern_met_before_gives_the_same_as_a_new_one() {
    let mut ldl = Ldl::new();
    for (side, seed) in [(3, 1), (5, 2), (5, 3), (3, 4)] {
        let (triplets, _) = grid(side, 20.0, seed);
        let (mut fresh, mut b) = (Ldl::new(), vec![1.0; triplets.size()]);
        let mut c = b.clone();
        assert_eq!(ldl.factor(&triplets, 0.0), fresh.factor(&triplets, 0.0));
        ldl.solve(&mut b);
        fresh.solve(&mut c);
        assert_eq!(b, c);
    }
}

#[test]
fn an_elimination_kept_for_two_patterns_solves_both() {
    let (full, _) = grid(5, 20.0, 7);
    let mut without = Triplets::new(full.size());
    // The same without the couplings of far unknowns, and with one that the first lacks.
    for (&(i, j), value) in full.places.iter().zip(&full.values) {
        if i.abs_diff(j) < 8 {
            without.add(i as usize, j as usize, *value);
        }
    }
    without.add(full.size() - 1, 0, 0.5);
    let mut kept = Ldl::new();
    for round in 0..4 {
        let matrix = if round % 2 == 0 { &full } else { &without };
        let (mut fresh, mut b) = (Ldl::new(), vec![1.0; matrix.size()]);
        let mut c = b.clone();
        assert_eq!(kept.factor(matrix, 0.0), fresh.factor(matrix, 0.0));
        kept.solve(&mut b);
        fresh.solve(&mut c);
        // Another order rounds otherwise: the condition is below 10.
        assert!(b.iter().zip(&c).all(|(b, c)| (b - c).abs() < 1e-15), "{round}");
        assert_eq!(kept.joined, if round == 0 { 1 } else { 2 });
    }
}

#[test]
fn singular_and_not_finite_matrices_are_refused_by_unknown() {
    let mut zero = Triplets::new(3);
    zero.add(0, 0, 1.0);
    zero.add(2, 2, 1.0);
    let refused = Ldl::new().factor(&zero, 0.0).unwrap_err();
    assert_eq!(refused.unknown, 1, "{refused}");
    zero.add(1, 1, f64::NAN);
    assert!(Ldl::new().factor(&zero, 0.0).is_err());
}

#[test]
fn fixed_unknowns_keep_out_of_the_rest() {
    let (mut triplets, dense) = grid(3, 20.0, 5);
    let mut fixed = vec![false; triplets.size()];
    fixed[4] = true;
    triplets.fix(&fixed, 1.0);
    let mut ldl = Ldl::new();
    ldl.factor(&triplets, 0.0).unwrap();
    let mut b = vec![1.0; triplets.size()];
    b[4] = 0.0;
    ldl.solve(&mut b);
    let rest = (&dense * DVector::from_column_slice(&b)).map(|v| v - 1.0);
    assert_eq!(b[4], 0.0);
    assert!(rest.iter().enumerate().all(|(i, r)| i == 4 || r.abs() < 1e-13));
}

/// A matrix without zeros, as one front of many columns: products by the library.
fn full(size: usize, diagonal: f64) -> (Triplets, DMatrix<f64>) {
    let (mut triplets, mut dense) = (Triplets::new(size), DMatrix::zeros(size, size));
    for i in 0..size {
        for j in 0..=i {
            let value = ((i * 37 + j * 91) as f64).sin() + if i == j { diagonal } else { 0.0 };
            triplets.add(i, j, value);
            (dense[(i, j)], dense[(j, i)]) = (value, value);
        }
    }
    (triplets, dense)
}

#[test]
fn fronts_of_any_size_agree_with_dense_algebra() {
    for size in [1, 2, 3, 4, 5, 7, 8, 9, 16, 47, 48, 49, 61, 97, 130, 200, 257, 305, 520] {
        for diagonal in [size as f64, 0.5] {
            let (triplets, dense) = full(size, diagonal);
            let mut ldl = Ldl::new();
            let inertia = ldl.factor(&triplets, 0.0).unwrap();
            let eigen = dense.clone().symmetric_eigenvalues();
            assert_eq!(inertia.negative, eigen.iter().filter(|v| **v < 0.0).count(), "{size}");
            let x = DVector::from_fn(size, |i, _| 1.0 + (i as f64).cos());
            let mut b: Vec<f64> = (&dense * &x).as_slice().to_vec();
            ldl.solve(&mut b);
            // Definite: rounding. Else without pivoting: times the growth of the entries.
            let bound = if diagonal >= size as f64 { 1e-12 } else { 1e-5 };
            assert!((DVector::from_vec(b) - x).amax() < bound, "{size} {diagonal}");
        }
    }
}

#[test]
fn a_large_grid_is_solved_to_rounding() {
    // 2592 unknowns: fronts of all sizes, joined with zeros, one on the other.
    let side = 36;
    let mut triplets = Triplets::new(2 * side * side);
    for i in 0..triplets.size() {
        for j in 0..=i {
            let (a, b) = (i / 2, j / 2);
            if (a % side).abs_diff(b % side) <= 1 && (a / side).abs_diff(b / side) <= 1 {
                triplets.add(i, j, if i == j { 12.0 } else { ((i + 3 * j) as f64).sin() });
            }
        }
    }
    let x: Vec<f64> = (0..triplets.size()).map(|i| (i as f64).cos()).collect();
    let mut b = triplets.product(&x);
    let mut ldl = Ldl::new();
    ldl.factor(&triplets, 0.0).unwrap();
    ldl.solve(&mut b);
    let residual = triplets.product(&b).into_iter().zip(triplets.product(&x));
    // The largest sum of a row, 30, times rounding, some tens of times.
    assert!(residual.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12);
}

/// The bound of a degree sums up elements that overlap: it once named a bucket beyond the last.
#[test]
fn orders_of_dense_and_star_shaped_patterns_are_found() {
    for size in [1, 2, 30] {
        for star in [false, true] {
            let mut triplets = Triplets::new(size);
            for i in 0..size {
                triplets.add(i, i, 3.0 * size as f64);
                for j in (0..i).filter(|j| !star || *j == 0 || i % 7 == j % 7) {
                    triplets.add(i, j, 1.0);
                }
            }
            let mut b = triplets.product(&vec![1.0; size]);
            let mut ldl = Ldl::new();
            ldl.factor(&triplets, 0.0).unwrap();
            ldl.solve(&mut b);
            assert!(b.iter().all(|x| (x - 1.0).abs() < 1e-14), "{size} {star}");
        }
    }
}
