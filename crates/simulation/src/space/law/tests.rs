//! Derivatives by finite differences, invariance, the plane's laws, closed forms and the projection.

mod derivatives;
mod extremes;
mod plane;
mod stretches;

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::*;
use crate::law::{Law, Ogden};

fn laws() -> [Law; 6] {
    [
        Law::StVenantKirchhoff,
        Law::Linear,
        Law::NeoHookean,
        Law::StableNeoHookean,
        Law::Ogden(Ogden::new(&[(1.0, 2.0)]).unwrap()),
        Law::Ogden(Ogden::new(&[(0.7, 1.3), (0.1, 5.0), (-0.2, -2.0)]).unwrap()),
    ]
}

/// Each law, and each with fibres.
fn materials(young: f64, poisson: f64) -> Vec<Material> {
    let bare = laws().map(|law| Material::new(law, young, poisson).unwrap());
    let fibre = Fibre::new(Vector3::new(1.0, -2.0, 0.5), 0.4 * young, 1.3).unwrap();
    let fibred = bare.map(|material| Material {
        fibre: Some(fibre),
        ..material
    });
    bare.into_iter().chain(fibred).collect()
}

/// Deterministic numbers in (-1, 1).
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Displacement gradients of size up to `size` that invert nothing.
fn gradients(count: usize, size: f64) -> Vec<Matrix3<f64>> {
    let mut next = numbers(7);
    let mut found = Vec::new();
    while found.len() < count {
        let g = Matrix3::from_fn(|_, _| next() * size);
        if (Matrix3::identity() + g).determinant() > 0.2 {
            found.push(g);
        }
    }
    found
}

fn rotation(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
    let axis = Unit::new_normalize(Vector3::new(next(), next(), next()));
    Rotation3::from_axis_angle(&axis, 3.0 * next()).into_inner()
}

fn moved(g: &Matrix3<f64>, entry: usize, by: f64) -> Matrix3<f64> {
    let mut moved = *g;
    moved.as_mut_slice()[entry] += by;
    moved
}
