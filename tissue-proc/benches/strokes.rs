//! States of the shipped scene's kidney from pose to pose: in, held, aside, along and out, at several speeds.
//!
//! `cargo bench -p tissue-proc --bench strokes [-- 9 20 100 truth tolerance=1e-3]`: speeds in mm/s; `truth` compares each settled state with one of
//! 1e-8 from pose to pose, at places inside and at nodes; results in `out/bench/tissue-strokes.csv`, one line a frame.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::disallowed_methods, reason = "measures wall time")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "strokes/dials.rs"]
mod dials;
#[path = "strokes/motion.rs"]
mod motion;
#[path = "strokes/organ.rs"]
mod organ;
#[path = "../../benches/shared/trade.rs"]
mod trade;

use motion::{Noise, RATE, stroke};
use nalgebra::{Isometry3, Vector3};
use organ::{Shipped, Targets, pose};
use simulation::space::frames::{Frame, Frames, Settings, State};

const HEADER: &str = "speed,frame,phase,ms,wall_ms,state,steps,contact_steps,factor,residual,unsettled,off,nodes_off,force,det,points,depth";

/// Where the tip first touches, mm from the entry; how deep it goes, and across.
const TOUCH: f64 = 55.0;
const DEPTH: f64 = 20.0;
const ACROSS: f64 = 5.0;
/// What a state is compared with is given so many frames.
const MOST_FRAMES: usize = 20;

fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn load() -> String {
    std::fs::read_to_string("/proc/loadavg")
        .unwrap_or_default()
        .trim()
        .to_owned()
}

fn name(state: &State) -> &'static str {
    match state {
        State::Settled => "settled",
        State::Approximate => "approximate",
        State::CatchingUp { .. } => "catching",
        State::Refused(_) => "refused",
    }
}

/// How far nodes of two states, and places inside, lie apart at most along an axis, mm.
fn apart(a: &[f64], b: &[f64], places: &Targets) -> [f64; 2] {
    let nodes = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (of_a, of_b) = (places.moved(a), places.moved(b));
    let inside = of_a.iter().zip(of_b).map(|(a, b)| (a - b).amax());
    [nodes, inside.fold(0.0, f64::max)]
}

/// The state at a pose to the truth's own tolerance, in as many frames as it takes; whether it came there.
fn settle(truth: &mut Frames, pose: &Isometry3<f64>) -> bool {
    (0..MOST_FRAMES).any(|_| truth.frame(pose).state == State::Settled)
}

struct Row {
    phase: &'static str,
    ms: f64,
    frame: Frame,
    /// How far nodes and places inside are from the truth, mm; `None` where that was not found.
    off: Option<[f64; 2]>,
    pressed: bool,
}

fn say(speed: f64, phase: &str, rows: &[&Row]) {
    let mut ms: Vec<f64> = rows.iter().map(|r| r.ms).collect();
    ms.sort_by(f64::total_cmp);
    let at = |part: f64| ms[((ms.len() as f64 * part) as usize).min(ms.len() - 1)];
    let sum = |f: &dyn Fn(&Row) -> usize| rows.iter().map(|r| f(r)).sum::<usize>() as f64 / rows.len() as f64;
    let settled = rows.iter().filter(|r| r.frame.state == State::Settled).count();
    let offs: Vec<(f64, [f64; 2])> = rows.iter().filter_map(|r| Some((r.frame.unsettled, r.off?))).collect();
    let small = offs.iter().filter(|(unsettled, [_, off])| off > unsettled).count();
    let [nodes, off] = [0, 1].map(|k| offs.iter().map(|(_, off)| off[k]).fold(0.0, f64::max));
    let unsettled = rows.iter().map(|r| r.frame.unsettled).fold(0.0, f64::max);
    println!(
        "{speed:5} mm/s {phase:7} {:4} frames, {settled:4} settled, {:4.1} steps, {:5.1} in contact: {:6.1} / {:6.1} / {:6.1} ms; unsettled <= {unsettled:.1e}; {} beside the truth: places inside off <= {off:.1e} mm, more than unsettled in {small}; nodes <= {nodes:.1e}",
        rows.len(),
        sum(&|r| r.frame.steps),
        sum(&|r| r.frame.contact_steps),
        at(0.5),
        at(0.95),
        at(1.0),
        offs.len(),
    );
}

