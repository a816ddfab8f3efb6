//! How far mapped stamps are from the truth, beside what other software does with the same frames.
//!
//! `cargo bench -p bus --bench clock_map -- [--out DIR]`. A table of six links with a known truth, how soon a clock that was set is
//! followed, what links do on which a law may lie, and what a frame costs; as Markdown on stdout. With `--out`, `clock_map.csv` and
//! `clock_map.png` there as well.
//!
//! Beside the lower envelope stand the arrival itself, a straight line over 20 frames as PLUS's temporal filter takes it, and recursive
//! least squares with a half-life of 90 s as the Lab Streaming Layer's dejitter filter does: both written here from their published
//! descriptions, with arrivals as their only input.

#![allow(clippy::print_stdout, reason = "the tables are what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

#[path = "clock_map/filters.rs"]
mod filters;
#[path = "../src/clock/mapping/tests/links.rs"]
mod links;
#[path = "clock_map/show.rs"]
mod show;
#[path = "../../../benches/shared/trade.rs"]
mod trade;

use std::path::PathBuf;

use bus::clock::mapping::{Event, Mapped, Mapping, Quality, Settings};
use bus::clock::monotonic_ns;
use links::{BREAKERS, LINKS, Link, Plan, STEPPED};

/// Frames before this do not count: the windows of the laws are not full.
const FROM_S: f64 = 30.0;
const SEED: u64 = 7;

/// What a capture's time is made of, on a WiFi link.
fn trade(trade: &trade::Trade) {
    let link = links::WIFI.link(SEED);
    let stamps = |way: usize| -> Vec<f64> {
        match way {
            0 => map(&link).iter().map(|m| m.capture_ns as f64 * 1e-9).collect(),
            1 => std::hint::black_box(&link.arrival).clone(),
            2 => filters::line_over_20(&link),
            _ => filters::recursive(&link, links::WIFI.rate_hz),
        }
    };
    let names = ["mapped", "arrival", "line over 20 frames", "recursive least squares"];
    let times = trade::turns(trade.rounds(3, 21), names.len(), |way| {
        std::hint::black_box(stamps(way));
    });
    let row = |(way, seconds): (usize, f64)| -> trade::Row {
        let errors = Row::of("", "", &link, &stamps(way), None);
        (
            names[way].to_owned(),
            1e9 * seconds / link.device.len() as f64,
            errors.quantile_ms(0.99),
        )
    };
    let dial = trade::Dial {
        name: "clock",
        chosen: names[0].to_owned(),
        time_unit: "ns a frame",
        error_unit: "ms",
        against: "what 99 of 100 stamps stay below to the drawn capture with its least delay; WiFi with 5 % of frames late by up to 100 ms and 2 s of congestion",
    };
    trade.write(&dial, &times.into_iter().enumerate().map(row).collect::<Vec<_>>());
}

fn main() {
    if let Some(trade) = trade::Trade::wanted() {
        return self::trade(&trade);
    }
    let out = folder();
    let rows: Vec<Row> = LINKS.iter().flat_map(rows).collect();
    show::table(&rows);
    println!();
    seeds();
    println!();
    steps();
    println!();
    breakers();
    println!();
    costs();
    if let Some(out) = out {
        std::fs::create_dir_all(&out).unwrap();
        std::fs::write(out.join("clock_map.csv"), show::csv(&rows)).unwrap();
        show::picture(&rows, &out.join("clock_map.png"));
    }
}

/// The folder behind `--out`. Cargo hands over `--bench` as well.
fn folder() -> Option<PathBuf> {
    let arguments: Vec<String> = std::env::args().collect();
    let at = arguments.iter().position(|argument| argument == "--out")?;
    Some(arguments.get(at + 1).expect("--out needs a folder").into())
}

/// What one way of stamping makes of a link.
struct Row {
    link: &'static str,
    by: &'static str,
    /// Sizes of errors, ms, in order.
    errors_ms: Vec<f64>,
    mean_ms: f64,
    /// The most that a stamp was later than its arrival, and stamps that were earlier than the one before.
    future_ms: f64,
    backwards: usize,
    /// The part of frames whose stated bound held, per cent, and the bound's median, ms; where one is stated.
    stated: Option<(f64, f64)>,
}

