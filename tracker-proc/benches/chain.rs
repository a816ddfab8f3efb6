//! A sample of the whole chain: processor time beside the error reached at the tip, and as the alternative the same without
//! covariances and weights, as a ratio. `cargo bench -p tracker-proc --bench chain`.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::print_stdout, reason = "the table is what this is for")]

#[path = "chain/dials.rs"]
mod dials;
#[path = "../../benches/shared/trade.rs"]
mod trade;

use std::hint::black_box;
use std::path::Path;

use calib::registration::{Method, Pairs, fit};
use geometry::{Frame as GeometryFrame, Point, Rigid, Tool, Tracker};
use rustix::time::{ClockId, clock_gettime};
use scene::{Scene, TrackerSource};
use tracker_proc::chain::{Chain, Registration};
use tracker_proc::operating_room::{Frame, OperatingRoom, Script};

const SAMPLES: u64 = 1000;
const BATCH: usize = 40;
const ROUNDS: usize = 20;

/// Processor time of this thread, ns.
fn cpu_ns() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e9 + now.tv_nsec as f64
}

/// Least and median of the batches, us a sample.
fn time(frames: &[Frame], mut work: impl FnMut(&Frame)) -> [f64; 2] {
    let mut all: Vec<f64> = frames
        .chunks(BATCH)
        .cycle()
        .take(ROUNDS * frames.len() / BATCH)
        .map(|batch| {
            let began = cpu_ns();
            batch.iter().for_each(|frame| work(black_box(frame)));
            (cpu_ns() - began) / 1e3 / batch.len() as f64
        })
        .collect();
    all.sort_by(f64::total_cmp);
    [all[0], all[all.len() / 2]]
}

/// The closed solution alone.
fn closed<F: GeometryFrame>(body: &calib::pose::Body<F>, seen: &[calib::pose::Sighting]) -> Rigid<Tracker, F> {
    let from: Vec<Point<F>> = seen.iter().map(|s| body.emitters()[s.emitter].place).collect();
    let to: Vec<Point<Tracker>> = seen.iter().map(|s| s.place).collect();
    fit(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap().transform
}

fn without_errors(chain: &Chain, frame: &Frame) -> Point<geometry::Ct> {
    let marker = closed(&chain.marker, &frame.tool);
    let tip = marker * (chain.marker_from_tool.transform() * Point::<Tool>::new(0.0, 0.0, 0.0));
    match (&chain.registration, &chain.reference) {
        (Registration::Referenced(at), Some(body)) => at.transform() * (closed(body, &frame.reference).inverse() * tip),
        (Registration::Fixed(at), _) => at.transform() * tip,
        _ => unreachable!("a reference has a body"),
    }
}

fn row(name: &str, tables: &str) {
    let text = format!(
        "[tracker]\nsource = \"operating-room\"\n[tracker.room.marker]\ncone_deg = 180\n[tracker.room.handle]\nradius_mm = 0\n{tables}"
    );
    let scene = Scene::parse(&text, Path::new("s.toml")).unwrap();
    let TrackerSource::OperatingRoom(spec) = &scene.tracker.source else {
        unreachable!("the scene says so")
    };
    let script = Script::of_room(spec, &[], None).unwrap();
    let room = OperatingRoom::new(script, spec, &scene.tracker.ct_from_tracker, 1, 60.0).unwrap();
    let chain = room.chain(Point::new(0.0, 0.0, 0.0)).unwrap();
    let frames: Vec<Frame> = (0..SAMPLES).map(|seq| room.frame(seq)).collect();
    let tip = Point::<Tool>::new(0.0, 0.0, 0.0);
    let full = |f: &Frame| chain.solve(&f.tool, &f.reference).unwrap().ct_from_tool.transform() * tip;
    let rms = |at: &dyn Fn(&Frame) -> Point<geometry::Ct>| {
        let squares: f64 = frames
            .iter()
            .map(|f| at(f).distance(f.ct_from_tool * tip).powi(2))
            .sum();
        (squares / frames.len() as f64).sqrt()
    };
    let plain = |f: &Frame| without_errors(&chain, f);
    let ([least, median], [other, _]) = (
        time(&frames, |f| {
            black_box(full(f));
        }),
        time(&frames, |f| {
            black_box(plain(f));
        }),
    );
    println!(
        "{name:<26} {least:>8.2} {median:>8.2} {:>10.4}   {other:>8.2} {:>10.4}   {:>6.2}",
        rms(&full),
        rms(&plain),
        least / other
    );
}

fn main() {
    if let Some(trade) = trade::Trade::wanted() {
        return dials::measure(&trade);
    }
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!(
        "24 emitters seen of each marker; us of processor time a sample (least, median of batches), tip rms in mm"
    );
    println!("load {load}");
    println!(
        "{:<26} {:>8} {:>8} {:>10}   {:>8} {:>10}   {:>6}",
        "", "least", "median", "tip", "closed", "tip", "ratio"
    );
    row("fixed localizer", "");
    row("marker on the patient", "[tracker.room.reference]\ncone_deg = 180\n");
}
