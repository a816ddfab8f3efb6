//! How soon a cover is up, what a watcher costs, and how often it is wrong: figures for people, never asserted.
//!
//! `cargo test -p window --test watch -- --ignored --nocapture figures`; TROCAR_TIMES sets how often (100), TROCAR_SECONDS how long it
//! is watched undisturbed (60).

use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::stage::{Stage, stage};

fn asked(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable)
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(otherwise)
}

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap();
    text.split_whitespace().next().unwrap_or_default().to_owned()
}

/// CPU time of a process, ticks of 10 ms.
fn ticks(pid: u32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let behind = text.rsplit(')').next().unwrap();
    behind
        .split_whitespace()
        .skip(11)
        .take(2)
        .map(|n| n.parse::<u64>().unwrap())
        .sum()
}

/// From the harm to red pixels on the screen, so often.
fn times(stage: &mut Stage, count: u64, harm: impl Fn(&mut Stage), mend: impl Fn(&mut Stage)) -> Vec<Duration> {
    let mut times = Vec::new();
    for i in 0..count {
        stage.wait_for_note("is what it says");
        stage.wait_red(false);
        // Not in step with the looks of the watcher, nor with the pictures of the window.
        std::thread::sleep(Duration::from_millis(200 + i * 7 % 50));
        let began = Instant::now();
        harm(stage);
        stage.wait_red(true);
        times.push(began.elapsed());
        // Else the next round would take the sign of life from before the harm for the one after it.
        stage.wait_for_note("covers");
        mend(stage);
    }
    times.sort_unstable();
    times
}

fn print(what: &str, times: &[Duration]) {
    let ms = |share: usize| times[(times.len() - 1) * share / 100].as_millis();
    let late = times.iter().filter(|time| **time > Duration::from_millis(500)).count();
    println!(
        "{what}: {} times, to red median {} ms, p90 {}, p99 {}, worst {}; {late} above 500 ms; load {}",
        times.len(),
        ms(50),
        ms(90),
        ms(99),
        ms(100),
        load()
    );
}

#[test]
#[ignore = "minutes of figures for people"]
fn figures_of_covers() {
    let Some(mut stage) = stage() else { return };
    let count = asked("TROCAR_TIMES", 100);
    let cont = |stage: &mut Stage| stage.signal(Signal::CONT);
    let paint = |stage: &mut Stage| stage.order("paint");
    print(
        "SIGSTOP",
        &times(&mut stage, count, |stage| stage.signal(Signal::STOP), cont),
    );
    print(
        "kill -9",
        &times(
            &mut stage,
            count,
            |stage| stage.signal(Signal::KILL),
            Stage::start_window,
        ),
    );
    print(
        "stops painting",
        &times(&mut stage, count, |stage| stage.order("freeze"), paint),
    );
    print("old pose", &times(&mut stage, count, |stage| stage.order("age"), paint));
}

#[test]
#[ignore = "minutes of figures for people"]
fn figures_of_quiet() {
    let Some(mut stage) = stage() else { return };
    let seconds = asked("TROCAR_SECONDS", 60);
    stage.wait_for_note("is what it says");
    let pid = stage.watcher_pid();
    let at = |stage: &mut Stage| (ticks(pid), stage.heard().unwrap().counters);
    let (before, from) = at(&mut stage);
    std::thread::sleep(Duration::from_secs(seconds));
    let (after, to) = at(&mut stage);
    let cpu = (after - before) as f64 / seconds as f64;
    println!(
        "{seconds} s of a window that paints: {} looks, {} of them under a cover; {cpu:.2} % of a core; load {}",
        to.published - from.published,
        to.lost - from.lost,
        load()
    );
}
