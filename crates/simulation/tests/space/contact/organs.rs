//! Contact of two deformable solids: derivatives, balance, a patch test, sliding, Hertz.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{OrganContact, Term};

use crate::contact::obstacle::{below, hold, newton, surface};
use crate::random;
use crate::terms::{check, scene};

/// A solid of a material of Young's modulus `young`.
pub(crate) fn deformable(mesh: &Mesh, law: Law, young: f64, nu: f64) -> Deformable {
    Deformable::new(mesh.clone(), Material::new(law, young, nu).unwrap(), Vector3::zeros()).unwrap()
}

/// A block from a corner to another, whole cubes.
pub(crate) fn block(
    corners: [[f64; 3]; 2],
    settings: &Settings,
    fine: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
) -> Mesh {
    Mesh::new(&below(1e3), corners.map(Vector3::from), settings, fine).unwrap()
}

/// Places where the ball of 20 mm radius at the origin has another of 25 mm below it, 1.5 mm deep in it, both deformed at random.
fn two_balls() -> (System, Vec<f64>, OrganContact) {
    let (mut system, mut a) = scene();
    let ball = Ball {
        centre: Vector3::new(3.0, 2.0, -43.3),
        radius: 25.0,
    };
    let corners = [ball.centre.add_scalar(-26.0), ball.centre.add_scalar(26.0)];
    let mesh = Mesh::new(&ball, corners, &Settings::of_side(13.0), &|_, _| false).unwrap();
    system.add(deformable(&mesh, Law::NeoHookean, 1.0, 0.4));
    let mut state = 5;
    a.extend((a.len()..system.bodies.size()).map(|_| 0.4 * (random(&mut state) - 0.5)));
    let contact = OrganContact::new(&system.bodies, [0, 1], surface(ball, 25.0), 2.0, |_, _| true).unwrap();
    (system, a, contact)
}

#[test]
fn derivatives_of_contact_between_organs() {
    let (system, a, mut contact) = two_balls();
    check(&contact, &system, &a);
    contact.update(&system.bodies, &a);
    check(&contact, &system, &a);
    let force = contact.force(&system.bodies, &a);
    assert!(
        force.points > 5 && force.force.z < 0.0 && force.depth > 0.5,
        "{force:?}"
    );
}

#[test]
fn what_one_organ_pushes_the_other_carries() {
    let (system, a, mut contact) = two_balls();
    contact.update(&system.bodies, &a);
    let mut gradient = vec![0.0; a.len()];
    contact.gradient(&system.bodies, &a, &mut gradient).unwrap();
    // Forces by a translation, moments by a turn about an axis: of each organ by its own unknowns.
    let largest = gradient.iter().fold(0.0_f64, |most, g| most.max(g.abs()));
    let work = |body: usize, way: &dyn Fn(Vector3<f64>) -> Vector3<f64>| -> f64 {
        let (solid, part) = (system.bodies.solid(body), system.bodies.part(body, &a));
        let (offset, places) = (system.bodies.offset(body), solid.places());
        let mut sum = 0.0;
        for node in 0..part.len() / 3 {
            let moved = Vector3::from_column_slice(&part[3 * node..3 * node + 3]);
            let way = way(Vector3::from(places[3 * node]) + moved);
            sum += (0..3).map(|k| gradient[offset + 3 * node + k] * way[k]).sum::<f64>();
        }
        sum
    };
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let forces = [0, 1].map(|body| work(body, &|_| axis));
        let moments = [0, 1].map(|body| work(body, &|x| axis.cross(&x)));
        assert!(
            (forces[0] + forces[1]).abs() < 1e-12 * largest * a.len() as f64,
            "{forces:?}"
        );
        assert!(
            (moments[0] + moments[1]).abs() < 1e-10 * largest * 70.0,
            "{moments:?} {largest}"
        );
        assert!(axis.z == 0.0 || forces[0].abs() > largest, "{forces:?}");
    }
}

/// Largest distance of a displacement from the exact one of two blocks, one on the other, under a pressure, beside the largest of them.
fn patch(sides: [f64; 2]) -> f64 {
    let law = Law::Linear;
    let (young, nu, pressure) = (1.0, 0.3, 0.01);
    let lower = block(
        [[0.0, 0.0, -30.0], [40.0, 40.0, 0.0]],
        &Settings::of_side(sides[0]),
        &|_, _| false,
    );
    let upper = block(
        [[0.0, 0.0, 0.0], [40.0, 40.0, 40.0]],
        &Settings::of_side(sides[1]),
        &|_, _| false,
    );
    let mut system = System::new();
    let [below_it, above] = [&lower, &upper].map(|mesh| system.add(deformable(mesh, law, young, nu)));
    hold(&mut system, below_it, &lower, 2);
    hold(&mut system, above, &upper, 2);
    for n in lower.nodes_where(|x| x.z < -30.0 + 1e-9) {
        system.fixed[3 * n + 2] = true;
    }
    let forces = deformable(&upper, law, young, nu).traction(|at, normal| {
        if at.z > 40.0 - 1e-9 && normal.z > 0.5 {
            -Vector3::z() * pressure
        } else {
            Vector3::zeros()
        }
    });
    system.load(above, &forces);
    let contact = OrganContact::new(
        &system.bodies,
        [above, below_it],
        surface(below(0.0), 10.0),
        2.0,
        |_, n| n.z < -0.5,
    );
    system.organs.push(contact.unwrap());
    let (mut search, mut a) = (newton(&system, 1e-10), system.initial());
    settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
    let force = system.organs[0].force(&system.bodies, &a);
    assert!((force.force.z / (-1600.0 * pressure) - 1.0).abs() < 1e-8, "{force:?}");
    let mut worst = 0.0_f64;
    for (mesh, body) in [(&lower, below_it), (&upper, above)] {
        let part = system.bodies.part(body, &a);
        for (n, x) in mesh.nodes.iter().enumerate() {
            let strain = Vector3::new(nu, nu, -1.0) * (pressure / young);
            let exact = strain.component_mul(&Vector3::new(x.x, x.y, x.z + 30.0));
            worst = worst.max((Vector3::from_column_slice(&part[3 * n..3 * n + 3]) - exact).norm());
        }
    }
    worst / (70.0 * pressure / young)
}

#[test]
fn a_uniform_pressure_passes_between_meshes_that_do_not_match() {
    // Exact where faces meet whole faces. Else the sum over the points of a face misses where the other's slope jumps between them: by
    // the cube of their distance, a quarter of a side, times the jump, some parts of the pressure; larger cubes are the worse side.
    for (side, most) in [
        (10.0, 1e-7),
        (5.0, 1e-6),
        (8.0, 1e-3),
        (20.0 / 3.0, 1e-3),
        (40.0 / 3.0, 1e-2),
    ] {
        let found = patch([10.0, side]);
        println!("cubes of {side} on cubes of 10 mm: {found:.2e}");
        assert!(found < most, "{side}: {found:e}");
    }
}
