//! The root that is kept, precision, threads.

use std::num::NonZeroUsize;

use nalgebra::{DMatrix, DVector};

use super::super::{Dissection, Ldl, Precision, Triplets};
use super::meshes::{dense, elastic, random};

/// The Schur complement by dense algebra.
fn schur(whole: &DMatrix<f64>, root: &[usize]) -> DMatrix<f64> {
    let others: Vec<usize> = (0..whole.nrows()).filter(|i| !root.contains(i)).collect();
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| whole[(rows[i], columns[j])])
    };
    if others.is_empty() {
        return part(root, root);
    }
    let solved = part(&others, &others).lu().solve(&part(&others, root)).unwrap();
    part(root, root) - part(root, &others) * solved
}

/// Everything that a kept root promises of one matrix.
fn holds(triplets: &Triplets, places: Option<&[[f64; 3]]>, root: &[usize], bound: f64) {
    let size = triplets.size();
    let dissection = match places {
        Some(places) => Dissection::by_places(places, root),
        None => Dissection::by_pattern(size, root),
    };
    let mut ldl = Ldl::ordered_by(dissection.unwrap());
    let inertia = ldl.factor(triplets, 0.0).unwrap();
    let whole = dense(triplets);
    assert_eq!(
        inertia.negative,
        whole
            .clone()
            .symmetric_eigenvalues()
            .iter()
            .filter(|v| **v < 0.0)
            .count()
    );
    let (unknowns, s) = ldl.root();
    assert!(unknowns.iter().map(|u| *u as usize).eq(root.iter().copied()));
    let exact = schur(&whole, root);
    let scale = exact.amax().max(1.0);
    assert!(
        (s - &exact).amax() <= bound * scale,
        "{root:?}: {}",
        (s - &exact).amax()
    );
    assert_eq!(s, &s.transpose());

    let b: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
    let mut x = b.clone();
    ldl.solve(&mut x);
    let reduced = ldl.reduce(&b);
    let y = if root.is_empty() {
        DVector::zeros(0)
    } else {
        s.clone()
            .lu()
            .solve(&DVector::from_column_slice(reduced.on_root()))
            .unwrap()
    };
    let by_root = ldl.back(&reduced, y.as_slice());
    let most = x.iter().map(|x| x.abs()).fold(1.0, f64::max);
    assert!(
        x.iter().zip(&by_root).all(|(a, b)| (a - b).abs() <= bound * most),
        "{root:?}"
    );
    // Any other place of the root: the others are in balance with it.
    let moved = ldl.back(&reduced, &vec![0.7; root.len()]);
    let left = triplets.product(&moved);
    let free = (0..size).filter(|i| !root.contains(i));
    assert!(free.into_iter().all(|i| (left[i] - b[i]).abs() < 40.0 * bound * most));
    assert!(root.iter().all(|i| moved[*i] == 0.7));
}

#[test]
fn a_kept_root_is_the_schur_complement_and_solves_as_the_whole() {
    let (triplets, places) = elastic(3, 0.3, 1.0);
    let top: Vec<usize> = (0..places.len()).filter(|u| places[*u][2] == 3.0).collect();
    // Parts of a node, any order, far from one another; all; none. The condition is some hundred.
    let everything: Vec<usize> = (0..places.len()).rev().collect();
    for root in [&[][..], &[7], &[100, 3, 50, 4, 5], &top, &everything] {
        holds(&triplets, Some(&places), root, 1e-12);
        holds(&triplets, None, root, 1e-12);
    }
}

#[test]
fn roots_of_random_and_disconnected_graphs() {
    for (k, (size, edges, parts)) in [(1, 0, 1), (40, 0, 1), (120, 1, 1), (150, 2, 4), (160, 3, 1)]
        .into_iter()
        .enumerate()
    {
        let triplets = random(size, edges, parts, 12.0, k as u64);
        for count in [0, 1, size / 3, size] {
            let root: Vec<usize> = (0..count).map(|i| (i * 7 + 3) % size).collect();
            // Seven has no part in the sizes: no unknown comes twice.
            holds(&triplets, None, &root, 1e-13);
        }
        // Negative: the others' part is as far from singular.
        let triplets = random(size, edges, parts, -12.0, k as u64);
        holds(&triplets, None, &[size - 1], 1e-13);
    }
}

#[test]
fn a_root_that_nothing_holds_is_there_although_the_whole_is_singular() {
    let mut triplets = Triplets::new(3);
    for (i, j) in [(0, 1), (1, 2)] {
        triplets.add(i, i, 1.0);
        triplets.add(j, j, 1.0);
        triplets.add(i, j, -1.0);
    }
    let mut ldl = Ldl::ordered_by(Dissection::by_pattern(3, &[2, 0]).unwrap());
    let refused = ldl.factor(&triplets, 0.0).unwrap_err();
    assert_eq!(refused.unknown, 0);
    // Two springs in a row.
    assert_eq!(ldl.root().1, &DMatrix::from_row_slice(2, 2, &[0.5, -0.5, -0.5, 0.5]));
    assert_eq!(ldl.reduce(&[0.0, 1.0, 0.0]).on_root(), [0.5, 0.5]);
}

