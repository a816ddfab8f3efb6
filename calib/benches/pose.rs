//! A marker's pose from the emitters seen: time of one sample beside the error reached, for full weights, equal weights and
//! the closed solution alone. `cargo bench -p calib --bench pose`.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "a benchmark measures real time")]
#![allow(clippy::print_stdout, reason = "the table is what this is for")]

#[path = "../../benches/shared/trade.rs"]
mod trade;

use std::hint::black_box;
use std::time::Instant;

use calib::pose::{Body, Gates, Localizer, Sighting, solve};
use calib::registration::{Method, Pairs, fit};
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use trade::{Dial, Row, Trade, rms, turns};

const SAMPLES: usize = 1000;
/// Samples timed in a row: short enough to go undisturbed now and then on a machine that is busy.
const BATCH: usize = 40;
const ROUNDS: usize = 15;

const LOCALIZER: Localizer = Localizer {
    eye: Point::new(0.0, 0.0, 0.0),
    across_mm: 0.1,
    depth_mm: 0.45,
    at_mm: 2300.0,
    growth_across: 1.0,
    growth_depth: 2.0,
    step_mm: 0.0,
};

/// Wide open: nothing is left out.
const GATES: Gates = Gates {
    min_emitters: 4,
    max_tip_mm: 100.0,
    max_fre_mm: 100.0,
    outlier_sigmas: 100.0,
};

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }
    fn vector<F>(&mut self, size: f64) -> Vector<F> {
        let mut one = || (2.0 * self.unit() - 1.0) * size;
        Vector::new(one(), one(), one())
    }
}

struct Sample {
    truth: Rigid<Tracker, Marker>,
    seen: Vec<Sighting>,
}

fn ball(n: usize) -> Vec<Point<Marker>> {
    let at = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let (r, a) = ((1.0 - z * z).sqrt(), i as f64 * 2.399_963_229_728_653);
        Point::new(50.0 * r * a.cos(), 50.0 * r * a.sin(), 50.0 * z)
    };
    (0..n).map(at).collect()
}

fn sample(places: &[Point<Marker>], localizer: &Localizer, random: &mut Random) -> Sample {
    let away = Vector::new(0.0, 0.0, 2300.0) + random.vector(300.0);
    let truth: Rigid<Tracker, Marker> = Rigid::from_rotation_vector(random.vector(1.8), away).unwrap();
    let mut noisy = |(emitter, p): (usize, &Point<Marker>)| {
        let place = truth * *p;
        let factor = localizer.covariance_mm2(place).cholesky().unwrap();
        let off = factor.l() * nalgebra::Vector3::from_fn(|_, _| random.normal());
        Sighting {
            emitter,
            place: place + Vector::new(off.x, off.y, off.z),
        }
    };
    let seen = places.iter().enumerate().map(&mut noisy).collect();
    Sample { truth, seen }
}

