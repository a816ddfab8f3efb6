//! What one Newton iteration costs, from 100 to 100 000 unknowns, and what a frame does.
//!
//! `cargo bench -p simulation --bench cost`. Two soft rings, one in the other, at the distance at which they begin to push. Apart:
//! the solids' derivatives, detection (with the barrier's energy), the proof of how far a step may go, the search for an order
//! of elimination, factorisation and solution. Beside them the flop floor: the multiplications of the factorisation at the rate of a
//! dense product in the same run. Then five solids in a cavity whose wall moves by 1e-3 a frame, by their number of unknowns, beside
//! the 16.7 ms of 60 Hz. Tables, `out/bench/solids-cost.{csv,png}` and `solids-frames.csv`.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
mod shared;

use common::scenes::{five, guard, ring_in_ring};
use picture::chart::{Axis, COLOURS, Chart};
use shared::{least, line, now, peak, say_load, write_charts, write_csv};
use simulation::control::{Newton, Potential, Settings};
use simulation::equilibrium::{settle, settled};
use simulation::law::Law;
use simulation::sparse::{Ldl, Triplets};

/// Seconds of a frame at 60 Hz, in milliseconds.
const FRAME_MS: f64 = 1e3 / 60.0;
/// A solid's stiffness that stands for what holds the rings.
const SHIFT: f64 = 1e-3;

fn main() {
    say_load();
    let rate = peak();
    println!("dense product: {rate:.1} Gflop/s of one thread");
    let costs: Vec<Cost> = [[4, 1], [8, 1], [12, 2], [20, 3], [32, 4], [64, 8], [128, 16], [224, 28]]
        .map(|elements| Cost::of(elements, rate))
        .into();
    let frames: Vec<Frame> = [2, 3, 4, 5, 6, 8, 10].into_iter().map(Frame::of).collect();
    write_csv(
        "solids-cost",
        Cost::HEADER,
        &costs.iter().map(Cost::row).collect::<Vec<_>>(),
    );
    write_csv(
        "solids-frames",
        Frame::HEADER,
        &frames.iter().map(Frame::row).collect::<Vec<_>>(),
    );
    write_charts("solids-cost", &[cost_chart(&costs, rate), frame_chart(&frames)]);
    say_load();
}

/// One part of it.
type Part = fn(&Cost) -> f64;

/// Milliseconds of the parts of one iteration.
struct Cost {
    unknowns: usize,
    solids: f64,
    detection: f64,
    reach: f64,
    order: f64,
    factor: f64,
    solve: f64,
    mflop: f64,
    floor: f64,
    residual: f64,
}

impl Cost {
    const HEADER: &str = "unknowns,solids_ms,detection_ms,reach_ms,order_ms,factor_ms,solve_ms,iteration_ms,factor_mflop,floor_ms,residual";

    fn of(elements: [usize; 2], rate: f64) -> Self {
        let mut system = ring_in_ring(elements, 0.01, 1e-2);
        let terms = std::mem::take(&mut system.terms);
        let (a, mut matrix) = (system.initial(), Triplets::default());
        let rounds = (40_000 / a.len()).clamp(3, 50);
        let (solids, ()) = least(rounds, || system.hessian(&a, false, &mut matrix).unwrap());
        // Two states in turn: what is remembered of one is no help for the other.
        let moved: Vec<f64> = a.iter().map(|x| x + 1e-4).collect();
        let contact = terms.last().unwrap();
        let (detection, _) = least(rounds, || {
            contact.energy(&system.bodies, &moved).unwrap() + contact.energy(&system.bodies, &a).unwrap()
        });
        let step: Vec<f64> = (0..a.len()).map(|k| 1e-3 * (k as f64).sin()).collect();
        let (reach, _) = least(rounds, || contact.reach(&system.bodies, &a, &step));
        for term in &terms {
            term.hessian(&system.bodies, &a, false, &mut matrix).unwrap();
        }
        let (order, _) = least(2, || Ldl::new().factor(&matrix, SHIFT).unwrap());
        let mut ldl = Ldl::new();
        ldl.factor(&matrix, SHIFT).unwrap();
        let (factor, _) = least(rounds, || ldl.factor(&matrix, SHIFT).unwrap());
        let mut x = vec![1.0; a.len()];
        let (solve, ()) = least(rounds, || {
            x.fill(1.0);
            ldl.solve(&mut x);
        });
        let left = matrix.product(&x).into_iter().zip(&x);
        let residual = left.map(|(y, x)| (y + SHIFT * x - 1.0).abs()).fold(0.0, f64::max);
        let mflop = 2e-6 * ldl.work() as f64;
        let cost = Self {
            unknowns: a.len(),
            solids,
            detection: 0.5 * detection,
            reach,
            order: order - factor,
            factor,
            solve,
            mflop,
            floor: mflop / rate,
            residual,
        };
        println!("{}", cost.row());
        cost
    }

