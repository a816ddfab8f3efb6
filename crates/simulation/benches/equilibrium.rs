//! What an equilibrium costs.
//!
//! `cargo bench -p simulation --bench equilibrium`. Times are of the thread's processor, the least of the rounds, so that other
//! work on the machine counts little. The thesis's scenes, heaps with thousands of contacts, and the thesis's class of method. What one
//! iteration costs is told by `cost`, and the trade of mesh, tolerance and barrier by `solids_trade`.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
mod shared;

use common::scenes::{
    five, five_exact, guard, heap, ring_behind_barrier, ring_exact, ring_in_ring, ring_in_ring_exact, star, tee,
    tee_on_ring, wall,
};
use nalgebra::Vector2;
use shared::{least, now, say_load};
use simulation::control::{Newton, Potential, Settings};
use simulation::equilibrium::{Equilibrium, settle, settled};
use simulation::law::Law;
use simulation::system::System;

fn main() {
    say_load();
    scenes();
    heaps();
    first_order();
    say_load();
}

fn report(name: &str, rounds: usize, build: impl Fn() -> (System, Vec<f64>)) {
    let (milliseconds, (size, found)) = least(rounds, || {
        let (mut system, mut a) = build();
        (a.len(), settled(&mut system, &mut a))
    });
    match found {
        Ok(Equilibrium {
            minimum,
            iterations,
            searches,
            exact,
            complementarity,
            ..
        }) => {
            let relative = minimum.residual / minimum.load;
            println!(
                "{name:28} {size:8} {milliseconds:9.3} {iterations:6} {searches:5} {relative:9.1e} {:?} exact {exact}, force x gap {complementarity:.0e}",
                minimum.stability
            );
        }
        Err(refused) => println!("{name:28} {size:8} {milliseconds:9.3} {refused}"),
    }
}

fn start(system: System) -> (System, Vec<f64>) {
    let a = system.initial();
    (system, a)
}

/// The thesis's scenes from their start; rigid ones took it a second, those of a hundred unknowns an hour.
fn scenes() {
    println!("\nscene, from its start        unknowns        ms  steps  searches  residual/load");
    for (name, angle, which) in [
        ("32: T upright", 0.0, 0),
        ("33: T inclined", 0.6, 0),
        ("34: star", 0.0, 1),
    ] {
        report(name, 20, || {
            let mut system = System::new();
            let body = system.add(if which == 0 { tee() } else { star() });
            wall(&mut system, (0.0, 1.0), 0.0, 1e3);
            let mut a = system.initial();
            system.bodies.solid(body).rotate(&mut a, angle, Vector2::zeros());
            system.bodies.solid(body).translate(&mut a, Vector2::new(0.0, 1.5));
            (system, a)
        });
    }
    report("37a: ring 8 x 2, exact", 5, || start(ring_behind_barrier([8, 2], 0.01)));
    report("37b: ring 15 x 3, exact", 5, || {
        start(ring_behind_barrier([15, 3], 0.01))
    });
    report("37b: by way of 0.02", 5, || start(ring_exact([15, 3], 0.02)));
    report("38: exact, by way of 0.02", 3, || {
        start(ring_in_ring_exact([12, 2], 0.02))
    });
    for width in [1e-2, 1e-3] {
        report(&format!("38: ring in ring, {width:.0e}"), 3, || {
            start(ring_in_ring([12, 2], 0.01, width))
        });
        report(&format!("40: five solids, {width:.0e}"), 3, || {
            start(five(2, Law::NeoHookean, width))
        });
    }
    for (name, width, exact) in [
        ("39: T on a ring, 1e-2", 1e-2, false),
        ("39: exact, by way of 0.02", 0.02, true),
        ("39: exact, by way of 0.04", 0.04, true),
    ] {
        report(name, 5, || tee_on_ring([width; 2], exact));
    }
    for widths in [[0.03, 0.03], [0.04, 0.04], [0.05, 0.0125], [0.1, 0.025]] {
        report(&format!("40: exact, by way of {}", widths[1]), 5, || {
            start(five_exact(2, widths))
        });
    }
    warm();
    warm_exact();
}

