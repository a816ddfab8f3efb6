//! Scenes at the ends of what may be asked: the right answer, or a refusal by name.

use nalgebra::{Matrix3, Point3, Vector3};
use simulation::control::Failed;
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Plane, Settings};
use simulation::space::equilibrium::{NoEquilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::{Tube, TubeError};

use crate::common::{balance, everywhere, newton};

/// A body that is a box of whole cubes, of Young's modulus 1.
fn boxed(size: [f64; 3], side: f64, law: Law, nu: f64) -> (System, Mesh) {
    let corners = [Vector3::zeros(), Vector3::from(size)];
    let mesh = Mesh::new(&everywhere(1e3), corners, &Settings::of_side(side), &|_, _| false).unwrap();
    let mut system = System::new();
    add(&mut system, &mesh, law, 1.0, nu);
    (system, mesh)
}

fn add(system: &mut System, mesh: &Mesh, law: Law, young: f64, nu: f64) -> usize {
    let material = Material::new(law, young, nu).unwrap();
    system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap())
}

#[test]
fn a_face_of_cubes_that_the_surface_runs_along_counts_once() {
    for by in [1e-2, 1e-6, 1e-9, 1e-10, 1e-12, 1e-15, 0.0, -1e-15, -1e-12, -1e-9, -1e-6] {
        let plane = Plane {
            point: Vector3::new(0.0, 0.0, 15.0 + 5.0 * by),
            normal: Vector3::z(),
        };
        let corners = [Vector3::zeros(), Vector3::repeat(20.0)];
        let mesh = Mesh::new(&plane, corners, &Settings::of_side(5.0), &|_, _| false).unwrap();
        let area: f64 = mesh.surface.iter().filter(|p| p.normal.z > 0.5).map(|p| p.area).sum();
        assert!((area / 400.0 - 1.0).abs() < 1e-12, "{by:e}: {area}");
    }
}

/// Steps, the largest error of a surface point and the least part of a cube that is filled, of a ball that pokes through faces
/// of its cubes by the part `by` of its radius. It is pulled at its surface as a constant gradient asks for.
fn poking(by: f64, least_fill: f64, nu: f64) -> (usize, f64, f64) {
    let settings = Settings {
        least_fill,
        ..Settings::of_side(5.0)
    };
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 10.0 * (1.0 + by),
    };
    let corners = [-15.0, 15.0].map(Vector3::repeat);
    let mesh = Mesh::new(&ball, corners, &settings, &|_, _| false).unwrap();
    // Of no trace: where volumes hardly change a pressure would outgrow the shear modulus.
    let g = Matrix3::new(0.02, -0.05, 0.02, 0.03, -0.08, 0.06, -0.04, 0.07, 0.06);
    let mut system = System::new();
    let body = add(&mut system, &mesh, Law::Linear, 1.0, nu);
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let stress = Matrix3::from_column_slice(material.response(&g).unwrap().stress.as_slice());
    let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
    system.load(body, &solid.traction(|_, normal| stress * normal));
    // Springs at rest in the exact state take rigid motions away.
    let springs = Springs::new(&system.bodies, body, |_, _| 0.1, |x| x + g * x);
    system.others.push(Box::new(springs));
    let mut a = system.initial();
    let found = balance(&system, &mut a, 1e-8).unwrap();
    let off = (0..solid.points()).map(|k| (solid.point(&a, k) - solid.reference(k).0 - g * solid.reference(k).0).norm());
    let volumes = mesh.elements.iter().map(|e| mesh.table(e).volume() / 125.0);
    (found.iterations, off.fold(0.0, f64::max), volumes.fold(1.0, f64::min))
}

#[test]
fn cubes_that_are_hardly_filled() {
    for nu in [0.3, 0.4999] {
        for by in [1e-2, 1e-3, 2e-4, 1e-5, 1e-7] {
            for fill in [0.02] {
                let (steps, off, least) = poking(by, fill, nu);
                println!("nu {nu}, {by:e}, fill {fill}: {steps} steps, off by {off:.1e}, least {least:.1e}");
            }
        }
    }
}

#[test]
fn beds_from_softest_to_stiffest() {
    // Without sideways strain: what is pressed moves by `t / k + t H / E`.
    for law in [Law::Linear, Law::NeoHookean] {
        for k in [1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9] {
            let (mut system, mesh) = boxed([10.0, 10.0, 20.0], 5.0, law.clone(), 0.0);
            let k = k / 20.0;
            let bed = Springs::new(&system.bodies, 0, |_, normal| if normal.z < -0.5 { k } else { 0.0 }, |x| *x);
            system.others.push(Box::new(bed.clone()));
            let t = 1e-6_f64.min(1e-3 * k);
            let solid = Deformable::new(mesh.clone(), Material::new(law.clone(), 1.0, 0.0).unwrap(), Vector3::zeros()).unwrap();
            let load = solid.traction(|_, normal| if normal.z > 0.5 { Vector3::z() * t } else { Vector3::zeros() });
            system.load(0, &load);
            let mut a = system.initial();
            let found = balance(&system, &mut a, 1e-8);
            let exact = t / k + t * 20.0;
            let top = mesh.nodes_where(|x| x.z > 20.0 - 1e-9);
            let worst = top.iter().map(|n| (a[3 * n + 2] / exact - 1.0).abs()).fold(0.0, f64::max);
            println!("{law:?} bed {k:e}: {:?}, {worst:.1e}", found.map(|f| (f.iterations, f.residual, f.load)));
        }
    }
}

