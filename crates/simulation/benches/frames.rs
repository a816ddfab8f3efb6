//! Tissue from frame to frame: a block pushed by a tube, in and out, at several sizes of mesh and speeds.
//!
//! The named alternative, in the same run on the same mesh: Newton's method from the last state with new factors at every step and the
//! same tolerance (`settle`). Errors are differences to states of `settle` at 1e-8.
//!
//! `cargo bench -p simulation --bench frames [-- 20mm_s 100mm_s jump kidney]`; results in `out/bench/solids-frames.csv`.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "measures wall time")]

#[path = "../tests/space/block.rs"]
mod block;
#[path = "assembly/regions.rs"]
mod regions;
mod shared;

use std::time::{Duration, Instant};

use block::{Grid, pose};
use nalgebra::{Isometry3, Point3, Vector3};
use shared::{now, say_load, write_csv};
use simulation::control::{Newton, Settings as Control};
use simulation::law::Law;
use simulation::space::cells::{LabelField, Mesh, Settings as Cells};
use simulation::space::equilibrium::{Tolerance, settle};
use simulation::space::frames::{Frame, Frames, Settings, State};
use simulation::space::law::Material;
use simulation::space::solid::Deformable;
use simulation::space::system::System;
use simulation::space::term::{Springs, TubeContact};
use simulation::space::tube::Tube;
use simulation::sparse::Dissection;

const HEADER: &str = "unknowns,mm_s,frames,not_settled,steps,cpu_median_ms,cpu_95_ms,cpu_worst_ms,clock_median_ms,clock_95_ms,clock_worst_ms,force_off_n,places_off_mm,newton_ms";

/// Depth of a stroke, mm, and frames in a second.
const STROKE: f64 = 20.0;
const RATE: f64 = 60.0;
/// Points of the top up to here from the middle may be touched, mm.
const REACH: f64 = 25.0;

const GRIDS: [Grid; 4] = [
    Grid {
        side: 100.0 / 3.0,
        fine: &[30.0, 14.0],
    },
    Grid {
        side: 20.0,
        fine: &[30.0],
    },
    Grid {
        side: 25.0,
        fine: &[40.0, 16.0],
    },
    Grid {
        side: 25.0,
        fine: &[40.0, 25.0],
    },
];

/// Depths of a stroke in and out.
fn stroke(speed: f64) -> Vec<f64> {
    let step = speed / RATE;
    let count = (STROKE / step).round() as usize;
    let there = (1..=count).map(|k| k as f64 * step);
    let back = (0..count).rev().map(|k| k as f64 * step);
    there.chain(back).collect()
}

/// Milliseconds of the thread's processor and of the clock, sorted.
struct Times {
    cpu: Vec<f64>,
    wall: Vec<f64>,
}

impl Times {
    fn of<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (cpu, wall) = (now(), Instant::now());
        let result = work();
        self.cpu.push(1e3 * (now() - cpu));
        self.wall.push(1e3 * wall.elapsed().as_secs_f64());
        result
    }

    /// Median, 95 % and worst.
    fn three(mut times: Vec<f64>) -> [f64; 3] {
        times.sort_by(f64::total_cmp);
        [times.len() / 2, times.len() * 95 / 100, times.len() - 1].map(|k| times[k])
    }
}

/// The same states by `settle`, from one to the next.
struct Alternative {
    system: System,
    newton: Newton,
    a: Vec<f64>,
    tolerance: Tolerance,
}

impl Alternative {
    fn new(grid: Grid, nu: f64, tolerance: f64) -> Self {
        let mut system = block::block(grid, nu);
        // Some ten times Young's modulus over the side of the finest cubes.
        let contact = TubeContact::new(&system.bodies, 0, block::tube(), 0.05, block::top(REACH)).unwrap();
        system.tubes.push(contact);
        let control = Control {
            provisional: true,
            tolerance,
            ..Control::default()
        };
        Self {
            a: system.initial(),
            newton: Newton::ordered_by(control, Dissection::by_places(&system.places(), &[]).unwrap()),
            system,
            tolerance: Tolerance {
                change: tolerance,
                depth: tolerance.min(1e-5),
            },
        }
    }

