//! Extremes of exact contact: stiffness, gaps, units, needles, corner on corner, no support, no room. Each ends in a right
//! answer or in a named refusal.

use crate::common::scenes::soft;
use nalgebra::Vector2;
use simulation::constraint::{HalfPlane, HalfPlaneBarrier, SolidBarrier, deepest};
use simulation::control::{Failed, Newton, Settings};
use simulation::equilibrium::{Equilibrium, NoEquilibrium, settle, settled};
use simulation::law::{Law, Material};
use simulation::q9::{rectangle, ring};
use simulation::solid::{Deformable, Rigid};
use simulation::system::System;

/// The largest free force: 1e-8 of the largest load, or what rounding leaves of stiffness times displacement.
fn allowed(found: &Equilibrium) -> f64 {
    found.minimum.rounding.max(1e-8 * found.minimum.load)
}

/// Balance, gaps, complementarity, stability, and nothing inside anything.
fn certify(system: &System, a: &[f64], found: &Equilibrium) {
    assert!(found.exact, "{found:?}");
    assert!(found.minimum.residual <= allowed(found), "{found:?}");
    assert!(found.least_gap >= -1e-12 * system.bodies.extent(), "{found:?}");
    assert!(found.complementarity <= 1e-8, "{found:?}");
    assert_eq!(found.minimum.stability.falling, 0, "{found:?}");
    assert!(found.minimum.least_determinant > 0.0, "{found:?}");
    let deep = deepest(&system.bodies, a, &|_, _| true).map_or(0.0, |o| o.depth);
    assert!(deep <= 1e-12 * system.bodies.extent(), "{deep:e}");
}

fn guard(system: &mut System, which: &[usize], normal: Vector2<f64>, offset: f64, width: f64, stiffness: f64) {
    let plane =
        HalfPlaneBarrier::new(&system.bodies, which, normal, offset, [width; 2], stiffness).expect("a direction");
    system.terms.push(Box::new(plane.then_exact()));
}

fn block(corner: (f64, f64), size: (f64, f64), young: f64, weight: f64) -> Deformable {
    let mesh = rectangle(Vector2::new(corner.0, corner.1), Vector2::new(size.0, size.1), [2, 2]).expect("a mesh");
    let material = Material::new(Law::NeoHookean, young, 0.3).expect("a material");
    Deformable::new(mesh, material, Vector2::new(0.0, -weight)).expect("a solid")
}

/// A block between two side walls stands on another block, and that on a floor.
fn stack(lower: f64, upper: f64, gap: f64, width: f64) -> System {
    let mut system = System::new();
    system.add(block((0.0, 1e-3), (1.0, 1.0), lower, 1e-3));
    system.add(block((0.1, 1.001 + gap), (0.8, 1.0), upper, 1e-3));
    for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -0.02), (-Vector2::x(), -1.02)] {
        guard(&mut system, &[0, 1], normal, offset, width, 0.1);
    }
    system
        .terms
        .push(Box::new(SolidBarrier::new(width, width, 0.1).then_exact()));
    system
}

/// An equilibrium in exact contact, certified: true. Else one behind a barrier that says so, or a search that says that it did
/// not converge.
fn found_or_refused(system: &mut System, a: &mut Vec<f64>) -> bool {
    match settled(system, a) {
        Ok(found) if found.exact => {
            certify(system, a, &found);
            true
        }
        // Behind its barrier, and says so.
        Ok(found) => found.minimum.residual > allowed(&found),
        Err(NoEquilibrium::Search {
            cause: Failed::NotConverged { iterations, .. },
            ..
        }) => {
            assert!(iterations <= Settings::default().most_iterations);
            false
        }
        Err(other) => panic!("{other}"),
    }
}

/// The stiffer block hardly deforms; the floor bears the weight of both.
#[test]
fn blocks_of_unlike_stiffness_in_contact_balance_or_are_refused() {
    for (lower, upper) in [(1.0, 1.0), (1.0, 1e3), (1e3, 1.0), (1.0, 1e6), (1.0, 1e12), (1e12, 1.0)] {
        let mut system = stack(lower, upper, 1e-3, 1e-2);
        let mut a = system.initial();
        let found = found_or_refused(&mut system, &mut a);
        assert!(found || f64::max(lower, upper) > 1.0, "{lower} {upper}");
        if found {
            let forces = system.terms[0].forces(&system.bodies, &a);
            let borne: f64 = forces.iter().map(|f| f.force.y).sum();
            // The free forces of 50 unknowns, 1e-8 of the load each.
            assert!((borne / 1.8e-3 - 1.0).abs() < 1e-6, "{borne}");
        }
    }
}