/// Five solids whose right wall moves by 1e-3 a frame.
fn warm() {
    let width = 1e-2;
    let mut system = five(2, Law::NeoHookean, width);
    let mut a = system.initial();
    settled(&mut system, &mut a).unwrap();
    let mut newton = Newton::new(Settings::default());
    let mut times = Vec::new();
    let mut steps = 0;
    for frame in 1..=40 {
        // The right wall is the third of the planes; the barrier between the solids comes last.
        let mut next = five(2, Law::NeoHookean, width);
        let pairs = next.terms.pop().unwrap();
        next.terms.pop();
        guard(&mut next, (-1.0, 0.0), -1.6 + 1e-3 * f64::from(frame), width);
        next.terms.push(pairs);
        let began = now();
        match settle(&mut next, &mut newton, &mut a) {
            Ok(found) => steps += found.iterations,
            Err(refused) => {
                println!("40, warm: frame {frame}: {refused}");
                return;
            }
        }
        times.push(1e3 * (now() - began));
    }
    times.sort_by(f64::total_cmp);
    let (median, late) = (times[20], times[38]);
    println!(
        "40, wall moves 1e-3 a frame: median {median:.3} ms, 95 % {late:.3} ms, {:.1} steps",
        f64::from(steps as u32) / 40.0
    );
}

/// The same in exact contact from frame to frame, without the barrier between.
fn warm_exact() {
    let mut system = five_exact(2, [0.03, 0.03]);
    let mut a = system.initial();
    settled(&mut system, &mut a).unwrap();
    let mut newton = Newton::new(Settings::default());
    let (mut times, mut steps, mut worst) = (Vec::new(), 0, 0.0_f64);
    for frame in 1..=40 {
        system.terms[2].move_wall(1e-3);
        let began = now();
        match settle(&mut system, &mut newton, &mut a) {
            Ok(found) => {
                steps += found.iterations;
                worst = worst.max(found.minimum.residual / found.minimum.load);
            }
            Err(refused) => {
                println!("40, warm in exact contact: frame {frame}: {refused}");
                return;
            }
        }
        times.push(1e3 * (now() - began));
    }
    times.sort_by(f64::total_cmp);
    println!(
        "40, the same in exact contact: median {:.3} ms, 95 % {:.3} ms, {:.1} steps, worst free force {worst:.1e} of the load",
        times[20],
        times[38],
        f64::from(steps as u32) / 40.0
    );
}

/// Round solids of one element each, in rows: up to thousands of contacts behind one barrier.
fn heaps() {
    println!(
        "\nheap of round solids, barrier 0.05 to 0.01: solids, unknowns, forces on samples (two a contact), ms, steps, what is certified"
    );
    for side in [4, 8, 16] {
        let mut system = heap(side, side, 0.002, [0.05, 0.01]);
        let mut a = system.initial();
        let began = now();
        let found = settled(&mut system, &mut a);
        let milliseconds = 1e3 * (now() - began);
        // A contact of two solids is told twice, once for either.
        let (solids, forces) = (system.bodies.len(), system.forces(&a).len());
        match found {
            Ok(e) => println!(
                "{solids} {} {forces} {milliseconds:.0} ms {} steps, free force {:.1e} of the largest, imbalance {:.1e}, least gap {:.1e}, {:?}",
                a.len(),
                e.iterations,
                e.minimum.residual / e.minimum.load,
                e.imbalance,
                e.least_gap,
                e.minimum.stability
            ),
            Err(refused) => println!("{solids} {} {forces} {milliseconds:.0} ms {refused}", a.len()),
        }
    }
}

/// The thesis's class of method, a step along the gradient, on the same energy, to a residual of 1e-3 of the load.
fn first_order() {
    let system = {
        let mut system = ring_behind_barrier([8, 2], 0.01);
        system.terms.clear();
        guard(&mut system, (0.0, 1.0), 0.0, 1e-2);
        system
    };
    let load = (0..system.size())
        .map(|i| Potential::load(&system, i).abs())
        .fold(0.0, f64::max);
    let (milliseconds, (steps, residual)) = least(1, || {
        let (mut a, mut gradient) = (system.initial(), vec![0.0; system.size()]);
        let mut energy = system.gradient(&a, &mut gradient).unwrap();
        let mut size = 0.1;
        let mut residual = f64::INFINITY;
        for step in 0..400_000 {
            residual = gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
            if residual <= 1e-3 * load {
                return (step, residual / load);
            }
            let next: Vec<f64> = a.iter().zip(&gradient).map(|(a, g)| a - size * g).collect();
            let mut other = vec![0.0; next.len()];
            match system.gradient(&next, &mut other) {
                Some(lower) if lower < energy => {
                    (a, gradient, energy) = (next, other, lower);
                    size *= 1.1;
                }
                _ => size *= 0.5,
            }
        }
        (400_000, residual / load)
    });
    println!(
        "\nalong the gradient, ring 8 x 2: {milliseconds:.0} ms, {steps} steps, residual {residual:.0e} of the load"
    );
}
