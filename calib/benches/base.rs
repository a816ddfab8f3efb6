//! What locating the calibration base costs and what it reaches.
//!
//! `cargo bench -p calib --bench base`. Three grooves of 45 mm, a pointer with 0.2 mm of noise per axis; the error is the
//! root mean square at a point 80 mm above the plate, counted and as the covariance predicts. The time is the median of
//! the runs, microseconds: with labels, without, and for one heap of touches.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../../benches/shared/trade.rs"]
mod trade;

use calib::base::{Group, Located, Options, locate, separate};
use common::Random;
use common::plate::{Touching, pose, uneven, unlabelled};
use geometry::{Base, Point, Tracker};
use trade::{Dial, Row, Trade, median, processor_s};

const SIGMA: f64 = 0.2;
const RUNS: usize = 300;

#[allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures time; nothing is stamped with it"
)]
fn now() -> std::time::Instant {
    std::time::Instant::now()
}

type Way = fn(&[Group<Tracker>]) -> Located<Tracker>;

fn labelled(groups: &[Group<Tracker>]) -> Located<Tracker> {
    locate(&uneven(), groups, &Options::new(SIGMA)).unwrap()
}

fn searched(groups: &[Group<Tracker>]) -> Located<Tracker> {
    locate(&uneven(), &unlabelled(groups), &Options::new(SIGMA)).unwrap()
}

fn heaped(groups: &[Group<Tracker>]) -> Located<Tracker> {
    let heap: Vec<Point<Tracker>> = groups.iter().flat_map(|g| g.touches.clone()).collect();
    let groups = separate(&heap, 6.0 * SIGMA).unwrap();
    locate(&uneven(), &groups, &Options::new(SIGMA)).unwrap()
}

/// Touches of the plate and of each groove.
fn trade(trade: &Trade) {
    let (drawing, target) = (uneven(), Point::<Base>::new(0.0, 0.0, 80.0));
    let runs = trade.rounds(5, RUNS);
    let row = |counts: [usize; 2]| -> Row {
        let touching = Touching {
            drawing: &drawing,
            tip_radius: 0.0,
            sigma: SIGMA,
            counts,
        };
        let (mut random, mut times, mut squares) = (Random::new(1), Vec::new(), 0.0);
        for _ in 0..runs {
            let truth = pose(&mut random);
            let groups = touching.groups(&mut random, truth);
            let began = processor_s();
            let found = labelled(&groups);
            times.push(1e6 * (processor_s() - began));
            squares += (found.place.transform() * target).distance(truth * target).powi(2);
        }
        (
            format!("{} + 3 x {}", counts[0], counts[1]),
            median(times),
            (squares / runs as f64).sqrt(),
        )
    };
    let rows: Vec<Row> = [[10, 5], [20, 10], [50, 25], [100, 50]].map(row).to_vec();
    let dial = Dial {
        name: "base-touches",
        chosen: "20 + 3 x 10".to_owned(),
        time_unit: "us a calibration",
        error_unit: "mm",
        against: "root mean square 80 mm above the plate to drawn poses; touches with noise of 0.2 mm along each axis",
    };
    trade.write(&dial, &rows);
}

fn main() {
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade);
    }
    let drawing = uneven();
    let target = Point::<Base>::new(0.0, 0.0, 80.0);
    println!("touches       way        error mm  predicted mm  condition  time us");
    let ways: [(&str, Way); 3] = [("labelled", labelled), ("searched", searched), ("one heap", heaped)];
    for counts in [[20, 10], [100, 50]] {
        let touching = Touching {
            drawing: &drawing,
            tip_radius: 0.0,
            sigma: SIGMA,
            counts,
        };
        for (name, way) in ways {
            let mut random = Random::new(1);
            let (mut squares, mut times, mut condition) = ([0.0; 2], Vec::new(), 0.0);
            for _ in 0..RUNS {
                let truth = pose(&mut random);
                let groups = touching.groups(&mut random, truth);
                let began = now();
                let found = way(&groups);
                times.push(began.elapsed().as_secs_f64() * 1e6);
                squares[0] += (found.place.transform() * target).distance(truth * target).powi(2);
                squares[1] += (found.place * target).rms_mm().powi(2);
                condition = found.condition;
            }
            times.sort_by(f64::total_cmp);
            let [error, predicted] = squares.map(|s| (s / RUNS as f64).sqrt());
            println!(
                "{:3} + 3 x {:2}  {name:9}  {error:8.4}  {predicted:12.4}  {condition:9.2}  {:7.0}",
                counts[0],
                counts[1],
                times[RUNS / 2]
            );
        }
    }
}
