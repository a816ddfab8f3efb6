//! What the calibration of a marker costs and what it reaches, by the number of views.
//!
//! `cargo bench -p calib --bench bundle`. 24 diodes on a ball of 30 mm, 0.1 mm of noise per axis, 8.9 seen in a view.
//! Errors are root mean squares over the emitters and the runs after the best alignment: of the chained views, of the
//! adjustment, and as its covariance predicts. The time is the median of the runs, milliseconds per calibration.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../../benches/shared/trade.rs"]
mod trade;

use calib::bundle::{Localizer, Options, calibrate};
use calib::registration::{Method, Pairs, fit};
use common::Random;
use common::ball::{ball, poses, seen};
use geometry::{Marker, Point, Reference};
use trade::{Dial, Row, Trade, median, processor_s};

/// Mean squared error of the places after the best alignment, mm^2.
fn squared(found: &[Option<Point<Marker>>], truth: &[Point<Marker>]) -> f64 {
    let to: Vec<Point<Marker>> = found.iter().flatten().copied().collect();
    let copy = |p: &Point<Marker>| Point::<Reference>::new(p.mm()[0], p.mm()[1], p.mm()[2]);
    let from: Vec<Point<Reference>> = truth.iter().map(copy).collect();
    let pairs = Pairs::new(&to, &from).unwrap();
    fit(pairs, Method::default()).unwrap().fre_rms_mm(pairs).powi(2)
}

#[allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures time; nothing is stamped with it"
)]
fn now() -> std::time::Instant {
    std::time::Instant::now()
}

/// Views of a marker.
fn trade(trade: &Trade, options: &Options) {
    let (truth, runs) = (ball(24, 30.0), trade.rounds(3, 20));
    let row = |views: usize| -> Row {
        let (mut times, mut sum, mut count) = (Vec::new(), 0.0, 0.0);
        for seed in 0..runs {
            let mut random = Random::new((1000 * views + seed) as u64);
            let poses = poses(&mut random, views);
            let seen = seen(&mut random, &truth, &poses, [0.1; 3]);
            let began = processor_s();
            let found = calibrate(&seen, 24, options);
            times.push(1e3 * (processor_s() - began));
            // Ten views may not hang together; a hundred do.
            if let Ok(found) = found {
                (sum, count) = (sum + squared(&found.emitters, &truth), count + 1.0);
            }
        }
        (format!("{views} views"), median(times), f64::sqrt(sum / count))
    };
    let rows: Vec<Row> = [20, 50, 100, 200, 400].map(row).to_vec();
    let dial = Dial {
        name: "marker-views",
        chosen: "100 views".to_owned(),
        time_unit: "ms a calibration",
        error_unit: "mm",
        against: "root mean square over 24 planted emitters on a ball of 30 mm after the best alignment; noise 0.1 mm along each axis",
    };
    trade.write(&dial, &rows);
}

fn main() {
    let truth = ball(24, 30.0);
    // Every emitter that is seen, so that few views are refused only where they do not hang together.
    let options = Options {
        needed_views: 1,
        ..Options::new(Localizer::Isotropic { sigma_mm: 0.1 })
    };
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade, &options);
    }
    println!("views   runs  refused   chained   bundle  predicted  steps  time");
    println!("                            mm       mm         mm            ms");
    for (views, runs) in [(10, 60), (20, 60), (50, 40), (100, 30), (400, 10)] {
        let (mut sums, mut times, mut steps, mut refused) = ([0.0; 3], Vec::new(), 0, 0);
        for seed in 0..runs {
            let mut random = Random::new(1000 * views as u64 + seed);
            let poses = poses(&mut random, views);
            let views = seen(&mut random, &truth, &poses, [0.1; 3]);
            let began = now();
            let Ok(found) = calibrate(&views, 24, &options) else {
                refused += 1;
                continue;
            };
            times.push(began.elapsed().as_secs_f64() * 1e3);
            sums[0] += squared(&found.chained, &truth);
            sums[1] += squared(&found.emitters, &truth);
            sums[2] += found.predicted_rms_mm().powi(2);
            steps = steps.max(found.steps);
        }
        times.sort_by(f64::total_cmp);
        let time = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
        let [chained, bundled, predicted] = sums.map(|s| (s / times.len() as f64).sqrt());
        println!(
            "{views:5}  {runs:5}  {refused:7}  {chained:8.4} {bundled:8.4}  {predicted:9.4}  {steps:5}  {time:.2}"
        );
    }
}
