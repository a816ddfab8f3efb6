//! Exact contact of arcs that run along one another: what its rows must not miss, and what ends the search for them.

use crate::common::scenes::{ring_exact, soft, tee};
use nalgebra::Vector2;
use simulation::constraint::{Constraint, HalfPlane, HalfPlaneBarrier, SolidBarrier, Stage, Term, deepest};
use simulation::equilibrium::settled;
use simulation::law::Law;
use simulation::q9::{rectangle, ring};
use simulation::solid::Rigid;
use simulation::system::System;

fn depth(system: &System, a: &[f64]) -> f64 {
    deepest(&system.bodies, a, &|_, _| true).map_or(0.0, |o| o.depth)
}

/// Figure 39: the ring lies along a side of the T, where no closest point stands out. Rows at points where arcs are closest
/// did not see it, and let 3e-5 of the T into the ring.
#[test]
fn arcs_that_run_along_one_another_do_not_cross_between_rows() {
    let mut system = System::new();
    let mesh = ring(Vector2::new(0.0, 1.005), [0.6, 1.0], [12, 2]).expect("a ring");
    system.add(soft(mesh, Law::NeoHookean, 0.005));
    let corners = [
        (-0.2, 0.0),
        (0.2, 0.0),
        (0.2, 1.0),
        (0.7, 1.0),
        (0.7, 1.3),
        (-0.7, 1.3),
        (-0.7, 1.0),
        (-0.2, 1.0),
    ];
    let corners = corners.map(|(x, y)| Vector2::new(x, y));
    let body = system.add(Rigid::new(&corners, Vector2::new(0.0, -0.03)).expect("a polygon"));
    let mut a = system.initial();
    let solid = system.bodies.solid(body);
    let mut part = system.bodies.part(body, &a).to_vec();
    solid.rotate(&mut part, 0.35, Vector2::zeros());
    solid.translate(&mut part, Vector2::new(0.2, 2.1));
    system.bodies.part_mut(body, &mut a).copy_from_slice(&part);
    for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -1.3), (-Vector2::x(), -1.3)] {
        let guard =
            HalfPlaneBarrier::new(&system.bodies, &[0, 1], normal, offset, [1e-2, 1e-3], 0.1).expect("a direction");
        system.terms.push(Box::new(guard.then_exact()));
    }
    system
        .terms
        .push(Box::new(SolidBarrier::new(1e-2, 1e-3, 0.1).then_exact()));
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    assert!(found.exact && found.complementarity <= 1e-8, "{found:?}");
    // Samples of arcs, in units of the ring's size, 2: nothing but rounding.
    assert!(depth(&system, &a) <= 2e-12, "{:e}", depth(&system, &a));
}

/// The lowest point of an arc over a plane moves with the arc: a row that stayed where it was once found needed a neighbour
/// after each step, thirty in all, and some hundred steps.
#[test]
fn rows_at_lowest_points_follow_them() {
    let mut system = ring_exact([12, 2], 0.02);
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    assert!(found.exact && found.least_gap >= 0.0, "{found:?}");
    // It could stand on an arc's middle, as on a hill: that is left.
    assert_eq!(found.minimum.stability.falling, 0, "{found:?}");
    let rows = system.terms[0].forces(&system.bodies, &a).len();
    // Four samples and a lowest point of each of the 12 outer arcs at most.
    assert!(rows <= 60, "{rows} rows, {found:?}");
}

/// A plane with multipliers hands them over: arcs then keep out of it between the nodes too.
#[test]
fn a_plane_with_multipliers_ends_exact_between_nodes() {
    let mut system = System::new();
    let mesh = ring(Vector2::new(0.0, 1.0), [0.7, 1.0], [12, 2]).expect("a ring");
    system.add(soft(mesh, Law::NeoHookean, 0.001));
    let plane = HalfPlane::new(&system.bodies, &[0], Vector2::y(), 0.0, 100.0).expect("a direction");
    system.terms.push(Box::new(plane));
    system
        .terms
        .iter_mut()
        .filter_map(|t| t.way_to_exact())
        .for_each(|way| way.want_exact());
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    assert!(system.terms[0].stage() == Stage::Exact, "{found:?}");
    assert!(found.violation <= 2e-13 && found.least_gap >= -2e-13, "{found:?}");
    assert!(found.complementarity <= 1e-8 && found.imbalance <= 1e-6, "{found:?}");
}

