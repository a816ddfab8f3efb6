//! Laws of principal stretches where two or three of them meet, against forms without stretches; and the projection.

use nalgebra::SMatrix;

use super::*;

/// Differences of stretches, from equal ones on.
const GAPS: [f64; 9] = [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3];

/// Displacement gradients whose stretches are `base` and `base + gap`, twice or all three, in turned directions.
fn meeting() -> Vec<Matrix3<f64>> {
    let mut next = numbers(23);
    let mut found = Vec::new();
    for gap in GAPS {
        for base in [0.5, 1.0, 1.7] {
            for stretches in [
                [base, base + gap, 1.2],
                [base, 0.8, base + gap],
                [base - gap, base, base + gap],
                [base + gap, base, base + gap],
            ] {
                let (left, right) = (rotation(&mut next), rotation(&mut next));
                let f = left * Matrix3::from_diagonal(&Vector3::from(stretches)) * right.transpose();
                found.push(f - Matrix3::identity());
                // Diagonal, where nothing is rounded on the way.
                found.push(Matrix3::from_diagonal(
                    &(Vector3::from(stretches) - Vector3::repeat(1.0)),
                ));
            }
        }
    }
    found
}

/// `d/dF` of a function of tensors along every entry, as columns.
fn columns(of: impl Fn(&Matrix3<f64>) -> Matrix3<f64>) -> Tangent {
    let mut tangent = Tangent::zeros();
    for entry in 0..9 {
        let column = of(&moved(&Matrix3::zeros(), entry, 1.0));
        tangent.set_column(entry, &vector(&column));
    }
    tangent
}

/// Stress and tangent of `sum l^4 / 4`: `F C`.
fn fourth(f: &Matrix3<f64>) -> (Tensor, Tangent) {
    let c = f.transpose() * f;
    let tangent = columns(|h| h * c + f * (h.transpose() * f + f.transpose() * h));
    (vector(&(f * c)), tangent)
}

/// Of `-sum l^-2 / 2`: `F^-T C^-1`.
fn inverse_square(f: &Matrix3<f64>) -> (Tensor, Tangent) {
    let inverse = f.try_inverse().unwrap();
    let (turned, c) = (inverse.transpose(), inverse * inverse.transpose());
    let tangent = columns(|h| {
        let step = -inverse * h * inverse;
        step.transpose() * c + turned * (step * inverse.transpose() + inverse * step.transpose())
    });
    (vector(&(turned * c)), tangent)
}

/// Of `ln J`.
fn logarithm(f: &Matrix3<f64>) -> (Tensor, Tangent) {
    let inverse = f.try_inverse().unwrap();
    let tangent = columns(|h| -(inverse * h * inverse).transpose());
    (vector(&inverse.transpose()), tangent)
}

#[test]
fn stretches_that_meet_keep_all_digits() {
    let mu = 0.9;
    let young = 2.0 * mu;
    for (exponent, form) in [(4.0, fourth as fn(&_) -> _), (-2.0, inverse_square)] {
        let weight = if exponent > 0.0 { 1.0 } else { -1.0 };
        let law = Law::Ogden(Ogden::new(&[(weight, exponent)]).unwrap());
        // Poisson's ratio 0: lambda is 0, and w = 2 mu / a (sum (l^a - 1) / a - ln J).
        let material = Material::new(law, young, 0.0).unwrap();
        let scale = 2.0 * mu / exponent;
        for g in meeting().into_iter().chain(gradients(100, 0.7)) {
            let f = Matrix3::identity() + g;
            let ((power, power_tangent), (log, log_tangent)) = (form(&f), logarithm(&f));
            // `fourth` and `inverse_square` are the derivatives of `l^a / a` with their sign.
            let (stress, tangent) = ((power - log) * scale, (power_tangent - log_tangent) * scale);
            let at = material.response(&g).unwrap();
            // Rounding of F, magnified by its condition squared in the forms of the inverse: up to 40.
            let size = power_tangent.amax().max(log_tangent.amax());
            let bound = 2e-13 * size.max(1.0);
            assert!(
                (at.stress - stress).amax() < bound,
                "{exponent} {g} {}",
                (at.stress - stress).amax()
            );
            let error = (at.tangent - tangent).amax();
            assert!(error < bound, "{exponent} {g} {error:e} of {bound:e}");
        }
    }
}

