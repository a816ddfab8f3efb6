//! Linear elasticity: `w = (lambda / 2) tr(e)^2 + mu tr(e^2)`, `e = sym(G)`. For small rotations only: turning a solid
//! costs it energy.

use super::response::{Tangent, Tensor, deformation, trace};

/// `2 mu sym(G)`.
fn stress(mu: f64, g: &Tensor) -> Tensor {
    // An entry and its mirror sum to the same bits in either order: the stress is exactly symmetric.
    Tensor::from_fn(|entry, _| mu * (g[entry] + g[entry / 3 + 3 * (entry % 3)]))
}

pub(super) fn shear_stress(mu: f64, g: &Tensor) -> (f64, Tensor) {
    let stress = stress(mu, g);
    // The stress is symmetric: its product with `G` is that with `sym(G)`, which alone has no cancellation.
    let sheared = |a: usize, b: usize| {
        let sum = g[a] + g[b];
        0.5 * sum * sum
    };
    let even = g[0] * g[0] + g[4] * g[4] + g[8] * g[8];
    (mu * (even + sheared(1, 3) + sheared(5, 7) + sheared(2, 6)), stress)
}

pub(super) fn shear_tangent(mu: f64) -> Tangent {
    let mut tangent = Tangent::identity() * mu;
    // The identity answers `G`, the transposition `G^T`: only their sum is blind to small rotations.
    for entry in 0..9 {
        tangent[(entry, entry / 3 + 3 * (entry % 3))] += mu;
    }
    tangent
}

/// `theta = tr G`, and its derivative.
pub(super) fn volume(g: &Tensor) -> (f64, Tensor) {
    // `I` is the deformation of no displacement.
    (trace(g), deformation(&Tensor::zeros()))
}
