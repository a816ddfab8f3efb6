//! Whether a state is a minimum, beside columns that carry more than Euler's load: one stands straight though it would buckle, one leans on the tube.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Mesh, Plane, Settings as Cells};
use simulation::space::frames::{Frames, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::tube::Tube;

const YOUNG: f64 = 5e-3;
const SIDE: f64 = 10.0;
const TALL: f64 = 100.0;
const RADIUS: f64 = 10.0;

/// Euler's load of a column that is fixed at its foot: `pi^2 E I / (4 L^2)`.
fn euler() -> f64 {
    let moment = SIDE.powi(4) / 12.0;
    std::f64::consts::PI.powi(2) * YOUNG * moment / (4.0 * TALL * TALL)
}

/// A column with so much on its top, downwards and aside, N.
fn column(down: f64, aside: f64) -> (System, Vec<usize>) {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    let half = 0.5 * SIDE;
    let corners = [Vector3::new(-half, -half, 0.0), Vector3::new(half, half, TALL)];
    let mesh = Mesh::new(&everywhere, corners, &Cells::of_side(SIDE), &|_, _| false).unwrap();
    let material = Material::new(Law::NeoHookean, YOUNG, 0.3).unwrap();
    let foot = mesh.nodes_where(|x| x.z < 1e-9);
    let top = mesh.nodes_where(|x| x.z > TALL - 1e-9);
    let mut system = System::new();
    system.add(Deformable::new(mesh, material, Vector3::zeros()).unwrap());
    for n in foot {
        (0..3).for_each(|k| system.fixed[3 * n + k] = true);
    }
    let each = 1.0 / top.len() as f64;
    let loads: Vec<(usize, f64)> = top
        .iter()
        .flat_map(|n| [(3 * n, aside * each), (3 * n + 2, -down * each)])
        .collect();
    System::load(&mut system, 0, &loads);
    (system, top)
}

/// An upright tube whose side has this gap to the column's.
fn pose(gap: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(0.5 * SIDE + gap + RADIUS, 0.0, 0.6 * TALL),
        nalgebra::UnitQuaternion::identity(),
    )
}

/// The column beside the tube, settled.
fn settled((system, _): (System, Vec<usize>), gap: f64) -> Frames {
    let settings = Settings {
        tolerance: 1e-9,
        depth: 1e-9,
        most_steps: 60,
        ..Settings::default()
    };
    let tube = Tube::straight(Point3::origin(), Vector3::z(), 200.0, RADIUS).unwrap();
    let a = system.initial();
    let tube = tube.at(pose(gap)).unwrap();
    let mut frames = Frames::new(system, a, 0, tube, settings, |_, n| n.x > 0.5).unwrap();
    let is_settled = (0..20).any(|_| frames.frame(&pose(gap)).state == State::Settled);
    assert!(is_settled);
    frames
}

/// The mean way of the top aside, mm.
fn aside(top: &[usize], a: &[f64]) -> f64 {
    top.iter().map(|n| a[3 * n]).sum::<f64>() / top.len() as f64
}

/// A unit of force on the top, aside.
fn unit(top: &[usize], size: usize) -> Vec<f64> {
    let mut forces = vec![0.0; size];
    top.iter().for_each(|n| forces[3 * n] = 1.0 / top.len() as f64);
    forces
}

#[test]
fn a_column_that_would_buckle_is_no_minimum_and_one_below_eulers_load_gives_way_as_much_more_as_it_says() {
    let far = 40.0;
    let soft = |part: f64| {
        let mut frames = settled(column(part * euler(), 0.0), far);
        assert!(frames.is_free());
        let top = column(0.0, 0.0).1;
        let straight = aside(&top, frames.state());
        assert!(straight.abs() < 1e-6, "{part}: it stands, {straight} mm aside");
        let forces = unit(&top, frames.state().len());
        let found = frames.yielding().map(|y| y.to(&forces).unwrap());
        found.map(|change| aside(&top, &change.unknowns))
    };
    let alone = soft(0.0).unwrap();
    // A beam's top goes aside by P L^3 / 3 E I; a load P on it makes that 1 / (1 - P / Euler's) as much (by the first mode alone, 1 % off).
    let beam = TALL.powi(3) / (3.0 * YOUNG * SIDE.powi(4) / 12.0);
    assert!((alone / beam - 1.0).abs() < 0.1, "{alone} {beam}");
    let half = soft(0.5).unwrap();
    println!("{alone} mm/N alone, {beam} of a beam, {half} with half of Euler's load");
    assert!((half / alone - 2.0).abs() < 0.1, "{half}");
    assert_eq!(soft(1.3), None);
}

#[test]
fn a_column_that_only_the_tube_holds_up_is_a_minimum_and_gives_way_as_states_do_that_are_solved_again() {
    let (down, lean, gap) = (1.3 * euler(), 1e-4, 0.5);
    let mut frames = settled(column(down, lean), gap);
    assert!(!frames.is_free(), "it leans on the tube");
    let top = column(0.0, 0.0).1;
    let forces = unit(&top, frames.state().len());
    let found = frames.yielding().unwrap().to(&forces).unwrap();
    let small = 1e-6;
    let [up, less] = [small, -small].map(|by| settled(column(down, lean + by), gap));
    let again = (aside(&top, up.state()) - aside(&top, less.state())) / (2.0 * small);
    let change = aside(&top, &found.unknowns);
    println!("top by {change} mm/N, {again} solved again");
    assert!(again > 1.0 && (change - again).abs() < 1e-4 * again, "{change} {again}");
}
