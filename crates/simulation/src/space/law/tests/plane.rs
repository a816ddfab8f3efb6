//! Where the third stretch is 1 the laws are those of the plane.

use nalgebra::Matrix2;

use super::*;
use crate::law;

/// Entries of the plane in a tensor of space.
const IN_PLANE: [usize; 4] = [0, 1, 3, 4];
/// The shears out of the plane.
const ACROSS: [usize; 4] = [2, 5, 6, 7];

#[test]
fn plane_strain_gives_the_laws_of_the_plane() {
    let mut next = numbers(5);
    let mut tried = 0;
    while tried < 60 {
        let plane = Matrix2::from_fn(|_, _| next() * 0.6);
        if (Matrix2::identity() + plane).determinant() < 0.1 {
            continue;
        }
        tried += 1;
        let mut g = Matrix3::zeros();
        g.fixed_view_mut::<2, 2>(0, 0).copy_from(&plane);
        for law in laws() {
            let material = Material::new(law, 1.7, 0.4).unwrap();
            let at = material.response(&g).unwrap();
            let flat = law::Material::new(law, 1.7, 0.4).unwrap().response(&plane).unwrap();
            // Some ten operations, each rounded to eps of numbers up to the scale. The plane takes a stretch from the
            // strain, so that a small one errs by eps over its square.
            let least = law::signed_svd(&(Matrix2::identity() + plane)).1.y;
            let scale = flat.tangent.amax() / (least * least).min(1.0);
            assert!((at.density - flat.density).abs() <= 1e-14 * scale, "{law:?} {plane}");
            for (k, row) in IN_PLANE.into_iter().enumerate() {
                assert!((at.stress[row] - flat.stress[k]).abs() <= 1e-14 * scale, "{law:?}");
                assert!(at.stress[ACROSS[k]].abs() <= 1e-15 * scale, "{law:?}");
                for (l, column) in IN_PLANE.into_iter().enumerate() {
                    let error = (at.tangent[(row, column)] - flat.tangent[(k, l)]).abs();
                    assert!(error <= 2e-14 * scale, "{law:?} {plane} {error:e}");
                }
            }
        }
    }
}

#[test]
fn uniaxial_stretch_has_its_closed_form() {
    // A bar stretched and free across, neo-Hookean with the logarithm: mu (b^2 - 1) + lambda ln J = 0 with J = a b^2.
    let material = Material::new(Law::NeoHookean, 2.0, 0.3).unwrap();
    let (lambda, mu) = (material.lame.lambda, material.lame.mu);
    for a in [0.4_f64, 0.9, 1.5, 3.0] {
        let free = |b: f64| mu * (b * b - 1.0) + lambda * (a * b * b).ln();
        let (mut low, mut high) = (1e-3, 1e3);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if free(middle) > 0.0 {
                high = middle
            } else {
                low = middle
            }
        }
        let g = Matrix3::from_diagonal(&Vector3::new(a - 1.0, low - 1.0, low - 1.0));
        let stress = material.stress(&g).unwrap().1;
        let along = (mu * (a * a - 1.0) + lambda * (a * low * low).ln()) / a;
        assert!((stress[0] - along).abs() < 1e-14 * 10.0, "{a}");
        assert!(stress[4].abs() < 1e-13 && stress[8].abs() < 1e-13, "{a} {stress}");
    }
}

#[test]
fn small_strains_keep_their_digits() {
    // The energy is Hooke's to the relative order of the strain. Forming F^T F - I would lose all digits at 1e-9.
    for law in laws() {
        let material = Material::new(law, 1.0, 0.3).unwrap();
        let hooke = Material::new(Law::Linear, 1.0, 0.3).unwrap();
        for size in [1e-6, 1e-9, 1e-12, 1e-30] {
            for shape in gradients(10, 0.9) {
                let g = shape * size;
                let (a, b) = (material.stress(&g).unwrap(), hooke.stress(&g).unwrap());
                let bound = 40.0 * size + 2e-14;
                assert!((a.0 / b.0 - 1.0).abs() < bound, "{law:?} {size}: {} {}", a.0, b.0);
                assert!((a.1 - b.1).amax() / b.1.amax() < bound, "{law:?} {size}");
                let theta = material.volume(&g).unwrap().theta;
                assert!((theta - shape.trace() * size).abs() < bound * size, "{law:?} {size}");
            }
        }
    }
}
