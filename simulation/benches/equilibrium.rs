//! What an equilibrium costs and how near it comes.
//!
//! `cargo bench -p simulation`. Times are of the thread's processor, the least of the rounds, so that other work on the
//! machine counts little. Three tables: one Newton iteration by the number of unknowns, beside dense Cholesky of
//! `nalgebra`; the thesis's scenes; the width of the barrier against time and error.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::scenes::{
    five, five_exact, guard, ring_behind_barrier, ring_exact, ring_in_ring, ring_in_ring_exact, ring_on_plane, star,
    tee, wall,
};
use nalgebra::{DMatrix, DVector, Vector2};
use simulation::control::{Newton, Potential, Settings};
use simulation::equilibrium::{Equilibrium, settle, settled};
use simulation::law::Law;
use simulation::sparse::{Ldl, Triplets};
use simulation::system::System;

/// Seconds of this thread's processor.
fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The least time of `rounds`, in milliseconds, and the last result.
fn least<T>(rounds: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut best = f64::INFINITY;
    let mut last = None;
    for _ in 0..rounds {
        let began = now();
        last = Some(work());
        best = best.min(1e3 * (now() - began));
    }
    (best, last.unwrap())
}

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load of the machine: {}", load.trim());
    scenes();
    iteration();
    widths();
    first_order();
    println!(
        "load of the machine: {}",
        std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim()
    );
}

/// Assembly, factorisation and solution of one system, by size.
fn iteration() {
    println!("\none Newton iteration of a ring, milliseconds");
    println!("unknowns  assembly  symbolic  factor  solve  fill/n  Mflop  dense  residual");
    for elements in [[5, 1], [8, 2], [15, 3], [32, 4], [64, 8], [128, 16], [256, 32]] {
        let system = ring_on_plane(elements, 0.01);
        let (a, mut matrix) = (system.initial(), Triplets::default());
        let rounds = 20;
        let (assembly, ()) = least(rounds, || system.hessian(&a, false, &mut matrix).unwrap());
        // A free ring: a small shift stands for what holds it.
        let (symbolic, _) = least(2, || Ldl::new().factor(&matrix, 1e-3).unwrap());
        let mut ldl = Ldl::new();
        ldl.factor(&matrix, 1e-3).unwrap();
        let (factor, _) = least(rounds, || ldl.factor(&matrix, 1e-3).unwrap());
        let n = matrix.size();
        let mut x = vec![1.0; n];
        let (solve, ()) = least(rounds, || {
            x.fill(1.0);
            ldl.solve(&mut x);
        });
        let residual = matrix
            .product(&x)
            .iter()
            .zip(&x)
            .map(|(y, x)| (y + 1e-3 * x - 1.0).abs())
            .fold(0.0, f64::max);
        let dense = if n <= 1200 {
            format!("{:.3}", dense(&matrix))
        } else {
            "-".to_owned()
        };
        let (fill, work) = (ldl.fill() / n, ldl.work() as f64 * 2e-6);
        println!(
            "{n:8} {assembly:9.3} {symbolic:9.3} {factor:7.3} {solve:6.3} {fill:6} {work:7.2} {dense:>7} {residual:.0e}"
        );
    }
}

/// Cholesky of the whole matrix.
fn dense(matrix: &Triplets) -> f64 {
    let n = matrix.size();
    let column = |k: usize| {
        let mut unit = vec![0.0; n];
        unit[k] = 1.0;
        let mut column = matrix.product(&unit);
        column[k] += 1e-3;
        DVector::from_vec(column)
    };
    let whole = DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>());
    least(2, || whole.clone().cholesky().unwrap()).0
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
    for widths in [[0.05, 0.0125], [0.1, 0.025]] {
        report(&format!("40: exact, by way of {}", widths[1]), 5, || {
            start(five_exact(2, widths))
        });
    }
    warm();
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

/// The height of a ring of 64 x 4 elements on a plane against the reference 1.5589765, by barrier width.
fn widths() {
    println!("\nring 64 x 4, w = 0.01: width  ms  steps  error of the crown");
    for width in [1e-2, 1e-3, 1e-4, 1e-5, 0.0] {
        let (milliseconds, (found, crown)) = least(1, || {
            let mut system = ring_behind_barrier([64, 4], 0.01);
            if width > 0.0 {
                system.terms.clear();
                guard(&mut system, (0.0, 1.0), 0.0, width);
            }
            let mut a = system.initial();
            let found = settled(&mut system, &mut a);
            let heights = (0..a.len() / 2).map(|n| system.bodies.point(0, n, &a).y);
            (found, heights.fold(0.0, f64::max))
        });
        let name = if width > 0.0 {
            format!("{width:.0e}")
        } else {
            "exact".to_owned()
        };
        match found {
            Ok(found) => println!(
                "{name:>29} {milliseconds:9.1} {:5} {:+.2e}",
                found.iterations,
                crown - 1.558_976_5
            ),
            Err(refused) => println!("{name:>29} {milliseconds:9.1} {refused}"),
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