/// What was found in a state is not taken for what a narrower barrier, or exact contact, finds in it.
#[test]
fn a_contact_that_has_changed_looks_anew_at_the_same_state() {
    let mut system = System::new();
    for k in 0..2 {
        let low = Vector2::new(1.005 * f64::from(k), 0.0);
        let mesh = rectangle(low, Vector2::new(1.0, 1.0), [1, 1]).expect("a mesh");
        system.add(soft(mesh, Law::Linear, 0.0));
    }
    let (bodies, a) = (&system.bodies, system.initial());
    let energy = |pairs: &SolidBarrier| pairs.energy(bodies, &a).expect("apart");
    let mut pairs = SolidBarrier::new(4e-2, 1e-2, 1.0).then_exact();
    let wide = energy(&pairs);
    assert!(wide > 0.0 && energy(&pairs.clone()) == wide);
    assert!(pairs.update(bodies, &a).again);
    let narrow = energy(&pairs);
    assert_eq!(narrow, energy(&SolidBarrier::new(1e-2, 1e-2, 1.0)));
    assert!(narrow != wide && pairs.stage() == Stage::Provisional);
    assert!(pairs.update(bodies, &a).again);
    assert!(energy(&pairs) == 0.0 && pairs.stage() == Stage::Exact);
}

/// Of three blocks that stand on one another only the named pairs keep apart, and the energy of the others is none.
#[test]
fn pairs_that_are_not_named_have_no_energy() {
    let block = |x: f64| {
        soft(
            rectangle(Vector2::new(x, 0.0), Vector2::new(1.0, 1.0), [1, 1]).expect("a mesh"),
            Law::Linear,
            0.0,
        )
    };
    let mut system = System::new();
    for k in 0..3 {
        system.add(block(1.005 * f64::from(k)));
    }
    let a = system.initial();
    let energy = |pairs: SolidBarrier| pairs.energy(&system.bodies, &a).expect("apart");
    let all = energy(SolidBarrier::new(1e-2, 1e-2, 1.0));
    let one = energy(SolidBarrier::new(1e-2, 1e-2, 1.0).among(&[[1, 0]]));
    let none = energy(SolidBarrier::new(1e-2, 1e-2, 1.0).among(&[[0, 2]]));
    assert!(
        one > 0.0 && (all / one - 2.0).abs() < 1e-9 && none == 0.0,
        "{all} {one} {none}"
    );
    assert!(energy(SolidBarrier::new(1e-2, 1e-2, 1.0).among(&[])) == 0.0);
}

/// A point is inside or outside by the corner that it is nearest to, whichever way the chords of curved sides run.
#[test]
fn depth_is_told_at_corners_that_stand_out_and_go_in() {
    let mut system = System::new();
    system.add(tee());
    let small = |x: f64, y: f64| {
        let corners = [(0.0, 0.0), (0.01, 0.0), (0.0, 0.01)].map(|(u, v)| Vector2::new(x + u, y + v));
        Rigid::new(&corners, Vector2::zeros()).expect("a polygon")
    };
    // In the inner corner under the right arm of the T, free; and 0.05 inside its foot.
    system.add(small(0.25, 0.9));
    let a = system.initial();
    assert!(deepest(&system.bodies, &a, &|_, _| true).is_none());
    system.add(small(-0.15, 0.5));
    let a = system.initial();
    let found = deepest(&system.bodies, &a, &|_, _| true).expect("inside");
    // The corner that lies deepest in the foot, which reaches from -0.2: 0.06.
    assert!((found.depth - 0.06).abs() < 1e-12 && found.first == 2, "{found:?}");
    assert!(deepest(&system.bodies, &a, &|i, j| i + j != 2).is_none());
}
