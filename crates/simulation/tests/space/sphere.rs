//! A thick ball under inner pressure, against Lame's closed form, for cubes that its surfaces cut anyhow.

use nalgebra::Vector3;
use simulation::control::{Newton, Potential, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Settings, Shell};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};
use simulation::space::system::System;
use simulation::sparse::Dissection;

pub(crate) const RADII: [f64; 2] = [20.0, 40.0];
const PRESSURE: f64 = 1e-3;

/// Displacement outwards at a distance from the centre, for Young's modulus 1.
pub(crate) fn lame(nu: f64, r: f64) -> f64 {
    let [a3, b3] = RADII.map(|r| r.powi(3));
    PRESSURE * a3 * r / (b3 - a3) * ((1.0 - 2.0 * nu) + (1.0 + nu) * b3 / (2.0 * r.powi(3)))
}

/// The largest error of a displacement on the surfaces beside the largest displacement, and the unknowns.
pub(crate) fn octant(settings: &Settings, nu: f64) -> (f64, usize) {
    let shell = Shell {
        centre: Vector3::zeros(),
        radii: RADII,
    };
    let corners = [Vector3::zeros(), Vector3::repeat(RADII[1])];
    let mesh = Mesh::new(&shell, corners, settings, &|_, _| false).unwrap();
    let unknowns = mesh.unknowns();
    let material = Material::new(Law::Linear, 1.0, nu).unwrap();
    let solid = Deformable::new(mesh, material, Vector3::zeros()).unwrap();
    let inner = |at: &Vector3<f64>| at.norm() < 0.5 * (RADII[0] + RADII[1]);
    // Inwards on the inner surface, which the normal points into; not on the three planes of symmetry.
    let flat = |at: &Vector3<f64>| at.iter().any(|x| x.abs() < 1e-9);
    let forces = solid.traction(|at, normal| {
        if inner(at) && !flat(at) {
            -normal * PRESSURE
        } else {
            Vector3::zeros()
        }
    });
    let held: Vec<usize> = (0..3)
        .flat_map(|k| {
            solid
                .mesh()
                .nodes_where(|x| x[k].abs() < 1e-9)
                .into_iter()
                .map(move |n| 3 * n + k)
        })
        .collect();
    let mut system = System::new();
    let body = system.add(solid);
    System::load(&mut system, body, &forces);
    held.iter().for_each(|i| system.fixed[*i] = true);
    let mut a = system.initial();
    let control = Control {
        provisional: true,
        ..Control::default()
    };
    Newton::ordered_by(control, Dissection::by_places(&system.places(), &[]).unwrap())
        .minimise(&system, &mut a)
        .unwrap();
    assert!(system.least_determinant(&a) > 0.9);
    (worst(system.bodies.solid(body), &a, nu), unknowns)
}

fn worst(solid: &dyn Solid, a: &[f64], nu: f64) -> f64 {
    let mut worst = 0.0_f64;
    for point in 0..solid.points() {
        let (at, _, _) = solid.reference(point);
        let exact = at * (lame(nu, at.norm()) / at.norm());
        worst = worst.max((solid.point(a, point) - at - exact).norm());
    }
    worst / lame(nu, RADII[0])
}

#[test]
fn the_worst_of_ten_grids_is_within_one_percent_at_eight_cubes_a_radius() {
    for (nu, count) in [(0.3, 10), (0.49, 10), (0.4999, 10)] {
        let mut worst = (0.0_f64, 0.0);
        for k in 0..count {
            // From 8 to 9 cubes a radius: the surfaces cut them in other places each time.
            let side = RADII[1] / (8.0 + (f64::from(k) + nu) / f64::from(count));
            let (error, _) = octant(&Settings::of_side(side), nu);
            worst = if error > worst.0 { (error, side) } else { worst };
        }
        println!(
            "nu {nu}: worst of {count} {:.4} % at a side of {:.3} mm",
            100.0 * worst.0,
            worst.1
        );
        // Quadratic elements of a twelfth of the gradient's length: (1/4)^3 of the largest displacement at most, as 4 cubes
        // make up the inner radius; what is asked for is less.
        assert!(worst.0 < 0.01, "{worst:?}");
    }
}

#[test]
#[ignore = "a table of two minutes: 30 grids for each least fill"]
fn error_by_least_fill() {
    for least_fill in [0.0, 0.02, 0.05, 0.1, 0.2] {
        let error = |k: u32| {
            let side = RADII[1] / (8.0 + f64::from(k) / 30.0);
            let settings = Settings {
                least_fill,
                ..Settings::of_side(side)
            };
            100.0 * octant(&settings, 0.3).0
        };
        let mut all: Vec<f64> = (0..30).map(error).collect();
        all.sort_by(f64::total_cmp);
        println!(
            "least fill {least_fill}: median {:.3} %, worst {:.3} %",
            all[15], all[29]
        );
    }
}

#[test]
fn every_grid_has_the_shells_volume() {
    // Of 30 grids one had lost 6e-5 of it when points were recombined, and with it the balance of a cube: 1.3 % of the
    // displacement there.
    for k in 0..30 {
        let side = RADII[1] / (8.0 + f64::from(k) / 30.0);
        let shell = Shell {
            centre: Vector3::zeros(),
            radii: RADII,
        };
        let corners = [Vector3::zeros(), Vector3::repeat(RADII[1])];
        let mesh = Mesh::new(&shell, corners, &Settings::of_side(side), &|_, _| false).unwrap();
        let exact = std::f64::consts::PI / 6.0 * (RADII[1].powi(3) - RADII[0].powi(3));
        let off = mesh.volume() / exact - 1.0;
        // The rules' own error at an eighth of the radius, order 7 from 1e-3 at four fifths of it.
        assert!(off.abs() < 1e-3 * (0.25_f64 / 0.8).powi(7), "{k}: {off:e}");
    }
}
