//! Derivatives by finite differences, invariance, closed forms and the projection.

use nalgebra::{Matrix2, Matrix4, Vector4};

use super::response::vector;
use super::*;

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
fn gradients(count: usize, size: f64) -> Vec<Matrix2<f64>> {
    let mut next = numbers(7);
    let mut found = Vec::new();
    while found.len() < count {
        let g = Matrix2::from_fn(|_, _| next() * size);
        if (Matrix2::identity() + g).determinant() > 0.2 {
            found.push(g);
        }
    }
    found
}

fn rotation(angle: f64) -> Matrix2<f64> {
    let (s, c) = angle.sin_cos();
    Matrix2::new(c, -s, s, c)
}

fn moved(g: &Matrix2<f64>, entry: usize, by: f64) -> Matrix2<f64> {
    let mut moved = *g;
    moved.as_mut_slice()[entry] += by;
    moved
}

#[test]
fn stress_and_tangent_are_the_derivatives() {
    // Central differences of step h err by h^2/6 times the third derivative, here below 1e3, plus rounding eps/h.
    let h = 1e-5;
    for law in laws() {
        let material = Material::new(law, 3.0, 0.35).unwrap();
        for g in gradients(40, 0.7) {
            let at = material.response(&g).unwrap();
            let scale = at.tangent.amax().max(1.0);
            assert!((at.density - material.density(&g).unwrap()).abs() <= 1e-14 * scale);
            let (density, stress) = material.stress(&g).unwrap();
            assert!((at.density - density).abs() <= 1e-14 * scale);
            assert!((at.stress - stress).amax() <= 1e-14 * scale, "{law:?} {g}");
            assert!(
                (at.tangent - material.tangent(&g).unwrap()).amax() <= 1e-14 * scale,
                "{law:?} {g}"
            );
            assert!((at.tangent - at.tangent.transpose()).amax() <= 1e-13 * scale);
            for entry in 0..4 {
                let [plus, minus] = [h, -h].map(|by| material.response(&moved(&g, entry, by)).unwrap());
                let slope = (plus.density - minus.density) / (2.0 * h);
                assert!((slope - at.stress[entry]).abs() < 1e-7 * scale, "{law:?} {g}");
                let column = (plus.stress - minus.stress) / (2.0 * h);
                assert!((column - at.tangent.column(entry)).amax() < 1e-7 * scale, "{law:?} {g}");
            }
        }
    }
}

#[test]
fn at_rest_every_law_is_hooke() {
    let hooke = Material::new(Law::Linear, 3.0, 0.35).unwrap();
    let hooke = hooke.response(&Matrix2::zeros()).unwrap().tangent;
    for law in laws() {
        let at = Material::new(law, 3.0, 0.35)
            .unwrap()
            .response(&Matrix2::zeros())
            .unwrap();
        assert_eq!(at.density, 0.0, "{law:?}");
        assert_eq!(at.stress, Vector4::zeros(), "{law:?}");
        assert!((at.tangent - hooke).amax() < 1e-14, "{law:?}");
    }
}

#[test]
fn turning_costs_nothing_and_turns_the_stress() {
    for law in laws().into_iter().filter(|law| *law != Law::Linear) {
        let material = Material::new(law, 1.0, 0.3).unwrap();
        for g in gradients(20, 0.5) {
            let at = material.response(&g).unwrap();
            for angle in [0.1, 1.0, 3.0, -2.0] {
                let r = rotation(angle);
                let f = r * (Matrix2::identity() + g);
                let turned = material.response(&(f - Matrix2::identity())).unwrap();
                assert!((turned.density - at.density).abs() < 1e-13, "{law:?}");
                let stress = r * Matrix2::from_column_slice(at.stress.as_slice());
                assert!((vector(&stress) - turned.stress).amax() < 1e-12, "{law:?}");
                // Isotropy: turning the reference changes nothing either.
                let f = (Matrix2::identity() + g) * r;
                let other = material.density(&(f - Matrix2::identity())).unwrap();
                assert!((other - at.density).abs() < 1e-13, "{law:?}");
            }
        }
    }
}

#[test]
fn small_strains_keep_their_digits() {
    // The energy is Hooke's to the relative order of the strain. Forming F^T F - I would lose all digits at 1e-9.
    for law in &laws()[..4] {
        let material = Material::new(*law, 1.0, 0.3).unwrap();
        let hooke = Material::new(Law::Linear, 1.0, 0.3).unwrap();
        for size in [1e-6, 1e-9, 1e-12, 1e-30] {
            let g = Matrix2::new(0.3, -0.7, 0.2, 0.9) * size;
            let (a, b) = (material.response(&g).unwrap(), hooke.response(&g).unwrap());
            let bound = 10.0 * size + 1e-14;
            assert!(
                (a.density / b.density - 1.0).abs() < bound,
                "{law:?} {size}: {} {}",
                a.density,
                b.density
            );
            assert!((a.stress - b.stress).amax() / b.stress.amax() < bound, "{law:?} {size}");
        }
    }
}

