//! Nanoseconds per call, over the cases that are away from special branches and over all.

use std::hint::black_box;
use std::time::Instant;

use geometry::rotation::{Rotation, Rotation4, RotationMatrix};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use serde_json::Value;

use crate::conversions::{log4, matrix, matrix4, na_matrix, na_quaternion, na_vector, quaternion, vector};
use crate::rotation_support::cases;

/// The least time of a call over 60 batches of all inputs, ns.
#[allow(clippy::disallowed_methods, reason = "a stop-watch: nothing is stamped")]
fn nanoseconds<I, O>(inputs: &[I], call: impl Fn(&I) -> O) -> f64 {
    let batch = || {
        let start = Instant::now();
        for _ in 0..20 {
            for input in inputs {
                black_box(call(black_box(input)));
            }
        }
        start.elapsed().as_secs_f64() * 1e9 / (20 * inputs.len()) as f64
    };
    (0..60).map(|_| batch()).fold(f64::INFINITY, f64::min)
}

fn row(name: &str, ours: f64, other: Option<f64>) {
    println!(
        "| {name} | {ours:.1} | {} |",
        other.map_or("-".into(), |ns| format!("{ns:.1}"))
    );
}

/// The rows of the table of times, on the random cases.
pub(crate) fn print_rows(file: &Value) {
    let random = |dimension| -> Vec<&Value> {
        cases(file, dimension, "f64")
            .iter()
            .filter(|c| c["regime"] == "random")
            .collect()
    };
    let space = random("so3");
    conversions(&space);
    operations(&space);
    in_4_space(&random("so4"));
}

fn conversions(cases: &[&Value]) {
    let w: Vec<_> = cases.iter().map(|c| (vector(c), na_vector(c))).collect();
    let q: Vec<_> = cases.iter().map(|c| (quaternion(c), na_quaternion(c))).collect();
    let m: Vec<_> = cases.iter().map(|c| (matrix(c), na_matrix(c))).collect();
    let exp = nanoseconds(&w, |(_, w)| UnitQuaternion::from_scaled_axis(*w));
    row("w -> q", nanoseconds(&w, |(w, _)| Rotation::from_vector(*w)), Some(exp));
    let exp = nanoseconds(&w, |(_, w)| Rotation3::from_scaled_axis(*w));
    row("w -> M", nanoseconds(&w, |(w, _)| w.matrix()), Some(exp));
    row(
        "q -> w",
        nanoseconds(&q, |(q, _)| q.vector()),
        Some(nanoseconds(&q, |(_, q)| q.scaled_axis())),
    );
    row(
        "q -> M",
        nanoseconds(&q, |(q, _)| q.matrix()),
        Some(nanoseconds(&q, |(_, q)| q.to_rotation_matrix())),
    );
    let from = nanoseconds(&m, |(_, m)| UnitQuaternion::from_rotation_matrix(m));
    row("M -> q", nanoseconds(&m, |(m, _)| m.rotation()), Some(from));
    let log = nanoseconds(&m, |(_, m)| UnitQuaternion::from_rotation_matrix(m).scaled_axis());
    row(
        "M -> w (nalgebra: through q)",
        nanoseconds(&m, |(m, _)| m.vector()),
        Some(log),
    );
    let log = nanoseconds(&m, |(_, m)| m.scaled_axis());
    row(
        "M -> w (nalgebra: directly)",
        nanoseconds(&m, |(m, _)| m.vector()),
        Some(log),
    );
}

fn operations(cases: &[&Value]) {
    let q: Vec<_> = cases.iter().map(|c| (quaternion(c), na_quaternion(c))).collect();
    let pairs: Vec<_> = q.windows(2).map(|w| (w[0].0, w[1].0, w[0].1, w[1].1)).collect();
    let other = nanoseconds(&pairs, |(_, _, a, b)| a * b);
    row(
        "composition q q",
        nanoseconds(&pairs, |(a, b, _, _)| *a * *b),
        Some(other),
    );
    let other = nanoseconds(&pairs, |(_, _, a, b)| a.slerp(b, 0.3));
    row(
        "slerp",
        nanoseconds(&pairs, |(a, b, _, _)| a.slerp(*b, 0.3)),
        Some(other),
    );
    let other = nanoseconds(&pairs, |(_, _, a, b)| a.angle_to(b));
    row(
        "geodesic distance",
        nanoseconds(&pairs, |(a, b, _, _)| a.distance(*b)),
        Some(other),
    );
    // What a tracker's file is off by.
    let noisy: Vec<_> = cases
        .iter()
        .map(|c| matrix(c).rows().map(|row| [row[0] + 3e-4, row[1], row[2] - 2e-4]))
        .collect();
    let other = nanoseconds(&noisy, |m| Rotation3::from_matrix(&Matrix3::from_fn(|i, j| m[i][j])));
    row(
        "nearest rotation, 5e-4 off",
        nanoseconds(&noisy, |m| RotationMatrix::nearest(*m)),
        Some(other),
    );
}

fn in_4_space(cases: &[&Value]) {
    let h: Vec<_> = cases.iter().map(|c| log4(c)).collect();
    let m: Vec<_> = cases.iter().map(|c| matrix4(c)).collect();
    row("H -> M, 4-D", nanoseconds(&h, |h| h.exp().matrix()), None);
    row(
        "M -> H, 4-D",
        nanoseconds(&m, |m| Rotation4::from_matrix(*m, 1e-14).map(|r| r.0.log())),
        None,
    );
}
