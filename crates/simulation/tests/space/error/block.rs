//! The pushed block: what is quick to test of its stated errors, and halving by jumps.

#![allow(clippy::print_stdout, reason = "the table is what one of these tests is for")]

use nalgebra::Vector3;
use simulation::law::Law;
use simulation::space::error::{Jumps, Stated, Touching, corrected};
use simulation::space::law::Material;

use super::table::{MESHES, REACH, TIP, next, next_of, pushed};
use super::{displacement, largest, settings};
use crate::push::{MOVED, quarter};

/// Cubes halved by jumps beside all of them.
#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn halved_by_jumps() {
    let (_, side, fine) = MESHES[2];
    let (block, _) = pushed(quarter(&settings(side.0, side.1), fine), 0.3, 10.0, 20.0);
    let (mesh, best) = next(&block, side, 0.3, 10.0);
    let (_, side, fine) = MESHES[0];
    let (block, force) = pushed(quarter(&settings(side.0, side.1), fine), 0.3, 10.0, 20.0);
    let jumps = Jumps::new(
        &block.mesh,
        &Material::new(Law::NeoHookean, 5e-3, 0.3).unwrap(),
        &block.a,
    )
    .unwrap();
    println!(
        "before: {} unknowns, force {force:.4} beside {:.4}",
        block.a.len(),
        4.0 * best.force.z
    );
    for part in [0.3, 0.5, 0.8, 0.95, 2.0] {
        let worst = jumps.worst(part);
        let (finer, found) = next_of(&block, side, [0.3, 10.0], Some(&worst));
        let off = |at: &Vector3<f64>| (displacement(&finer, &found.a, at) - displacement(&mesh, &best.a, at)).norm();
        println!(
            "{part}: {} of {} cubes, {} unknowns, force off by {:.4}, places by {:.3?}",
            worst.len(),
            block.mesh.cubes().len(),
            found.a.len(),
            4.0 * (found.force.z - best.force.z),
            largest(&finer, &TIP, REACH, off)
        );
    }
}

#[test]
fn stated_errors_of_a_pushed_block_are_no_less_than_true_ones() {
    let (_, side, fine) = MESHES[0];
    let (block, coarse) = pushed(quarter(&settings(side.0, side.1), fine), 0.49, 10.0, 20.0);
    let (mesh, found) = next(&block, side, 0.49, 10.0);
    let [old, new] = [0.25 * coarse, found.force.z].map(|force| Vector3::z() * force);
    let stated = Stated::new((&block.mesh, &block.a, old), (&mesh, &found.a, new), &TIP, REACH);
    let mut ratios = [
        4.0 * stated.force / (coarse - 1.636).abs(),
        f64::INFINITY,
        f64::INFINITY,
    ];
    for (at, moved) in MOVED.map(|(at, moved)| (Vector3::from(at), Vector3::from(moved))) {
        let (which, stated) = if (at - TIP).norm() > REACH {
            (2, stated.elsewhere)
        } else {
            (1, stated.near)
        };
        ratios[which] = ratios[which].min(stated / (displacement(&block.mesh, &block.a, &at) - moved).norm());
    }
    println!("stated by true errors of force, places near and elsewhere: {ratios:.2?}");
    // Places are a few of those that count: the worst of all is further off than the worst of them.
    assert!(ratios.iter().all(|r| (1.0..5.0).contains(r)), "{ratios:?}");
}

#[test]
fn an_equilibrium_stays_where_it_is() {
    let (_, side, fine) = MESHES[0];
    let (mut block, coarse) = pushed(quarter(&settings(side.0, side.1), fine), 0.49, 10.0, 8.0);
    let tube = block.system.tubes.remove(0).tube().clone();
    let wanted = |_: &Vector3<f64>, normal: &Vector3<f64>| normal.z > 0.5;
    let touching = Touching {
        body: block.body,
        tube: &tube,
        wanted: &wanted,
    };
    let found = corrected(&block.system, &block.a, Some(&touching)).unwrap();
    // The force within the tolerance of pressures, 1e-3 of it; places within 1e-4 of the radius of contact's depth.
    assert!(
        (4.0 * found.force.z / coarse - 1.0).abs() < 2e-3,
        "{} {coarse}",
        4.0 * found.force.z
    );
    let moved = found
        .a
        .iter()
        .zip(&block.a)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(moved < 5e-3, "{moved}");
    // And one from which contact was taken away is none.
    let free = corrected(&block.system, &block.a, None).unwrap();
    assert!(free.force == Vector3::zeros() && free.a.iter().zip(&block.a).any(|(a, b)| (a - b).abs() > 0.5));
}
