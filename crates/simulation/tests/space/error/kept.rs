//! Cases that were not looked at when the factor was chosen: bodies that their cubes cut anyhow, on an elastic bed, pushed by a tube.

#![allow(clippy::print_stdout, reason = "the table is what these tests are for")]

use nalgebra::{Point3, Vector3};
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{Ball, Field, LabelField, LabelMap, Mesh, Smoothing};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::error::{Stated, Touching, corrected, halved, taken_over};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

use super::{displacement, largest, settings};

const RADIUS: f64 = 12.0;

/// A body on its bed, and where the tube comes down on it.
struct Scene<'a> {
    field: &'a dyn Field,
    corners: [Vector3<f64>; 2],
    tip: Vector3<f64>,
    /// Whether `x = 0` and `y = 0` are planes of symmetry that the box ends at.
    quarter: bool,
}

impl Scene<'_> {
    fn tube(&self, depth: f64) -> Tube {
        let origin = Point3::from(self.tip + Vector3::z() * (RADIUS - depth));
        Tube::straight(origin, Vector3::z(), 100.0, RADIUS).unwrap()
    }

    /// Whether a place is on the body's own surface.
    fn outside(&self, at: &Vector3<f64>) -> bool {
        !self.quarter || at.x > 1e-9 && at.y > 1e-9
    }

    fn wanted(&self, at: &Vector3<f64>, normal: &Vector3<f64>) -> bool {
        normal.z > 0.3 && self.outside(at)
    }

    /// The body without the tube.
    fn system(&self, mesh: &Mesh) -> System {
        let material = Material::new(Law::NeoHookean, 5e-3, 0.45).unwrap();
        let mut system = System::new();
        system.add(Deformable::new(mesh.clone(), material, Vector3::zeros()).unwrap());
        for k in (0..2).filter(|_| self.quarter) {
            let flat = mesh.nodes_where(|x| x[k].abs() < 1e-9);
            flat.into_iter().for_each(|n| system.fixed[3 * n + k] = true);
        }
        let bed = |at: &Vector3<f64>, normal: &Vector3<f64>| {
            if normal.z < -0.3 && self.outside(at) { 2e-3 } else { 0.0 }
        };
        let bed = Springs::new(&system.bodies, 0, bed, |x| *x);
        system.others.push(Box::new(bed));
        system
    }
}

/// State and force of the tube 8 mm in, and the same on cubes half as large.
fn states(scene: &Scene<'_>, side: f64) -> [(Mesh, Vec<f64>, f64); 2] {
    let settings = settings(side, 0);
    let mesh = Mesh::new(scene.field, scene.corners, &settings, &|_, _| false).unwrap();
    let mut one = scene.system(&mesh);
    let wanted = |at: &Vector3<f64>, normal: &Vector3<f64>| scene.wanted(at, normal);
    one.tubes
        .push(TubeContact::new(&one.bodies, 0, scene.tube(0.0), 0.3 / side, wanted).unwrap());
    let control = Control {
        provisional: true,
        ..Control::default()
    };
    let mut newton = Newton::ordered_by(control, Dissection::by_places(&one.places(), &[]).unwrap());
    let mut a = one.initial();
    for depth in [2.0, 4.0, 6.0, 8.0] {
        one.tubes[0].move_to(scene.tube(depth));
        settle(&mut one, &mut newton, &mut a, &Tolerance::default()).unwrap();
    }
    let force = one.tubes[0].force(&one.bodies, &a).force.z;
    let finer = halved(&mesh, scene.field, scene.corners, &settings, None).unwrap();
    let touching = Touching {
        body: 0,
        tube: one.tubes[0].tube(),
        wanted: &wanted,
    };
    let next = corrected(&scene.system(&finer), &taken_over(&mesh, &a, &finer), Some(&touching)).unwrap();
    println!(
        "{} -> {} unknowns, left {:.3}, {} factors",
        a.len(),
        next.a.len(),
        next.left,
        next.factors
    );
    [(mesh, a, force), (finer, next.a, next.force.z)]
}

/// Prints what is stated on larger cubes beside the difference from the best state, that on half of `best` mm.
fn compare(scene: &Scene<'_>, best: f64, sides: &[f64]) {
    let [_, best] = states(scene, best);
    for side in sides {
        let [one, next] = states(scene, *side);
        let of = |s: &(Mesh, Vec<f64>, f64)| Vector3::z() * s.2;
        let (coarse, fine) = ((&one.0, &one.1[..], of(&one)), (&next.0, &next.1[..], of(&next)));
        let stated = Stated::new(coarse, fine, &scene.tip, 20.0);
        let truth = largest(&next.0, &scene.tip, 20.0, |at| {
            let off = || displacement(&one.0, &one.1, at) - displacement(&best.0, &best.1, at);
            best.0.row(at).map_or(0.0, |_| off().norm())
        });
        let all = [
            [stated.force, (one.2 - best.2).abs()],
            [stated.near, truth[0]],
            [stated.elsewhere, truth[1]],
        ];
        let forces = [one.2, next.2, best.2];
        println!(
            "{side} mm, forces {forces:.5?}: {all:.4?}, ratios {:.2?}",
            all.map(|[s, t]| s / t)
        );
    }
}

#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn a_ball_kept_aside() {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 40.0,
    };
    let scene = Scene {
        field: &ball,
        corners: [Vector3::new(0.0, 0.0, -41.3), Vector3::repeat(41.3)],
        tip: Vector3::new(0.0, 0.0, 40.0),
        quarter: true,
    };
    compare(&scene, 9.0, &[18.0, 13.0]);
}

/// A kidney's size: 120 x 60 x 50 mm, bent, in voxels of 3 mm.
#[test]
#[ignore = "minutes: the tables of docs/solids-3d.md"]
fn a_bean_of_voxels_kept_aside() {
    let size = [60, 40, 30];
    let inside = |n: usize| {
        let at = [n % size[0], n / size[0] % size[1], n / size[0] / size[1]].map(|x| 3.0 * x as f64);
        let [x, y, z] = [at[0] - 90.0, at[1] - 60.0, at[2] - 45.0];
        let y = y - x * x / 200.0;
        (x / 60.0).powi(2) + (y / 30.0).powi(2) + (z / 25.0).powi(2) < 1.0
    };
    let labels: Vec<u16> = (0..size.iter().product()).map(|n| u16::from(inside(n))).collect();
    let map = LabelMap {
        size,
        origin: Vector3::zeros(),
        spacing: Vector3::repeat(3.0),
        labels: &labels,
    };
    let smoothing = Smoothing {
        sigma: 3.0,
        ..Smoothing::default()
    };
    let field = LabelField::new(&map, 1, &smoothing).unwrap();
    let scene = Scene {
        corners: field.corners,
        field: &field,
        tip: Vector3::new(90.0, 60.0, 70.0),
        quarter: false,
    };
    compare(&scene, 12.0, &[18.0]);
}
