//! Two organs that lie on one another: pressed by a tube, and moved along one another.

use nalgebra::{Point3, Vector3};
use simulation::control::Newton;
use simulation::law::Law;
use simulation::space::cells::Settings;
use simulation::space::equilibrium::{Equilibrium, NoEquilibrium, Tolerance, settle};
use simulation::space::system::System;
use simulation::space::term::{OrganContact, Term, TubeContact};
use simulation::space::tube::Tube;

use crate::contact::obstacle::{below, hold, newton, surface};
use crate::contact::organs::{block, deformable};

/// A quarter of a stack of two blocks, one on the other, pressed by a tube from above.
struct Stack {
    system: System,
    newton: Newton,
    a: Vec<f64>,
}

const RADIUS: f64 = 10.0;

fn tube(depth: f64) -> Tube {
    Tube::straight(
        Point3::new(0.0, 0.0, 25.0 - depth + RADIUS),
        Vector3::z(),
        200.0,
        RADIUS,
    )
    .unwrap()
}

impl Stack {
    fn new() -> Self {
        let young = 5e-3;
        let tip = Vector3::new(0.0, 0.0, 25.0);
        let fine = |low: &Vector3<f64>, high: &Vector3<f64>| (tip.sup(low).inf(high) - tip).norm() < 12.0;
        let settings = Settings {
            levels: 1,
            ..Settings::of_side(12.5)
        };
        let upper = block([[0.0, 0.0, 0.0], [37.5, 37.5, 25.0]], &settings, &fine);
        let lower = block(
            [[0.0, 0.0, -30.0], [45.0, 45.0, 0.0]],
            &Settings::of_side(15.0),
            &|_, _| false,
        );
        let mut system = System::new();
        let above = system.add(deformable(&upper, Law::NeoHookean, young, 0.45));
        let below_it = system.add(deformable(&lower, Law::NeoHookean, 2.0 * young, 0.4));
        hold(&mut system, above, &upper, 2);
        hold(&mut system, below_it, &lower, 2);
        let offset = system.bodies.offset(below_it);
        for n in lower.nodes_where(|x| x.z < -30.0 + 1e-9) {
            system.fixed[offset + 3 * n + 2] = true;
        }
        let stiffness = 20.0 * young / 12.5;
        let organ = OrganContact::new(
            &system.bodies,
            [above, below_it],
            surface(below(0.0), 10.0),
            stiffness,
            |_, n| n.z < -0.5,
        );
        system.organs.push(organ.unwrap());
        let contact = TubeContact::new(&system.bodies, above, tube(0.0), 2.0 * stiffness, |_, n| n.z > 0.5);
        system.tubes.push(contact.unwrap());
        Self {
            newton: newton(&system, 1e-8),
            a: system.initial(),
            system,
        }
    }

    /// State, and the forces on the tube and on the lower block.
    fn to(&mut self, depth: f64) -> Result<(Equilibrium, [f64; 2]), NoEquilibrium> {
        self.system.tubes[0].move_to(tube(depth));
        self.system.organs[0].restart();
        let found = settle(&mut self.system, &mut self.newton, &mut self.a, &Tolerance::default())?;
        let (bodies, a) = (&self.system.bodies, &self.a);
        let tube = self.system.tubes[0].force(bodies, a).force.z;
        let organ = self.system.organs[0].force(bodies, a);
        Ok((found, [tube, organ.force.z]))
    }
}

#[test]
fn a_stack_carries_the_tube_and_the_way_back_is_the_way_there() {
    let mut stack = Stack::new();
    let found = [1.0, 3.0, 4.99, 5.0, 5.01, 8.0, 5.0, 3.0, 1.0].map(|depth| stack.to(depth).unwrap());
    for (state, [tube, organ]) in &found {
        println!(
            "tube {tube:.8} N, lower block {organ:.8} N, J {:.3}, {} rounds, {} steps",
            state.least_determinant, state.rounds, state.iterations
        );
        // Unknowns are within 1e-8 of a point's largest force, pressures within 1e-6 of it.
        assert!((tube + organ).abs() < 1e-6 * tube, "{tube} {organ}");
    }
    for (there, back) in [(0, 8), (1, 7), (3, 6)] {
        let ([one, other], [there, back]) = (
            [there, back].map(|k| found[k].1[0]),
            [there, back].map(|k| found[k].0.energy),
        );
        println!("force {one} {other}, energy {there} {back}");
        assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        // The energy is least: of the second order in what forces are off by.
        assert!((there / back - 1.0).abs() < 1e-6, "{there} {back}");
    }
    // A central difference of a smooth energy, to 0.01 mm: third derivatives are some 0.1 N/mm^2 of a quarter.
    let slope = (found[4].0.energy - found[2].0.energy) / 0.02;
    println!("slope of the energy {slope}, force {}", found[3].1[0]);
    assert!((slope / found[3].1[0] - 1.0).abs() < 1e-4);
}