#[test]
fn a_soft_body_beside_one_a_million_times_as_stiff() {
    let (alone, mesh) = boxed([20.0; 3], 5.0, Law::NeoHookean, 0.45);
    let with = |stiff: f64| {
        let mut system = System::new();
        add(&mut system, &mesh, Law::NeoHookean, 1.0, 0.45);
        if stiff > 0.0 {
            add(&mut system, &mesh, Law::NeoHookean, stiff, 0.45);
        }
        for (body, e) in [(0, 1.0), (1, stiff)].into_iter().take(system.bodies.len()) {
            for n in mesh.nodes_where(|x| x.z < 1e-9) {
                let at = system.bodies.offset(body) + 3 * n;
                system.fixed[at..at + 3].fill(true);
            }
            let tube = Tube::straight(Point3::new(10.0, 10.0, 23.0), Vector3::z(), 100.0, 5.0).unwrap();
            let contact = TubeContact::new(&system.bodies, body, tube, 12.0 * e, |_, n| n.z > 0.5).unwrap();
            system.tubes.push(contact);
        }
        let mut a = system.initial();
        let mut newton = newton(&system, 1e-8);
        let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
        println!("{stiff}: {found:?}");
        let forces: Vec<f64> = system.tubes.iter().map(|t| t.force(&system.bodies, &a).force.z).collect();
        println!("{forces:?}");
        forces
    };
    drop(alone);
    let one = with(0.0);
    for stiff in [1.0, 1e3, 1e6] {
        let both = with(stiff);
        println!("{stiff:e}: {:e} {:e}", both[0] / one[0] - 1.0, both[1] / stiff / one[0] - 1.0);
    }
}

/// Force on a tube along y whose axis is at `(x, z)` beside a block's edge at `x = z = 20`, and steps.
fn grazing([x, z]: [f64; 2]) -> Result<(Vector3<f64>, usize), NoEquilibrium> {
    let (mut system, mesh) = boxed([20.0, 10.0, 20.0], 5.0, Law::NeoHookean, 0.45);
    for n in mesh.nodes_where(|x| x.z < 1e-9) {
        system.fixed[3 * n..3 * n + 3].fill(true);
    }
    let tube = Tube::straight(Point3::new(x, -50.0, z), Vector3::y(), 100.0, 4.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 12.0, |_, _| true).unwrap();
    system.tubes.push(contact);
    let mut a = system.initial();
    let mut newton = newton(&system, 1e-8);
    let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default())?;
    println!("{found:?}");
    Ok((system.tubes[0].force(&system.bodies, &a).force, found.iterations))
}

#[test]
fn a_tube_at_an_edge() {
    let diagonal = 4.0 / 2.0_f64.sqrt();
    for by in [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 0.0, -1e-3, -0.1, -0.5, -1.0, -1.5] {
        println!("{by:e}: {:?}", grazing([20.0 + diagonal + by; 2]));
    }
    println!("beside {:?}", grazing([23.9, 22.0]));
    println!("beside {:?}", grazing([23.9, 10.0]));
}

#[test]
fn a_tube_through_a_thin_plate() {
    // 4 mm thick, held all around; the tube's radius is 3.
    let (mut system, mesh) = boxed([32.0, 32.0, 4.0], 4.0, Law::NeoHookean, 0.45);
    for n in mesh.nodes_where(|x| x.x < 1e-9 || x.y < 1e-9 || x.x > 32.0 - 1e-9 || x.y > 32.0 - 1e-9) {
        system.fixed[3 * n..3 * n + 3].fill(true);
    }
    let tube = |depth: f64| Tube::straight(Point3::new(16.0, 16.0, 7.0 - depth), Vector3::z(), 100.0, 3.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube(0.0), 15.0, |_, _| true).unwrap();
    system.tubes.push(contact);
    let mut a = system.initial();
    let mut newton = newton(&system, 1e-8);
    for step in 1..=14 {
        let depth = f64::from(step);
        system.tubes[0].move_to(tube(depth));
        let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
        let force = system.tubes[0].force(&system.bodies, &a);
        println!("{depth}: {force:?} {found:?}");
        if found.is_err() {
            break;
        }
    }
}
