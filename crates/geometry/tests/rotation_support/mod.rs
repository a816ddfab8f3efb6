//! Reads the 60-digit references and measures errors against them, all digits counted.

use std::path::PathBuf;

use serde_json::Value;

/// A reference number as a sum of two doubles: 32 digits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// The file of references, or the reason why it cannot be had.
pub(crate) fn load() -> Result<Value, String> {
    let shared = std::env::var_os("TROCAR_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
        PathBuf::from,
    );
    let path = shared.join("oracles/rotations.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
}

/// The cases of a dimension (`so3`, `so4`) in a precision (`f64`, `f32`).
pub(crate) fn cases<'a>(file: &'a Value, dimension: &str, precision: &str) -> &'a [Value] {
    file[dimension][precision].as_array().unwrap()
}

/// A C hex float, exactly.
pub(crate) fn hex(text: &str) -> f64 {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (mantissa, exponent) = rest.strip_prefix("0x").unwrap().split_once('p').unwrap();
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).unwrap();
    let exponent = exponent.parse::<i32>().unwrap() - 4 * fraction.len() as i32;
    // In two steps: the power alone may be below the smallest number.
    sign * digits as f64 * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2)
}

pub(crate) fn inputs<const N: usize>(case: &Value, key: &str) -> [f64; N] {
    std::array::from_fn(|i| hex(case[key][i].as_str().unwrap()))
}

pub(crate) fn references<const N: usize>(case: &Value, key: &str) -> [Reference; N] {
    std::array::from_fn(|i| reference(case[key][i].as_str().unwrap()))
}

/// A decimal number of up to 40 digits.
pub(crate) fn reference(text: &str) -> Reference {
    let high: f64 = text.parse().unwrap();
    if high == 0.0 {
        return Reference { high, low: 0.0 };
    }
    let exponent = exponent_of(&normal_form(text));
    // The decimal expansion of a double is exact in Rust's formatting.
    let (a, b) = (
        digits(&normal_form(text), exponent),
        digits(&format!("{high:.60e}"), exponent),
    );
    let low = ((a - b) as f64 * 1e-35) * 10f64.powi(exponent);
    Reference {
        high,
        low: low * high.signum(),
    }
}

/// d.ddd...e±n without sign.
fn normal_form(text: &str) -> String {
    let text = text.trim_start_matches('-');
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let all = format!("{whole}{fraction}");
    let zeros = all.len() - all.trim_start_matches('0').len();
    let significant = &all[zeros..];
    let exponent = exponent.parse::<i32>().unwrap() + whole.len() as i32 - 1 - zeros as i32;
    format!("{}.{}e{exponent}", &significant[..1], &significant[1..])
}

fn exponent_of(normal: &str) -> i32 {
    normal.split_once('e').unwrap().1.parse().unwrap()
}

/// The number's first 36 digits counted from 10^exponent, as an integer.
fn digits(normal: &str, exponent: i32) -> i128 {
    let normal = normal.trim_start_matches('-');
    let (mantissa, own) = normal.split_once('e').unwrap();
    let shift = own.parse::<i32>().unwrap() - exponent;
    let mut text: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    text.extend(std::iter::repeat_n('0', 40));
    match shift {
        0 => text[..36].parse().unwrap(),
        1 => text[..37].parse().unwrap(),
        -1 => text[..35].parse().unwrap(),
        _ => panic!("{normal} is not next to 10^{exponent}"),
    }
}

/// The spacing of doubles at `x`.
pub(crate) fn ulp(x: f64) -> f64 {
    let x = x.abs();
    f64::from_bits(x.to_bits() + 1) - x
}

/// Euclidean norm without overflow or underflow.
pub(crate) fn norm(v: impl IntoIterator<Item = f64>) -> f64 {
    v.into_iter().fold(0.0, f64::hypot)
}

/// The largest component's error, in units of `unit`.
pub(crate) fn error(got: &[f64], want: &[Reference], unit: f64) -> f64 {
    assert_eq!(got.len(), want.len());
    let errors = got.iter().zip(want).map(|(g, w)| ((g - w.high) - w.low).abs() / unit);
    errors.fold(0.0, |worst, e| if e > worst || e.is_nan() { e } else { worst })
}

/// The error in ulp of the reference's Euclidean norm.
pub(crate) fn vector_error(got: &[f64], want: &[Reference]) -> f64 {
    error(got, want, ulp(norm(want.iter().map(|w| w.high))))
}

/// As [`vector_error`], the sign of the whole free.
pub(crate) fn line_error(got: &[f64], want: &[Reference]) -> f64 {
    let minus: Vec<f64> = got.iter().map(|x| -x).collect();
    vector_error(got, want).min(vector_error(&minus, want))
}