#[test]
fn ogden_of_one_square_is_neo_hookean() {
    let ogden = Material::new(Law::Ogden(Ogden::new(&[(5.0, 2.0)]).unwrap()), 1.0, 0.3).unwrap();
    let neo = Material::new(Law::NeoHookean, 1.0, 0.3).unwrap();
    let equal_stretches = [-0.3, 0.0, 1.0].map(|s| Matrix2::identity() * s);
    for g in gradients(50, 0.8).into_iter().chain(equal_stretches) {
        let (a, b) = (ogden.response(&g).unwrap(), neo.response(&g).unwrap());
        let scale = b.tangent.amax();
        assert!((a.density - b.density).abs() < 1e-13 * scale);
        assert!((a.stress - b.stress).amax() < 1e-13 * scale);
        assert!(
            (a.tangent - b.tangent).amax() < 1e-12 * scale,
            "{}",
            a.tangent - b.tangent
        );
    }
}

#[test]
fn lifting_keeps_what_is_positive_and_drops_the_rest() {
    for law in laws() {
        let material = Material::new(law, 1.0, 0.4).unwrap();
        let squeezed = gradients(40, 0.9)
            .into_iter()
            .map(|g| g * 0.9 - Matrix2::identity() * 0.1);
        for g in squeezed.filter(|g| (Matrix2::identity() + g).determinant() > 0.05) {
            let tangent = material.response(&g).unwrap().tangent;
            let eigen = tangent.symmetric_eigen();
            let clamped = Matrix4::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0)));
            let expected = eigen.eigenvectors * clamped * eigen.eigenvectors.transpose();
            // The linear law is not isotropic in F away from the identity: its tangent is positive anyway.
            let lifted = material.convex(&tangent, &g);
            let scale = tangent.amax();
            if law == Law::Linear {
                assert!((lifted - tangent).amax() < 1e-13);
            } else {
                assert!((lifted - expected).amax() < 1e-12 * scale, "{law:?} {g}");
            }
        }
    }
}

#[test]
fn the_signed_decomposition_gives_back_the_matrix() {
    let mut next = numbers(3);
    let special = [
        Matrix2::zeros(),
        Matrix2::identity(),
        -Matrix2::identity(),
        Matrix2::new(1.0, 0.0, 0.0, -1.0),
    ];
    let random = (0..200).map(|_| Matrix2::from_fn(|_, _| next()));
    for f in special.into_iter().chain(random.collect::<Vec<_>>()) {
        let (u, s, v) = signed_svd(&f);
        assert!((u * Matrix2::from_diagonal(&s) * v.transpose() - f).amax() < 1e-15 * 8.0);
        assert!((u.determinant() - 1.0).abs() < 1e-14 && (v.determinant() - 1.0).abs() < 1e-14);
        assert!(s.x >= s.y.abs() && (s.x * s.y - f.determinant()).abs() < 1e-14);
    }
}

#[test]
fn an_inverted_gradient_has_no_energy_under_a_logarithm() {
    for law in laws() {
        let material = Material::new(law, 1.0, 0.3).unwrap();
        let flat = Matrix2::new(-1.0, 0.0, 0.0, 0.0);
        let inverted = Matrix2::new(-1.5, 0.0, 0.0, 0.0);
        for g in [flat, inverted] {
            assert_eq!(material.response(&g).is_none(), material.forbids_inversion(), "{law:?}");
            assert_eq!(material.density(&g).is_none(), material.forbids_inversion(), "{law:?}");
            assert_eq!(material.stress(&g).is_none(), material.forbids_inversion(), "{law:?}");
            assert_eq!(material.tangent(&g).is_none(), material.forbids_inversion(), "{law:?}");
        }
        let not_a_number = Matrix2::from_element(f64::NAN);
        assert!(material.density(&not_a_number).is_none() && material.response(&not_a_number).is_none());
        assert!(material.stress(&not_a_number).is_none() && material.tangent(&not_a_number).is_none());
    }
}

#[test]
fn lame_coefficients_and_what_they_refuse() {
    let lame = Lame::new(2.0, 0.25).unwrap();
    assert!((lame.lambda - 0.8).abs() < 1e-15 && (lame.mu - 0.8).abs() < 1e-15);
    assert!((lame.young() - 2.0).abs() < 1e-15 && (lame.confined() - 2.4).abs() < 1e-15);
    for nu in [0.5, 0.7, -1.0, f64::NAN] {
        assert!(matches!(Lame::new(1.0, nu), Err(Refused::Poisson { .. })));
    }
    for young in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(Lame::new(young, 0.3), Err(Refused::Young { .. })));
    }
    assert_eq!(Ogden::new(&[]), Err(Refused::OgdenTerms { found: 0, most: 3 }));
    assert!(matches!(
        Ogden::new(&[(1.0, 2.0), (1.0, -2.0)]),
        Err(Refused::OgdenTerm { term: 1, .. })
    ));
}
