//! Exact contact, certified: balance of forces, gaps, forces times gaps, stability; flat on flat; a solid with itself;
//! loads in parts.

use crate::common::scenes::{five_exact, ring_exact, soft};
use nalgebra::Vector2;
use simulation::constraint::{HalfPlaneBarrier, SolidBarrier, overlapping};
use simulation::control::{Newton, Settings};
use simulation::equilibrium::{Equilibrium, NoEquilibrium, settle, settle_in_steps, settled};
use simulation::law::{Law, Material};
use simulation::q9::{rectangle, ring};
use simulation::solid::Deformable;
use simulation::system::System;

/// The four criteria of every scene.
fn certify(system: &System, a: &[f64], found: &Equilibrium) {
    assert!(found.exact, "{found:?}");
    assert!(found.minimum.residual <= 1e-8 * found.minimum.load, "{found:?}");
    assert!(found.least_gap >= 0.0 && found.violation == 0.0, "{found:?}");
    assert!(found.complementarity <= 1e-8, "{found:?}");
    assert!(found.imbalance <= 1e-8 * a.len() as f64, "{found:?}");
    assert_eq!(found.minimum.stability.falling, 0, "{found:?}");
    assert!(found.minimum.least_determinant > 0.0, "{found:?}");
    assert!(overlapping(&system.bodies, a).is_empty());
}

#[test]
fn five_solids_in_a_cavity_touch_exactly() {
    for widths in [[0.05, 0.0125], [0.1, 0.025]] {
        let mut system = five_exact(2, widths);
        let mut a = system.initial();
        let found = settled(&mut system, &mut a).expect("an equilibrium");
        certify(&system, &a, &found);
    }
}

#[test]
fn a_ring_touches_a_plane_exactly_and_rests_where_an_independent_code_says() {
    let mut system = ring_exact([64, 4], 0.02);
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    certify(&system, &a, &found);
    let crown = (0..a.len() / 2)
        .map(|n| system.bodies.point(0, n, &a).y)
        .fold(0.0, f64::max);
    // No point of an arc may lie below the plane, not only no node: arcs 0.098 long stand higher by some part of the cube
    // of that, 9e-4, which is the order of the mesh.
    assert!((crown - 1.558_976_5).abs() < 3e-4, "{crown}");
}

/// Two blocks of 3 and 2 elements across, pressed together by a uniform traction, without Poisson's effect: the exact state
/// is uniform.
#[test]
fn flat_on_flat_is_uniform_across_edges_that_do_not_match() {
    let material = Material::new(Law::StVenantKirchhoff, 1.0, 0.0).expect("a material");
    let below = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [3, 2]).expect("a mesh");
    let above = rectangle(Vector2::new(0.0, 1.01), Vector2::new(1.0, 1.0), [2, 1]).expect("a mesh");
    let (clamped, traction) = (
        below.nodes_where(|x| x.y == 0.0),
        above.traction(Vector2::new(0.0, -0.05), |x| x.y > 2.0),
    );
    let heights: Vec<f64> = below.nodes.iter().map(|x| x.y).collect();
    let mut system = System::new();
    let lower = system.add(Deformable::new(below, material, Vector2::zeros()).expect("a solid"));
    let upper = system.add(Deformable::new(above, material, Vector2::zeros()).expect("a solid"));
    system.clamp(lower, &clamped);
    // Nothing but contact holds the upper block upright: it may only go up and down.
    let start = system.bodies.offset(upper);
    (start..system.fixed.len())
        .step_by(2)
        .for_each(|k| system.fixed[k] = true);
    system.load(upper, &traction);
    system
        .terms
        .push(Box::new(SolidBarrier::new(0.05, 0.0125, 0.1).then_exact()));
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    assert!(
        found.exact && found.least_gap >= 0.0 && found.complementarity <= 1e-8,
        "{found:?}"
    );
    // (s^3 - s) / 2 = -0.05: the stretch of a uniform column.
    let stretch = (0..50).fold(0.9_f64, |s, _| {
        s - ((s * s * s - s) / 2.0 + 0.05) / ((3.0 * s * s - 1.0) / 2.0)
    });
    let off = heights
        .iter()
        .enumerate()
        .map(|(n, y)| (a[2 * n + 1] - (stretch - 1.0) * y).abs());
    let off = off.fold(0.0, f64::max);
    // Gaps of rows that are neither loaded nor free differ by the root of what is left of force times gap, 1e-21.
    assert!(off <= 1e-10, "{off:e} {found:?}");
}

