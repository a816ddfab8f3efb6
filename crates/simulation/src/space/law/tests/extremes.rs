//! Rank-one, flat, inverted and infinite states.

use super::*;

#[test]
fn an_inverted_gradient_has_no_energy_under_a_logarithm() {
    let flat = Matrix3::from_diagonal(&Vector3::new(-1.0, 0.0, 0.0));
    let inverted = Matrix3::from_diagonal(&Vector3::new(-1.5, 0.0, 0.0));
    let point = -Matrix3::identity();
    let turned_over = -Matrix3::identity() * 2.0;
    // Of rank one, F = a b^T.
    let line = Vector3::new(1.0, 2.0, -1.0) * Vector3::new(0.5, 0.25, 0.125).transpose() - Matrix3::identity();
    for material in materials(1.0, 0.3) {
        for g in [flat, inverted, point, turned_over, line] {
            let none = material.forbids_inversion();
            assert_eq!(material.density(&g).is_none(), none, "{material:?}");
            assert_eq!(material.stress(&g).is_none(), none, "{material:?}");
            assert_eq!(material.tangent(&g).is_none(), none, "{material:?}");
            assert_eq!(material.response(&g).is_none(), none, "{material:?}");
            assert_eq!(material.shear(&g).is_none(), none, "{material:?}");
        }
    }
}

#[test]
fn what_is_no_number_has_no_energy() {
    for material in materials(1.0, 0.3) {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
            for entry in 0..9 {
                let g = moved(&Matrix3::zeros(), entry, bad);
                // A shear or stretch of 1e200 squares to infinity.
                assert!(material.density(&g).is_none(), "{material:?} {g}");
                assert!(material.stress(&g).is_none(), "{material:?} {g}");
            }
        }
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(material.tangent(&Matrix3::from_element(bad)).is_none(), "{material:?}");
        }
    }
}

#[test]
fn rank_one_gradients_stretch_one_direction() {
    // F = I + t a b^T: J - 1 = t a.b, without cancellation for tiny t, and the neo-Hookean shear energy of that.
    let (a, b) = (Vector3::new(0.3, -0.7, 0.2), Vector3::new(0.5, 0.1, -0.9));
    let material = Material::new(Law::NeoHookean, 2.0, 0.0).unwrap();
    for t in [1e-8_f64, 1e-3, 0.5, 2.0, -1.0] {
        let g = a * b.transpose() * t;
        let x = t * a.dot(&b);
        let theta = material.volume(&g).unwrap().theta;
        assert!((theta / x.ln_1p() - 1.0).abs() < 1e-14, "{t}");
        // |F|^2 - 3 = 2 x + t^2 |a|^2 |b|^2.
        let q = t * t * a.norm_squared() * b.norm_squared();
        let exact = 0.5 * q + crate::law::x_minus_ln_1p(x);
        let density = material.density(&g).unwrap();
        assert!((density / exact - 1.0).abs() < 1e-14, "{t} {density} {exact}");
    }
}

#[test]
fn derivatives_that_overflow_are_no_stress() {
    // l^-40 is a number where l^-41 is none.
    let law = Law::Ogden(Ogden::new(&[(-1.0, -40.0)]).unwrap());
    let material = Material::new(law, 1.0, 0.3).unwrap();
    let g = Matrix3::from_diagonal(&Vector3::new(10.0_f64.powf(-7.6) - 1.0, 0.0, 0.0));
    assert!(material.density(&g).is_some());
    assert!(material.stress(&g).is_none() && material.tangent(&g).is_none() && material.response(&g).is_none());
}
