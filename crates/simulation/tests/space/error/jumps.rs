//! Jumps of tractions.

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::cells::Mesh;
use simulation::space::error::{Jumps, halved, taken_over};
use simulation::space::law::Material;

use super::{displacement, settings};
use crate::push::{EVERYWHERE, QUARTER, quarter};

fn material() -> Material {
    Material::new(Law::NeoHookean, 1.0, 0.3).unwrap()
}

fn field(mesh: &Mesh, of: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Vec<f64> {
    mesh.nodes.iter().flat_map(|x| <[f64; 3]>::from(of(x))).collect()
}

#[test]
fn constant_stress_has_none_and_a_kink_has_them_where_it_is() {
    let mesh = quarter(&settings(25.0, 1), &[30.0]);
    let linear = field(&mesh, |x| {
        Vector3::new(0.02 * x.y, 0.01 * x.z, -0.03 * x.x + 0.01 * x.z)
    });
    let none = Jumps::new(&mesh, &material(), &linear).unwrap();
    let kink = |x: &Vector3<f64>| Vector3::new(0.0, 0.0, -0.02 * (x.z - 50.0).max(0.0));
    let jumps = Jumps::new(&mesh, &material(), &field(&mesh, kink)).unwrap();
    // Strains of 2 % beside rounding, both squared.
    assert!(none.sum() < 1e-20 * jumps.sum(), "{} {}", none.sum(), jumps.sum());
    for (cell, energy) in &jumps.cubes {
        let [low, high] = mesh.grid().corners(cell);
        let at_it = low.z == 50.0 || high.z == 50.0;
        assert!(at_it == (*energy > 1e-6 * jumps.sum()), "{cell:?} {energy}");
    }
    // The jump of the traction is known: h / 24 / mu times the area times the square of about E' 0.02, less at large strains.
    let across = material().lame.confined() * 0.02;
    let exact = 25.0 / 24.0 / material().lame.mu * 2500.0 * across * across;
    assert!((jumps.sum() / exact - 1.0).abs() < 0.1, "{} {exact}", jumps.sum());
}

#[test]
fn the_worst_cubes_are_halved_and_no_others_but_for_balance() {
    let settings = settings(25.0, 1);
    let mesh = quarter(&settings, &[30.0]);
    let bump = |x: &Vector3<f64>| {
        Vector3::new(
            0.0,
            0.0,
            -(-(x - Vector3::new(0.0, 0.0, 100.0)).norm_squared() / 300.0).exp(),
        )
    };
    let a = field(&mesh, bump);
    let jumps = Jumps::new(&mesh, &material(), &a).unwrap();
    let worst = jumps.worst(0.8);
    assert!(
        !worst.is_empty() && worst.len() < mesh.cubes().len() / 3,
        "{}",
        worst.len()
    );
    assert!(jumps.worst(1.0).len() <= mesh.cubes().len() && jumps.worst(0.0).is_empty());
    let finer = halved(&mesh, &EVERYWHERE, QUARTER, &settings, Some(&worst)).unwrap();
    for cell in mesh.cubes() {
        let [low, high] = mesh.grid().corners(cell);
        let there = finer.grid().containing(&(low * 0.7 + high * 0.3)).unwrap();
        let part = finer.grid().length(there.span) / mesh.grid().length(cell.span);
        assert!(part == 0.5 || part == 1.0 && !worst.contains(cell), "{part}");
    }
    let far = finer
        .cubes()
        .iter()
        .filter(|c| finer.grid().length(c.span) == 25.0)
        .count();
    assert!(far > 0);
    // All halved: eight for one, and the state is the same function.
    let all = halved(&mesh, &EVERYWHERE, QUARTER, &settings, None).unwrap();
    assert_eq!(all.cubes().len(), 8 * mesh.cubes().len());
    let taken = taken_over(&mesh, &a, &all);
    for point in all.points() {
        let off = displacement(&all, &taken, &point.at) - displacement(&mesh, &a, &point.at);
        assert!(off.norm() < 1e-13, "{off}");
    }
}
