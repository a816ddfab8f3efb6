//! A thick ball under inner pressure, against Lame's closed form, for cubes that its surfaces cut anyhow.

use nalgebra::Vector3;
use simulation::control::{Newton, Potential, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Settings, Shell};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;

pub(crate) const RADII: [f64; 2] = [20.0, 40.0];
const PRESSURE: f64 = 1e-3;

/// Displacement outwards at a distance from the centre, for Young's modulus 1.
pub(crate) fn lame(nu: f64, r: f64) -> f64 {
    let [a3, b3] = RADII.map(|r| r.powi(3));
    PRESSURE * a3 * r / (b3 - a3) * ((1.0 - 2.0 * nu) + (1.0 + nu) * b3 / (2.0 * r.powi(3)))
}

/// The largest error of a displacement on the surfaces beside the largest displacement, and the unknowns.
pub(crate) fn octant(settings: &Settings, nu: f64) -> (f64, usize) {
    let shell = Shell { centre: Vector3::zeros(), radii: RADII };
    let corners = [Vector3::zeros(), Vector3::repeat(RADII[1])];
    let mesh = Mesh::new(&shell, corners, settings, &|_, _| false).unwrap();
    let unknowns = mesh.unknowns();
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
    let inner = |at: &Vector3<f64>| at.norm() < 0.5 * (RADII[0] + RADII[1]);
    // Inwards on the inner surface, which the normal points into; not on the three planes of symmetry.
    let flat = |at: &Vector3<f64>| at.iter().any(|x| x.abs() < 1e-9);
    let forces = solid.traction(|at, normal| {
        if inner(at) && !flat(at) { -normal * PRESSURE } else { Vector3::zeros() }
    });
    let held: Vec<usize> = (0..3)
        .flat_map(|k| solid.mesh().nodes_where(|x| x[k].abs() < 1e-9).into_iter().map(move |n| 3 * n + k))
        .collect();
    let mut system = System::new();
    let body = system.add(solid);
    System::load(&mut system, body, &forces);
    held.iter().for_each(|i| system.fixed[*i] = true);
    let mut a = system.initial();
    let control = Control { provisional: true, ..Control::default() };
    Newton::new(control).minimise(&system, &mut a).unwrap();
    assert!(system.least_determinant(&a) > 0.9);
    (worst(system.bodies.solid(body), &a, nu), unknowns)
}

fn worst(solid: &dyn Solid, a: &[f64], nu: f64) -> f64 {
    let mut worst = 0.0_f64;
    let mut all = Vec::new();
    for point in 0..solid.points() {
        let (at, _, _) = solid.reference(point);
        let exact = at.normalize() * lame(nu, at.norm());
        let e = (solid.point(a, point) - at - exact).norm();
        all.push((e, at, (solid.point(a, point) - at).dot(&at.normalize()) / exact.norm()));
        worst = worst.max(e);
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    for k in [0usize; 0] { if k < all.len() { println!("{} {:.3e} at {:?} r {} ratio {}", k, all[k].0 / lame(nu, RADII[0]), all[k].1.as_slice(), all[k].1.norm(), all[k].2); } }
    worst / lame(nu, RADII[0])
}

#[test]
fn the_worst_of_many_grids_is_near_the_closed_form() {
    for nu in [0.3] {
        for cells in [4.0, 8.0] {
            let mut worst = (0.0_f64, 0.0);
            let count = 1;
            for k in 0..count {
                // From some 8 to 9 cubes a radius: the surfaces cut them in other places each time.
                let side = RADII[1] / (cells + f64::from(k) / f64::from(count));
                let (error, unknowns) = octant(&Settings::of_side(side), nu);
                println!("nu {nu} side {side:.3}: {:.4} % with {unknowns} unknowns", 100.0 * error);
                worst = if error > worst.0 { (error, side) } else { worst };
            }
            println!("nu {nu}, {cells} cells a radius: worst {:.4} % at a side of {:.3}", 100.0 * worst.0, worst.1);
        }
    }
}

#[test]
fn explore() {
    use simulation::space::element::Dilatation;
    for (name, s) in [
        ("as is", Settings::of_side(1.0)),
        ("plain", Settings { dilatation: Dilatation::Plain, ..Settings::of_side(1.0) }),
        ("constant", Settings { dilatation: Dilatation::Constant, ..Settings::of_side(1.0) }),
        ("no ties", Settings { least_fill: 0.0, ..Settings::of_side(1.0) }),
        ("no ties plain", Settings { least_fill: 0.0, dilatation: Dilatation::Plain, ..Settings::of_side(1.0) }),
        ("least fill 0.1", Settings { least_fill: 0.1, ..Settings::of_side(1.0) }),
        ("least fill 0.05", Settings { least_fill: 0.05, ..Settings::of_side(1.0) }),
        ("fast", Settings::of_side(1.0).fast()),
    ] {
        for cells in [4.1, 5.9, 8.2] {
            let side = RADII[1] / cells;
            let (error, unknowns) = octant(&Settings { side, ..s }, 0.3);
            println!("{name}: {cells} cells: {:.4} % {unknowns}", 100.0 * error);
        }
    }
}

#[test]
fn explore_worst() {
    for nu in [0.3, 0.4999] {
        for least_fill in [0.0, 0.02, 0.05, 0.1, 0.2] {
            let mut all = Vec::new();
            for k in 0..30 {
                let side = RADII[1] / (8.0 + f64::from(k) / 30.0);
                all.push(octant(&Settings { side, least_fill, ..Settings::of_side(1.0) }, nu).0 * 100.0);
            }
            all.sort_by(f64::total_cmp);
            println!("nu {nu} fill {least_fill}: median {:.3} worst {:.3} {:.3} {:.3}", all[15], all[27], all[28], all[29]);
        }
    }
}