/// Places as a hand makes them; with the tracker's noise.
fn run(
    mut truth: Option<&mut Frames>,
    frames: &mut Frames,
    organ: (&organs::Way, &Targets),
    speed: f64,
    csv: &mut Vec<String>,
) {
    let (way, places) = organ;
    let across = way
        .direction
        .cross(&Vector3::ith(way.direction.imin(), 1.0))
        .normalize();
    let other = way.direction.cross(&across);
    let (mut noise, mut rows) = (Noise(1), Vec::new());
    let (before, mut due) = (load(), std::time::Instant::now());
    for (k, place) in stroke(TOUCH, DEPTH, ACROSS, 0.7, speed).into_iter().enumerate() {
        let aside = across * place.aside[0] + other * place.aside[1] + noise.vector(0.05);
        let pose = pose(way, place.gone, &aside);
        std::thread::sleep(due.saturating_duration_since(std::time::Instant::now()));
        due = std::time::Instant::now() + std::time::Duration::from_secs_f64(1.0 / RATE);
        let (began, clock) = (now(), std::time::Instant::now());
        let frame = frames.frame(&pose);
        let (ms, wall) = (1e3 * (now() - began), 1e3 * clock.elapsed().as_secs_f64());
        let truth = truth.as_mut().filter(|_| frame.state == State::Settled);
        let off = truth.and_then(|truth| settle(truth, &pose).then(|| apart(frames.state(), truth.state(), places)));
        let [nodes, inside] = off.unwrap_or([f64::NAN; 2]);
        csv.push(format!(
            "{speed},{k},{},{ms:.3},{wall:.3},{},{},{},{},{:.2e},{:.2e},{inside:.2e},{nodes:.2e},{:.4},{:.3},{},{:.1e}",
            place.phase,
            name(&frame.state),
            frame.steps,
            frame.contact_steps,
            frame.factor,
            frame.residual,
            frame.unsettled,
            frame.force.force.norm(),
            frame.least_determinant,
            frame.force.points,
            frame.depth
        ));
        rows.push(Row {
            phase: place.phase,
            ms,
            pressed: frame.force.points > 0,
            frame,
            off,
        });
    }
    for phase in ["press", "hold", "slide", "along", "out"] {
        let of: Vec<&Row> = rows.iter().filter(|r| r.phase == phase).collect();
        say(speed, phase, &of);
    }
    let pressed: Vec<&Row> = rows.iter().filter(|r| r.pressed).collect();
    say(speed, "pressed", &pressed);
    println!(
        "  factors {}, load {before} to {}",
        rows[rows.len() - 1].frame.factor,
        load()
    );
}

fn main() {
    if let Some(trade) = trade::Trade::wanted() {
        return dials::measure(&trade);
    }
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let number = |name: &str, usual: f64| {
        let found = words
            .iter()
            .find_map(|w| w.strip_prefix(name)?.strip_prefix('=')?.parse().ok());
        found.unwrap_or(usual)
    };
    let usual = Settings::default();
    let settings = Settings {
        tolerance: number("tolerance", usual.tolerance),
        refresh: number("refresh", usual.refresh),
        delay: number("delay", usual.delay as f64) as usize,
        ..usual
    };
    let truth = Settings {
        tolerance: 1e-8,
        depth: 1e-7,
        delay: 0,
        most_steps: 40,
        ..settings
    };
    let speeds: Vec<f64> = words.iter().filter_map(|w| w.parse().ok()).collect();
    let speeds = if speeds.is_empty() {
        vec![9.0, 20.0, 100.0]
    } else {
        speeds
    };
    let with_truth = words.iter().any(|w| w == "truth");
    let shipped = Shipped::read();
    let model = shipped.model();
    let places = Shipped::places(&model);
    let mut csv = vec![HEADER.to_owned()];
    for speed in speeds {
        let (mut frames, way, _) = shipped.frames(&model, &settings);
        let mut truth = with_truth.then(|| shipped.frames(&model, &truth).0);
        println!("{} unknowns", frames.state().len());
        run(truth.as_mut(), &mut frames, (&way, &places), speed, &mut csv);
    }
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../out/bench");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("tissue-strokes.csv"), csv.join("\n") + "\n").unwrap();
}
