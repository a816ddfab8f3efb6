//! Every conversion against 60-digit references.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops where it cannot go on, and prints what it measured or why it was skipped"
)]

mod rotation_support;

use geometry::rotation::{Log4, Rotation, Rotation4, RotationMatrix, RotationVector};
use rotation_support::{
    Reference, cases, error, inputs, line_error, load, norm, reference, references, ulp, vector_error,
};
use serde_json::Value;

/// The bound asked for, ulp.
const BOUND: f64 = 4.0;

fn rows<T: Copy, const N: usize, const M: usize>(m: [T; M]) -> [[T; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[N * i + j]))
}

/// The error in ulp of the largest entry: between 2^-53 and 2^-52 for a rotation.
fn matrix_error(got: &[f64], want: &[Reference]) -> f64 {
    let most = want.iter().fold(0.0, |most: f64, w| most.max(w.high.abs()));
    error(got, want, ulp(most))
}

/// [`worst_of`] the double precision cases.
fn worst(name: &str, dimension: &str, bound: f64, measure: impl Fn(&Value) -> Option<f64>) {
    worst_of("f64", name, dimension, bound, measure);
}

/// Runs a measurement over cases, prints the worst per regime, and checks the worst of all.
fn worst_of(precision: &str, name: &str, dimension: &str, bound: f64, measure: impl Fn(&Value) -> Option<f64>) {
    let file = match load() {
        Ok(file) => file,
        Err(why) => return println!("skipped, no references: {why}"),
    };
    let mut regimes: Vec<(String, f64, usize)> = Vec::new();
    for case in cases(&file, dimension, precision) {
        let regime = case["regime"].as_str().unwrap();
        let regime = regime.split(':').next().unwrap();
        let Some(e) = measure(case) else { continue };
        if e > bound || e.is_nan() {
            println!("{name}: {e} ulp at {case}");
        }
        match regimes.iter_mut().find(|r| r.0 == regime) {
            Some(r) => *r = (r.0.clone(), r.1.max(e), r.2 + 1),
            None => regimes.push((regime.to_string(), e, 1)),
        }
    }
    let all = regimes.iter().map(|r| r.1).fold(0.0, f64::max);
    let count: usize = regimes.iter().map(|r| r.2).sum();
    println!("{name}: worst {all:.2} ulp of {count}; {regimes:.2?}");
    assert!(all <= bound, "{name}: {all} ulp");
    assert!(count > 0);
}

/// The half-turn's sign is free where the reference is a half-turn to rounding.
fn log_error(got: [f64; 3], want: [Reference; 3]) -> f64 {
    if std::f64::consts::PI - norm(want.map(|w| w.high)) < 1e-15 {
        line_error(&got, &want)
    } else {
        vector_error(&got, &want)
    }
}

fn vector(case: &Value) -> RotationVector {
    RotationVector::new(inputs(case, "w")).unwrap()
}

fn matrix(case: &Value) -> RotationMatrix {
    // Off by the rounding of nine entries.
    RotationMatrix::new(rows(inputs::<9>(case, "M_in")), 1e-15).unwrap()
}

fn quaternion(case: &Value) -> Rotation {
    Rotation::from_quaternion(inputs(case, "q_in")).unwrap()
}

#[test]
fn vector_to_quaternion() {
    worst("w -> q", "so3", BOUND, |case| {
        Some(line_error(
            &Rotation::from_vector(vector(case)).quaternion(),
            &references::<4>(case, "q"),
        ))
    });
    // The part that small motions are made of, relative to itself.
    worst("w -> q, vector part", "so3", BOUND, |case| {
        let [_, x, y, z] = Rotation::from_vector(vector(case)).quaternion();
        let [_, a, b, c] = references::<4>(case, "q");
        Some(line_error(&[x, y, z], &[a, b, c]))
    });
}

#[test]
fn vector_to_matrix() {
    worst("w -> M", "so3", BOUND, |case| {
        Some(matrix_error(
            vector(case).matrix().rows().as_flattened(),
            &references::<9>(case, "M"),
        ))
    });
}

/// What small motions are made of: the differences across the diagonal, 2 sin(a) times the axis.
fn skew<T>(m: [T; 9], minus: impl Fn(&T, &T) -> T) -> [T; 3] {
    [minus(&m[7], &m[5]), minus(&m[2], &m[6]), minus(&m[3], &m[1])]
}

#[test]
fn small_motions_in_matrices() {
    for (name, key) in [("w -> M, skew part", "M"), ("q -> M, skew part", "M_from_q")] {
        worst(name, "so3", BOUND, |case| {
            let m = if key == "M" {
                vector(case).matrix()
            } else {
                quaternion(case).matrix()
            };
            let got = skew(m.rows().as_flattened().try_into().unwrap(), |a: &f64, b| a - b);
            let want = skew(references::<9>(case, key), |a, b| Reference {
                high: a.high - b.high,
                low: a.low - b.low,
            });
            // Further from 0 the differences lose digits to the entries' own rounding.
            (case["regime"] == "near0").then(|| vector_error(&got, &want))
        });
    }
    worst("M -> q, vector part", "so3", BOUND, |case| {
        let [_, x, y, z] = matrix(case).rotation().quaternion();
        let [_, a, b, c] = references::<4>(case, "q_from_M");
        Some(line_error(&[x, y, z], &[a, b, c]))
    });
}

