//! The nearest positive semidefinite tangent.
//!
//! At `F = sum_i s_i u_i v_i^T` the tangent of an isotropic law falls into a twist and a flip of each pair of principal
//! directions, `(u_i v_j^T -+ u_j v_i^T) / sqrt 2`, and a 3 x 3 block of scalings `u_i v_i^T` (Smith, de Goes and Kim
//! 2019): independent sets of eigenvalues, each lifted by itself.

use nalgebra::Matrix3;

use super::principal::Principal;
use super::response::{Tangent, Tensor, add_square};

/// Of an isotropic law, by its modes.
pub(super) fn isotropic(tangent: &Tangent, g: &Tensor) -> Tangent {
    let principal = Principal::of(g);
    let mut lifted = *tangent;
    for i in 0..3 {
        let j = (i + 1) % 3;
        let (ij, ji) = (principal.dyad(i, j), principal.dyad(j, i));
        // One product serves both modes, as the tangent treats `ji` as it does `ij`.
        let image = tangent * ij;
        let (own, crossed) = (ij.dot(&image), ji.dot(&image));
        // Both dyads have the same stiffness: of their difference and sum it is `own` less and more what couples them.
        lift(&mut lifted, &(ij - ji), own - crossed, 0.5);
        lift(&mut lifted, &(ij + ji), own + crossed, 0.5);
    }
    let scalings: [Tensor; 3] = std::array::from_fn(|i| principal.dyad(i, i));
    // Scalings couple through the volume: their block has eigenvectors of its own.
    let images = scalings.map(|scaling| tangent * scaling);
    let block = Matrix3::from_fn(|i, j| scalings[i].dot(&images[j])).symmetric_eigen();
    for (value, vector) in block.eigenvalues.iter().zip(block.eigenvectors.column_iter()) {
        // Asked here as well as in `lift`, so that no mode is formed where nothing is lifted.
        if *value < 0.0 {
            let mode = scalings[0] * vector[0] + scalings[1] * vector[1] + scalings[2] * vector[2];
            lift(&mut lifted, &mode, *value, 1.0);
        }
    }
    lifted
}

/// Of any law, by all nine eigenvalues.
pub(super) fn general(tangent: &Tangent) -> Tangent {
    // A fibre breaks the symmetry that the modes of an isotropic law rest on: no smaller block splits off.
    let eigen = tangent.symmetric_eigen();
    let mut lifted = *tangent;
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        lift(&mut lifted, &vector.into_owned(), *value, 1.0);
    }
    lifted
}

/// Takes a negative eigenvalue away; `square` is 1 over the squared length of `mode`.
fn lift(tangent: &mut Tangent, mode: &Tensor, value: f64, square: f64) {
    if value < 0.0 {
        add_square(tangent, mode, -value * square);
    }
}
