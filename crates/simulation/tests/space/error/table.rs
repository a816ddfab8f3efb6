//! The table of docs/solids-3d.md: stated by true errors.

#![allow(clippy::print_stdout, reason = "the table is what these tests are for")]

use std::collections::BTreeSet;

use nalgebra::Vector3;
use simulation::space::cells::{Cell, Mesh};
use simulation::space::error::{Correction, SAFETY, Stated, Touching, corrected, halved, taken_over};

use super::ball::{manufactured, thick_ball};
use super::{displacement, largest, settings};
use crate::now;
use crate::push::{EVERYWHERE, MOVED, Pushed, QUARTER, quarter};

pub(super) const TIP: Vector3<f64> = Vector3::new(0.0, 0.0, 100.0);
pub(super) const REACH: f64 = 20.0;

/// A block with a tube of this radius at this depth.
pub(super) fn pushed(mesh: Mesh, nu: f64, radius: f64, depth: f64) -> (Pushed, f64) {
    let mut block = Pushed::of(mesh, nu, radius);
    let steps = (depth / (0.25 * radius)).ceil();
    let mut force = 0.0;
    for k in 1..=steps as u32 {
        force = block.to(depth * f64::from(k) / steps).unwrap().1;
    }
    (block, force)
}

/// The state on cubes half as large, with the force on a quarter of the tube.
pub(super) fn next(block: &Pushed, levels: (f64, u32), nu: f64, radius: f64) -> (Mesh, Correction) {
    next_of(block, levels, [nu, radius], None)
}

/// The same with some cubes halved.
pub(super) fn next_of(
    block: &Pushed,
    levels: (f64, u32),
    [nu, radius]: [f64; 2],
    which: Option<&BTreeSet<Cell>>,
) -> (Mesh, Correction) {
    let mesh = halved(&block.mesh, &EVERYWHERE, QUARTER, &settings(levels.0, levels.1), which).unwrap();
    let mut finer = Pushed::of(mesh, nu, radius);
    finer.system.tubes.clear();
    let touching = Touching {
        body: finer.body,
        tube: block.system.tubes[0].tube(),
        wanted: &|_, normal| normal.z > 0.5,
    };
    let a = taken_over(&block.mesh, &block.a, &finer.mesh);
    let found = corrected(&finer.system, &a, Some(&touching)).unwrap();
    (finer.mesh, found)
}

struct Case {
    name: &'static str,
    side: (f64, u32),
    fine: &'static [f64],
    nu: f64,
    tube: [f64; 2],
}

/// What a state has beside a truth of places and force: prints stated, true and their ratio.
fn row(case: &Case, truth: &dyn Fn(&Vector3<f64>) -> Option<Vector3<f64>>, force: f64) {
    let (block, coarse) = pushed(
        quarter(&settings(case.side.0, case.side.1), case.fine),
        case.nu,
        case.tube[0],
        case.tube[1],
    );
    let start = now();
    let (mesh, found) = next(&block, case.side, case.nu, case.tube[0]);
    // The part of a quarter that the other quarters hold in balance is none of the tube's.
    let [old, new] = [0.25 * coarse, found.force.z].map(|force| Vector3::z() * force);
    let stated = Stated::new((&block.mesh, &block.a, old), (&mesh, &found.a, new), &TIP, REACH);
    let seconds = now() - start;
    let off =
        |at: &Vector3<f64>| truth(at).map_or(0.0, |exact| (displacement(&block.mesh, &block.a, at) - exact).norm());
    let moved =
        |at: &Vector3<f64>| (displacement(&block.mesh, &block.a, at) - displacement(&mesh, &found.a, at)).norm();
    // At the second code's places, and at all.
    let (mut exact, mut here) = (largest(&mesh, &TIP, REACH, off), [0.0_f64; 2]);
    for at in MOVED.map(|(at, _)| Vector3::from(at)) {
        let which = usize::from((at - TIP).norm() > REACH);
        exact[which] = exact[which].max(off(&at));
        here[which] = here[which].max(SAFETY * moved(&at));
    }
    let all = [
        [4.0 * stated.force, (coarse - force).abs()],
        [stated.near, exact[0]],
        [stated.elsewhere, exact[1]],
    ];
    println!(
        "{}, nu {}, tube {:?}, {} -> {} unknowns: [force, near, elsewhere] stated, true {all:.4?}, ratios {:.2?}; stated at the second code's places {here:.4?}; left {:.3}, {} factors, {seconds:.1} s",
        case.name,
        case.nu,
        case.tube,
        block.a.len(),
        found.a.len(),
        all.map(|[stated, exact]| stated / exact),
        found.left,
        found.factors,
    );
}

#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn known_states() {
    for (nu, radii) in [
        (0.3, [20.0, 40.0]),
        (0.49, [20.0, 40.0]),
        (0.4999, [20.0, 40.0]),
        (0.45, [12.0, 40.0]),
    ] {
        for cubes in [3.3, 4.2, 5.5] {
            println!(
                "ball {radii:?} nu {nu}, {cubes} cubes: {:.2?}",
                thick_ball(cubes, nu, radii)
            );
        }
    }
    for (nu, shift) in [(0.3, 0.0), (0.499, 0.0), (0.45, 1.0)] {
        for cubes in [3.0, 4.0] {
            println!(
                "manufactured nu {nu} shift {shift}, {cubes}: {:.2?}",
                manufactured(cubes, nu, shift)
            );
        }
    }
}

pub(super) const MESHES: [(&str, (f64, u32), &[f64]); 3] = [
    ("25 mm, 12.5 by the tip", (25.0, 1), &[30.0]),
    ("12.5 mm", (12.5, 0), &[]),
    ("25 mm, 6.25 by the tip", (25.0, 2), &[40.0, 25.0]),
];

/// The second code's places.
#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn block_of_the_second_code() {
    let truth = |at: &Vector3<f64>| {
        let known = MOVED.iter().find(|m| (Vector3::from(m.0) - at).norm() < 1e-9);
        known.map(|m| Vector3::from(m.1))
    };
    for (name, side, fine) in MESHES {
        let case = Case {
            name,
            side,
            fine,
            nu: 0.49,
            tube: [10.0, 20.0],
        };
        row(&case, &truth, 1.636);
    }
}

/// Against the same state on cubes half as large as those of the finest mesh.
fn against_finer(nu: f64, tube: [f64; 2]) {
    let (_, side, fine) = MESHES[2];
    let (block, _) = pushed(quarter(&settings(side.0, side.1), fine), nu, tube[0], tube[1]);
    let (mesh, found) = next(&block, side, nu, tube[0]);
    println!("reference: {} unknowns, left {:.3}", found.a.len(), found.left);
    let truth = |at: &Vector3<f64>| Some(displacement(&mesh, &found.a, at));
    for (name, side, fine) in &MESHES[..2] {
        let case = Case {
            name,
            side: *side,
            fine,
            nu,
            tube,
        };
        row(&case, &truth, 4.0 * found.force.z);
    }
}

#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn blocks_against_finer() {
    against_finer(0.3, [10.0, 20.0]);
    against_finer(0.49, [10.0, 20.0]);
}

/// Not looked at when the factor was chosen.
#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn blocks_kept_aside() {
    against_finer(0.45, [14.0, 16.0]);
    against_finer(0.4, [7.0, 9.0]);
}
