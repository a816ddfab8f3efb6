//! Prints the table of errors and times of the rotation conversions, as Markdown:
//! `cargo run --release -p geometry --example rotation_table crates/geometry/examples/rotation_peers.csv > docs/rotations.md`.
//!
//! The file of other libraries' figures is optional; `rotation_peers.py` writes it.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a command that prints, and that may stop where its references are broken"
)]

mod conversions;
mod peers;
#[path = "../../tests/rotation_support/mod.rs"]
mod rotation_support;
mod timing;

use conversions::{Conversion, conversions};
use peers::Peer;
use rotation_support::{cases, line_error, load, norm, references, vector_error};
use serde_json::Value;

const REGIMES: [&str; 5] = ["near0", "mid", "nearpi", "random", "4-D"];

fn main() {
    let file = match load() {
        Ok(file) => file,
        Err(why) => return println!("No references: {why}"),
    };
    let peers = match peers::load() {
        Ok(peers) => peers,
        Err(why) => return println!("No figures of other libraries: {why}"),
    };
    println!("{}", include_str!("head.md"));
    println!("## Worst error, ulp of the result's norm\n");
    println!("| conversion | by | near 0 | mid | near pi | random | all |\n|---|---|---|---|---|---|---|");
    for conversion in conversions() {
        error_row(&file, &conversion);
        if conversion.by != "ours" {
            peer_rows(&peers, &full_name(&conversion));
        }
    }
    timing::print_table(&file, &peers);
}

fn full_name(conversion: &Conversion) -> String {
    let part = if conversion.vector_part { ", vector part" } else { "" };
    format!("{}{part}", conversion.name)
}

/// The lines of other libraries for one conversion.
fn peer_rows(peers: &[Peer], name: &str) {
    for Peer { by, errors, .. } in peers.iter().filter(|p| p.conversion == name) {
        let cells = errors.map(shown).join(" | ");
        println!("| {name} | {by} | {cells} |");
    }
}

/// One line of the table: the worst error of each regime.
fn error_row(file: &Value, conversion: &Conversion) {
    let mut worst = [0.0f64; 5];
    for case in cases(file, conversion.dimension, "f64") {
        let regime = case["regime"].as_str().unwrap();
        let column = REGIMES.iter().position(|r| regime == *r).unwrap_or(4);
        if let Some(e) = error(case, conversion) {
            worst[column] = if e.is_nan() {
                f64::INFINITY
            } else {
                worst[column].max(e)
            };
        }
    }
    let all = worst.iter().copied().fold(0.0, f64::max);
    let [near0, mid, nearpi, random, _] = worst.map(|e| {
        if conversion.dimension == "so4" {
            "-".into()
        } else {
            shown(e)
        }
    });
    let (name, by) = (full_name(conversion), conversion.by);
    println!(
        "| {name} | {by} | {near0} | {mid} | {nearpi} | {random} | {} |",
        shown(all)
    );
}

/// The error of one case, its sign free for quaternions and at half-turns; `None` where the reference has no answer.
fn error(case: &Value, conversion: &Conversion) -> Option<f64> {
    let want: Vec<_> = match conversion.count {
        3 => references::<3>(case, conversion.answer).to_vec(),
        4 => references::<4>(case, conversion.answer).to_vec(),
        6 if case[conversion.answer].is_null() => return None,
        6 => references::<6>(case, conversion.answer).to_vec(),
        9 => references::<9>(case, conversion.answer).to_vec(),
        _ => references::<16>(case, conversion.answer).to_vec(),
    };
    let got = (conversion.run)(case);
    let (got, want) = if conversion.vector_part {
        (&got[1..], &want[1..])
    } else {
        (&got[..], &want[..])
    };
    let half_turn = conversion.count == 3 && std::f64::consts::PI - norm(want.iter().map(|w| w.high)) < 1e-15;
    let measure = if half_turn || conversion.count == 4 {
        line_error
    } else {
        vector_error
    };
    Some(measure(got, want))
}

fn shown(e: f64) -> String {
    if e < 100.0 {
        format!("{e:.2}")
    } else {
        format!("**{e:.1e}**")
    }
}