/// Matrices that are rotations to single precision only: what is nearest to them, to all digits.
#[test]
fn nearest_rotations() {
    let nearest = |case: &Value| RotationMatrix::nearest(rows(inputs::<9>(case, "M_in"))).unwrap().matrix;
    worst_of("f32", "M off by 1e-7 -> q", "so3", BOUND, |case| {
        let want = references::<4>(case, "q_from_M");
        Some(line_error(&nearest(case).rotation().quaternion(), &want))
    });
    worst_of("f32", "M off by 1e-7 -> w, relative to 1", "so3", BOUND, |case| {
        let want = references::<3>(case, "w_from_M");
        let unit = ulp(norm(want.map(|w| w.high)).max(1.0));
        let got = nearest(case).vector().radians();
        Some(error(&got, &want, unit).min(error(&got.map(|x| -x), &want, unit)))
    });
}

#[test]
fn quaternion_to_vector() {
    worst("q -> w", "so3", BOUND, |case| {
        Some(log_error(
            quaternion(case).vector().radians(),
            references(case, "w_from_q"),
        ))
    });
}

#[test]
fn quaternion_to_matrix() {
    worst("q -> M", "so3", BOUND, |case| {
        Some(matrix_error(
            quaternion(case).matrix().rows().as_flattened(),
            &references::<9>(case, "M_from_q"),
        ))
    });
}

#[test]
fn matrix_to_quaternion() {
    worst("M -> q", "so3", BOUND, |case| {
        Some(line_error(
            &matrix(case).rotation().quaternion(),
            &references::<4>(case, "q_from_M"),
        ))
    });
}

#[test]
fn matrix_to_vector() {
    worst("M -> w", "so3", BOUND, |case| {
        Some(log_error(matrix(case).vector().radians(), references(case, "w_from_M")))
    });
}

fn log4(case: &Value) -> Log4 {
    Log4::new(inputs(case, "h")).unwrap()
}

#[test]
fn exponential_in_dimension_4() {
    worst("H -> M, 4-D", "so4", BOUND, |case| {
        Some(matrix_error(
            log4(case).exp().matrix().as_flattened(),
            &references::<16>(case, "M"),
        ))
    });
    worst("H -> pair, 4-D", "so4", BOUND, |case| {
        let (p, q) = log4(case).exp().pair();
        let [a, b] = ["qL", "qR"].map(|key| references::<4>(case, key));
        Some(vector_error(&p.quaternion(), &a).max(vector_error(&q.quaternion(), &b)))
    });
    worst("H -> angles, 4-D", "so4", BOUND, |case| {
        let want = ["w1", "w2"].map(|key| reference(case[key].as_str().unwrap()));
        Some(vector_error(&log4(case).angles(), &want))
    });
    worst("H -> g, h, 4-D", "so4", BOUND, |case| {
        let (g, h) = log4(case).factors();
        let [a, b] = ["g", "h_d"].map(|key| references::<3>(case, key));
        Some(vector_error(&g, &a).max(vector_error(&h, &b)))
    });
}

#[test]
fn logarithm_in_dimension_4() {
    worst("M -> H, 4-D", "so4", BOUND, |case| {
        if case["h_from_M"].is_null() {
            return None;
        }
        let (rotation, _) = Rotation4::from_matrix(rows(inputs::<16>(case, "M_in")), 1e-14).unwrap();
        Some(vector_error(
            &rotation.log().radians(),
            &references::<6>(case, "h_from_M"),
        ))
    });
}

#[test]
fn single_precision_is_rounded_once() {
    let Ok(file) = load() else {
        return println!("skipped, no references");
    };
    // Half an ulp of the single format, and 4 ulp of the double one.
    let bound = 0.5 + 4.0 * 2f64.powi(-28);
    for case in cases(&file, "so3", "f32") {
        let q = Rotation::from_quaternion_f32(inputs(case, "q_in").map(|x| x as f32)).unwrap();
        let m = RotationMatrix::from_f32(rows(inputs::<9>(case, "M_in").map(|x| x as f32)), 1e-6).unwrap();
        let w = RotationVector::from_f32(inputs(case, "w").map(|x| x as f32)).unwrap();
        single(case, "q", &Rotation::from_vector(w).quaternion_f32(), bound);
        single(case, "M", w.matrix().to_f32().as_flattened(), bound);
        single(case, "M_from_q", q.matrix().to_f32().as_flattened(), bound);
        single(case, "q_from_M", &m.rotation().quaternion_f32(), bound);
        single(case, "w_from_q", &q.vector().to_f32(), bound);
        single(case, "w_from_M", &m.vector().to_f32(), bound);
    }
}

fn single(case: &Value, key: &str, got: &[f32], bound: f64) {
    let want: Vec<Reference> = case[key]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| reference(v.as_str().unwrap()))
        .collect();
    let n = norm(want.iter().map(|w| w.high)) as f32;
    let unit = f64::from(f32::from_bits(n.to_bits() + 1) - n);
    let error = |sign: f64| {
        got.iter().zip(&want).fold(0.0, |worst: f64, (g, w)| {
            worst.max((sign * f64::from(*g) - w.high).abs() / unit)
        })
    };
    let free = key.starts_with('q') || (std::f64::consts::PI - f64::from(n)).abs() < 1e-6;
    let worst = if free { error(1.0).min(error(-1.0)) } else { error(1.0) };
    assert!(worst <= bound, "{key}: {worst} ulp, {got:?}, {case}");
}

#[test]
fn the_measure_counts_every_digit() {
    let third = reference("3.333333333333333333333333333333333333333e-1");
    assert_eq!(third.high, 1.0 / 3.0);
    let exact = 1.0 / 3.0 - 3.333_333_333_333_333e-1;
    assert!(
        (third.low - 1.850_371_707_708_594e-17).abs() < 1e-31,
        "{third:?} {exact}"
    );
    let tiny = reference("-9.999999999999999999999999999999999999999e-301");
    assert_eq!(tiny.high, -1e-300);
    assert_eq!(ulp(1.0), f64::EPSILON);
    assert_eq!(rotation_support::hex("-0x1.8p-1074"), -5e-324 * 2.0);
}
