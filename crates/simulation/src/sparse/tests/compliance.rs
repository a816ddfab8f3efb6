//! What a few combinations of unknowns move of one another.

use nalgebra::DMatrix;

use super::super::compliance::Combinations;
use super::super::{Dissection, Ldl};
use super::grid;

#[test]
fn compliance_is_that_of_the_dense_inverse() {
    // Definite and indefinite; one combination, none, some that are alike or empty, and more than a strip of the product has.
    for (side, diagonal) in [(1, 20.0), (6, 20.0), (12, 20.0), (9, -20.0)] {
        let (triplets, dense) = grid(side, diagonal, 7);
        let (size, inverse) = (triplets.size(), dense.try_inverse().unwrap());
        let by_pattern = Ldl::ordered_by(Dissection::by_pattern(size, &[]).unwrap());
        for mut ldl in [Ldl::new(), by_pattern] {
            ldl.factor(&triplets, 0.0).unwrap();
            for count in [0, 1, 5, 61] {
                let (mut combinations, mut rows) = (Combinations::default(), DMatrix::zeros(count, size));
                for k in 0..count {
                    // Every fifth is empty; unknowns may come twice.
                    let entries = (0..k % 5).map(|j| (((7 * k + 3 * j) % size) as u32, 1.0 / (1 + j + k) as f64));
                    entries.clone().for_each(|(i, w)| rows[(k, i as usize)] += w);
                    combinations.push(entries);
                }
                let found = ldl.compliance(&combinations);
                let exact = &rows * &inverse * rows.transpose();
                // Rounding of sums of some hundred terms of size 1 / 20, times the growth of a factorisation without pivoting.
                let off = (&found - &exact).iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                assert!(off < 1e-13, "{side} {diagonal} {count}: {off}");
                assert_eq!(found, found.transpose());
            }
        }
    }
}
