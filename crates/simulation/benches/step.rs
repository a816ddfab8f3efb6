//! One step of Newton's method on a block of some 105 000 unknowns: assembly, factorisation, solution.
//!
//! `cargo bench -p simulation --bench step [-- CELLS]`; results in `out/bench/solids-step.csv`. A cube of 16^3 hexahedra of 27 nodes on
//! the ground, neo-Hookean, nu = 0.49, bent. The named alternative, in the same run on the same matrix: factors in double precision by
//! one thread. Times are of the processors, the least of the rounds, and of the clock where that is said; residuals are the largest of what a solution leaves, beside the largest force.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/space/block.rs"]
#[allow(dead_code, reason = "only the block is asked for")]
mod block;
mod shared;

use std::num::NonZeroUsize;

use block::Grid;
use rustix::time::{ClockId, clock_gettime};
use shared::{peak, say_load, write_csv};
use simulation::control::Potential;
use simulation::space::system::System;
use simulation::sparse::{Dissection, Ldl, Precision, Triplets};

const ROUNDS: usize = 3;
/// Solutions with the residual in double precision at most, and the residual that ends them.
const REFINEMENTS: usize = 8;
const WANTED: f64 = 1e-10;

const HEADER: &str = "unknowns,precision,threads,symbolic_s,assembly_s,taken_up_s,factor_s,factor_clock_s,gflops,solve_s,solves,residual,step_s,step_clock_s";

fn main() {
    say_load();
    let cells: usize = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(16);
    let mut step = Step::new(cells);
    println!(
        "{} unknowns; dense product: {:.1} Gflop/s of one thread",
        step.right.len(),
        peak()
    );
    println!("{HEADER}");
    let cases = [
        ("double", Precision::Double, 1),
        ("double", Precision::Double, 2),
        ("single throughout", Precision::SingleThroughout, 1),
        ("single throughout", Precision::SingleThroughout, 2),
    ];
    let rows: Vec<String> = cases
        .into_iter()
        .map(|(name, precision, threads)| step.row(name, precision, threads))
        .collect();
    write_csv("solids-step", HEADER, &rows);
    say_load();
}

/// The least seconds of some rounds: of the clock, and of all processors that work for this program.
fn seconds(rounds: usize, mut work: impl FnMut()) -> [f64; 2] {
    let clocks = || {
        [ClockId::Monotonic, ClockId::ProcessCPUTime].map(|clock| {
            let time = clock_gettime(clock);
            time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
        })
    };
    let mut least = [f64::INFINITY; 2];
    for _ in 0..rounds {
        let began = clocks();
        work();
        let ended = clocks();
        least = std::array::from_fn(|k| least[k].min(ended[k] - began[k]));
    }
    least
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// The block, a state of it, and a right side.
struct Step {
    system: System,
    a: Vec<f64>,
    matrix: Triplets,
    right: Vec<f64>,
}

impl Step {
    fn new(cells: usize) -> Self {
        let side = 2.0 * 50.0 / cells as f64;
        let system = block::block(Grid { side, fine: &[] }, 0.49);
        let size = system.initial().len();
        // Bent to the side, every layer shifted as a whole: no volume changes, and the matrix is definite.
        let places = system.places();
        let a: Vec<f64> = (0..size)
            .map(|k| {
                if k % 3 == 0 {
                    10.0 * (places[k][2] / block::HEIGHT).powi(2)
                } else {
                    0.0
                }
            })
            .collect();
        let right = (0..size)
            .map(|k| if system.fixed[k] { 0.0 } else { (0.37 * k as f64).sin() })
            .collect();
        Self {
            matrix: Triplets::new(size),
            system,
            a,
            right,
        }
    }

    fn assemble(&mut self) {
        self.system.hessian(&self.a, false, &mut self.matrix).unwrap();
        let scale = largest(&self.matrix.diagonal());
        self.matrix.fix(self.system.fixed(), scale);
    }

    fn row(&mut self, name: &str, precision: Precision, threads: usize) -> String {
        let assembly = seconds(ROUNDS, || self.assemble());
        let mut ldl = Ldl::ordered_by(Dissection::by_places(&self.system.places(), &[]).unwrap());
        ldl.set_precision(precision);
        ldl.set_threads(NonZeroUsize::new(threads).unwrap());
        let symbolic = seconds(1, || ldl.take(&self.matrix));
        let taken = seconds(ROUNDS, || ldl.take(&self.matrix));
        let factor = seconds(ROUNDS, || assert!(ldl.definite(0.0).unwrap()));
        let mut solved = (0, 0.0);
        let solve = seconds(ROUNDS, || solved = self.solve(&ldl));
        // The factorisation alone takes several processors.
        let step: [f64; 2] = std::array::from_fn(|k| assembly[k] + taken[k] + factor[k] + solve[k]);
        let row = format!(
            "{},{name},{threads},{:.2},{:.3},{:.3},{:.3},{:.3},{:.1},{:.3},{},{:.1e},{:.3},{:.3}",
            self.right.len(),
            symbolic[1],
            assembly[1],
            taken[1],
            factor[1],
            factor[0],
            2e-9 * ldl.work() as f64 / factor[1],
            solve[1],
            solved.0,
            solved.1,
            step[1],
            step[0],
        );
        println!("{row}");
        println!(
            "  entries of L {:.3e}, multiplications {:.3e}",
            ldl.fill() as f64,
            ldl.work() as f64
        );
        row
    }

    /// Solutions until little is left: how many, and what is left.
    fn solve(&self, ldl: &Ldl) -> (usize, f64) {
        let mut x = vec![0.0; self.right.len()];
        let mut left = self.right.clone();
        for count in 1..=REFINEMENTS {
            ldl.solve(&mut left);
            x.iter_mut().zip(&left).for_each(|(x, d)| *x += d);
            left = self.matrix.product(&x);
            left.iter_mut().zip(&self.right).for_each(|(y, b)| *y = b - *y);
            let residual = largest(&left) / largest(&self.right);
            if residual <= WANTED || count == REFINEMENTS {
                return (count, residual);
            }
        }
        (REFINEMENTS, f64::NAN)
    }
}
