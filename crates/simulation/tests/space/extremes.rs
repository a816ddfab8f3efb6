//! Scenes at the ends of what may be asked: the right answer, or a refusal by name.

use nalgebra::{Matrix3, Point3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh, Plane, Settings};
use simulation::space::equilibrium::{NoEquilibrium, Tolerance, settle};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;

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

/// Steps, and the largest error of a surface point by the largest displacement, of a ball that pokes through faces
/// of its cubes by the part `by` of its radius. It is pulled at its surface as a constant gradient asks for.
fn poking(by: f64, nu: f64) -> (usize, f64) {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 10.0 * (1.0 + by),
    };
    let corners = [-15.0, 15.0].map(Vector3::repeat);
    let mesh = Mesh::new(&ball, corners, &Settings::of_side(5.0), &|_, _| false).unwrap();
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
    let off = (0..solid.points()).map(|k| {
        let at = solid.reference(k).0;
        (solid.point(&a, k) - at - g * at).norm()
    });
    (found.iterations, off.fold(0.0, f64::max))
}

#[test]
fn cubes_that_are_hardly_filled() {
    for nu in [0.3, 0.4999] {
        // Caps in 24 cubes, filled by 6e-4, 6e-6, 2.5e-7 and 6e-10 of them.
        let each = [1e-2, 1e-3, 2e-4, 1e-5].map(|by| poking(by, nu));
        println!("nu {nu}: {each:?}");
        // What integrals over quarters of the ball are off by, whatever pokes out.
        let most = each.iter().map(|e| e.1).fold(0.0, f64::max);
        assert!(most < 2e-3 && most < 1.5 * each[3].1, "{each:?}");
        assert!(each.iter().all(|e| e.0 <= 2), "{each:?}");
    }
}

#[test]
fn beds_from_softest_to_stiffest() {
    // Without sideways strain: what is pulled moves by `t / k + t H / E`.
    for law in [Law::Linear, Law::NeoHookean] {
        for k in [1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9].map(|k| k / 20.0) {
            let (mut system, mesh) = boxed([10.0, 10.0, 20.0], 5.0, law, 0.0);
            let bed = |_: &Vector3<f64>, normal: &Vector3<f64>| if normal.z < -0.5 { k } else { 0.0 };
            let bed = Springs::new(&system.bodies, 0, bed, |x| *x);
            system.others.push(Box::new(bed));
            let t = 1e-6_f64.min(1e-3 * k);
            let material = Material::new(law, 1.0, 0.0).unwrap();
            let solid = Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap();
            let load = solid.traction(|_, normal| if normal.z > 0.5 { normal * t } else { Vector3::zeros() });
            system.load(0, &load);
            let mut a = system.initial();
            let found = balance(&system, &mut a, 1e-8).unwrap();
            let exact = t / k + t * 20.0;
            let top = mesh.nodes_where(|x| x.z > 20.0 - 1e-9);
            let worst = top
                .iter()
                .map(|n| (a[3 * n + 2] / exact - 1.0).abs())
                .fold(0.0, f64::max);
            // The law bends by half of the strain, 1e-6 at most; residuals are 1e-8 of the load.
            assert!(
                worst < 1e-6 && found.iterations <= 3,
                "{law:?} {k:e}: {worst:e} {found:?}"
            );
        }
    }
}

/// Forces on tubes in two blocks beside one another in one system, one of Young's modulus 1; the other one, if any, of another.
fn pushed(mesh: &Mesh, other: Option<f64>) -> Vec<f64> {
    let mut system = System::new();
    for young in [Some(1.0), other].into_iter().flatten() {
        let body = add(&mut system, mesh, Law::NeoHookean, young, 0.45);
        for n in mesh.nodes_where(|x| x.z < 1e-9) {
            let at = system.bodies.offset(body) + 3 * n;
            system.fixed[at..at + 3].fill(true);
        }
        let tube = Tube::straight(Point3::new(10.0, 10.0, 23.0), Vector3::z(), 100.0, 5.0).unwrap();
        let contact = TubeContact::new(&system.bodies, body, tube, 12.0 * young, |_, n| n.z > 0.5).unwrap();
        system.tubes.push(contact);
    }
    let (mut a, mut newton) = (system.initial(), newton(&system, 1e-8));
    settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    let each = system.tubes.iter().map(|t| t.force(&system.bodies, &a).force.z);
    each.collect()
}

