//! Contact of two deformable solids: derivatives, balance, a patch test, sliding, Hertz.

use nalgebra::{Point3, Vector3};
use simulation::control::Newton;
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Settings};
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{OrganContact, Term, TubeContact};
use simulation::space::tube::Tube;

use crate::obstacle::{approach_of_ball, below, hold, newton, surface};
use crate::random;
use crate::terms::{check, scene};

/// A solid of a material of Young's modulus `young`.
fn deformable(mesh: &Mesh, law: Law, young: f64, nu: f64) -> Deformable {
    Deformable::new(mesh.clone(), Material::new(law, young, nu).unwrap(), Vector3::zeros()).unwrap()
}

/// A block from a corner to another, whole cubes.
fn block(corners: [[f64; 3]; 2], settings: &Settings, fine: &dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool) -> Mesh {
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
fn patch(sides: [f64; 2], law: Law) -> f64 {
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
    let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
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
    println!(
        "cubes of {sides:?} mm: {:.2e}, {} rounds, {} steps",
        worst / 0.7,
        found.rounds,
        found.iterations
    );
    worst / (70.0 * pressure / young)
}

#[test]
fn a_uniform_pressure_passes_between_meshes_that_do_not_match() {
    for sides in [
        [10.0, 10.0],
        [10.0, 8.0],
        [10.0, 20.0 / 3.0],
        [10.0, 5.0],
        [10.0, 40.0 / 3.0],
        [10.0, 20.0],
    ] {
        let found = patch(sides, Law::Linear);
        assert!(found < 1e-1, "{sides:?}: {found:e}");
    }
}

/// A quarter of a stack of two blocks, one on the other, pressed by a tube from above.
struct Stack {
    system: System,
    newton: Newton,
    a: Vec<f64>,
}

const RADIUS: f64 = 10.0;

fn tube(depth: f64) -> Tube {
    Tube::straight(
        Point3::new(0.0, 0.0, 25.0 - depth + RADIUS),
        Vector3::z(),
        200.0,
        RADIUS,
    )
    .unwrap()
}

impl Stack {
    fn new() -> Self {
        let young = 5e-3;
        let tip = Vector3::new(0.0, 0.0, 25.0);
        let fine = |low: &Vector3<f64>, high: &Vector3<f64>| (tip.sup(low).inf(high) - tip).norm() < 12.0;
        let settings = Settings {
            levels: 1,
            ..Settings::of_side(12.5)
        };
        let upper = block([[0.0, 0.0, 0.0], [37.5, 37.5, 25.0]], &settings, &fine);
        let lower = block(
            [[0.0, 0.0, -30.0], [45.0, 45.0, 0.0]],
            &Settings::of_side(15.0),
            &|_, _| false,
        );
        let mut system = System::new();
        let above = system.add(deformable(&upper, Law::NeoHookean, young, 0.45));
        let below_it = system.add(deformable(&lower, Law::NeoHookean, 2.0 * young, 0.4));
        hold(&mut system, above, &upper, 2);
        hold(&mut system, below_it, &lower, 2);
        let offset = system.bodies.offset(below_it);
        for n in lower.nodes_where(|x| x.z < -30.0 + 1e-9) {
            system.fixed[offset + 3 * n + 2] = true;
        }
        let stiffness = 20.0 * young / 12.5;
        let organ = OrganContact::new(
            &system.bodies,
            [above, below_it],
            surface(below(0.0), 10.0),
            stiffness,
            |_, n| n.z < -0.5,
        );
        system.organs.push(organ.unwrap());
        let contact = TubeContact::new(&system.bodies, above, tube(0.0), 2.0 * stiffness, |_, n| n.z > 0.5);
        system.tubes.push(contact.unwrap());
        Self {
            newton: newton(&system, 1e-8),
            a: system.initial(),
            system,
        }
    }

    /// State, and the forces on the tube and on the lower block.
    fn to(&mut self, depth: f64) -> Result<(Equilibrium, [f64; 2]), NoEquilibrium> {
        self.system.tubes[0].move_to(tube(depth));
        self.system.organs[0].restart();
        let found = settle(&mut self.system, &mut self.newton, &mut self.a, &Tolerance::default())?;
        let (bodies, a) = (&self.system.bodies, &self.a);
        let tube = self.system.tubes[0].force(bodies, a).force.z;
        let organ = self.system.organs[0].force(bodies, a);
        println!(
            "{depth} mm: tube {tube:.8} N, lower block {:.8} N at {} points, J {:.3}, {} rounds, {} steps",
            organ.force.z, organ.points, found.least_determinant, found.rounds, found.iterations
        );
        Ok((found, [tube, organ.force.z]))
    }
}

#[test]
fn a_stack_carries_the_tube_and_the_way_back_is_the_way_there() {
    let mut stack = Stack::new();
    let found = [1.0, 3.0, 4.99, 5.0, 5.01, 8.0, 5.0, 3.0, 1.0].map(|depth| stack.to(depth).unwrap());
    for (_, [tube, organ]) in &found {
        // Unknowns are within 1e-8 of a point's largest force, pressures within 1e-6 of it.
        assert!((tube + organ).abs() < 1e-6 * tube, "{tube} {organ}");
    }
    for (there, back) in [(0, 8), (1, 7), (3, 6)] {
        let ([one, other], [there, back]) = (
            [there, back].map(|k| found[k].1[0]),
            [there, back].map(|k| found[k].0.energy),
        );
        println!("force {one} {other}, energy {there} {back}");
        assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        // The energy is least: of the second order in what forces are off by.
        assert!((there / back - 1.0).abs() < 1e-6, "{there} {back}");
    }
    // A central difference of a smooth energy, to 0.01 mm: third derivatives are some 0.1 N/mm^2 of a quarter.
    let slope = (found[4].0.energy - found[2].0.energy) / 0.02;
    println!("slope of the energy {slope}, force {}", found[3].1[0]);
    assert!((slope / found[3].1[0] - 1.0).abs() < 1e-4);
}

#[test]
fn an_organ_slides_without_resistance() {
    // A block under a pressure on a slab that is 1e4 times as stiff, moved along by one of its sides.
    let (young, pressure) = (1.0, 0.05);
    let slab = block(
        [[-10.0, -10.0, -20.0], [50.0, 30.0, 0.0]],
        &Settings::of_side(10.0),
        &|_, _| false,
    );
    let upper = block(
        [[0.0, 0.0, 0.0], [16.0, 16.0, 16.0]],
        &Settings::of_side(8.0),
        &|_, _| false,
    );
    let mut system = System::new();
    let above = system.add(deformable(&upper, Law::NeoHookean, young, 0.4));
    let under = system.add(deformable(&slab, Law::NeoHookean, 1e4 * young, 0.3));
    let offset = system.bodies.offset(under);
    for n in slab.nodes_where(|x| x.z < -20.0 + 1e-9) {
        (0..3).for_each(|k| system.fixed[offset + 3 * n + k] = true);
    }
    let side = upper.nodes_where(|x| x.x < 1e-9);
    let middle = upper.nodes_where(|x| (x.y - 8.0).abs() < 1e-9);
    side.iter().for_each(|n| system.fixed[3 * n] = true);
    middle.iter().for_each(|n| system.fixed[3 * n + 1] = true);
    let forces = deformable(&upper, Law::NeoHookean, young, 0.4).traction(|at, normal| {
        if at.z > 16.0 - 1e-9 && normal.z > 0.5 {
            -Vector3::z() * pressure
        } else {
            Vector3::zeros()
        }
    });
    system.load(above, &forces);
    let contact = OrganContact::new(
        &system.bodies,
        [above, under],
        surface(below(0.0), 10.0),
        2.0,
        |_, n| n.z < -0.5,
    );
    system.organs.push(contact.unwrap());
    let (mut search, mut a) = (newton(&system, 1e-9), system.initial());
    let mut first = None;
    for moved in [0.0, 0.7, 3.0, 5.0, 9.7, 17.0, 24.0] {
        side.iter().for_each(|n| a[3 * n] = moved);
        system.organs[0].restart();
        let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let force = system.organs[0].force(&system.bodies, &a).force;
        println!(
            "{moved} mm: {:.3e}, {:.3e} of the weight, energy {:.9e}, {} rounds, {} steps",
            force.x / force.z,
            force.y / force.z,
            found.energy,
            found.rounds,
            found.iterations
        );
        assert!((force.z / (-256.0 * pressure) - 1.0).abs() < 1e-6);
        // What the slab sinks by under it is 5e-6 of its width: no steeper slope to slide on.
        assert!(force.xy().norm() < 5e-6 * force.z.abs(), "{force}");
        let first = *first.get_or_insert(found.energy);
        assert!((found.energy / first - 1.0).abs() < 1e-4, "{} {first}", found.energy);
    }
}

#[test]
fn two_balls_are_those_of_hertz() {
    let (radii, nu) = ([20.0, 30.0], 0.3);
    let touch = Vector3::zeros();
    let settings = Settings {
        levels: 4,
        ..Settings::of_side(10.0)
    };
    let fine = |reach: f64| {
        move |low: &Vector3<f64>, high: &Vector3<f64>| {
            let apart = (touch.sup(low).inf(high) - touch).norm();
            apart < reach || apart < high.x - low.x
        }
    };
    let upper = Ball {
        centre: Vector3::z() * radii[0],
        radius: radii[0],
    };
    let lower = Ball {
        centre: -Vector3::z() * radii[1],
        radius: radii[1],
    };
    let meshes = [
        Mesh::new(&upper, [touch, Vector3::new(20.0, 20.0, 20.0)], &settings, &fine(1.6)).unwrap(),
        Mesh::new(
            &lower,
            [Vector3::new(0.0, 0.0, -30.0), Vector3::new(30.0, 30.0, 0.0)],
            &settings,
            &fine(1.6),
        )
        .unwrap(),
    ];
    let mut system = System::new();
    for (mesh, middle) in meshes.iter().zip([20.0, -30.0]) {
        let body = system.add(deformable(mesh, Law::Linear, 1.0, nu));
        hold(&mut system, body, mesh, 2);
        let offset = system.bodies.offset(body);
        for n in mesh.nodes_where(|x| (x.z - middle).abs() < 1e-9) {
            system.fixed[offset + 3 * n + 2] = true;
        }
    }
    let contact = OrganContact::new(&system.bodies, [0, 1], surface(lower, 30.0), 40.0, |at, _| {
        at.norm() < 5.0
    });
    system.organs.push(contact.unwrap());
    let middle = meshes[0].nodes_where(|x| (x.z - 20.0).abs() < 1e-9);
    let (mut search, mut a) = (newton(&system, 1e-7), system.initial());
    let radius = radii[0] * radii[1] / (radii[0] + radii[1]);
    for depth in [0.08, 0.16] {
        middle.iter().for_each(|n| a[3 * n + 2] = -depth);
        system.organs[0].restart();
        let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let whole = -4.0 * system.organs[0].force(&system.bodies, &a).force.z;
        let contact = (1.5 * (1.0 - nu * nu) * radius * whole).cbrt();
        let far: f64 = radii
            .iter()
            .map(|r| approach_of_ball(*r, nu, 1.0, whole, contact))
            .sum();
        let expected = contact * contact / radius - far;
        let hertz = 2.0 / 3.0 / (1.0 - nu * nu) * radius.sqrt() * depth.powf(1.5);
        println!(
            "{} unknowns, {depth} mm, contact's radius {contact:.3} mm: force {whole:.6} N, that of Hertz {:+.2} %, approach for the force {:+.3} %; {} rounds, {} steps",
            a.len(),
            100.0 * (whole / hertz - 1.0),
            100.0 * (depth / expected - 1.0),
            found.rounds,
            found.iterations
        );
        // As for a ball between plates.
        assert!((depth / expected - 1.0).abs() < 0.005);
    }
}
