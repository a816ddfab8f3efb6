//! Orders by nested dissection.

use nalgebra::{Point3, Rotation3};

use super::super::order::{Dissection, NoOrder};
use super::super::{Ldl, Triplets};
use super::meshes::{Numbers, dense, elastic, random};

fn is_permutation(order: &[u32], size: usize) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted.iter().copied().eq(0..size as u32)
}

/// Residual of a solution beside what rounding may leave, in the largest entry.
fn lack(ldl: &Ldl, triplets: &Triplets) -> f64 {
    let b: Vec<f64> = (0..triplets.size()).map(|i| (i as f64 + 0.5).sin()).collect();
    let mut x = b.clone();
    ldl.solve(&mut x);
    let left = triplets.product(&x).into_iter().zip(&b);
    left.map(|(y, b)| (y - b).abs()).fold(0.0, f64::max)
}

#[test]
fn random_graphs_in_several_parts_are_solved_and_have_their_inertia() {
    for (k, (size, edges, parts)) in [
        (1, 0, 1),
        (2, 1, 1),
        (3, 0, 1),
        (300, 0, 1),
        (400, 1, 1),
        (500, 2, 3),
        (600, 3, 2),
        (300, 20, 1),
    ]
    .into_iter()
    .enumerate()
    {
        for diagonal in [30.0, 3.0] {
            let triplets = random(size, edges, parts, diagonal, k as u64);
            let mut numbers = Numbers(7 + k as u64);
            let places: Vec<[f64; 3]> = (0..size).map(|_| std::array::from_fn(|_| numbers.next())).collect();
            let negative = Ldl::new().factor(&triplets, 0.0).unwrap().negative;
            let same = vec![[1.0; 3]; size];
            let orders = [
                Dissection::by_pattern(size, &[]),
                Dissection::by_places(&places, &[]),
                Dissection::by_places(&same, &[]),
            ];
            for dissection in orders {
                let mut ldl = Ldl::ordered_by(dissection.unwrap());
                let inertia = ldl.factor(&triplets, 0.0).unwrap();
                assert_eq!((inertia.negative, inertia.positive), (negative, size - negative));
                assert!(is_permutation(ldl.order(), size), "{size} {edges}");
                // A row's sum is 40 or so, times rounding; indefinite ones times the growth of the entries.
                let bound = if diagonal > 20.0 { 1e-13 } else { 1e-8 };
                assert!(lack(&ldl, &triplets) < bound, "{size} {edges} {diagonal}");
            }
        }
    }
}

#[test]
fn indefinite_matrices_have_the_inertia_of_their_eigenvalues() {
    let (triplets, places) = elastic(3, 0.3, 1.0);
    let eigen = dense(&triplets).symmetric_eigenvalues();
    let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &[]).unwrap());
    ldl.take(&triplets);
    for shift in [0.0, -0.05, -0.2, -0.5, -1.0, -9.0] {
        let negative = eigen.iter().filter(|v| **v + shift < 0.0).count();
        assert_eq!(ldl.shifted(shift).unwrap().negative, negative, "{shift}");
        assert_eq!(ldl.definite(shift).unwrap(), negative == 0);
    }
}

/// A cube of `11^3` nodes costs less than 0.6 of minimum degree's work by places, whatever the axes' scale and the unknowns' numbers.
#[test]
fn a_mesh_is_dissected_as_well_when_its_unknowns_are_shuffled_and_its_axes_stretched() {
    let (triplets, places) = elastic(10, 0.3, 1.0);
    let size = triplets.size();
    let mut minimum = Ldl::new();
    minimum.take(&triplets);
    let mut numbers = Numbers(3);
    let mut shuffled: Vec<usize> = (0..size).collect();
    (1..size).rev().for_each(|i| shuffled.swap(i, numbers.below(i + 1)));
    let mut other = Triplets::new(size);
    for (&(i, j), value) in triplets.places.iter().zip(&triplets.values) {
        other.add(shuffled[i as usize], shuffled[j as usize], *value);
    }
    for scale in [[1.0, 1.0, 1.0], [1e-9, 1.0, 1e9]] {
        let mut moved = vec![[0.0; 3]; size];
        (0..size).for_each(|i| moved[shuffled[i]] = std::array::from_fn(|d| scale[d] * places[i][d] - 1e3));
        let mut ldl = Ldl::ordered_by(Dissection::by_places(&moved, &[]).unwrap());
        ldl.factor(&other, 0.0).unwrap();
        assert!(is_permutation(ldl.order(), size));
        // Entries of up to 3, solutions of up to 1e3: times rounding, some tens of times.
        assert!(lack(&ldl, &other) < 1e-10);
        assert!(
            (ldl.work() as f64) < 0.6 * minimum.work() as f64,
            "{} {}",
            ldl.work(),
            minimum.work()
        );
    }
}

