//! Rigid punches on a half space: flat ones, and Hertz's ball.

use nalgebra::{Point3, Vector3};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::system::System;
use simulation::space::term::TubeContact;
use simulation::space::tube::Tube;

use crate::closed::half_space::{block, hold_far, mindlin, solid};
use crate::common::{balance, forces, hold, newton};

/// Capacity of a square plate of unit side by that of a ball of unit radius: a flat punch without friction presses as charge
/// lies on a plate, `F = pi C E* d` (a disc of radius `a` has `2 a / pi`).
const SQUARE: f64 = 0.366_79;

/// Half the side of the square punch.
const HALF: f64 = 10.0;

/// Force by `E* d a` of a square punch of half side `a`.
fn square(reach: f64, side: f64, nu: f64) -> (f64, usize) {
    let mesh = block(reach, side, 1.25 * HALF);
    let press = |depth: f64, far: f64| {
        let (mut system, mut a) = solid(&mesh, nu);
        hold_far(&mut system, &mut a, &mesh, reach, |x| mindlin(nu, 0.0, x) * far);
        let under = mesh.nodes_where(|x| x.z < 1e-9 && x.x < HALF + 1e-9 && x.y < HALF + 1e-9);
        under.iter().for_each(|n| hold(&mut system, &mut a, 3 * n + 2, depth));
        balance(&system, &mut a, 1e-10).unwrap();
        let forces = forces(system.bodies.solid(0), &a);
        4.0 * under.iter().map(|n| forces[3 * n + 2]).sum::<f64>()
    };
    // The far faces move by the force, and the force is less by what they move: linear both.
    let force = press(1.0, 0.0) / (1.0 - press(0.0, 1.0));
    (force * (1.0 - nu * nu) / HALF, mesh.unknowns())
}

#[test]
fn a_flat_square_punch() {
    let exact = 2.0 * std::f64::consts::PI * SQUARE;
    for nu in [0.3, 0.4999] {
        let found = [(40.0, 5.0), (80.0, 5.0), (40.0, 2.5)].map(|(reach, side)| {
            let (force, unknowns) = square(reach, side, nu);
            let off = force / exact - 1.0;
            println!(
                "nu {nu}, block of {reach}, cubes of {side}, {unknowns} unknowns: {:+.3} %",
                100.0 * off
            );
            off
        });
        // Pressures grow without end at the edge, as the root of the distance falls: of order 1. What a larger block adds
        // falls with the cube of its size.
        let block = (found[1] - found[0]) * 8.0 / 7.0;
        let limit = 2.0 * found[2] - found[0] + block;
        println!("  without end and with cubes of no size: {:+.3} %", 100.0 * limit);
        assert!(
            (found[2] + block).abs() < 0.02 && limit.abs() < 0.005,
            "{found:?} {limit}"
        );
    }
}

/// Radius of the ball and how deep it is. It touches out to 10, a hundredth of the radius: the part that Hertz's paraboloid
/// and points that do not move sideways are off by.
const BALL: [f64; 2] = [1000.0, 0.1];

/// A quarter of a block with the ball on it, held far away as Hertz's force moves it there.
///
/// What a block that is too stiff adds to the force shows more than once, by `1 + c`, where the far faces' way takes the part
/// `c` of the force, below 0.3.
fn ball(reach: f64, side: f64, nu: f64) -> (System, Vec<f64>) {
    let [radius, depth] = BALL;
    let mesh = block(reach, side, 12.5);
    let (mut system, mut a) = solid(&mesh, nu);
    let force = hertz(nu);
    hold_far(&mut system, &mut a, &mesh, reach, |x| mindlin(nu, 0.0, x) * force);
    let tip = Point3::new(0.0, 0.0, depth - radius);
    let tube = Tube::straight(tip, -Vector3::z(), 10.0 * radius, radius).unwrap();
    let contact = TubeContact::new(&system.bodies, 0, tube, 60.0 / side, |_, normal| normal.z < -0.5).unwrap();
    system.tubes.push(contact);
    (system, a)
}

/// Hertz's force, of Young's modulus 1.
fn hertz(nu: f64) -> f64 {
    4.0 / 3.0 * BALL[0].sqrt() * BALL[1].powf(1.5) / (1.0 - nu * nu)
}

#[test]
fn a_ball_on_a_half_space() {
    for nu in [0.3, 0.4999] {
        let found = [(40.0, 5.0), (80.0, 5.0), (40.0, 2.5)].map(|(reach, side)| {
            let (mut system, mut a) = ball(reach, side, nu);
            // Forces are found to 1e-4 where single ones still change by 1e-3.
            let tolerance = Tolerance {
                change: 1e-3,
                depth: 1e-5,
            };
            // Places 1000 from the ball's centre are rounded to 1e-13, which raised stiffnesses make a force of.
            let mut newton = newton(&system, 1e-6);
            let found = settle(&mut system, &mut newton, &mut a, &tolerance).unwrap();
            let on = system.tubes[0].force(&system.bodies, &a);
            let off = -4.0 * on.force.z / hertz(nu) - 1.0;
            println!(
                "nu {nu}, block of {reach}, cubes of {side}, {} unknowns, {} steps: {:+.3} %",
                a.len(),
                found.iterations,
                100.0 * off
            );
            off
        });
        let limit = found[2] + (found[1] - found[0]) * 8.0 / 7.0;
        println!("  without end: {:+.3} %", 100.0 * limit);
        // The radius of contact is four cubes: 1 % is asked for, and Hertz's own error is less than half of that.
        assert!(limit.abs() < 0.005 && found.iter().all(|f| f.abs() < 0.01), "{found:?}");
    }
}

#[test]
#[ignore = "fault: no convergence, as stiffnesses raised for slow depths round forces by more than the tolerance"]
fn a_ball_on_a_half_space_to_the_default_tolerance() {
    for (side, tolerance) in [(5.0, 1e-8), (2.5, 1e-8)] {
        let (mut system, mut a) = ball(40.0, side, 0.3);
        let mut newton = newton(&system, tolerance);
        let found = settle(&mut system, &mut newton, &mut a, &Tolerance::default());
        println!("cubes of {side}: {found:?}");
        assert!(found.is_ok(), "{found:?}");
    }
}
