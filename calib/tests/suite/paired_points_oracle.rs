//! Every method against the optima of a 50-digit solve on the exact doubles.
//!
//! The file is `oracles/paired_points.json` under `TROCAR_SHARED`, or under `shared` beside the repository; without it
//! the test says so and passes.

#![allow(clippy::print_stdout, reason = "the ratios reached are worth reading")]

use std::path::PathBuf;

use calib::registration::{Method, Pairs, Refused, fit};
use geometry::{Ct, Point, Tracker};
use serde_json::Value;

/// Half a unit in the last place of 1: the `epsilon` of the bound.
const U: f64 = 0.5 * f64::EPSILON;
/// The bound, in units of `U` times the condition.
const BOUND: f64 = 20.0;

struct Case {
    name: String,
    to: Vec<Point<Ct>>,
    from: Vec<Point<Tracker>>,
    /// Row by row.
    rotation: [[f64; 3]; 3],
    condition: f64,
    mean_squared_residual: f64,
}

fn oracle() -> Option<Vec<Case>> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = std::env::var_os("TROCAR_SHARED").map_or(beside, PathBuf::from);
    let path = shared.join("oracles/paired_points.json");
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: {} is not there", path.display());
        return None;
    };
    // JSON has no infinity; Python writes one.
    let text = text.replace("Infinity", "1e999").replace("NaN", "null");
    let text = text.replace("1e999", "\"inf\"");
    let file: Value = serde_json::from_str(&text).unwrap();
    Some(file["cases"].as_array().unwrap().iter().map(case).collect())
}

fn case(value: &Value) -> Case {
    let strings = |key: &str| value[key].as_array().cloned().unwrap_or_default();
    let rotation: Vec<f64> = strings("rotation_a_from_b").iter().map(decimal).collect();
    let at = |i: usize| rotation.get(i).copied().unwrap_or(f64::NAN);
    Case {
        name: value["case"].as_str().unwrap().to_owned(),
        to: points(&strings("a")).map(|[x, y, z]| Point::new(x, y, z)).collect(),
        from: points(&strings("b")).map(|[x, y, z]| Point::new(x, y, z)).collect(),
        rotation: std::array::from_fn(|r| std::array::from_fn(|c| at(3 * r + c))),
        condition: value["condition"].as_f64().unwrap_or(f64::INFINITY),
        mean_squared_residual: value["mean_squared_residual"].as_f64().unwrap_or(f64::NAN),
    }
}

fn decimal(value: &Value) -> f64 {
    value.as_str().map_or(f64::NAN, |s| s.parse().unwrap())
}

fn points(values: &[Value]) -> impl Iterator<Item = [f64; 3]> {
    let numbers: Vec<f64> = values.iter().map(|v| hex(v.as_str().unwrap())).collect();
    let triples: Vec<[f64; 3]> = numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    triples.into_iter()
}

/// A C hexadecimal float, exactly.
fn hex(text: &str) -> f64 {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |t| (-1.0, t));
    let (mantissa, exponent) = text.strip_prefix("0x").unwrap().split_once('p').unwrap();
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap();
    let exponent: i32 = exponent.parse::<i32>().unwrap() - 4 * fraction.len() as i32;
    // In two halves, each a normal power of two.
    let half = exponent / 2;
    sign * (digits as f64 * 2.0_f64.powi(half)) * 2.0_f64.powi(exponent - half)
}

/// The angle between two rotations, radians: `|R - S|_F / sqrt 2`, a little above the sine's double of half the angle.
fn angle(q: [f64; 4], r: &[[f64; 3]; 3]) -> f64 {
    let s = rows(q);
    let squares = (0..9).map(|i| (s[i / 3][i % 3] - r[i / 3][i % 3]).powi(2));
    (squares.sum::<f64>() / 2.0).sqrt()
}

fn rows([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// The error over the condition, in `U`, or why the set was refused.
fn ratio(case: &Case, method: Method) -> Result<f64, Refused> {
    let fit = fit(Pairs::new(&case.to, &case.from).unwrap(), method)?;
    Ok(angle(fit.transform.quaternion(), &case.rotation) / (U * case.condition))
}

/// No digit of these would hold.
fn undetermined(case: &Case) -> bool {
    case.condition >= 1.0 / (BOUND * U)
}

/// Worst ratio over the determined cases; fails where one is refused or an undetermined one is not.
fn worst(cases: &[Case], method: Method) -> (f64, String) {
    let mut worst = (0.0, String::new());
    for case in cases {
        let found = ratio(case, method);
        if undetermined(case) {
            let named = matches!(found, Err(Refused::Coincident { .. } | Refused::Collinear(_)));
            assert!(named, "{method:?}, {}: {found:?}", case.name);
            continue;
        }
        let ratio = found.unwrap_or_else(|e| panic!("{method:?}, {} (condition {:e}): {e}", case.name, case.condition));
        if ratio.is_nan() || ratio > worst.0 {
            worst = (ratio, case.name.clone());
        }
    }
    worst
}

#[test]
fn accurate_methods_hold_the_bound_on_every_case() {
    let Some(cases) = oracle() else { return };
    assert!(cases.len() >= 140);
    for method in [
        Method::Newton,
        Method::Svd,
        Method::HornQuaternion,
        Method::FaugerasHebert,
        Method::RotationVector,
    ] {
        let (ratio, name) = worst(&cases, method);
        println!("{method:?}: worst {ratio:.2} on {name}");
        assert!(ratio <= BOUND, "{method:?}: {ratio} on {name}");
    }
}

#[test]
fn the_polar_form_holds_the_squared_bound_or_says_so() {
    let Some(cases) = oracle() else { return };
    for case in cases.iter().filter(|case| !undetermined(case)) {
        match ratio(case, Method::HornPolar) {
            Ok(ratio) => assert!(ratio <= BOUND * case.condition.max(1.0), "{}: {ratio}", case.name),
            Err(Refused::MethodFails(values)) => assert!(values.condition() > 1e8, "{}: {values}", case.name),
            Err(other) => panic!("{}: {other}", case.name),
        }
    }
}

#[test]
fn the_registration_error_is_that_of_the_optimum() {
    let Some(cases) = oracle() else { return };
    for case in cases.iter().filter(|case| !undetermined(case)) {
        let pairs = Pairs::new(&case.to, &case.from).unwrap();
        let found = fit(pairs, Method::Newton).unwrap().fre_rms_mm(pairs);
        // Squares below 1e-300 or above 1e300 do not fit the file's own numbers.
        if !(1e-300..1e300).contains(&case.mean_squared_residual) {
            continue;
        }
        let expected = case.mean_squared_residual.sqrt();
        let radius = |p: [f64; 3]| p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let size = case
            .to
            .iter()
            .map(|p| radius(p.mm()))
            .chain(case.from.iter().map(|p| radius(p.mm())));
        // An angle d adds (s2 + s3) d^2 to the square; with d up to the bound that is 20 U sqrt(s1 condition), and s1
        // is below the squared size. The roundings of the centred coordinates come on top.
        let bound = BOUND * U * size.fold(0.0, f64::max) * (1.0 + case.condition.sqrt());
        assert!(
            (found - expected).abs() <= bound,
            "{}: {found:e} {expected:e}",
            case.name
        );
    }
}