#[test]
fn ogden_of_one_square_is_neo_hookean() {
    let ogden = Material::new(Law::Ogden(Ogden::new(&[(5.0, 2.0)]).unwrap()), 1.0, 0.3).unwrap();
    let neo = Material::new(Law::NeoHookean, 1.0, 0.3).unwrap();
    let equal = [-0.3, 0.0, 1.0].map(|s| Matrix3::identity() * s);
    for g in gradients(100, 0.8).into_iter().chain(equal).chain(meeting()) {
        let (a, b) = (ogden.response(&g).unwrap(), neo.response(&g).unwrap());
        let scale = b.tangent.amax();
        assert!((a.density - b.density).abs() < 1e-14 * scale);
        assert!((a.stress - b.stress).amax() < 1e-14 * scale, "{g}");
        assert!(
            (a.tangent - b.tangent).amax() < 4e-14 * scale,
            "{}",
            a.tangent - b.tangent
        );
    }
}

#[test]
fn squeezed_stretches_keep_their_digits() {
    // Stretches known exactly in turned directions: of 1e-3 to 1e3 at once, a stretch errs by the rounding of F, eps times
    // the largest, which the density of the smallest sees as eps 1e6.
    let law = Law::Ogden(Ogden::new(&[(1.0, 2.0)]).unwrap());
    let material = Material::new(law, 2.0, 0.0).unwrap();
    let mut next = numbers(31);
    for stretches in [[1e-3, 1.0, 1e3], [1e3, 1e-3, 1e-3], [2.0, 1e-3, 3.0], [1e-6, 1.0, 1.0]] {
        let exact: f64 = stretches.iter().map(|l: &f64| 0.5 * (l * l - 1.0) - l.ln()).sum();
        let turns = [Matrix3::identity(), rotation(&mut next), rotation(&mut next)];
        for (left, right) in turns.iter().zip(turns.iter().rev()) {
            let f = left * Matrix3::from_diagonal(&Vector3::from(stretches)) * right.transpose();
            let density = material.density(&(f - Matrix3::identity())).unwrap();
            let largest = stretches.iter().fold(1.0_f64, |a, b| a.max(*b));
            let least = stretches.iter().fold(1.0_f64, |a, b| a.min(*b));
            let bound = 8.0 * f64::EPSILON * largest / least + 1e-13 * exact;
            assert!((density - exact).abs() < bound, "{stretches:?} {density} {exact}");
        }
    }
}

/// The nearest positive semidefinite matrix, by all eigenvalues.
fn clamped(tangent: &Tangent) -> Tangent {
    let eigen = tangent.symmetric_eigen();
    let values = SMatrix::from_diagonal(&eigen.eigenvalues.map(|v: f64| v.max(0.0)));
    eigen.eigenvectors * values * eigen.eigenvectors.transpose()
}

#[test]
fn lifting_keeps_what_is_positive_and_drops_the_rest() {
    let squeezed: Vec<_> = gradients(40, 0.9)
        .into_iter()
        .map(|g| g * 0.9 - Matrix3::identity() * 0.1)
        .filter(|g| (Matrix3::identity() + g).determinant() > 0.05)
        .chain(meeting())
        .collect();
    let mut lifted_some = 0;
    for material in materials(1.0, 0.4) {
        for g in &squeezed {
            let tangent = material.tangent(g).unwrap();
            let lifted = material.convex(&tangent, g);
            let scale = tangent.amax();
            let error = (lifted - clamped(&tangent)).amax();
            assert!(error < 1e-13 * scale, "{material:?} {g} {error:e}");
            lifted_some += usize::from((lifted - tangent).amax() > 1e-6 * scale);
        }
    }
    assert!(lifted_some > 100, "{lifted_some}");
}

#[test]
fn inverted_and_flat_states_are_lifted_too() {
    let planted = [
        Matrix3::zeros(),
        Matrix3::from_diagonal(&Vector3::new(2.0, 0.0, 0.0)),
        Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)),
        Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0)),
        -Matrix3::identity(),
        Vector3::new(1.0, 2.0, -0.5) * Vector3::new(0.3, -0.2, 0.7).transpose(),
    ];
    let mut next = numbers(17);
    let random = (0..100).map(|_| Matrix3::from_fn(|_, _| next())).collect::<Vec<_>>();
    for law in [Law::StVenantKirchhoff, Law::StableNeoHookean] {
        let material = Material::new(law, 1.0, 0.4).unwrap();
        for f in planted.iter().chain(&random) {
            let g = f - Matrix3::identity();
            let tangent = material.tangent(&g).unwrap();
            let error = (material.convex(&tangent, &g) - clamped(&tangent)).amax();
            assert!(error < 1e-13 * tangent.amax(), "{law:?} {f} {error:e}");
        }
    }
}