impl Row {
    fn of(link: &'static str, by: &'static str, frames: &Link, stamps: &[f64], stated: Option<(f64, f64)>) -> Self {
        let from_s = FROM_S.min(frames.truth[frames.truth.len() / 2]);
        let counted = frames.truth.iter().position(|t| *t > from_s).unwrap();
        let all = stamps.iter().zip(&frames.truth).zip(&frames.arrival).skip(counted);
        let errors: Vec<f64> = all.clone().map(|((stamp, truth), _)| 1e3 * (stamp - truth)).collect();
        let future = all.map(|((stamp, _), arrival)| 1e3 * (stamp - arrival));
        let mean_ms = errors.iter().sum::<f64>() / errors.len() as f64;
        let mut errors_ms: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
        errors_ms.sort_by(f64::total_cmp);
        Self {
            link,
            by,
            errors_ms,
            mean_ms,
            // A nanosecond is what stamps are rounded to.
            future_ms: future.fold(0.0, f64::max),
            backwards: stamps[counted..].windows(2).filter(|w| w[1] < w[0]).count(),
            stated,
        }
    }

    fn quantile_ms(&self, q: f64) -> f64 {
        self.errors_ms[((self.errors_ms.len() - 1) as f64 * q).round() as usize]
    }
}

fn rows(plan: &Plan) -> [Row; 4] {
    let link = plan.link(SEED);
    let mapped = map(&link);
    let stamps: Vec<f64> = mapped.iter().map(|m| m.capture_ns as f64 * 1e-9).collect();
    let row = |by, stamps: &[f64], stated| Row::of(plan.name, by, &link, stamps, stated);
    [
        row("arrival", &link.arrival, None),
        row("PLUS", &filters::line_over_20(&link), None),
        row("LSL", &filters::recursive(&link, plan.rate_hz), None),
        row("lower envelope", &stamps, Some(stated(&link, &mapped))),
    ]
}

