//! Saint Venant-Kirchhoff: `w = (lambda / 2) tr(E)^2 + mu tr(E^2)`, `E = sym(G) + G^T G / 2`.
//!
//! Finite at `det F = 0` and soft under compression: the least determinant of a state tells where it inverts.

use super::response::{Tangent, Tensor, deformation};

/// Green-Lagrange strain, column by column, straight from the displacement gradient.
fn strain(g: &Tensor) -> Tensor {
    let mut strain = Tensor::zeros();
    for column in 0..3 {
        // One half is copied to the other: mirrored shears are the same number to the last bit.
        for row in column..3 {
            let (p, q) = (3 * row, 3 * column);
            let product = g[p] * g[q] + g[p + 1] * g[q + 1] + g[p + 2] * g[q + 2];
            // From G: `F^T F - I` would leave eps of 1 in a strain of any size.
            let value = 0.5 * (g[row + q] + g[column + p] + product);
            strain[row + q] = value;
            strain[column + p] = value;
        }
    }
    strain
}

/// `P = F S`, `S = 2 mu E`.
pub(super) fn shear_stress(mu: f64, g: &Tensor) -> (f64, Tensor) {
    let (strain, f) = (strain(g), deformation(g));
    let stress = Tensor::from_fn(|entry, _| {
        let (row, column) = (entry % 3, 3 * (entry / 3));
        let sum = f[row] * strain[column] + f[row + 3] * strain[column + 1] + f[row + 6] * strain[column + 2];
        2.0 * mu * sum
    });
    // A sum of squares, which no strain makes cancel.
    (mu * strain.norm_squared(), stress)
}

/// `dP/dF = d_ik S_JL + mu (F_iL F_kJ + (F F^T)_ik d_JL)`.
pub(super) fn shear_tangent(mu: f64, g: &Tensor) -> Tangent {
    let (strain, f) = (strain(g), deformation(g));
    let squared = |i: usize, k: usize| f[i] * f[k] + f[i + 3] * f[k + 3] + f[i + 6] * f[k + 6];
    Tangent::from_fn(|a, b| {
        let (i, jj, k, ll) = (a % 3, a / 3, b % 3, b / 3);
        let mut value = mu * f[i + 3 * ll] * f[k + 3 * jj];
        // The stress as it stands: the one part that can be negative, where the solid is compressed.
        if i == k {
            value += 2.0 * mu * strain[jj + 3 * ll];
        }
        if jj == ll {
            value += mu * squared(i, k);
        }
        value
    })
}

/// `theta = tr E`, and its derivative `F`. The second derivative is the identity.
pub(super) fn volume(g: &Tensor) -> (f64, Tensor) {
    let strain = strain(g);
    // `tr E` is half of `|F|^2 - 3`: its derivative is F itself and needs no strain.
    (strain[0] + strain[4] + strain[8], deformation(g))
}