    /// The force on the tube along its axis; none where the search failed.
    fn to(&mut self, pose: &Isometry3<f64>) -> Option<f64> {
        let tube = block::tube().at(*pose).unwrap();
        self.system.tubes[0].move_to(tube);
        settle(&mut self.system, &mut self.newton, &mut self.a, &self.tolerance).ok()?;
        Some(self.system.tubes[0].force(&self.system.bodies, &self.a).force.z)
    }
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Strokes in and out at a speed; a line of the table.
fn strokes(grid: Grid, speed: f64, settings: Settings, rows: &mut Vec<String>) {
    let mut frames = block::frames(grid, 0.49, REACH, settings);
    let mut times = Times {
        cpu: Vec::new(),
        wall: Vec::new(),
    };
    let (mut steps, mut failed, mut worst) = (0, 0, [0.0_f64; 2]);
    let depths = stroke(speed);
    let mut truth = Alternative::new(grid, 0.49, 1e-8);
    let (mut alternative, mut other) = (
        Alternative::new(grid, 0.49, settings.tolerance),
        Times {
            cpu: Vec::new(),
            wall: Vec::new(),
        },
    );
    let every = (depths.len() / 12).max(1);
    let mut due = Instant::now();
    for (k, depth) in depths.iter().enumerate() {
        let pose = pose(*depth, 0.0, 0.0);
        // A frame begins when its pose comes: the other thread has until then.
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        due = Instant::now() + Duration::from_secs_f64(1.0 / RATE);
        let frame: Frame = times.of(|| frames.frame(&pose));
        steps += frame.steps;
        failed += usize::from(frame.state != State::Settled);
        // Not every frame: the alternative takes a second and more at each.
        if k % every == every - 1 {
            let force = truth.to(&pose).unwrap();
            worst[0] = worst[0].max((frame.force.force.z - force).abs());
            worst[1] = worst[1].max(largest(frames.state(), &truth.a));
        }
        if k < 6 {
            other.of(|| alternative.to(&pose));
        }
    }
    let count = depths.len();
    let [cpu, wall, alternative] = [times.cpu, times.wall, other.cpu].map(Times::three);
    println!(
        "{:6} unknowns, {speed:5.0} mm/s, {count:3} frames, {failed} not settled, {:.1} steps: cpu {:.1} / {:.1} / {:.1} ms, clock {:.1} / {:.1} / {:.1} ms; \
         force off by {:.1e} N, places by {:.1e} mm; Newton {:.0} ms a frame: {:.1}x",
        frames.state().len(),
        steps as f64 / count as f64,
        cpu[0],
        cpu[1],
        cpu[2],
        wall[0],
        wall[1],
        wall[2],
        worst[0],
        worst[1],
        alternative[0],
        alternative[0] / cpu[0],
    );
    rows.push(format!(
        "{},{speed},{count},{failed},{},{},{},{},{},{},{},{},{},{}",
        frames.state().len(),
        steps as f64 / count as f64,
        cpu[0],
        cpu[1],
        cpu[2],
        wall[0],
        wall[1],
        wall[2],
        worst[0],
        worst[1],
        alternative[0],
    ));
}

/// A tube that is all at once deep in the block: frames until it is there, and their times.
fn jump(grid: Grid, depth: f64, settings: Settings) {
    let mut frames: Frames = block::frames(grid, 0.49, REACH, settings);
    let mut times = Times {
        cpu: Vec::new(),
        wall: Vec::new(),
    };
    let target = pose(depth, 0.0, 0.0);
    let last = (0..100).find_map(|_| {
        let frame = times.of(|| frames.frame(&target));
        (!matches!(frame.state, State::CatchingUp { .. })).then_some(frame)
    });
    let total: f64 = times.wall.iter().sum();
    println!(
        "{:6} unknowns, {depth} mm at once: {:?} after {} frames, {total:.0} ms, {:.4} N",
        frames.state().len(),
        last.map(|f| f.state),
        times.wall.len(),
        frames.force().force.z
    );
}

/// A kidney of 5 kPa on a bed, pushed from the side by a tube of 10 mm; smaller cubes about its tip.
fn kidney(field: &LabelField) -> Frames {
    let whole = Mesh::new(field, field.corners, &Cells::of_side(12.0), &|_, _| false).unwrap();
    let right = whole
        .surface
        .iter()
        .max_by(|a, b| a.at.x.total_cmp(&b.at.x))
        .unwrap()
        .at;
    let middle = 0.5 * (field.corners[0].x + field.corners[1].x);
    let near = |low: &Vector3<f64>, high: &Vector3<f64>| (right.sup(low).inf(high) - right).norm() < 12.0;
    let settings = Cells {
        levels: 1,
        ..Cells::of_side(12.0)
    };
    let mesh = Mesh::new(field, field.corners, &settings, &near).unwrap();
    let mut system = System::new();
    let material = Material::new(Law::NeoHookean, 5e-3, 0.49).unwrap();
    system.add(Deformable::new(mesh, material, Vector3::zeros()).unwrap());
    let bed = Springs::new(&system.bodies, 0, |x, _| if x.x < middle { 0.005 } else { 0.0 }, |x| *x);
    system.others.push(Box::new(bed));
    let tip = Point3::new(right.x + 5.0, right.y, right.z);
    let tube = Tube::straight(tip, Vector3::x(), 200.0, 5.0).unwrap();
    let a = system.initial();
    let wanted = |x: &Vector3<f64>, _: &Vector3<f64>| (x - right).norm() < 22.0;
    Frames::new(system, a, 0, tube, Settings::default(), wanted).unwrap()
}

/// The kidney pushed 20 mm in and out at 20 mm/s.
fn strokes_of_kidney(field: &LabelField) {
    let mut frames = kidney(field);
    let start = *frames.tube().pose();
    let mut times = Times {
        cpu: Vec::new(),
        wall: Vec::new(),
    };
    let (mut steps, mut unsettled, mut least, mut force) = (0, 0, f64::INFINITY, Vec::new());
    let mut due = Instant::now();
    for depth in stroke(20.0) {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        due = Instant::now() + Duration::from_secs_f64(1.0 / RATE);
        let mut pose = start;
        pose.translation.vector.x -= depth;
        let frame = times.of(|| frames.frame(&pose));
        steps += frame.steps;
        unsettled += usize::from(frame.state != State::Settled);
        if frame.state != State::Settled {
            println!("  {depth:.2} mm: {:?}, residual {:.1e}", frame.state, frame.residual);
        }
        least = f64::min(least, frame.least_determinant);
        force.push(frame.force.force.norm());
    }
    let count = times.cpu.len();
    let [cpu, wall] = [times.cpu, times.wall].map(Times::three);
    println!(
        "kidney, {:6} unknowns, 20 mm/s, {count} frames, {unsettled} not settled, {:.1} steps: cpu {:.1} / {:.1} / {:.1} ms, clock {:.1} / {:.1} / {:.1} ms; \
         least det F {least:.2}, force at 5, 10, 15, 20 mm {:.3} {:.3} {:.3} {:.3} N, at the end {:.1e} N",
        frames.state().len(),
        steps as f64 / count as f64,
        cpu[0],
        cpu[1],
        cpu[2],
        wall[0],
        wall[1],
        wall[2],
        force[14],
        force[29],
        force[44],
        force[59],
        force[count - 1],
    );
}

fn main() {
    say_load();
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let does = |name: &str| wanted.is_empty() || wanted.iter().any(|w| w == name);
    let mut rows = Vec::new();
    for grid in GRIDS {
        for (name, speed) in [("20mm_s", 20.0), ("100mm_s", 100.0)] {
            if does(name) {
                strokes(grid, speed, Settings::default(), &mut rows);
            }
        }
        if does("jump") {
            jump(grid, STROKE, Settings::default());
        }
    }
    if does("kidney") {
        match regions::kidney() {
            Some(field) => strokes_of_kidney(&field),
            None => println!("no kidney: TROCAR_SHARED does not name its folder"),
        }
    }
    say_load();
    write_csv("solids-frames", HEADER, &rows);
}