fn ns(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

fn map(link: &Link) -> Vec<Mapped> {
    let mut mapping = Mapping::new(Settings::default());
    let frames = link.device.iter().zip(&link.arrival);
    frames
        .map(|(device, arrival)| mapping.map(ns(*device), ns(*arrival)))
        .collect()
}

/// After 2 s, the part of mapped frames whose error is within what is stated, per cent, and the median of that, ms.
fn stated(link: &Link, mapped: &[Mapped]) -> (f64, f64) {
    let frames = mapped.iter().zip(&link.truth).filter(|(_, truth)| **truth > 2.0);
    let bounds =
        frames.filter_map(|(m, truth)| Some((m.uncertain_ns? as f64 * 1e-6, m.capture_ns as f64 * 1e-6 - 1e3 * truth)));
    let bounds: Vec<(f64, f64)> = bounds.collect();
    let held = bounds.iter().filter(|(bound, error)| error.abs() <= *bound).count();
    let mut sizes: Vec<f64> = bounds.iter().map(|(bound, _)| *bound).collect();
    sizes.sort_by(f64::total_cmp);
    (100.0 * held as f64 / bounds.len() as f64, sizes[sizes.len() / 2])
}

/// The same of the lower envelope over a hundred seeds of each link.
fn seeds() {
    println!("| link | p99 of a run, median, ms | worst | max of all, ms | stated holds, all frames, % | worst run |");
    println!("|---|---|---|---|---|---|");
    for plan in &LINKS {
        let runs = (0..100).map(|seed| {
            let link = plan.link(seed);
            let mapped = map(&link);
            let stamps: Vec<f64> = mapped.iter().map(|m| m.capture_ns as f64 * 1e-9).collect();
            Row::of(plan.name, "", &link, &stamps, Some(stated(&link, &mapped)))
        });
        let runs: Vec<Row> = runs.collect();
        let mut p99: Vec<f64> = runs.iter().map(|row| row.quantile_ms(0.99)).collect();
        p99.sort_by(f64::total_cmp);
        let most = runs.iter().map(|row| row.quantile_ms(1.0)).fold(0.0, f64::max);
        let held = runs.iter().filter_map(|row| row.stated.map(|(held, _)| held));
        let (sum, least) = held.fold((0.0, 100.0), |(sum, least), h| (sum + h, f64::min(least, h)));
        let (name, median, worst, held) = (plan.name, p99[50], p99[99], sum / 100.0);
        println!("| {name} | {median:.3} | {worst:.3} | {most:.3} | {held:.2} | {least:.2} |");
    }
}

/// After how long a step is told, over a hundred seeds of each link.
fn steps() {
    println!(
        "| clock set by 80 ms | told, of 200 | told otherwise | after, median | 99 of 100 | at most, s | size wrong by at most, ms |"
    );
    println!("|---|---|---|---|---|---|---|");
    for plan in &STEPPED {
        let (mut after, mut wrong, mut others) = (Vec::new(), 0.0_f64, 0);
        for seed in 0..100 {
            let link = plan.link(seed);
            for (mapped, arrival) in map(&link).iter().zip(&link.arrival) {
                let Some(Event::Step { by_ns }) = mapped.event else {
                    continue;
                };
                match plan.steps.iter().find(|(at, _)| (0.0..1.0).contains(&(arrival - at))) {
                    Some((at, by)) => {
                        after.push(arrival - at);
                        wrong = wrong.max((by_ns as f64 * 1e-6 - 1e3 * by).abs());
                    }
                    None => others += 1,
                }
            }
        }
        after.sort_by(f64::total_cmp);
        let at = |q: f64| after[((after.len() - 1) as f64 * q) as usize];
        let (name, told) = (plan.name, after.len());
        println!(
            "| {name} | {told} | {others} | {:.3} | {:.3} | {:.3} | {wrong:.2} |",
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
}

fn breakers() {
    println!("| link | error p99, ms | max, ms | stated, median ms | holds, % | not mapped, frames | steps told, ms |");
    println!("|---|---|---|---|---|---|---|");
    for plan in &BREAKERS {
        let link = plan.link(SEED);
        let mapped = map(&link);
        let stamps: Vec<f64> = mapped.iter().map(|m| m.capture_ns as f64 * 1e-9).collect();
        let row = Row::of(plan.name, "", &link, &stamps, Some(stated(&link, &mapped)));
        let (held, median) = row.stated.unwrap();
        let frames = mapped.iter().zip(&link.truth).filter(|(_, truth)| **truth > 2.0);
        let arrivals = frames.filter(|(m, _)| m.quality != Quality::Mapped).count();
        let told = mapped.iter().filter_map(|m| match m.event {
            Some(Event::Step { by_ns }) => Some(format!("{:+.1}", by_ns as f64 * 1e-6)),
            _ => None,
        });
        let told: Vec<String> = told.collect();
        let (name, p99, most) = (plan.name, row.quantile_ms(0.99), row.quantile_ms(1.0));
        println!(
            "| {name} | {p99:.3} | {most:.3} | {median:.3} | {held:.2} | {arrivals} | {} |",
            told.join(", ")
        );
    }
}

/// What a frame costs at three rates: the least of nine runs.
fn costs() {
    println!("| rate | ns a frame |");
    println!("|---|---|");
    for rate_hz in [10.0, 60.0, 4000.0] {
        let length_s = (200_000.0_f64 / rate_hz).min(600.0);
        let link = Plan {
            rate_hz,
            length_s,
            ..links::ETHERNET
        }
        .link(SEED);
        let best = (0..9).map(|_| {
            let began = monotonic_ns();
            std::hint::black_box(map(&link));
            (monotonic_ns() - began) as f64 / link.device.len() as f64
        });
        println!("| {rate_hz} Hz | {:.0} |", best.fold(f64::INFINITY, f64::min));
    }
}
