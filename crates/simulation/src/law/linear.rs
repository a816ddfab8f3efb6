//! Linear elasticity: `w = (lambda / 2) tr(e)^2 + mu tr(e^2)`, `e = sym(G)`. For small rotations only: turning a solid
//! costs it energy.

use nalgebra::{Matrix4, Vector4};

use super::response::{IDENTITY, Response, Volume};

pub(super) fn shear_density(mu: f64, g: &Vector4<f64>) -> f64 {
    let shear = g[1] + g[2];
    mu * (g[0] * g[0] + g[3] * g[3] + 0.5 * shear * shear)
}

pub(super) fn shear(mu: f64, g: &Vector4<f64>) -> Response {
    #[rustfmt::skip]
    let tangent = Matrix4::new(
        2.0, 0.0, 0.0, 0.0,
        0.0, 1.0, 1.0, 0.0,
        0.0, 1.0, 1.0, 0.0,
        0.0, 0.0, 0.0, 2.0,
    ) * mu;
    Response {
        density: shear_density(mu, g),
        stress: tangent * g,
        tangent,
    }
}

/// `theta = tr G`.
pub(super) fn volume(g: &Vector4<f64>) -> Volume {
    Volume {
        theta: g[0] + g[3],
        gradient: IDENTITY,
        hessian: Matrix4::zeros(),
    }
}
