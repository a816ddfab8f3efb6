//! Stresses and tangents against differences of what they derive.

use super::*;

#[test]
fn stress_and_tangent_are_the_derivatives() {
    // Central differences of step h err by h^2/6 times the third derivative, here below 1e3 of the scale, plus eps/h.
    let h = 1e-5;
    for material in materials(3.0, 0.35) {
        for g in gradients(30, 0.6) {
            let at = material.response(&g).unwrap();
            let scale = at.tangent.amax().max(1.0);
            assert!((at.density - material.density(&g).unwrap()).abs() <= 1e-14 * scale);
            assert!((at.tangent - at.tangent.transpose()).amax() <= 1e-14 * scale);
            for entry in 0..9 {
                let [plus, minus] = [h, -h].map(|by| material.stress(&moved(&g, entry, by)).unwrap());
                let slope = (plus.0 - minus.0) / (2.0 * h);
                assert!((slope - at.stress[entry]).abs() < 1e-7 * scale, "{material:?} {g}");
                let column = (plus.1 - minus.1) / (2.0 * h);
                let error = (column - at.tangent.column(entry)).amax();
                assert!(error < 1e-7 * scale, "{material:?} {g} {error:e} of {scale:e}");
            }
        }
    }
}

#[test]
fn shear_and_volume_are_the_parts() {
    let h = 1e-5;
    for material in materials(3.0, 0.35) {
        for g in gradients(10, 0.6) {
            let (at, shear, volume) = (
                material.response(&g).unwrap(),
                material.shear(&g).unwrap(),
                material.volume(&g).unwrap(),
            );
            let (lambda, pressure) = (material.lame.lambda, material.lame.lambda * volume.theta);
            let scale = at.tangent.amax().max(1.0);
            assert!((shear.density + 0.5 * pressure * volume.theta - at.density).abs() < 1e-14 * scale);
            assert!((shear.stress + volume.gradient * pressure - at.stress).amax() < 1e-14 * scale);
            let outer = volume.gradient * volume.gradient.transpose();
            let sum = shear.tangent + outer * lambda + volume.hessian * pressure;
            assert!((sum - at.tangent).amax() < 1e-14 * scale);
            for entry in 0..9 {
                let [plus, minus] = [h, -h].map(|by| material.volume(&moved(&g, entry, by)).unwrap());
                let slope = (plus.theta - minus.theta) / (2.0 * h);
                assert!((slope - volume.gradient[entry]).abs() < 1e-7 * scale);
                let column = (plus.gradient - minus.gradient) / (2.0 * h);
                let error = (column - volume.hessian.column(entry)).amax();
                assert!(error < 1e-7 * volume.hessian.amax().max(1.0), "{material:?}");
            }
        }
    }
}

#[test]
fn at_rest_every_law_is_hooke() {
    let hooke = Material::new(Law::Linear, 3.0, 0.35).unwrap();
    let hooke = hooke.tangent(&Matrix3::zeros()).unwrap();
    for material in materials(3.0, 0.35) {
        let at = material.response(&Matrix3::zeros()).unwrap();
        assert_eq!(at.density, 0.0, "{material:?}");
        assert_eq!(at.stress, Tensor::zeros(), "{material:?}");
        assert!((at.tangent - hooke).amax() < 4e-15, "{material:?}");
    }
}

#[test]
fn turning_costs_nothing_and_turns_the_stress() {
    let mut next = numbers(11);
    for material in materials(1.0, 0.3).into_iter().filter(|m| m.law != Law::Linear) {
        for g in gradients(20, 0.5) {
            let (density, stress) = material.stress(&g).unwrap();
            let r = rotation(&mut next);
            let f = r * (Matrix3::identity() + g);
            let (turned, turned_stress) = material.stress(&(f - Matrix3::identity())).unwrap();
            let scale = stress.amax().max(1.0);
            assert!((turned - density).abs() < 1e-14 * scale, "{material:?}");
            let stress = r * Matrix3::from_column_slice(stress.as_slice());
            assert!((vector(&stress) - turned_stress).amax() < 1e-13 * scale, "{material:?}");
            if material.fibre.is_none() {
                // Isotropy: turning the reference changes nothing either.
                let f = (Matrix3::identity() + g) * r;
                let other = material.density(&(f - Matrix3::identity())).unwrap();
                assert!((other - density).abs() < 1e-14 * scale, "{material:?}");
            }
        }
    }
}

#[test]
fn a_fibre_bears_tension_alone() {
    let axis = Vector3::new(2.0, 1.0, -2.0) / 3.0;
    let fibre = Fibre::new(axis * 1e200, 2.0, 0.7).unwrap();
    assert!((fibre.direction() - axis).amax() < 1e-15);
    let bare = Material::new(Law::NeoHookean, 1.0, 0.3).unwrap();
    let material = Material {
        fibre: Some(fibre),
        ..bare
    };
    for stretch in [0.5, 0.999, 1.0, 1.001, 1.3] {
        let g = axis * axis.transpose() * (stretch - 1.0);
        let more = material.stress(&g).unwrap();
        let less = bare.stress(&g).unwrap();
        // Uniaxial: P = dw/d stretch, w = k1 / (2 k2) (exp(k2 x^2) - 1), x = stretch^2 - 1.
        let x: f64 = (stretch * stretch - 1.0_f64).max(0.0);
        let growth = (0.7 * x * x).exp();
        assert!(
            (more.0 - less.0 - (growth - 1.0) * 2.0 / 1.4).abs() < 1e-14,
            "{stretch}"
        );
        let pull = vector(&(axis * axis.transpose())) * (2.0 * x * growth * 2.0 * stretch);
        assert!((more.1 - less.1 - pull).amax() < 1e-14, "{stretch}");
    }
    // Next to no exponent: w = k1 / 2 (I4 - 1)^2.
    for k2 in [1e-310, 1e-30] {
        let soft = Material {
            fibre: Some(Fibre::new(axis, 2.0, k2).unwrap()),
            ..bare
        };
        let g = axis * axis.transpose() * 0.1;
        let (more, less) = (soft.response(&g).unwrap(), bare.response(&g).unwrap());
        assert!((more.density - less.density - 0.21 * 0.21).abs() < 1e-15, "{k2}");
    }
    // Beyond the largest exponential there is no energy; before it, where derivatives 1e4 times it are numbers, there is.
    let pulled = |x: f64| axis * axis.transpose() * ((1.0 + x).sqrt() - 1.0);
    let limit = (709.0_f64 / 0.7).sqrt();
    assert!(material.response(&pulled(0.98 * limit)).is_some());
    for g in [pulled(1.001 * limit), pulled(1e3 * limit)] {
        assert!(material.density(&g).is_none() && material.stress(&g).is_none() && material.tangent(&g).is_none());
    }
}

#[test]
fn bad_fibres_are_refused() {
    for direction in [
        Vector3::zeros(),
        Vector3::repeat(f64::NAN),
        Vector3::new(1.0, f64::INFINITY, 0.0),
    ] {
        assert!(matches!(
            Fibre::new(direction, 1.0, 1.0),
            Err(BadFibre::Direction { .. })
        ));
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Fibre::new(Vector3::x(), bad, 1.0),
            Err(BadFibre::Coefficient { what: "k1", .. })
        ));
        assert!(matches!(
            Fibre::new(Vector3::x(), 1.0, bad),
            Err(BadFibre::Coefficient { what: "k2", .. })
        ));
    }
}