#[test]
fn a_ring_pressed_flat_keeps_out_of_itself() {
    let mut newton = Newton::new(Settings::default());
    let mut a: Option<Vec<f64>> = None;
    let mut least = f64::INFINITY;
    for frame in 0..34 {
        let half = 1.04 - 0.02 * f64::from(frame);
        let mesh = ring(Vector2::zeros(), [0.75, 1.0], [12, 1]).expect("a ring");
        let mut system = System::new();
        system.add(soft(mesh, Law::NeoHookean, 0.0));
        for normal in [Vector2::y(), -Vector2::y()] {
            let guard =
                HalfPlaneBarrier::new(&system.bodies, &[0], normal, -half, [0.05, 0.05], 0.1).expect("a direction");
            system.terms.push(Box::new(guard));
        }
        system
            .terms
            .push(Box::new(SolidBarrier::new(0.05, 0.05, 0.1).with_own(&[0])));
        let mut state = a.take().unwrap_or_else(|| system.initial());
        let found = settle(&mut system, &mut newton, &mut state).expect("an equilibrium");
        assert!(
            !found.exact && found.minimum.least_determinant > 0.0,
            "{half}: {found:?}"
        );
        // The first inner nodes: the inner side lies on the far side of the wall's thickness from each wall.
        let inner = (0..24).map(|n| system.bodies.point(0, n, &state).y);
        let (low, high) = inner.fold((f64::INFINITY, f64::NEG_INFINITY), |m, y| (m.0.min(y), m.1.max(y)));
        least = high - low;
        a = Some(state);
    }
    assert!(least > 0.0);
}

#[test]
fn a_load_too_large_for_one_search_is_applied_in_parts() {
    let beam = || {
        let mesh = rectangle(Vector2::zeros(), Vector2::new(10.0, 1.0), [10, 1]).expect("a mesh");
        let clamped = mesh.nodes_where(|x| x.x == 0.0);
        let mut system = System::new();
        let body = system.add(soft(mesh, Law::NeoHookean, 4e-4));
        system.clamp(body, &clamped);
        system
    };
    let few = Settings {
        most_iterations: 6,
        ..Settings::default()
    };
    let (mut system, mut newton) = (beam(), Newton::new(few));
    let mut a = system.initial();
    let refused = settle(&mut system, &mut newton, &mut a).expect_err("too few steps");
    assert!(matches!(refused, NoEquilibrium::Search { .. }), "{refused}");
    let mut a = system.initial();
    let found = settle_in_steps(&mut system, &mut newton, &mut a, 30).expect("an equilibrium");
    assert!(
        found.load_steps > 1 && found.minimum.residual <= 1e-8 * found.minimum.load,
        "{found:?}"
    );
    let mut whole = beam();
    let mut b = whole.initial();
    settled(&mut whole, &mut b).expect("an equilibrium");
    // Both within 1e-8 of the load of one equilibrium; the beam yields some 1e4 lengths by unit of force, 4e-3 of load.
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6));
    // Without enough tries: refused with what was reached.
    let mut c = whole.initial();
    let refused = settle_in_steps(&mut beam(), &mut Newton::new(few), &mut c, 2).expect_err("refused");
    assert!(matches!(refused, NoEquilibrium::Load { tries: 2, .. }), "{refused}");
}