#[test]
fn solids_that_start_next_to_one_another_find_their_equilibrium_or_are_refused() {
    for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
        let mut system = stack(1.0, 1.0, gap, 1e-2);
        let mut a = system.initial();
        let found = found_or_refused(&mut system, &mut a);
        assert!(found || gap < 1e-3, "{gap:e}");
    }
}

/// The same ring on the same floor in other units.
#[test]
fn exact_contact_does_not_know_units() {
    let solve = |unit: f64, young: f64| {
        let mesh = ring(Vector2::new(0.0, 1.005 * unit), [0.7 * unit, unit], [8, 2]).expect("a ring");
        let material = Material::new(Law::NeoHookean, young, 0.3).expect("a material");
        let weight = Vector2::new(0.0, -0.01 * young / unit);
        let mut system = System::new();
        system.add(Deformable::new(mesh, material, weight).expect("a solid"));
        guard(&mut system, &[0], Vector2::y(), 0.0, 0.02 * unit, 0.1 * young);
        let mut a = system.initial();
        let found = settled(&mut system, &mut a).expect("an equilibrium");
        certify(&system, &a, &found);
        found.minimum.energy / (young * unit * unit)
    };
    let expected = solve(1.0, 1.0);
    for (unit, young) in [(1e-9, 1e12), (1e9, 1e-12), (1e-9, 1e-9), (1e9, 1e9)] {
        let found = solve(unit, young);
        // The energy is flat at its minimum: forces off by 1e-8 change it by the square of that.
        assert!(
            (found / expected - 1.0).abs() < 1e-9,
            "{unit} {young}: {found} {expected}"
        );
    }
}

fn rigid(corners: &[(f64, f64)], weight: f64) -> Rigid {
    let corners: Vec<Vector2<f64>> = corners.iter().map(|(x, y)| Vector2::new(*x, *y)).collect();
    Rigid::new(&corners, Vector2::new(0.0, -weight)).expect("a polygon")
}

/// Needles of ever less width, thrown on a floor between walls: they come to lie, or say why not.
#[test]
fn needle_polygons_come_to_rest_or_are_refused() {
    let mut rested = 0;
    for width in [1e-1, 1e-3, 1e-6] {
        let mut system = System::new();
        system.add(rigid(&[(0.0, 0.01), (1.0, 0.02), (0.0, 0.01 + width)], 1.0 / width));
        system.add(rigid(&[(0.1, 0.3), (1.1, 0.4), (0.1, 0.3 + width)], 1.0 / width));
        for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -0.2), (-Vector2::x(), -1.3)] {
            guard(&mut system, &[0, 1], normal, offset, 1e-2, 10.0);
        }
        system
            .terms
            .push(Box::new(SolidBarrier::new(1e-2, 1e-2, 10.0).then_exact()));
        let mut a = system.initial();
        match settled(&mut system, &mut a) {
            Ok(found) => {
                assert!(
                    found.minimum.residual <= 1e-8 * found.minimum.load,
                    "{width}: {found:?}"
                );
                rested += usize::from(found.exact);
                let deep = deepest(&system.bodies, &a, &|_, _| true).map_or(0.0, |o| o.depth);
                assert!(!found.exact || deep <= 1e-12, "{width}: {deep:e}");
            }
            Err(refused) => assert!(!refused.to_string().is_empty()),
        }
    }
    assert!(rested >= 1);
}

/// A square on its corner on the corner of another that is held, walls beside it: it cannot stay there, and comes down.
#[test]
fn corner_on_corner_is_left() {
    for off in [0.0, 1e-9, 1e-3] {
        let mut system = System::new();
        let tip = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)];
        system.add(rigid(&tip, 0.0));
        let above: Vec<(f64, f64)> = tip.iter().map(|(x, y)| (x + off, y + 2.01)).collect();
        system.add(rigid(&above, 1.0));
        system.fixed[..3].fill(true);
        for (normal, offset) in [(Vector2::y(), -1.2), (Vector2::x(), -3.0), (-Vector2::x(), -3.0)] {
            guard(&mut system, &[1], normal, offset, 1e-2, 10.0);
        }
        system
            .terms
            .push(Box::new(SolidBarrier::new(1e-2, 1e-2, 10.0).then_exact()));
        let mut a = system.initial();
        let found = settled(&mut system, &mut a).expect("an equilibrium");
        certify(&system, &a, &found);
        assert!(a[4] < -0.1, "{off}: still on the tip, {a:?}");
    }
}