/// Number of emitters with full weights, and weights with the usual 24.
fn trade(trade: &Trade) {
    let count = trade.rounds(200, SAMPLES);
    let at_tip = Point::<Marker>::new(0.0, 0.0, 300.0);
    let cases: [usize; 5] = [4, 8, 16, 24, 32];
    let made = cases.map(|n| {
        let (places, mut random) = (ball(n), Random(7));
        let samples: Vec<Sample> = (0..count).map(|_| sample(&places, &LOCALIZER, &mut random)).collect();
        (Body::of_points(&places).unwrap(), places, samples)
    });
    let by = |(body, places, samples): &(Body<Marker>, Vec<Point<Marker>>, Vec<Sample>), way: usize| -> f64 {
        let tip = |s: &Sample| match way {
            0 | 1 => {
                let localizer = if way == 0 { LOCALIZER } else { Localizer::isotropic(0.2) };
                solve(body, at_tip, &s.seen, &localizer, &GATES)
                    .unwrap()
                    .transform
                    .transform()
                    * at_tip
            }
            _ => {
                let to: Vec<Point<Tracker>> = s.seen.iter().map(|s| s.place).collect();
                fit(Pairs::new(&to, places).unwrap(), Method::Newton).unwrap().transform * at_tip
            }
        };
        rms(samples
            .iter()
            .map(|s| black_box(tip(black_box(s))).distance(s.truth * at_tip)))
    };
    let rounds = trade.rounds(1, 15);
    let mut errors = [0.0; 5];
    let times = turns(rounds, 5, |k| errors[k] = by(&made[k], 0));
    let dial = |name, chosen: &str| Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "ns a pose",
        error_unit: "mm",
        against: "root mean square at a tip 300 mm away to drawn poses; noise of 0.1 mm across and 0.45 mm along the line of sight",
    };
    let row = |k: usize, name: String, times: &[f64], errors: &[f64]| -> Row {
        (name, 1e9 * times[k] / count as f64, errors[k])
    };
    let rows: Vec<Row> = (0..5)
        .map(|k| row(k, format!("{} emitters", cases[k]), &times, &errors))
        .collect();
    trade.write(&dial("emitters", "24 emitters"), &rows);
    let times = turns(rounds, 3, |k| errors[k] = by(&made[3], k));
    let names = ["full weights", "equal weights", "closed solution"];
    let rows: Vec<Row> = (0..3).map(|k| row(k, names[k].to_owned(), &times, &errors)).collect();
    trade.write(&dial("weights", "full weights"), &rows);
}

/// Least time of a batch, ns per sample, and the root mean square error at the tip, mm.
fn measure(samples: &[Sample], mut tip: impl FnMut(&Sample) -> Point<Tracker>) -> (f64, f64) {
    let at_tip = Point::<Marker>::new(0.0, 0.0, 300.0);
    let squares: f64 = samples.iter().map(|s| tip(s).distance(s.truth * at_tip).powi(2)).sum();
    let mut least = f64::INFINITY;
    for batch in samples.chunks(BATCH).cycle().take(ROUNDS * SAMPLES / BATCH) {
        let began = Instant::now();
        batch.iter().for_each(|s| {
            black_box(tip(black_box(s)));
        });
        least = least.min(began.elapsed().as_nanos() as f64 / batch.len() as f64);
    }
    (least, (squares / samples.len() as f64).sqrt())
}

fn main() {
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade);
    }
    let (localizer, gates) = (LOCALIZER, GATES);
    let at_tip = Point::<Marker>::new(0.0, 0.0, 300.0);
    println!(
        "tip 300 mm from a ball of 50 mm, noise 0.1 mm across and 0.45 mm along the line of sight; least of {} batches",
        ROUNDS * SAMPLES / BATCH
    );
    println!("{:>9} {:<34} {:>9} {:>14}", "emitters", "", "ns", "tip rms, mm");
    for n in [4, 8, 24, 32] {
        let (places, mut random) = (ball(n), Random(7));
        let body = Body::of_points(&places).unwrap();
        let samples: Vec<Sample> = (0..SAMPLES).map(|_| sample(&places, &localizer, &mut random)).collect();
        let by = |localizer: Localizer| {
            let (body, gates) = (&body, &gates);
            move |s: &Sample| {
                solve(body, at_tip, &s.seen, &localizer, gates)
                    .unwrap()
                    .transform
                    .transform()
                    * at_tip
            }
        };
        let closed = |s: &Sample| {
            let to: Vec<Point<Tracker>> = s.seen.iter().map(|s| s.place).collect();
            fit(Pairs::new(&to, &places).unwrap(), Method::Newton)
                .unwrap()
                .transform
                * at_tip
        };
        let rows = [
            ("full weights, covariance, gates", measure(&samples, by(localizer))),
            (
                "equal weights, covariance, gates",
                measure(&samples, by(Localizer::isotropic(0.2))),
            ),
            ("closed solution alone", measure(&samples, closed)),
        ];
        for (name, (ns, mm)) in rows {
            println!("{n:>9} {name:<34} {ns:>9.0} {mm:>14.4}");
        }
    }
}