/// Nearly incompressible, stiff cells beside soft ones: conditions of 10, 1e4 and 1e5 and more.
#[test]
fn a_factor_in_single_precision_is_refined_to_rounding() {
    for (ratio, soft, least) in [(0.3, 1.0, 1e1), (0.4999, 1.0, 1e4), (0.49, 1e-4, 1e5)] {
        let (triplets, places) = elastic(5, ratio, soft);
        let eigen = dense(&triplets).symmetric_eigenvalues();
        assert!(eigen.max() / eigen.min() > least, "{}", eigen.max() / eigen.min());
        let root: Vec<usize> = (0..places.len()).filter(|u| places[*u][2] == 5.0).collect();
        let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &root).unwrap());
        ldl.set_precision(Precision::Single);
        ldl.factor(&triplets, 0.0).unwrap();
        let exact: Vec<f64> = (0..places.len()).map(|i| (i as f64).sin()).collect();
        let b = triplets.product(&exact);
        let scale = b.iter().map(|b| b.abs()).fold(0.0, f64::max);
        let mut x = vec![0.0; b.len()];
        let mut errors = Vec::new();
        for _ in 0..6 {
            let mut left: Vec<f64> = triplets.product(&x).iter().zip(&b).map(|(y, b)| b - y).collect();
            errors.push(left.iter().map(|l| l.abs()).fold(0.0, f64::max) / scale);
            ldl.solve(&mut left);
            x.iter_mut().zip(&left).for_each(|(x, d)| *x += d);
        }
        // One solution alone is no better than single precision, so that this is what was tested.
        assert!(errors[1] > 1e-10, "{errors:?}");
        assert!(errors[4] < 1e-12, "{errors:?}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (triplets, places) = elastic(8, 0.3, 1.0);
    let root: Vec<usize> = (0..places.len()).filter(|u| places[*u][2] == 8.0).take(60).collect();
    for root in [&root[..], &[]] {
        let dissection = Dissection::by_places(&places, root).unwrap();
        let of = |threads: usize, shift: f64| {
            let mut ldl = Ldl::ordered_by(dissection.clone());
            ldl.set_threads(NonZeroUsize::new(threads).unwrap());
            let inertia = ldl.factor(&triplets, shift).unwrap();
            let mut x = vec![1.0; places.len()];
            ldl.solve(&mut x);
            let s = ldl.root().1.clone();
            let definite = ldl.definite(shift).unwrap();
            (inertia, x, s, definite, ldl.falling_direction())
        };
        for shift in [0.0, -0.3] {
            let one = of(1, shift);
            assert_eq!(one.4.is_some(), shift < 0.0);
            for threads in [2, 3, 8, 64] {
                assert_eq!(of(threads, shift), one, "{threads} {shift}");
            }
        }
    }
}

/// One front so large that its products are shared.
#[test]
fn threads_that_share_a_front_give_the_same_bits() {
    let size = 600;
    let triplets = random(size, 3 * size, 1, 400.0, 6);
    let of = |threads: usize, root: &[usize]| {
        let mut ldl = Ldl::ordered_by(Dissection::by_pattern(size, root).unwrap());
        ldl.set_threads(NonZeroUsize::new(threads).unwrap());
        ldl.factor(&triplets, 0.0).unwrap();
        let mut x = vec![1.0; size];
        ldl.solve(&mut x);
        (x, ldl.root().1.clone())
    };
    for root in [&[][..], &[3, 1, 599]] {
        let one = of(1, root);
        for threads in [2, 5] {
            assert_eq!(of(threads, root), one, "{threads}");
        }
    }
}

#[test]
fn threads_name_the_same_unknown_where_a_matrix_is_singular() {
    let (mut triplets, places) = elastic(6, 0.3, 1.0);
    let mut fixed = vec![false; places.len()];
    (40..50).for_each(|u| fixed[7 * u] = true);
    triplets.fix(&fixed, 0.0);
    let refused = [1, 2, 5].map(|threads| {
        let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &[]).unwrap());
        ldl.set_threads(NonZeroUsize::new(threads).unwrap());
        ldl.factor(&triplets, 0.0).unwrap_err()
    });
    assert!(fixed[refused[0].unknown]);
    assert_eq!(refused, [refused[0]; 3]);
}

/// What a front leaves behind was kept by each elimination that ended early: memory grew to gigabytes in searches through states that
/// are no minima.
#[test]
fn eliminations_that_end_early_take_no_more_memory_each_time() {
    let (triplets, places) = elastic(8, 0.3, 1.0);
    // The less it is indefinite, the later is its first negative pivot, and the more was left behind till then.
    let shifts = (0..7).map(|k| -0.3 * 0.5_f64.powi(k));
    for (threads, shift) in shifts.flat_map(|shift| [(1, shift), (3, shift)]) {
        let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &[]).unwrap());
        ldl.set_threads(NonZeroUsize::new(threads).unwrap());
        ldl.take(&triplets);
        let mut held = [0, 0];
        // Memory that is too short for its first uses grows in the first rounds.
        for (rounds, held) in [20, 20].into_iter().zip(&mut held) {
            (0..rounds).for_each(|_| assert!(!ldl.definite(shift).unwrap()));
            *held = ldl.workers.held();
        }
        assert!(held[1] <= held[0], "{threads} threads, {shift}: {held:?}");
    }
}