#[test]
fn without_support_touching_solids_have_no_equilibrium() {
    let mut system = System::new();
    system.add(block((0.0, 0.0), (1.0, 1.0), 1.0, 1e-3));
    system.add(block((0.0, 1.005), (1.0, 1.0), 1.0, 1e-3));
    system
        .terms
        .push(Box::new(SolidBarrier::new(1e-2, 1e-2, 0.1).then_exact()));
    let mut a = system.initial();
    let refused = settled(&mut system, &mut a).expect_err("it falls");
    let falls = matches!(
        refused,
        NoEquilibrium::Search {
            cause: Failed::Unbounded { .. },
            ..
        }
    );
    assert!(falls, "{refused}");
}

/// Walls that leave no room at all: refused within the limit of steps, for rigid and for elastic solids.
#[test]
fn walls_without_room_are_refused() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mesh = || rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [2, 2]).expect("a mesh");
    let solids: [&dyn Fn(&mut System) -> usize; 2] =
        [&|system: &mut System| system.add(rigid(&square, 1.0)), &|system| {
            system.add(soft(mesh(), Law::NeoHookean, 1e-3))
        }];
    for (k, add) in solids.into_iter().enumerate() {
        let mut system = System::new();
        add(&mut system);
        for (normal, offset) in [(Vector2::x(), 0.6), (-Vector2::x(), -0.4), (Vector2::y(), -0.1)] {
            let plane = HalfPlane::new(&system.bodies, &[0], normal, offset, 100.0).expect("a direction");
            system.terms.push(Box::new(plane));
        }
        system
            .terms
            .iter_mut()
            .filter_map(|t| t.way_to_exact())
            .for_each(|way| way.want_exact());
        let settings = Settings {
            most_iterations: 100,
            ..Settings::default()
        };
        let mut a = system.initial();
        let refused = settle(&mut system, &mut Newton::new(settings), &mut a).expect_err("no room");
        assert!(!refused.to_string().is_empty(), "{k}: {refused}");
    }
}

/// In exact contact, a solid that slides freely ends at the wall on its way, and not behind it: rows of the wall were once those of
/// samples nearer than twice the barrier's width, and no others were looked at.
#[test]
fn what_slides_freely_in_exact_contact_ends_at_a_far_wall() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| (x, y + 2e-3));
    let mut system = System::new();
    let body = system.add(rigid(&square, 1.0));
    for (normal, offset) in [(Vector2::y(), 0.0), (-Vector2::x(), -31.0)] {
        guard(&mut system, &[body], normal, offset, 1e-3, 0.1);
    }
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("a place on the floor");
    certify(&system, &a, &found);
    // A push from the left, as strong as the weight.
    system.load(body, &[(0, 1.0)]);
    let found = settled(&mut system, &mut a).expect("a place at the wall");
    certify(&system, &a, &found);
    // Rows keep 3e-11 apart, and force times gap is 1e-10 of load and size, shared by a few of them.
    assert!((a[0] - 30.0).abs() < 1e-8, "{a:?}");
}

/// Frame after frame in exact contact, without the barrier between: a wall comes in, and every state is certified.
#[test]
fn exact_contact_follows_a_wall_that_comes_in() {
    let mut system = System::new();
    let mesh = ring(Vector2::new(0.0, 1.01), [0.7, 1.0], [16, 2]).expect("a ring");
    system.add(soft(mesh, Law::NeoHookean, 0.002));
    guard(&mut system, &[0], Vector2::y(), 0.0, 0.01, 0.1);
    guard(&mut system, &[0], -Vector2::y(), -2.04, 0.01, 0.1);
    let mut a = system.initial();
    for frame in 0..8 {
        let found = settled(&mut system, &mut a).unwrap_or_else(|why| panic!("{frame}: {why}"));
        certify(&system, &a, &found);
        println!("{frame}: {} steps", found.iterations);
        system.terms[1].move_wall(0.02);
    }
}

/// A square that stands on a corner is in equilibrium, and no minimum: it falls over, in exact contact, on one of its sides.
#[test]
fn what_stands_on_its_corner_falls_over() {
    let half = 0.5_f64.sqrt();
    let corners = [(0.0, 0.0), (half, half), (0.0, 2.0 * half), (-half, half)].map(|(x, y)| (x, y + 2e-3));
    let mut system = System::new();
    let body = system.add(rigid(&corners, 1.0));
    for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -2.0), (-Vector2::x(), -2.0)] {
        guard(&mut system, &[body], normal, offset, 1e-2, 0.1);
    }
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    certify(&system, &a, &found);
    // Its centre comes down from half a diagonal to half a side, but for gaps of 1e-10.
    let fall = -a[1] - 2e-3;
    assert!((fall - (half - 0.5)).abs() < 1e-8, "{fall} {found:?}");
}