#[test]
fn a_soft_body_beside_one_a_million_times_as_stiff() {
    let (_, mesh) = boxed([20.0; 3], 5.0, Law::NeoHookean, 0.45);
    let alone = pushed(&mesh, None)[0];
    for stiff in [1.0, 1e3, 1e6] {
        let both = pushed(&mesh, Some(stiff));
        let off = [both[0] / alone - 1.0, both[1] / stiff / alone - 1.0].map(f64::abs);
        println!("{stiff:e}: forces differ by {off:?}");
        // Forces count as balanced at 1e-8 of the stiff body's: what is within the tolerance of contact must be left.
        assert!(off.iter().all(|o| *o < 1e-6), "{stiff:e} {off:?}");
    }
}

/// Force on a tube along y whose axis is at `(x, z)` beside a block's edge at `x = z = 20`.
fn grazing([x, z]: [f64; 2]) -> Vector3<f64> {
    let (mut system, mesh) = boxed([20.0, 10.0, 20.0], 5.0, Law::NeoHookean, 0.45);
    for n in mesh.nodes_where(|x| x.z < 1e-9) {
        system.fixed[3 * n..3 * n + 3].fill(true);
    }
    let tube = Tube::straight(Point3::new(x, -50.0, z), Vector3::y(), 100.0, 4.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 12.0, |_, _| true).unwrap();
    system.tubes.push(contact);
    let (mut a, mut newton) = (system.initial(), newton(&system, 1e-8));
    settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
    system.tubes[0].force(&system.bodies, &a).force
}

#[test]
fn a_tube_at_an_edge() {
    // Of the tube and the edge, by which they are apart along x and z alike.
    let touching = 20.0 + 4.0 / 2.0_f64.sqrt();
    for apart in [1.0, 1e-6, 1e-12, 0.0] {
        assert_eq!(grazing([touching + apart; 2]), Vector3::zeros(), "{apart:e}");
    }
    // The last points are 0.07 of a side, 0.35 mm, from the edge: what dips in less is not seen.
    let forces = [0.1, 0.5, 1.0, 1.5].map(|deep| grazing([touching - deep; 2]));
    println!("{forces:.4?}");
    assert_eq!(forces[0], Vector3::zeros());
    for pair in forces.windows(2) {
        assert!(
            pair[1].x > pair[0].x && pair[1].norm() > 1.2 * pair[0].norm(),
            "{pair:?}"
        );
    }
    // Along the edge nothing pulls; of forces some 1e-9 of one.
    assert!(forces.iter().all(|f| f.y.abs() < 1e-9), "{forces:?}");
}

#[test]
fn a_tube_pushes_a_thin_plate_along() {
    // 4 mm thick, held all around; the tube's radius is 3.
    // It is stretched to more than twice its length: points of cubes of 4 mm are 1.53 mm from the middle between them then, more than half
    // the radius.
    let settings = Settings {
        levels: 1,
        ..Settings::of_side(4.0)
    };
    let fine = |low: &Vector3<f64>, high: &Vector3<f64>| (0.5 * (low + high)).xy().add_scalar(-16.0).amax() < 4.0;
    let corners = [Vector3::zeros(), Vector3::new(32.0, 32.0, 4.0)];
    let mesh = Mesh::new(&everywhere(1e3), corners, &settings, &fine).unwrap();
    let mut system = System::new();
    add(&mut system, &mesh, Law::NeoHookean, 1.0, 0.45);
    for n in mesh.nodes_where(|x| x.xy().min() < 1e-9 || x.xy().max() > 32.0 - 1e-9) {
        system.fixed[3 * n..3 * n + 3].fill(true);
    }
    let tube = |depth: f64| Tube::straight(Point3::new(16.0, 16.0, 7.0 - depth), Vector3::z(), 100.0, 3.0).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube(0.0), 15.0, |_, _| true).unwrap();
    system.tubes.push(contact);
    let (mut a, mut newton, mut last) = (system.initial(), newton(&system, 1e-8), 0.0);
    for depth in (1..=12).map(f64::from) {
        system.tubes[0].move_to(tube(depth));
        settle(&mut system, &mut newton, &mut a, &Tolerance::default()).unwrap();
        let force = system.tubes[0].force(&system.bodies, &a).force;
        assert!(force.z > last && force.xy().norm() < 1e-6 * force.z, "{depth}: {force}");
        last = force.z;
        // Three times its thickness deep the plate is still before the tip.
        let solid = system.bodies.solid(0);
        let middle = (0..solid.points()).filter(|k| (solid.reference(*k).0.xy().add_scalar(-16.0)).norm() < 0.5);
        let above = middle.map(|k| solid.point(&a, k).z).fold(f64::NEG_INFINITY, f64::max);
        assert!(above < 4.3 - depth, "{depth}: {above}");
    }
    // From rest as deep at once it might be anywhere.
    let mut a = system.initial();
    system.tubes[0].move_to(tube(3.0));
    let refused = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
    assert!(matches!(refused, Err(NoEquilibrium::TooDeep { .. })), "{refused:?}");
}
