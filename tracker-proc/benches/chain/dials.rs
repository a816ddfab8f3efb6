//! How late and how wrong the pose is that is shown at any moment: by smoothing, and by the localizer's rate.
//!
//! A tip goes to and fro over 20 mm, 10 mm/s at its fastest, and is measured with 0.3 mm of noise along each axis; who looks, at each
//! millisecond, sees the newest pose. How late that is, is the delay of the true motion that comes nearest to it.

use std::f64::consts::TAU;

use chance::Chance;
use geometry::{Ct, Rigid, Tool, Vector};
use tracker_proc::chain::Smoothing;

use super::trade::{Dial, Row, Trade, rms};

const NOISE_MM: f64 = 0.3;
const REACH_MM: f64 = 10.0;
const MM_S: f64 = 10.0;

fn truth(t_s: f64) -> [f64; 3] {
    [REACH_MM * (t_s * MM_S / REACH_MM).sin(), 0.0, 0.0]
}

/// The tip that is shown at each millisecond.
fn shown(length_s: f64, rate_hz: f64, time_constant_s: f64) -> Vec<[f64; 3]> {
    let (mut smoothing, chance) = (Smoothing::new(time_constant_s), Chance::new(1, 0));
    let (mut shown, mut next, mut last) = (Vec::new(), 0_u64, [0.0; 3]);
    for ms in 0..(length_s * 1e3) as u64 {
        while next as f64 / rate_hz <= ms as f64 * 1e-3 {
            let t_s = next as f64 / rate_hz;
            let [x, y, z] = std::array::from_fn(|a| truth(t_s)[a] + NOISE_MM * chance.normal(3 * next + a as u64));
            let pose: Rigid<Ct, Tool> =
                Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), Vector::new(x, y, z)).unwrap();
            last = smoothing.smooth((t_s * 1e9) as i64, pose).translation_mm();
            next += 1;
        }
        shown.push(last);
    }
    shown
}

/// Root mean square distance of what is shown to where the tip was so long before, leaving out the first second.
fn distance(shown: &[[f64; 3]], delay_s: f64) -> f64 {
    let off = |(ms, at): (usize, &[f64; 3])| {
        let truth = truth(ms as f64 * 1e-3 - delay_s);
        (0..3).map(|a| (at[a] - truth[a]).powi(2)).sum::<f64>().sqrt()
    };
    rms(shown.iter().enumerate().skip(1000).map(off))
}

fn row(name: String, length_s: f64, rate_hz: f64, time_constant_s: f64) -> Row {
    let shown = shown(length_s, rate_hz, time_constant_s);
    // Tenths of a millisecond; the least of a parabola, found by halving steps.
    let (mut delay_s, mut step) = (0.0, 0.064);
    while step > 5e-5 {
        let better = [delay_s - step, delay_s + step]
            .into_iter()
            .find(|d| distance(&shown, *d) < distance(&shown, delay_s));
        match better {
            Some(better) => delay_s = better,
            None => step /= 2.0,
        }
    }
    (name, 1e3 * delay_s, distance(&shown, 0.0))
}

pub(crate) fn measure(trade: &Trade) {
    // Whole periods of the motion.
    let length_s = 1.0 + trade.rounds(2, 20) as f64 * TAU * REACH_MM / MM_S;
    let dial = |name, chosen: &str| Dial {
        name,
        chosen: chosen.to_owned(),
        time_unit: "ms late",
        error_unit: "mm",
        against: "root mean square at the tip to the drawn motion of up to 10 mm/s at the moment of looking; 0.3 mm of noise along each axis",
    };
    let constants = [0.0, 10.0, 20.0, 35.0, 70.0, 150.0];
    let name = |ms: f64| {
        if ms > 0.0 {
            format!("{ms} ms")
        } else {
            "none".to_owned()
        }
    };
    let rows: Vec<Row> = constants.map(|ms| row(name(ms), length_s, 60.0, ms * 1e-3)).to_vec();
    trade.write(&dial("smoothing", "none"), &rows);
    let rows: Vec<Row> = [10.0, 20.0, 60.0, 120.0, 400.0]
        .map(|hz| row(format!("{hz} a second"), length_s, hz, 0.0))
        .to_vec();
    trade.write(&dial("rate", "60 a second"), &rows);
}