    /// An iteration with a known pattern and one factorisation.
    fn iteration(&self) -> f64 {
        self.solids + self.detection + self.reach + self.factor + self.solve
    }

    fn row(&self) -> String {
        format!(
            "{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.3},{:.5},{:.0e}",
            self.unknowns,
            self.solids,
            self.detection,
            self.reach,
            self.order,
            self.factor,
            self.solve,
            self.iteration(),
            self.mflop,
            self.floor,
            self.residual
        )
    }
}

fn cost_chart(costs: &[Cost], rate: f64) -> Chart {
    let mut chart = Chart::new(
        format!("One Newton iteration, one thread; floor: factorisation at {rate:.0} Gflop/s"),
        Axis::log("unknowns").within(50.0, 200_000.0),
        Axis::log("processor time, ms"),
    );
    let parts: [(&str, Part); 7] = [
        ("iteration", Cost::iteration),
        ("solids' derivatives", |c| c.solids),
        ("factorisation", |c| c.factor),
        ("order of elimination (new pattern)", |c| c.order),
        ("solution", |c| c.solve),
        ("detection and barrier", |c| c.detection),
        ("how far a step may go", |c| c.reach),
    ];
    for (k, (name, part)) in parts.into_iter().enumerate() {
        let colour = COLOURS[(k + 6) % COLOURS.len()];
        chart.push(line(name, colour, costs.iter().map(|c| [c.unknowns as f64, part(c)])));
    }
    let floor = costs.iter().map(|c| [c.unknowns as f64, c.floor]);
    chart.push(line("flop floor of the factorisation", COLOURS[5], floor).dashed());
    chart
}

/// Frames of five solids of `k` x `k` elements.
struct Frame {
    unknowns: usize,
    median: f64,
    late: f64,
    steps: f64,
}

impl Frame {
    const HEADER: &str = "unknowns,median_ms,p95_ms,steps";

    fn of(k: usize) -> Self {
        let width = 1e-2;
        let mut system = five(k, Law::NeoHookean, width);
        let mut a = system.initial();
        settled(&mut system, &mut a).unwrap();
        let mut newton = Newton::new(Settings::default());
        let (mut times, mut steps, frames) = (Vec::new(), 0, 30);
        for frame in 1..=frames {
            // The right wall is the third of the planes; the barrier between the solids comes last.
            let pairs = system.terms.pop().unwrap();
            system.terms.pop();
            guard(&mut system, (-1.0, 0.0), -1.6 + 1e-3 * f64::from(frame), width);
            system.terms.push(pairs);
            let began = now();
            let found = settle(&mut system, &mut newton, &mut a).unwrap();
            times.push(1e3 * (now() - began));
            steps += found.iterations;
        }
        times.sort_by(f64::total_cmp);
        let found = Self {
            unknowns: a.len(),
            median: times[times.len() / 2],
            late: times[times.len() * 95 / 100],
            steps: steps as f64 / f64::from(frames),
        };
        println!("frames: {}", found.row());
        found
    }

    fn row(&self) -> String {
        format!(
            "{},{:.3},{:.3},{:.1}",
            self.unknowns, self.median, self.late, self.steps
        )
    }
}

fn frame_chart(frames: &[Frame]) -> Chart {
    let mut chart = Chart::new(
        "Five solids, a wall moves by 1e-3 a frame (behind the barrier of 1e-2)",
        Axis::log("unknowns"),
        Axis::log("processor time of a frame, ms"),
    );
    let each = |part: fn(&Frame) -> f64| frames.iter().map(move |f| [f.unknowns as f64, part(f)]);
    chart.push(line("median", COLOURS[0], each(|f| f.median)));
    chart.push(line("95 %", COLOURS[1], each(|f| f.late)));
    chart.push(line("60 Hz", COLOURS[2], each(|_| FRAME_MS)).dashed());
    chart
}
