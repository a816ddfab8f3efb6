//! Nanoseconds per call, over the cases that are away from special branches and over all.

use std::hint::black_box;
use std::time::Instant;

use geometry::rotation::{Rotation, Rotation2, Rotation4, RotationMatrix};
use nalgebra::{Matrix3, Rotation3, UnitComplex, UnitQuaternion};
use serde_json::Value;

use crate::conversions::{log4, matrix, matrix4, na_matrix, na_quaternion, na_vector, quaternion, vector};
use crate::peers::{Peer, libraries};
use crate::rotation_support::cases;

/// The least time of a call over 60 batches of all inputs, ns.
#[allow(clippy::disallowed_methods, reason = "a stop-watch: nothing is stamped")]
fn nanoseconds<I, O>(inputs: &[I], call: impl Fn(&I) -> O) -> f64 {
    let batch = || {
        let start = Instant::now();
        for _ in 0..20 {
            for input in inputs {
                // By reference: moving the result would copy it, in chunks that wait for how it was written.
                black_box(&call(black_box(input)));
            }
        }
        start.elapsed().as_secs_f64() * 1e9 / (20 * inputs.len()) as f64
    };
    (0..60).map(|_| batch()).fold(f64::INFINITY, f64::min)
}

/// A table in the making: the other libraries, whose times are known by name.
struct Table<'a>(&'a [Peer]);

impl Table<'_> {
    fn head(&self) {
        let names = libraries(self.0);
        let columns: String = names.iter().map(|by| format!(" {by}, ns |")).collect();
        println!("\n## Time\n\n| operation | ours, ns | nalgebra, ns |{columns}");
        println!("|---|---|---|{}", "---|".repeat(names.len()));
    }

    fn row(&self, name: &str, ours: f64, other: Option<f64>) {
        let shown = |ns: Option<f64>| ns.map_or("-".into(), |ns| format!("{ns:.1}"));
        let time = |by: &str| self.0.iter().find(|p| p.by == by && p.conversion == name)?.ns;
        let peers: String = libraries(self.0)
            .iter()
            .map(|by| format!(" {} |", shown(time(by))))
            .collect();
        println!("| {name} | {ours:.1} | {} |{peers}", shown(other));
    }
}

/// The table of times, on the random cases.
pub(crate) fn print_table(file: &Value, peers: &[Peer]) {
    let random = |dimension| -> Vec<&Value> {
        cases(file, dimension, "f64")
            .iter()
            .filter(|c| c["regime"] == "random")
            .collect()
    };
    let table = Table(peers);
    table.head();
    let space = random("so3");
    conversions(&table, &space);
    axis_angle(&table, &space);
    operations(&table, &space);
    in_the_plane(&table, &space);
    in_4_space(&table, &random("so4"));
}

fn axis_angle(table: &Table<'_>, cases: &[&Value]) {
    let q: Vec<_> = cases.iter().map(|c| (quaternion(c), na_quaternion(c))).collect();
    let a: Vec<_> = q.iter().map(|(q, n)| (q.axis_angle(), n.axis_angle())).collect();
    let a: Vec<_> = a.into_iter().filter_map(|(ours, na)| Some((ours, na?))).collect();
    let other = nanoseconds(&a, |(_, (axis, angle))| UnitQuaternion::from_axis_angle(axis, *angle));
    table.row("axis, angle -> q", nanoseconds(&a, |(a, _)| a.rotation()), Some(other));
    let other = nanoseconds(&a, |(_, (axis, angle))| Rotation3::from_axis_angle(axis, *angle));
    table.row("axis, angle -> M", nanoseconds(&a, |(a, _)| a.matrix()), Some(other));
    let other = nanoseconds(&q, |(_, q)| q.axis_angle());
    table.row(
        "q -> axis, angle",
        nanoseconds(&q, |(q, _)| q.axis_angle()),
        Some(other),
    );
}

