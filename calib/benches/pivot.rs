//! What a pivot calibration costs and how near it comes, by method.
//!
//! `cargo bench -p calib --bench pivot`. Tip at 160 mm, noise of 0.1 mm and 0.2 degrees, cones of 5 and 30 degrees, with and
//! without a tenth of the poses slipped by 10 mm. Times are the lowest quartile of the rounds, microseconds per
//! calibration with residuals and covariance; the error is the root mean square distance of the tip over the recordings.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

#[path = "../../benches/shared/trade.rs"]
mod trade;

use std::f64::consts::TAU;
use std::hint::black_box;

use calib::pivot::{Method, Options, PoseNoise, calibrate};
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use trade::{Dial, Row, Trade, rms, turns};

const RECORDINGS: usize = 40;
const ROUNDS: usize = 10;
const TIP: Point<Marker> = Point::new(0.0, 0.0, 160.0);

const NOISE: PoseNoise = PoseNoise {
    sigma_mm: 0.1,
    sigma_rad: 0.2_f64.to_radians(),
};

type Pose = Rigid<Tracker, Marker>;

/// Numbers the same in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (TAU * self.unit()).cos()
    }

    fn noise(&mut self, sigma: f64) -> [f64; 3] {
        [(); 3].map(|()| sigma * self.normal())
    }
}

fn turn(v: [f64; 3]) -> Rotation {
    RotationVector::new(v).map_or(Rotation::IDENTITY, Rotation::from_vector)
}

fn pose(random: &mut Random, cone_deg: f64, noise: &PoseNoise, slipped: bool) -> Pose {
    let (tilt, side) = (cone_deg.to_radians() * random.unit().sqrt(), TAU * random.unit());
    let exact = turn([0.3, 2.1, -0.4]) * turn([tilt * side.cos(), tilt * side.sin(), 0.0]);
    let lever = Pose::from_parts(exact, Vector::new(0.0, 0.0, 0.0)) * TIP;
    let [x, y, z] = random.noise(noise.sigma_mm);
    let slip = if slipped { 10.0 } else { 0.0 };
    let t = Point::new(100.0 + x + slip, y, 2000.0 + z) - lever;
    Pose::from_parts(turn(random.noise(noise.sigma_rad)) * exact, t)
}

#[allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures time; nothing is stamped with it"
)]
fn microseconds(mut work: impl FnMut()) -> f64 {
    let began = std::time::Instant::now();
    work();
    began.elapsed().as_nanos() as f64 * 1e-3
}

/// Lowest quartile of the time, and the error, of a method on recordings.
fn measure(recordings: &[Vec<Pose>], options: &Options) -> (f64, f64) {
    let mut times = Vec::with_capacity(RECORDINGS * ROUNDS);
    let mut squares = 0.0;
    for _ in 0..ROUNDS {
        for poses in recordings {
            times.push(microseconds(|| {
                let _ = black_box(calibrate(black_box(poses), options));
            }));
        }
    }
    for poses in recordings {
        let miss = calibrate(poses, options).map_or(f64::NAN, |found| found.tip.distance(TIP));
        squares += miss * miss;
    }
    times.sort_by(f64::total_cmp);
    (times[times.len() / 4], (squares / recordings.len() as f64).sqrt())
}

/// Poses of so many turns in a divot; a tenth of them slipped by 10 mm.
fn recordings(count: usize) -> Vec<Vec<Pose>> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut record = |_| {
        (0..count)
            .map(|i| pose(&mut random, 30.0, &NOISE, i % 10 == 0))
            .collect()
    };
    (0..RECORDINGS).map(&mut record).collect()
}

/// Methods on ten seconds of poses, and seconds with the default method.
fn trade(trade: &Trade) {
    let rounds = trade.rounds(1, 9);
    let tips = |recordings: &[Vec<Pose>], method| {
        let options = Options { method, noise: NOISE };
        let miss =
            |poses: &Vec<Pose>| calibrate(black_box(poses), &options).map_or(f64::NAN, |found| found.tip.distance(TIP));
        rms(recordings.iter().map(miss))
    };
    let dial = |name, chosen: &str| Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "us a calibration",
        error_unit: "mm",
        against: "root mean square of the tip over 40 recordings to the planted one; noise 0.1 mm and 0.2 degrees; cone 30 degrees; a tenth of the poses slipped by 10 mm",
    };
    let row = |name: String, time: f64, error: f64| -> Row { (name, 1e6 * time / RECORDINGS as f64, error) };
    let ten_s = recordings(600);
    let mut errors = [0.0; Method::ALL.len()];
    let times = turns(rounds, Method::ALL.len(), |k| errors[k] = tips(&ten_s, Method::ALL[k]));
    let rows: Vec<Row> = (0..times.len())
        .map(|k| row(Method::ALL[k].name().to_owned(), times[k], errors[k]))
        .collect();
    trade.write(&dial("pivot-method", Method::default().name()), &rows);
    let seconds = [2, 5, 10, 20, 40];
    let all = seconds.map(|s| recordings(60 * s));
    let mut errors = [0.0; 5];
    let times = turns(rounds, 5, |k| errors[k] = tips(&all[k], Method::default()));
    let rows: Vec<Row> = (0..5)
        .map(|k| row(format!("{} s of 60 poses", seconds[k]), times[k], errors[k]))
        .collect();
    trade.write(&dial("pivot-turning", "20 s of 60 poses"), &rows);
}

fn main() {
    if let Some(trade) = Trade::wanted() {
        return self::trade(&trade);
    }
    let noise = NOISE;
    println!(
        "{:>5} {:>6} {:>6} {:<20} {:>9} {:>9}",
        "cone", "poses", "slips", "method", "us", "error mm"
    );
    for (cone, count, slips) in [
        (30.0, 100, 0),
        (30.0, 500, 0),
        (30.0, 500, 10),
        (5.0, 500, 0),
        (30.0, 5000, 0),
    ] {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut record = |_| -> Vec<Pose> {
            (0..count)
                .map(|i| pose(&mut random, cone, &noise, slips > 0 && i % 10 == 0))
                .collect()
        };
        let recordings: Vec<Vec<Pose>> = (0..RECORDINGS).map(&mut record).collect();
        for method in Method::ALL {
            let (time, error) = measure(&recordings, &Options { method, noise });
            let name = method.name();
            println!("{cone:>5} {count:>6} {slips:>5}% {name:<20} {time:>9.1} {error:>9.4}");
        }
    }
}