/// Cells that lie across the axes, and no places at all, cost no more than two thirds of minimum degree either.
#[test]
fn a_mesh_is_dissected_well_across_the_axes_and_by_its_pattern() {
    let (triplets, places) = elastic(10, 0.3, 1.0);
    let work = |mut ldl: Ldl| {
        ldl.take(&triplets);
        ldl.work() as f64
    };
    let turn = Rotation3::from_euler_angles(0.4, 0.5, 0.6);
    let turned: Vec<[f64; 3]> = places.iter().map(|p| (turn * Point3::from(*p)).into()).collect();
    let minimum = work(Ldl::new());
    for dissection in [
        Dissection::by_places(&turned, &[]),
        Dissection::by_pattern(places.len(), &[]),
    ] {
        let found = work(Ldl::ordered_by(dissection.unwrap()));
        assert!(found < 0.67 * minimum, "{found} {minimum}");
    }
}

#[test]
fn the_same_order_is_found_every_time() {
    let (triplets, places) = elastic(6, 0.3, 1.0);
    for dissection in [
        Dissection::by_places(&places, &[5, 1]),
        Dissection::by_pattern(places.len(), &[5, 1]),
    ] {
        let dissection = dissection.unwrap();
        let orders = [0; 2].map(|_| {
            let mut ldl = Ldl::ordered_by(dissection.clone());
            ldl.take(&triplets);
            ldl.order().to_vec()
        });
        assert_eq!(orders[0], orders[1]);
    }
}

#[test]
fn what_is_no_order_is_refused_by_name() {
    let places = |x: f64| vec![[0.0; 3], [1.0, x, 0.0]];
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(Dissection::by_places(&places(x), &[]).unwrap_err(), NoOrder::Place(1));
    }
    assert_eq!(
        Dissection::by_places(&places(0.0), &[1, 0, 1]).unwrap_err(),
        NoOrder::Twice(1)
    );
    let beyond = NoOrder::Beyond { unknown: 2, size: 2 };
    assert_eq!(Dissection::by_pattern(2, &[2]).unwrap_err(), beyond);
    assert!(Dissection::by_places(&[], &[]).is_ok());
    // Finite, although their difference is not.
    let far = [[f64::MAX; 3], [-f64::MAX; 3]];
    let mut ldl = Ldl::ordered_by(Dissection::by_places(&far, &[]).unwrap());
    ldl.take(&random(2, 1, 1, 9.0, 1));
    assert_eq!(ldl.order().len(), 2);
}

#[test]
fn a_matrix_of_another_size_is_dissected_by_its_pattern_and_keeps_no_root() {
    let mut ldl = Ldl::ordered_by(Dissection::by_places(&[[0.0; 3]; 4], &[2]).unwrap());
    ldl.factor(&random(4, 1, 1, 9.0, 1), 0.0).unwrap();
    let triplets = random(300, 3, 1, 30.0, 4);
    ldl.factor(&triplets, 0.0).unwrap();
    assert!(ldl.root().0.is_empty() && ldl.root().1.is_empty());
    assert!(lack(&ldl, &triplets) < 1e-13);
    ldl.factor(&random(4, 1, 1, 9.0, 1), 0.0).unwrap();
    assert_eq!(ldl.root().0, [2]);
    ldl.factor(&Triplets::new(0), 0.0).unwrap();
    ldl.solve(&mut []);
}

#[test]
fn a_pattern_that_changes_is_ordered_again() {
    let (triplets, places) = elastic(4, 0.3, 1.0);
    let root = [9, 280, 299];
    let mut ldl = Ldl::ordered_by(Dissection::by_places(&places, &root[..1]).unwrap());
    ldl.factor(&triplets, 0.0).unwrap();
    let mut more = triplets.clone();
    more.add(root[1], root[0], 0.01);
    more.add(root[2], 0, 0.01);
    ldl.factor(&more, 0.0).unwrap();
    assert!(lack(&ldl, &more) < 1e-12);
    assert_eq!(ldl.root().0, [9]);
    ldl.factor(&triplets, 0.0).unwrap();
    assert!(lack(&ldl, &triplets) < 1e-12);
}