fn in_the_plane(table: &Table<'_>, cases: &[&Value]) {
    let angles: Vec<f64> = cases.iter().map(|c| vector(c).angle()).collect();
    let other = nanoseconds(&angles, |a| UnitComplex::new(*a));
    let ours = nanoseconds(&angles, |a| Rotation2::from_angle(*a));
    table.row("angle -> complex, 2-D", ours, Some(other));
    let turns: Vec<_> = angles
        .iter()
        .filter_map(|a| Some((Rotation2::from_angle(*a).ok()?, UnitComplex::new(*a))))
        .collect();
    let other = nanoseconds(&turns, |(_, c)| c.angle());
    table.row(
        "complex -> angle, 2-D",
        nanoseconds(&turns, |(r, _)| r.angle()),
        Some(other),
    );
    let pairs: Vec<_> = turns.windows(2).map(|w| (w[0], w[1])).collect();
    let other = nanoseconds(&pairs, |(a, b)| a.1 * b.1);
    table.row("composition, 2-D", nanoseconds(&pairs, |(a, b)| a.0 * b.0), Some(other));
    let other = nanoseconds(&pairs, |(a, b)| a.1.slerp(&b.1, 0.3));
    table.row(
        "slerp, 2-D",
        nanoseconds(&pairs, |(a, b)| a.0.slerp(b.0, 0.3)),
        Some(other),
    );
}

fn conversions(table: &Table<'_>, cases: &[&Value]) {
    let w: Vec<_> = cases.iter().map(|c| (vector(c), na_vector(c))).collect();
    let q: Vec<_> = cases.iter().map(|c| (quaternion(c), na_quaternion(c))).collect();
    let m: Vec<_> = cases.iter().map(|c| (matrix(c), na_matrix(c))).collect();
    let exp = nanoseconds(&w, |(_, w)| UnitQuaternion::from_scaled_axis(*w));
    table.row("w -> q", nanoseconds(&w, |(w, _)| Rotation::from_vector(*w)), Some(exp));
    let exp = nanoseconds(&w, |(_, w)| Rotation3::from_scaled_axis(*w));
    table.row("w -> M", nanoseconds(&w, |(w, _)| w.matrix()), Some(exp));
    table.row(
        "q -> w",
        nanoseconds(&q, |(q, _)| q.vector()),
        Some(nanoseconds(&q, |(_, q)| q.scaled_axis())),
    );
    table.row(
        "q -> M",
        nanoseconds(&q, |(q, _)| q.matrix()),
        Some(nanoseconds(&q, |(_, q)| q.to_rotation_matrix())),
    );
    let from = nanoseconds(&m, |(_, m)| UnitQuaternion::from_rotation_matrix(m));
    table.row("M -> q", nanoseconds(&m, |(m, _)| m.rotation()), Some(from));
    let log = nanoseconds(&m, |(_, m)| UnitQuaternion::from_rotation_matrix(m).scaled_axis());
    table.row("M -> w", nanoseconds(&m, |(m, _)| m.vector()), Some(log));
    let log = nanoseconds(&m, |(_, m)| m.scaled_axis());
    table.row(
        "M -> w, nalgebra directly",
        nanoseconds(&m, |(m, _)| m.vector()),
        Some(log),
    );
}

fn operations(table: &Table<'_>, cases: &[&Value]) {
    let q: Vec<_> = cases.iter().map(|c| (quaternion(c), na_quaternion(c))).collect();
    let pairs: Vec<_> = q.windows(2).map(|w| (w[0].0, w[1].0, w[0].1, w[1].1)).collect();
    let other = nanoseconds(&pairs, |(_, _, a, b)| a * b);
    table.row(
        "composition q q",
        nanoseconds(&pairs, |(a, b, _, _)| *a * *b),
        Some(other),
    );
    let other = nanoseconds(&pairs, |(_, _, a, b)| a.slerp(b, 0.3));
    table.row(
        "slerp",
        nanoseconds(&pairs, |(a, b, _, _)| a.slerp(*b, 0.3)),
        Some(other),
    );
    let other = nanoseconds(&pairs, |(_, _, a, b)| a.angle_to(b));
    table.row(
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
    table.row(
        "nearest rotation, 5e-4 off",
        nanoseconds(&noisy, |m| RotationMatrix::nearest(*m)),
        Some(other),
    );
}

fn in_4_space(table: &Table<'_>, cases: &[&Value]) {
    let h: Vec<_> = cases.iter().map(|c| log4(c)).collect();
    let m: Vec<_> = cases.iter().map(|c| matrix4(c)).collect();
    table.row("H -> M, 4-D", nanoseconds(&h, |h| h.exp().matrix()), None);
    table.row(
        "M -> H, 4-D",
        nanoseconds(&m, |m| Rotation4::from_matrix(*m, 1e-14).map(|r| r.0.log())),
        None,
    );
}
