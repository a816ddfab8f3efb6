//! Stated errors against true ones.

mod ball;
mod block;
mod jumps;
mod kept;
mod table;

use nalgebra::Vector3;
use simulation::control::{Newton, Settings as Control};
use simulation::space::cells::{Field, Mesh, Settings};
use simulation::space::error::{Stated, corrected, halved, taken_over};
use simulation::space::system::System;
use simulation::sparse::Dissection;

fn settings(side: f64, levels: u32) -> Settings {
    Settings {
        levels,
        ..Settings::of_side(side)
    }
}

/// The equilibrium of a system without contact.
fn found(system: &System, mut a: Vec<f64>) -> Vec<f64> {
    let control = Control {
        provisional: true,
        tolerance: 1e-9,
        ..Control::default()
    };
    Newton::ordered_by(control, Dissection::by_places(&system.places(), &[]).unwrap())
        .minimise(system, &mut a)
        .unwrap();
    a
}

/// The largest of some errors within a reach of a place, and of the others.
fn largest(mesh: &Mesh, tip: &Vector3<f64>, reach: f64, error: impl Fn(&Vector3<f64>) -> f64) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    let surface = mesh.surface.iter().map(|p| p.at);
    for at in mesh.points().iter().map(|p| p.at).chain(surface) {
        let which = &mut largest[usize::from((at - tip).norm() > reach)];
        *which = which.max(error(&at));
    }
    largest
}

/// The displacement of a place by a mesh's unknowns.
fn displacement(mesh: &Mesh, a: &[f64], at: &Vector3<f64>) -> Vector3<f64> {
    let row = mesh.row(at).unwrap();
    row.iter()
        .map(|(n, w)| Vector3::from_column_slice(&a[3 * *n as usize..3 * *n as usize + 3]) * *w)
        .sum()
}

/// Stated by true errors of a body without contact, near a place and elsewhere, with the unknowns of both meshes.
fn ratios(
    (field, corners, settings): (&dyn Field, [Vector3<f64>; 2], &Settings),
    mesh: &Mesh,
    make: impl Fn(&Mesh) -> System,
    exact: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    (tip, reach): (Vector3<f64>, f64),
) -> ([f64; 2], [usize; 2]) {
    let coarse = make(mesh);
    let a = found(&coarse, coarse.initial());
    let finer = halved(mesh, field, corners, settings, None).unwrap();
    let next = corrected(&make(&finer), &taken_over(mesh, &a, &finer), None).unwrap();
    let none = Vector3::zeros();
    let stated = Stated::new((mesh, &a, none), (&finer, &next.a, none), &tip, reach);
    let truth = largest(&finer, &tip, reach, |at| {
        (displacement(mesh, &a, at) - exact(at)).norm()
    });
    let stated = [stated.near, stated.elsewhere];
    ([0, 1].map(|k| stated[k] / truth[k]), [a.len(), next.a.len()])
}
