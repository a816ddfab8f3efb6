//! Scenes with contact.

use nalgebra::Vector2;
use simulation::constraint::{HalfPlane, HalfPlaneBarrier, SolidBarrier};
use simulation::law::{Law, Material};
use simulation::q9::{Mesh, blob, ring};
use simulation::solid::{Deformable, Rigid};
use simulation::system::System;

pub(crate) fn soft(mesh: Mesh, law: Law, weight: f64) -> Deformable {
    let material = Material::new(law, 1.0, 0.3).expect("a material");
    Deformable::new(mesh, material, Vector2::new(0.0, -weight)).expect("a solid")
}

/// Adds a half-plane that all solids keep out of.
pub(crate) fn wall(system: &mut System, normal: (f64, f64), offset: f64, stiffness: f64) {
    let all: Vec<usize> = (0..system.bodies.len()).collect();
    let normal = Vector2::new(normal.0, normal.1);
    let plane = HalfPlane::new(&system.bodies, &all, normal, offset, stiffness).expect("a direction");
    system.terms.push(Box::new(plane));
}

/// Adds a half-plane behind a barrier that all solids keep away from.
pub(crate) fn guard(system: &mut System, normal: (f64, f64), offset: f64, width: f64) {
    let all: Vec<usize> = (0..system.bodies.len()).collect();
    let normal = Vector2::new(normal.0, normal.1);
    let widths = [width.max(1e-2), width];
    let plane = HalfPlaneBarrier::new(&system.bodies, &all, normal, offset, widths, 0.1).expect("a direction");
    system.terms.push(Box::new(plane));
}

/// A full ring on the plane y = 0, thesis's figure 37.
pub(crate) fn ring_on_plane(elements: [usize; 2], weight: f64) -> System {
    let mesh = ring(Vector2::new(0.0, 1.0), [0.7, 1.0], elements).expect("a ring");
    let mut system = System::new();
    system.add(soft(mesh, Law::StVenantKirchhoff, weight));
    wall(&mut system, (0.0, 1.0), 0.0, 100.0);
    system
}

/// The same ring, first behind a barrier: for weights under which it rolls on its way.
pub(crate) fn ring_behind_barrier(elements: [usize; 2], weight: f64) -> System {
    let mesh = ring(Vector2::new(0.0, 1.005), [0.7, 1.0], elements).expect("a ring");
    let mut system = System::new();
    system.add(soft(mesh, Law::StVenantKirchhoff, weight));
    let guard = HalfPlaneBarrier::new(&system.bodies, &[0], Vector2::y(), 0.0, [1e-2, 1e-4], 0.1).expect("a direction");
    system.terms.push(Box::new(guard.then_exact()));
    system
}

/// A ring in a ring on a plane, figure 38.
pub(crate) fn ring_in_ring(elements: [usize; 2], weight: f64, width: f64) -> System {
    let outer = ring(Vector2::new(0.0, 2.005), [1.4, 2.0], elements).expect("a ring");
    let inner = ring(Vector2::new(0.0, 1.61 + 0.005), [0.7, 1.0], elements).expect("a ring");
    let mut system = System::new();
    system.add(soft(outer, Law::NeoHookean, weight));
    system.add(soft(inner, Law::NeoHookean, weight));
    guard(&mut system, (0.0, 1.0), 0.0, width);
    system.terms.push(Box::new(SolidBarrier::new(1e-2, width, 0.1)));
    system
}

/// Five solids of `k` x `k` elements in a cavity, figure 40.
pub(crate) fn five(k: usize, law: Law, width: f64) -> System {
    let blobs = [
        (-0.75, 0.75, 0.70, 0.62, 0.2),
        (0.78, 0.70, 0.72, 0.6, -0.3),
        (-0.70, 2.15, 0.75, 0.6, 0.4),
        (0.80, 2.10, 0.70, 0.65, 0.1),
        (0.05, 3.45, 0.8, 0.6, 0.0),
    ];
    let mut system = System::new();
    for (x, y, a, b, angle) in blobs {
        let mesh = blob(Vector2::new(x, 1.05 * y), [a, b], angle, [k, k]).expect("a blob");
        system.add(soft(mesh, law, 0.02));
    }
    guard(&mut system, (0.0, 1.0), 0.0, width);
    guard(&mut system, (1.0, 0.0), -1.6, width);
    guard(&mut system, (-1.0, 0.0), -1.6, width);
    system.terms.push(Box::new(SolidBarrier::new(1e-2, width, 0.1)));
    system
}

/// The corners of a T, upright, its foot at the origin.
fn tee_corners() -> [(f64, f64); 8] {
    [
        (-0.2, 0.0),
        (0.2, 0.0),
        (0.2, 1.0),
        (0.7, 1.0),
        (0.7, 1.3),
        (-0.7, 1.3),
        (-0.7, 1.0),
        (-0.2, 1.0),
    ]
}

/// That T.
pub(crate) fn tee() -> Rigid {
    Rigid::new(&tee_corners().map(|(x, y)| Vector2::new(x, y)), Vector2::new(0.0, -1.0)).expect("a polygon")
}

