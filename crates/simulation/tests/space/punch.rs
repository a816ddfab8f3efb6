//! Rigid punches on a half space: flat ones, and Hertz's ball.

use nalgebra::{Point3, Vector3};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::term::TubeContact;
use simulation::space::tube::Tube;

use crate::common::{balance, forces, hold, newton};
use crate::half_space::{block, hold_far, mindlin, solid};

/// Capacity of a square plate of unit side by that of a ball of unit radius: a flat punch without friction presses as charge
/// lies on a plate, `F = pi C E* d` (a disc of radius `a` has `2 a / pi`).
const SQUARE: f64 = 0.366_79;

/// Force by `E* d a` of a square punch of half side `a`.
fn square(reach: f64, side: f64, half: f64, nu: f64) -> (f64, usize) {
    let mesh = block(reach, side, 1.25 * half);
    let press = |depth: f64, far: f64| {
        let (mut system, mut a) = solid(&mesh, nu);
        hold_far(&mut system, &mut a, &mesh, reach, |x| mindlin(nu, 0.0, x) * far);
        let under = mesh.nodes_where(|x| x.z < 1e-9 && x.x < half + 1e-9 && x.y < half + 1e-9);
        under.iter().for_each(|n| hold(&mut system, &mut a, 3 * n + 2, depth));
        balance(&system, &mut a, 1e-10).unwrap();
        let forces = forces(system.bodies.solid(0), &a);
        4.0 * under.iter().map(|n| forces[3 * n + 2]).sum::<f64>()
    };
    // The far faces move by the force, and the force is less by what they move: linear both.
    let force = press(1.0, 0.0) / (1.0 - press(0.0, 1.0));
    (force * (1.0 - nu * nu) / half, mesh.unknowns())
}

#[test]
fn a_flat_square_punch() {
    let exact = 2.0 * std::f64::consts::PI * SQUARE;
    for nu in [0.3_f64, 0.4999] {
        for (reach, half, side) in [(40.0, 10.0, 5.0), (80.0, 10.0, 5.0), (40.0, 10.0, 2.5)] {
            let (found, unknowns) = square(reach, side, half, nu);
            println!("nu {nu} reach {reach} half {half} side {side} {unknowns}: {:+.4} %", 100.0 * (found / exact - 1.0));
        }
    }
}

/// Radius of the ball and how deep it is: it touches out to 10, and half the square of that by its radius is what a ball
/// differs from Hertz's paraboloid by, 0.5 % of the contact's radius.
const BALL: [f64; 2] = [100.0, 1.0];

/// Hertz's force by `E*`.
fn hertz() -> f64 {
    4.0 / 3.0 * BALL[0].sqrt() * BALL[1].powf(1.5)
}

/// Force of the ball, by Hertz's; the radius of a disc as large as what presses on it; unknowns.
fn ball(reach: f64, side: f64, nu: f64) -> (f64, f64, usize) {
    let [radius, depth] = BALL;
    let mesh = block(reach, side, 12.5);
    let (mut system, mut a) = solid(&mesh, nu);
    // Far faces stand where Hertz's force moves them: a block that is too stiff shows by `1 + c` of what it is too stiff by,
    // where a far face's way takes the part `c`, below 0.3, of the force.
    let force = hertz() / (1.0 - nu * nu);
    hold_far(&mut system, &mut a, &mesh, reach, |x| mindlin(nu, 0.0, x) * force);
    let tube = Tube::straight(Point3::new(0.0, 0.0, depth - radius), -Vector3::z(), 10.0 * radius, radius).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 60.0 / side, |_, normal| normal.z < -0.5).unwrap();
    system.tubes.push(contact);
    // The deepest point is below 1e-3 of the depth of the ball.
    let tolerance = Tolerance {
        change: 1e-5,
        depth: 1e-5,
    };
    let mut newton = newton(&system, 1e-8);
    for round in 0..16 {
        let f = newton.minimise(&system, &mut a);
        let Ok(f) = f else { println!("{f:?}"); break; };
        let c = system.update(&a);
        let on = system.tubes[0].force(&system.bodies, &a);
        println!("round {round}: its {} residual {:.1e} load {:.2e} change {:.2e} depth {:.2e} points {} force {}", f.iterations, f.residual, f.load, c.force, c.depth, on.points, on.force.z);
    }
    let found = settle(&mut system, &mut newton, &mut a, &tolerance).unwrap();
    println!("{} rounds {} {}", found.rounds, found.iterations, found.depth);
    let on = system.tubes[0].force(&system.bodies, &a);
    let wide = (4.0 * on.area / std::f64::consts::PI).sqrt();
    (-4.0 * on.force.z / force, wide, a.len())
}

#[test]
fn a_ball_on_a_half_space() {
    for nu in [0.3] {
        for (reach, side) in [(40.0, 5.0), (40.0, 2.5)] {
            let (found, wide, unknowns) = ball(reach, side, nu);
            println!("nu {nu}, block of {reach}, cubes of {side}, {unknowns} unknowns: contact radius {wide:.2}, force {:+.3} %", 100.0 * (found - 1.0));
        }
    }
}