/// A block under a pressure on a slab that is so many times as stiff, moved along as a whole and then held by one of its sides alone: what
/// resists beside what presses, at its worst, and the rounds at each place.
fn slide(ratio: f64) -> (f64, Vec<usize>) {
    let (young, pressure) = (1.0, 0.05);
    let slab = block(
        [[-10.0, -10.0, -20.0], [40.0, 30.0, 0.0]],
        &Settings::of_side(10.0),
        &|_, _| false,
    );
    let upper = block(
        [[0.0, 0.0, 0.0], [16.0, 16.0, 16.0]],
        &Settings::of_side(8.0),
        &|_, _| false,
    );
    let mut system = System::new();
    let above = system.add(deformable(&upper, Law::NeoHookean, young, 0.4));
    let under = system.add(deformable(&slab, Law::NeoHookean, ratio * young, 0.3));
    let offset = system.bodies.offset(under);
    for n in slab.nodes_where(|x| x.z < -20.0 + 1e-9) {
        (0..3).for_each(|k| system.fixed[offset + 3 * n + k] = true);
    }
    let side = upper.nodes_where(|x| x.x < 1e-9);
    let middle = upper.nodes_where(|x| (x.y - 8.0).abs() < 1e-9);
    side.iter().for_each(|n| system.fixed[3 * n] = true);
    middle.iter().for_each(|n| system.fixed[3 * n + 1] = true);
    let top = |at: &Vector3<f64>, normal: &Vector3<f64>| at.z > 16.0 - 1e-9 && normal.z > 0.5;
    let forces = deformable(&upper, Law::NeoHookean, young, 0.4).traction(|at, normal| {
        if top(at, normal) {
            -Vector3::z() * pressure
        } else {
            Vector3::zeros()
        }
    });
    system.load(above, &forces);
    let stiffness = 2.0 * ratio * young;
    let surface = surface(below(0.0), 10.0);
    let contact = OrganContact::new(&system.bodies, [above, under], surface, stiffness, |_, n| n.z < -0.5);
    system.organs.push(contact.unwrap());
    let (mut search, mut a) = (newton(&system, 1e-8), system.initial());
    let (mut worst, mut rounds) = (0.0_f64, Vec::new());
    for moved in [0.0, 3.0, 5.0, 9.7] {
        // As a whole: the side alone would turn its cubes inside out.
        let way = moved - a[3 * side[0]];
        (0..upper.nodes.len()).for_each(|n| a[3 * n] += way);
        system.organs[0].restart();
        let found = settle(&mut system, &mut search, &mut a, &Tolerance::default()).unwrap();
        let force = system.organs[0].force(&system.bodies, &a).force;
        assert!((force.z / (-256.0 * pressure) - 1.0).abs() < 1e-6);
        worst = worst.max(force.xy().norm() / force.z.abs());
        rounds.push(found.rounds);
    }
    (worst, rounds)
}

#[test]
fn an_organ_slides_without_resistance() {
    // It sinks into the slab by some parts of pressure over stiffness, 5e-3 and 5e-6, of its width: no steeper slope is there to
    // slide on, and what it is pushed by at one end it is pushed back by at the other.
    for (ratio, most) in [(10.0, 5e-3), (1e4, 5e-6)] {
        let (found, rounds) = slide(ratio);
        println!("{ratio} times as stiff: {found:.2e}, {rounds:?} rounds");
        assert!(found < most, "{ratio}: {found:e}");
    }
}

#[test]
fn organs_that_are_put_into_one_another_are_refused() {
    let mut stack = Stack::new();
    let upper = stack.system.bodies.part(0, &stack.a).len();
    stack.a[..upper].iter_mut().skip(2).step_by(3).for_each(|u| *u = -6.0);
    let refused = stack.to(0.0).map(|(found, _)| found.rounds);
    assert!(
        matches!(refused, Err(NoEquilibrium::TooDeep { most: 5.0, depth }) if (depth - 6.0).abs() < 1e-9),
        "{refused:?}"
    );
    // And no step takes them there.
    let stack = Stack::new();
    let contact = &stack.system.organs[0];
    for down in [-1.0, -6.0, -1e3] {
        let step: Vec<f64> = (0..stack.a.len())
            .map(|i| if i < upper && i % 3 == 2 { down } else { 0.0 })
            .collect();
        let reach = contact.reach(&stack.system.bodies, &stack.a, &step);
        assert!((reach - (5.0 / -down).min(1.0)).abs() < 1e-9, "{down} {reach}");
    }
}
