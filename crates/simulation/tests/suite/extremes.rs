//! Extremes of units, stiffness and shape: a right answer or a named refusal.

use crate::common::cases::settle;
use nalgebra::Vector2;
use simulation::control::{Failed, Minimum, Newton, Settings};
use simulation::law::{Law, Material};
use simulation::q9::{Mesh, grid, rectangle};
use simulation::solid::{Deformable, NotMixed, Solid};
use simulation::system::System;

/// A cantilever of `length` x 1 in units of `unit`, under `weight` of Young's modulus over the unit.
fn cantilever(unit: f64, young: f64, length: f64, weight: f64, elements: [usize; 2]) -> (System, Vec<usize>) {
    let mesh = rectangle(Vector2::zeros(), Vector2::new(length * unit, unit), elements).expect("a mesh");
    let clamped = mesh.nodes_where(|x| x.x == 0.0);
    let tip = mesh.nodes_where(|x| x.x >= (length - 1e-9) * unit && (x.y - 0.5 * unit).abs() < 1e-9 * unit);
    let material = Material::new(Law::NeoHookean, young, 0.3).expect("a material");
    let force = Vector2::new(0.0, -weight * young / unit);
    let mut system = System::new();
    let body = system.add(Deformable::new(mesh, material, force).expect("a solid"));
    system.clamp(body, &clamped);
    (system, tip)
}

/// The same beam in other units is the same search: the same steps, the same numbers.
#[test]
fn units_do_not_matter() {
    let solve = |unit: f64, young: f64| -> (f64, Minimum) {
        let (mut system, tip) = cantilever(unit, young, 10.0, 2e-4, [10, 2]);
        let (a, found) = settle(&mut system);
        (a[2 * tip[0] + 1] / unit, found)
    };
    let (expected, same) = solve(1.0, 1.0);
    // Powers of two scale every number exactly; others round.
    for (unit, young) in [
        (2.0_f64.powi(30), 1.0),
        (2.0_f64.powi(-30), 2.0_f64.powi(40)),
        (1e-9, 1e12),
        (1e9, 1e-12),
    ] {
        let (found, minimum) = solve(unit, young);
        assert!(
            (found / expected - 1.0).abs() < 1e-11,
            "{unit} {young}: {found} {expected}"
        );
        assert_eq!(minimum.iterations, same.iterations, "{unit} {young}");
    }
}

/// Two beams in one system whose stiffness differs by the ratio: a pivot is small beside its own diagonal only.
#[test]
fn stiffness_ratios_up_to_1e12_balance() {
    for ratio in [1e6, 1e12] {
        let mut system = System::new();
        let layer = |y: f64| rectangle(Vector2::new(0.0, y), Vector2::new(4.0, 0.5), [8, 1]).expect("a mesh");
        let mut add = |mesh: Mesh, young: f64| {
            let clamped = mesh.nodes_where(|x| x.x == 0.0);
            let material = Material::new(Law::StVenantKirchhoff, young, 0.3).expect("a material");
            let body = system.add(Deformable::new(mesh, material, Vector2::new(0.0, -1e-6)).expect("a solid"));
            system.clamp(body, &clamped);
        };
        add(layer(0.0), 1.0);
        add(layer(0.5), ratio);
        let (_, found) = settle(&mut system);
        assert!(found.residual <= 1e-8 * found.load, "{ratio}: {found:?}");
    }
}

#[test]
fn slender_beams_bend_as_beam_theory_says() {
    // Small deflection w L^4 / (8 E' I), E' = E / (1 - nu^2), I = 1/12. Shear adds about 1 / L^2 of it, the clamp that
    // keeps the section's width about 1 / L. Rounding of the stiffness counts L^4 times: 2e-16 and 1e12 make some 1e-3.
    for (length, bound) in [(100.0, 2e-2), (1000.0, 5e-3)] {
        let small = 1e-3 * 8.0 / 12.0 / 0.91 / f64::powi(length, 3);
        let (mut system, tip) = cantilever(1.0, 1.0, length, small, [50, 1]);
        let (a, found) = settle(&mut system);
        let theory = -1e-3 * length;
        assert!(
            (a[2 * tip[0] + 1] / theory - 1.0).abs() < bound,
            "{length}: {} {theory} {found:?}",
            a[2 * tip[0] + 1]
        );
    }
}

#[test]
fn random_inverted_starts_recover_or_are_refused() {
    let mesh = grid([3, 3], false, Vector2::new).expect("a mesh");
    let clamped = mesh.nodes_where(|x| x.y == 0.0);
    let mut state = 11_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut recovered = 0;
    for law in [Law::StableNeoHookean, Law::NeoHookean, Law::StVenantKirchhoff] {
        for _ in 0..5 {
            let material = Material::new(law, 1.0, 0.3).expect("a material");
            let solid = Deformable::new(mesh.clone(), material, Vector2::new(0.0, -0.01)).expect("a solid");
            let mut system = System::new();
            let body = system.add(solid);
            system.clamp(body, &clamped);
            let mut a: Vec<f64> = system
                .fixed
                .iter()
                .map(|fixed| if *fixed { 0.0 } else { 0.4 * next() })
                .collect();
            assert!(system.least_determinant(&a) < 0.0);
            match Newton::new(Settings::default()).minimise(&system, &mut a) {
                Ok(found) => {
                    assert!(found.least_determinant > 0.0 && found.residual <= 1e-8 * found.load);
                    recovered += usize::from(law == Law::StableNeoHookean);
                }
                Err(Failed::NoEnergy) => assert_eq!(law, Law::NeoHookean),
                Err(refused) => assert!(law != Law::NeoHookean, "{law:?}: {refused}"),
            }
        }
    }
    assert!(recovered >= 1);
}

#[test]
fn nearly_incompressible_plain_elements_are_refused() {
    let mesh = || rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [1, 1]).expect("a mesh");
    let material = Material::new(Law::NeoHookean, 1.0, 0.4999).expect("a material");
    let refused = Deformable::new(mesh(), material, Vector2::zeros()).expect_err("refused");
    assert!(
        matches!(refused, NotMixed { poisson } if (poisson - 0.4999).abs() < 1e-12),
        "{refused}"
    );
    let solid = Deformable::new(mesh().mixed(), material, Vector2::zeros()).expect("a solid");
    assert_eq!(solid.parameters(), 18);
}

#[test]
fn without_any_force_the_start_is_the_answer() {
    let mesh = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [2, 2]).expect("a mesh");
    let material = Material::new(Law::NeoHookean, 1.0, 0.3).expect("a material");
    let mut system = System::new();
    system.add(Deformable::new(mesh, material, Vector2::zeros()).expect("a solid"));
    let (a, found) = settle(&mut system);
    assert!(
        a.iter().all(|a| *a == 0.0) && found.iterations == 0 && found.stability.neutral == 3,
        "{found:?}"
    );
}
