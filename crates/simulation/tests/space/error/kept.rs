//! A case that was not looked at when the factor was chosen: a ball that its cubes cut anyhow, on an elastic bed, pushed by a tube.

#![allow(clippy::print_stdout, reason = "the table is what these tests are for")]

use nalgebra::{Point3, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Ball, Mesh};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::error::{Stated, Touching, corrected, halved, taken_over};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use super::{displacement, largest, settings};

const BALL: Ball = Ball {
    centre: Vector3::new(0.0, 0.0, 0.0),
    radius: 40.0,
};
const QUARTER: [Vector3<f64>; 2] = [Vector3::new(0.0, 0.0, -41.3), Vector3::new(41.3, 41.3, 41.3)];
const TIP: Vector3<f64> = Vector3::new(0.0, 0.0, 40.0);
const RADIUS: f64 = 12.0;

fn tube(depth: f64) -> Tube {
    Tube::straight(
        Point3::from(TIP + Vector3::z() * (RADIUS - depth)),
        Vector3::z(),
        100.0,
        RADIUS,
    )
    .unwrap()
}

fn wanted(at: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
    normal.z > 0.3 && at.x > 1e-9 && at.y > 1e-9
}

/// A quarter of the ball on its bed, without the tube.
fn system(mesh: &Mesh) -> System {
    let material = Material::new(Law::NeoHookean, 5e-3, 0.45).unwrap();
    let mut system = System::new();
    system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
    for k in 0..2 {
        let flat = mesh.nodes_where(|x| x[k].abs() < 1e-9);
        flat.into_iter().for_each(|n| system.fixed[3 * n + k] = true);
    }
    let bed = |at: &Vector3<f64>, normal: &Vector3<f64>| {
        if normal.z < -0.3 && at.x > 1e-9 && at.y > 1e-9 {
            2e-3
        } else {
            0.0
        }
    };
    let bed = Springs::new(&system.bodies, 0, bed, |x| *x);
    system.others.push(Box::new(bed));
    system
}

/// State and force of the tube 8 mm in, and the same on cubes half as large.
fn states(side: f64) -> [(Mesh, Vec<f64>, f64); 2] {
    let settings = settings(side, 0);
    let mesh = Mesh::new(&BALL, QUARTER, &settings, &|_, _| false).unwrap();
    let mut one = system(&mesh);
    one.tubes
        .push(TubeContact::new(&one.bodies, 0, tube(0.0), 0.3 / side, wanted).unwrap());
    let control = Control {
        provisional: true,
        ..Control::default()
    };
    let mut newton = Newton::ordered_by(control, Dissection::by_places(&one.places(), &[]).unwrap());
    let mut a = one.initial();
    for depth in [2.0, 4.0, 6.0, 8.0] {
        one.tubes[0].move_to(tube(depth));
        settle(&mut one, &mut newton, &mut a, &Tolerance::default()).unwrap();
    }
    let force = one.tubes[0].force(&one.bodies, &a).force.z;
    let finer = halved(&mesh, &BALL, QUARTER, &settings, None).unwrap();
    let touching = Touching {
        body: 0,
        tube: one.tubes[0].tube(),
        wanted: &wanted,
    };
    let next = corrected(&system(&finer), &taken_over(&mesh, &a, &finer), Some(&touching)).unwrap();
    println!(
        "{} -> {} unknowns, left {:.3}, {} factors",
        a.len(),
        next.a.len(),
        next.left,
        next.factors
    );
    [(mesh, a, force), (finer, next.a, next.force.z)]
}

#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn a_ball_kept_aside() {
    let [_, best] = states(9.0);
    for side in [18.0, 13.0] {
        let [one, next] = states(side);
        let of = |s: &(Mesh, Vec<f64>, f64)| Vector3::z() * s.2;
        let stated = Stated::new((&one.0, &one.1, of(&one)), (&next.0, &next.1, of(&next)), &TIP, 20.0);
        let truth = largest(&next.0, &TIP, 20.0, |at| {
            best.0.row(at).map_or(0.0, |_| {
                (displacement(&one.0, &one.1, at) - displacement(&best.0, &best.1, at)).norm()
            })
        });
        let all = [
            [stated.force, (one.2 - best.2).abs()],
            [stated.near, truth[0]],
            [stated.elsewhere, truth[1]],
        ];
        println!(
            "{side} mm, force {:.5}, {:.5}, {:.5}: {all:.4?}, ratios {:.2?}",
            one.2,
            next.2,
            best.2,
            all.map(|[s, t]| s / t)
        );
    }
}