/// A star of five points about the origin.
pub(crate) fn star() -> Rigid {
    let corner = |k: usize| {
        let radius = if k.is_multiple_of(2) { 1.0 } else { 0.45 };
        let angle = std::f64::consts::PI * (0.2 * k as f64 + 0.13);
        Vector2::new(angle.cos(), angle.sin()) * radius
    };
    let corners: Vec<Vector2<f64>> = (0..10).map(corner).collect();
    Rigid::new(&corners, Vector2::new(0.0, -1.0)).expect("a polygon")
}

/// The same in exact contact, from a barrier of the first width by way of the second.
pub(crate) fn five_exact(k: usize, [first, last]: [f64; 2]) -> System {
    let mut system = five(k, Law::NeoHookean, last);
    system.terms.clear();
    let all: Vec<usize> = (0..5).collect();
    for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -1.6), (-Vector2::x(), -1.6)] {
        let guard =
            HalfPlaneBarrier::new(&system.bodies, &all, normal, offset, [first, last], 0.1).expect("a direction");
        system.terms.push(Box::new(guard.then_exact()));
    }
    system
        .terms
        .push(Box::new(SolidBarrier::new(first, last, 0.1).then_exact()));
    system
}

/// Figure 37 in exact contact, from a barrier of this width.
pub(crate) fn ring_exact(elements: [usize; 2], width: f64) -> System {
    let mut system = ring_behind_barrier(elements, 0.01);
    system.terms.clear();
    let guard = HalfPlaneBarrier::new(&system.bodies, &[0], Vector2::y(), 0.0, [width; 2], 0.1).expect("a direction");
    system.terms.push(Box::new(guard.then_exact()));
    system
}

/// Figure 38 in exact contact, from a barrier of this width.
pub(crate) fn ring_in_ring_exact(elements: [usize; 2], width: f64) -> System {
    let mut system = ring_in_ring(elements, 0.01, width);
    system.terms.clear();
    let guard =
        HalfPlaneBarrier::new(&system.bodies, &[0, 1], Vector2::y(), 0.0, [width; 2], 0.1).expect("a direction");
    system.terms.push(Box::new(guard.then_exact()));
    system
        .terms
        .push(Box::new(SolidBarrier::new(width, width, 0.1).then_exact()));
    system
}

/// A rigid T on an elastic ring between three walls, figure 39; in exact contact where that is wanted.
pub(crate) fn tee_on_ring(widths: [f64; 2], exact: bool) -> (System, Vec<f64>) {
    let mesh = ring(Vector2::new(0.0, 1.005), [0.6, 1.0], [12, 2]).expect("a ring");
    let mut system = System::new();
    system.add(soft(mesh, Law::NeoHookean, 0.005));
    let corners = tee_corners().map(|(x, y)| Vector2::new(x, y));
    let body = system.add(Rigid::new(&corners, Vector2::new(0.0, -0.03)).expect("a polygon"));
    for (normal, offset) in [(Vector2::y(), 0.0), (Vector2::x(), -1.3), (-Vector2::x(), -1.3)] {
        let guard = HalfPlaneBarrier::new(&system.bodies, &[0, 1], normal, offset, widths, 0.1).expect("a direction");
        system.terms.push(if exact {
            Box::new(guard.then_exact())
        } else {
            Box::new(guard)
        });
    }
    let pairs = SolidBarrier::new(widths[0], widths[1], 0.1);
    system
        .terms
        .push(Box::new(if exact { pairs.then_exact() } else { pairs }));
    let mut a = system.initial();
    system
        .bodies
        .solid(body)
        .rotate(system.bodies.part_mut(body, &mut a), 0.35, Vector2::zeros());
    system
        .bodies
        .solid(body)
        .translate(system.bodies.part_mut(body, &mut a), Vector2::new(0.2, 2.1));
    (system, a)
}

/// A heap of soft round solids of one element each, in rows shifted by half a width, between walls.
pub(crate) fn heap(columns: usize, rows: usize, weight: f64, widths: [f64; 2]) -> System {
    let mut system = System::new();
    for row in 0..rows {
        let (shift, count) = (0.5 * (row % 2) as f64, columns - row % 2);
        for column in 0..count {
            let centre = Vector2::new(column as f64 + shift + 0.5, 0.9 * row as f64 + 0.53);
            let angle = 0.7 * (row * columns + column) as f64;
            let mesh = blob(centre, [0.44, 0.44], angle, [1, 1]).expect("a blob");
            system.add(soft(mesh, Law::NeoHookean, weight));
        }
    }
    let all: Vec<usize> = (0..system.bodies.len()).collect();
    let sides = [
        (Vector2::y(), 0.0),
        (Vector2::x(), 0.0),
        (-Vector2::x(), -(columns as f64)),
    ];
    for (normal, offset) in sides {
        let guard = HalfPlaneBarrier::new(&system.bodies, &all, normal, offset, widths, 0.1).expect("a direction");
        system.terms.push(Box::new(guard));
    }
    system
        .terms
        .push(Box::new(SolidBarrier::new(widths[0], widths[1], 0.1)));
    system
}
