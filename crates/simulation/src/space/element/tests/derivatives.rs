//! Forces and stiffness against differences of what they derive; convexity; memory.

use super::*;
use crate::sparse::Triplets;

#[test]
fn forces_and_stiffness_are_the_derivatives() {
    // Differences of step h err by h^2/6 times a third derivative, below 1e3 of the scale, plus eps/h.
    let h = 1e-5;
    for material in materials() {
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            let (table, u) = (&cell.table, noisy(&cell, 0.06, 5));
            let (energy, at) = forces(table, &material, &u);
            let matrix = stiffness(table, &material, &u, false);
            let scale = matrix.amax();
            assert!((table.energy(&material, &u).unwrap() - energy).abs() < 1e-13 * scale);
            for entry in 0..u.len() {
                let moved = |by: f64| {
                    let mut moved = u.clone();
                    moved[entry] += by;
                    moved
                };
                let [plus, minus] = [h, -h].map(|by| forces(table, &material, &moved(by)));
                let slope = (plus.0 - minus.0) / (2.0 * h);
                assert!((slope - at[entry]).abs() < 1e-7 * scale, "{material:?}");
                let column = (plus.1 - minus.1) / (2.0 * h);
                let error = (column - matrix.column(entry)).amax();
                assert!(error < 1e-7 * scale, "{material:?} {error:e} of {scale:e}");
            }
        }
    }
}

#[test]
fn forces_are_added() {
    let cell = cube(Order::Linear, 1.0, Dilatation::Constant);
    let (material, u) = (materials()[2], noisy(&cell, 0.1, 2));
    let (_, once) = forces(&cell.table, &material, &u);
    let mut sum = vec![1.0; 24];
    cell.table.gradient(&material, &u, &mut sum).unwrap();
    assert!(
        sum.iter()
            .zip(&once)
            .all(|(sum, once)| (sum - once - 1.0).abs() < 1e-15)
    );
}

#[test]
fn convex_stiffness_is_positive() {
    let mut lifted = 0;
    for material in materials() {
        for cell in DILATATIONS.into_iter().flat_map(cells) {
            // Squeezed to seven tenths, and noise: where laws are not convex.
            let mut u = displaced(&cell, |x| x * -0.3);
            u.iter_mut().zip(noisy(&cell, 0.03, 8)).for_each(|(u, n)| *u += n);
            let plain = stiffness(&cell.table, &material, &u, false);
            let convex = stiffness(&cell.table, &material, &u, true);
            let least = convex.symmetric_eigenvalues().min();
            assert!(least > -1e-12 * convex.amax(), "{material:?} {least:e}");
            lifted += usize::from(plain.symmetric_eigenvalues().min() < -1e-3 * plain.amax());
        }
    }
    assert!(lifted > 20, "{lifted}");
}

#[test]
fn no_memory_is_asked_for_twice() {
    let cell = cube(Order::Quadratic, 1.0, Dilatation::Linear);
    let (material, u) = (materials()[2], noisy(&cell, 0.05, 2));
    let mut packed = Vec::new();
    cell.table.stiffness(&material, &u, false, &mut packed).unwrap();
    let (first, place) = (packed.clone(), packed.as_ptr());
    cell.table.stiffness(&material, &u, false, &mut packed).unwrap();
    assert_eq!(packed, first);
    assert_eq!(packed.as_ptr(), place);
}

#[test]
fn a_packed_stiffness_is_what_triplets_take() {
    let cell = cube(Order::Linear, 1.0, Dilatation::Constant);
    let (material, u) = (materials()[2], noisy(&cell, 0.05, 2));
    let (mut packed, mut sum) = (Vec::new(), Triplets::new(27));
    cell.table.stiffness(&material, &u, false, &mut packed).unwrap();
    // Unknowns 3 on, the last node first.
    let unknowns = (0..24).map(|k| 3 + 3 * (7 - k / 3) + k % 3);
    sum.add_block(unknowns.clone(), &packed);
    let way: Vec<f64> = (0..27).map(|k| f64::from(k).sin()).collect();
    let found = sum.product(&way);
    let matrix = full(&packed, 24);
    let exact = &matrix * DVector::from_iterator(24, unknowns.clone().map(|k| way[k]));
    let error = unknowns.zip(exact.iter()).map(|(k, exact)| (found[k] - exact).abs());
    assert!(error.fold(0.0, f64::max) < 1e-14 * matrix.amax());
    assert_eq!(found[..3], [0.0; 3]);
}
