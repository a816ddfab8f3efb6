//! Saint Venant-Kirchhoff: `w = (lambda / 2) tr(E)^2 + mu tr(E^2)` (II 3.26), `E = sym(G) + G^T G / 2`.
//!
//! Finite at `det F = 0` and soft under compression: a confined bar carries the most at the stretch `1 / sqrt 3`, and
//! beyond it meshes invert without any sign in the energy. The least determinant of a state tells.

use nalgebra::{Matrix4, Vector4};

use super::response::{IDENTITY, Response, Volume};

/// Green-Lagrange strain `(E11, E22, E12)`, straight from the displacement gradient.
#[inline]
pub(crate) fn strain(g: &Vector4<f64>) -> [f64; 3] {
    [
        g[0] + 0.5 * (g[0] * g[0] + g[1] * g[1]),
        g[3] + 0.5 * (g[2] * g[2] + g[3] * g[3]),
        0.5 * (g[1] + g[2] + (g[0] * g[2] + g[1] * g[3])),
    ]
}

pub(super) fn shear_density(mu: f64, g: &Vector4<f64>) -> f64 {
    let [e11, e22, e12] = strain(g);
    mu * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12)
}

/// `S = 2 mu E`, `P = F S`, `dP/dF = d_ik S_JL + mu (F_iL F_kJ + (F F^T)_ik d_JL)`.
pub(super) fn shear(mu: f64, g: &Vector4<f64>) -> Response {
    let [e11, e22, e12] = strain(g);
    let s = [[2.0 * mu * e11, 2.0 * mu * e12], [2.0 * mu * e12, 2.0 * mu * e22]];
    let f = [[1.0 + g[0], g[2]], [g[1], 1.0 + g[3]]];
    let mut stress = Vector4::zeros();
    let mut tangent = Matrix4::zeros();
    // Components column by column: a is (i, J), b is (k, L).
    for a in 0..4 {
        let (i, jj) = (a % 2, a / 2);
        stress[a] = f[i][0] * s[0][jj] + f[i][1] * s[1][jj];
        for b in 0..4 {
            let (k, ll) = (b % 2, b / 2);
            let mut value = mu * f[i][ll] * f[k][jj];
            if i == k {
                value += s[jj][ll];
            }
            if jj == ll {
                value += mu * (f[i][0] * f[k][0] + f[i][1] * f[k][1]);
            }
            tangent[(a, b)] = value;
        }
    }
    Response {
        density: mu * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12),
        stress,
        tangent,
    }
}

/// The law whole: density and stress.
pub(super) fn stress([lambda, mu]: [f64; 2], g: &Vector4<f64>) -> (f64, Vector4<f64>) {
    let [e11, e22, e12] = strain(g);
    let pressure = lambda * (e11 + e22);
    let density = mu * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12) + 0.5 * pressure * (e11 + e22);
    let [s11, s22, s12] = [2.0 * mu * e11 + pressure, 2.0 * mu * e22 + pressure, 2.0 * mu * e12];
    // `P = F S`, column by column.
    let f = IDENTITY + g;
    let stress = Vector4::new(
        f[0] * s11 + f[2] * s12,
        f[1] * s11 + f[3] * s12,
        f[0] * s12 + f[2] * s22,
        f[1] * s12 + f[3] * s22,
    );
    (density, stress)
}

/// `theta = tr E`.
pub(super) fn volume(g: &Vector4<f64>) -> Volume {
    let [e11, e22, _] = strain(g);
    Volume {
        theta: e11 + e22,
        gradient: IDENTITY + g,
        hessian: Matrix4::identity(),
    }
}
