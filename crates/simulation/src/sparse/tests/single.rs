//! Factors in single precision from end to end.

use std::num::NonZeroUsize;

use super::super::{Dissection, Ldl, Precision, Triplets};
use super::meshes::{dense, elastic, random};

fn throughout(dissection: Dissection, threads: usize) -> Ldl {
    let mut ldl = Ldl::ordered_by(dissection);
    ldl.set_precision(Precision::SingleThroughout);
    ldl.set_threads(NonZeroUsize::new(threads).unwrap());
    ldl
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// What so many solutions with the residual in double leave of a right side, beside its largest entry.
fn left_after(ldl: &Ldl, triplets: &Triplets, solutions: usize) -> f64 {
    let exact: Vec<f64> = (0..triplets.size()).map(|i| (i as f64).sin()).collect();
    let b = triplets.product(&exact);
    let (mut x, mut left) = (vec![0.0; b.len()], b.clone());
    for _ in 0..solutions {
        ldl.solve(&mut left);
        x.iter_mut().zip(&left).for_each(|(x, d)| *x += d);
        left = triplets.product(&x).iter().zip(&b).map(|(y, b)| b - y).collect();
    }
    largest(&left) / largest(&b)
}

/// Conditions of 10, 1e4 and 1e5 and more, as of factors that are only kept in single precision.
#[test]
fn solutions_are_refined_to_rounding() {
    for (ratio, soft) in [(0.3, 1.0), (0.4999, 1.0), (0.49, 1e-4)] {
        let (triplets, places) = elastic(5, ratio, soft);
        let root: Vec<usize> = (0..places.len()).filter(|u| places[*u][2] == 5.0).collect();
        for root in [&root[..], &[]] {
            let mut ldl = throughout(Dissection::by_places(&places, root).unwrap(), 1);
            ldl.take(&triplets);
            assert!(ldl.definite(0.0).unwrap());
            let errors = [1, 2, 4, 6].map(|count| left_after(&ldl, &triplets, count));
            // One solution alone is no better than single precision, so that this is what was tested.
            assert!(errors[0] > 1e-10 && errors[3] < 1e-12, "{ratio} {soft}: {errors:?}");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (elastic, places) = elastic(8, 0.3, 1.0);
    // One front so large that its products, and what its children leave, are shared.
    let wide = random(600, 1800, 1, 400.0, 6);
    let orders = [
        (&elastic, Dissection::by_places(&places, &[5, 7]).unwrap()),
        (&wide, Dissection::by_pattern(600, &[3, 599]).unwrap()),
    ];
    for (triplets, order) in orders {
        let of = |threads: usize| {
            let mut ldl = throughout(order.clone(), threads);
            let found = ldl.factor(triplets, 0.0).unwrap();
            let mut x = vec![1.0; triplets.size()];
            ldl.solve(&mut x);
            let falls = ldl.definite(-500.0).unwrap();
            (found, x, falls, ldl.falling_direction(), ldl.root().1.clone())
        };
        let one = of(1);
        for threads in [2, 3, 8] {
            assert_eq!(of(threads), one, "{threads}");
        }
    }
}

/// Beyond what single precision holds: the matrix is brought near 1 first.
#[test]
fn a_matrix_times_a_power_of_two_gives_the_same_bits() {
    let (triplets, places) = elastic(4, 0.49, 1.0);
    for precision in [Precision::Double, Precision::Single, Precision::SingleThroughout] {
        let of = |power: i32| {
            let scale = 2.0_f64.powi(power);
            let mut other = triplets.clone();
            other.values.iter_mut().for_each(|v| *v *= scale);
            let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &[0, 9]).unwrap());
            ldl.set_precision(precision);
            ldl.factor(&other, 0.0).unwrap();
            let mut x = vec![1.0; places.len()];
            ldl.solve(&mut x);
            x.iter_mut().for_each(|x| *x *= scale);
            (x, ldl.root().1 / scale)
        };
        let one = of(0);
        for power in [-400, -150, 1, 130, 400] {
            assert_eq!(of(power), one, "{precision:?} {power}");
        }
    }
}

/// With no eigenvalue within 1e-4 of zero, signs are those of the eigenvalues, and a falling direction falls.
#[test]
fn signs_are_those_of_the_eigenvalues() {
    let (triplets, places) = elastic(3, 0.3, 1.0);
    let whole = dense(&triplets);
    let eigen = whole.clone().symmetric_eigenvalues();
    for shift in [0.0, -0.05, -0.2, -0.5, -1.0, -9.0] {
        assert!(eigen.iter().all(|v| (v + shift).abs() > 1e-4), "{shift}");
        let mut ldl = throughout(Dissection::by_places(&places, &[]).unwrap(), 1);
        let negative = eigen.iter().filter(|v| **v + shift < 0.0).count();
        assert_eq!(ldl.factor(&triplets, shift).unwrap().negative, negative, "{shift}");
        assert_eq!(ldl.definite(shift), Ok(negative == 0));
        if let Some(v) = ldl.falling_direction() {
            let v = nalgebra::DVector::from_vec(v);
            assert!(v.dot(&(&whole * &v)) + shift * v.norm_squared() < 0.0, "{shift}");
        }
    }
}

#[test]
fn singular_and_not_finite_matrices_are_refused_by_unknown() {
    let (mut triplets, places) = elastic(6, 0.3, 1.0);
    let mut fixed = vec![false; places.len()];
    (40..50).for_each(|u| fixed[7 * u] = true);
    triplets.fix(&fixed, 0.0);
    let order = Dissection::by_places(&places, &[]).unwrap();
    let refused = [1, 2, 5].map(|threads| throughout(order.clone(), threads).factor(&triplets, 0.0).unwrap_err());
    let mut double = Ldl::ordered_by(order.clone());
    let as_double = double.factor(&triplets, 0.0).unwrap_err();
    assert_eq!(refused, [as_double; 3]);
    triplets.add(9, 9, f64::NAN);
    assert!(throughout(order.clone(), 2).factor(&triplets, 0.0).is_err());
    triplets.add(9, 9, f64::INFINITY);
    assert!(throughout(order, 2).factor(&triplets, 0.0).is_err());
}
