//! Detection against comparing all with all, and heaps with many contacts.

use crate::common::scenes::{five, heap};
use nalgebra::Vector2;
use simulation::bodies::Bodies;
use simulation::constraint::{SolidBarrier, Term, barrier, nearest};
use simulation::equilibrium::settled;
use simulation::law::Law;

/// The energy of a barrier of this width and stiffness, by every sample of every solid against every arc of every other: four
/// samples an arc, as many as arcs have that bend less than the width.
fn all_with_all(bodies: &Bodies, a: &[f64], width: f64, stiffness: f64) -> f64 {
    let arcs: Vec<(usize, usize, [Vector2<f64>; 3])> = (0..bodies.len())
        .flat_map(|body| (0..bodies.solid(body).boundary().arcs.len()).map(move |arc| (body, arc)))
        .map(|(body, arc)| {
            let nodes = bodies.solid(body).boundary().arcs[arc];
            (body, arc, nodes.map(|n| bodies.point(body, n, a)))
        })
        .collect();
    let mut energy = 0.0;
    for (body, arc, nodes) in &arcs {
        let reference = bodies.solid(*body).boundary().reference[*arc];
        for k in 0..4 {
            let u = 0.5 * f64::from(k) - 1.0;
            let at = |x: &[Vector2<f64>; 3]| {
                x[0] * (0.5 * u * (u - 1.0)) + x[1] * (1.0 - u * u) + x[2] * (0.5 * u * (u + 1.0))
            };
            let slope = reference[0] * (u - 0.5) - reference[1] * (2.0 * u) + reference[2] * (u + 0.5);
            for (_, _, other) in arcs.iter().filter(|(other, _, _)| other != body) {
                let distance = nearest(other, at(nodes)).distance;
                let [value, ..] = barrier(distance / width).expect("apart");
                energy += 0.5 * stiffness * width * (0.5 * slope.norm()) * value;
            }
        }
    }
    energy
}

#[test]
fn a_barrier_sees_what_all_with_all_sees() {
    let system = five(2, Law::NeoHookean, 1e-2);
    let mut a = system.initial();
    for (round, width) in [0.1, 0.2, 0.4].into_iter().enumerate() {
        // Nearer to one another from round to round, and deformed.
        for (k, a) in a.iter_mut().enumerate() {
            *a += 0.01 * ((k * (round + 3)) as f64).sin();
        }
        let pairs = SolidBarrier::new(width, width, 0.1);
        let found = pairs.energy(&system.bodies, &a).expect("an energy");
        let all = all_with_all(&system.bodies, &a, width, 0.1);
        // Sums in another order: rounding of some hundred terms.
        assert!(
            all > 0.0 && (found - all).abs() <= 1e-12 * all,
            "{width}: {found:e} {all:e}"
        );
    }
}

#[test]
fn a_heap_with_many_contacts_comes_to_rest() {
    let mut system = heap(5, 5, 0.002, [0.05, 0.01]);
    let mut a = system.initial();
    let found = settled(&mut system, &mut a).expect("an equilibrium");
    let (contacts, minimum) = (system.forces(&a).len(), found.minimum);
    assert!(contacts > 100, "{contacts}");
    assert!(minimum.residual <= 1e-8 * minimum.load, "{minimum:?}");
    assert_eq!(minimum.stability.falling, 0);
    assert!(found.least_gap > 0.0 && minimum.least_determinant > 0.0, "{found:?}");
    // The sum of a solid's forces: its unknowns' residuals, of which it has 18.
    assert!(found.imbalance <= 18.0 * 1e-8, "{found:?}");
}
