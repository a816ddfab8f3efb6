//! What a second machine costs and how late it is: `cargo bench --bench link [-- WORDS]`, WORDS to take the rows that hold them.
//!
//! Each row is a sender with a run of its own and receivers with theirs, all on this machine, so that the truth of the sender's clock is
//! known. The added latency of a pose is from its arrival on the sender's bus to that on the receiver's, both seen by a thread that is
//! woken. `ahead` is by how much the receiver's clock is ahead of the truth, which is by how much every age is overstated; below 0 it
//! would be understated. What the latency must keep within stands behind each row, and whether it does.
//!
//! `-- room` measures instead what the navigating room notices of it, beside a whole run (see `room.rs`).

#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    clippy::unwrap_used,
    missing_docs,
    reason = "tests and benchmarks start programs, measure time and say why they skip"
)]

#[allow(dead_code, reason = "the tests use all of it")]
#[path = "../../tests/run/both.rs"]
mod both;
mod delay;
mod listen;
#[allow(dead_code, reason = "the tests use all of it")]
#[path = "../../tests/run/rig.rs"]
mod rig;
mod room;
mod rows;
#[allow(dead_code, reason = "the tests use all of it")]
#[path = "../../tests/run/wire.rs"]
mod wire;

use std::time::{Duration, Instant};

use bus::clock::ms;

use delay::Delay;
use listen::Listener;
use rig::{Program, Room, Second, free_endpoint, keys, remote_proc, until, world};
use rows::{Row, rows};

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    if let Some(("room", guests)) = words.split_first().map(|(first, rest)| (first.as_str(), rest)) {
        return room::room(guests);
    }
    say(&format!(
        "{:<30}{:>7}{:>6}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}{:>9}{:>9}{:>8}  must: p50, p99",
        "link",
        "poses",
        "lost",
        "added",
        "p99 ms",
        "max",
        "ahead",
        "p99 ms",
        "least",
        "MB/s",
        "send cpu",
        "recv cpu",
        "volume"
    ));
    for row in rows() {
        if words.iter().all(|word| row.name.contains(word.as_str())) {
            measure(&row);
        }
    }
}

fn measure(row: &Row) {
    let world = world();
    let endpoint = match row.tls {
        true => free_endpoint().replace("tcp/", "tls/"),
        false => free_endpoint(),
    };
    let keys = row.tls.then(|| keys(world.path(), "127.0.0.1"));
    let mut room = Room::open(world.path(), Duration::from_secs(5), row.dims, |_| {});
    let mut send = remote_proc();
    send.args(["send", "--run", "room", "--listen", &endpoint]);
    send.args(keys.iter().flat_map(|keys| ["--keys", keys]));
    let sender = Program::start(world.path(), "send", send);
    let near = Listener::on(&room.run, None);
    let delay = row.delay.map(|half| Delay::before(&endpoint, half));
    let dialled = delay.as_ref().map_or(endpoint.clone(), |delay| delay.endpoint(row.tls));
    let began = Instant::now();
    let mut seconds = Vec::new();
    for number in 0..row.receivers {
        let second = Second::open(world.path(), &format!("s{number}"), &dialled);
        let mut command = remote_proc();
        command
            .args(["receive", &dialled, "--session", &room.id(), "--run-dir"])
            .arg(&second.run.dir);
        command.args(keys.iter().flat_map(|keys| ["--keys", keys]));
        let receiver = Program::start(world.path(), &format!("s{number}"), command);
        seconds.push((second, receiver));
    }
    for (second, _) in &seconds {
        until("the examination", || {
            room.serve_late_joiners();
            second.volumes.poll().unwrap()
        });
    }
    let volume_s = began.elapsed().as_secs_f64();
    let far: Vec<Listener> = seconds
        .iter()
        .map(|(second, _)| Listener::on(&second.run, Some(room.run.epoch_ns)))
        .collect();
    // Until every clock is known to its best.
    paced(&mut room, row.hz, 3.0);
    let (first, lo, cpu) = (room.pose().seq + 1, lo_bytes(), cpu_of(&sender, &seconds));
    let measured = Instant::now();
    paced(&mut room, row.hz, row.seconds);
    let passed_s = measured.elapsed().as_secs_f64();
    let (lo, cpu_after) = (lo_bytes() - lo, cpu_of(&sender, &seconds));
    let last = room.pose().seq;
    std::thread::sleep(Duration::from_millis(500));
    let near = near.heard();
    let (mut added, mut ahead, mut lost) = (Vec::new(), Vec::new(), 0);
    for listener in far {
        let heard = listener.heard();
        for seq in first..last {
            match (near.get(&seq), heard.get(&seq)) {
                (Some(here), Some(there)) => {
                    added.push(ms(there.at_ns - here.at_ns));
                    ahead.push(ms(there.ahead_ns));
                }
                _ => lost += 1,
            }
        }
    }
    let (added, ahead) = (sorted(added), sorted(ahead));
    let cpu: Vec<f64> = cpu
        .iter()
        .zip(&cpu_after)
        .map(|(a, b)| 100.0 * (b - a) / passed_s)
        .collect();
    say(&format!(
        "{:<30}{:>7}{:>6}{:>9.3}{:>9.3}{:>9.3}{:>9.3}{:>9.3}{:>9.3}{:>8.3}{:>8.1}%{:>8.1}%{:>6.2} s  {} ms: {}, {}",
        row.name,
        added.len(),
        lost,
        at(&added, 0.5),
        at(&added, 0.99),
        at(&added, 1.0),
        at(&ahead, 0.5),
        at(&ahead, 0.99),
        at(&ahead, 0.0),
        lo as f64 / 1e6 / passed_s / row.receivers as f64 / if row.delay.is_some() { 2.0 } else { 1.0 },
        cpu[0],
        cpu[1..].iter().sum::<f64>() / row.receivers as f64,
        volume_s,
        row.must_ms,
        reached(at(&added, 0.5), row.must_ms),
        reached(at(&added, 0.99), row.must_ms),
    ));
}

/// Whether a latency keeps within what it must; one that is not known does not.
fn reached(found_ms: f64, must_ms: f64) -> &'static str {
    match found_ms <= must_ms {
        true => "reached",
        false => "NOT REACHED",
    }
}

/// Publishes poses at `hz` for so long.
fn paced(room: &mut Room, hz: f64, seconds: f64) {
    let began = Instant::now();
    let mut number = 0_u32;
    loop {
        let due = Duration::from_secs_f64(f64::from(number) / hz);
        if due.as_secs_f64() >= seconds {
            return;
        }
        std::thread::sleep(due.saturating_sub(began.elapsed()));
        room.pose();
        room.serve_late_joiners();
        number += 1;
    }
}

/// Bytes that went over the loopback so far.
fn lo_bytes() -> u64 {
    let text = std::fs::read_to_string("/sys/class/net/lo/statistics/tx_bytes").unwrap();
    text.trim().parse().unwrap()
}

/// Processor time of the sender and of each receiver, s.
fn cpu_of(sender: &Program, seconds: &[(Second, Program)]) -> Vec<f64> {
    [sender]
        .into_iter()
        .chain(seconds.iter().map(|(_, receiver)| receiver))
        .map(cpu_s)
        .collect()
}

/// Processor time of a process so far, s.
fn cpu_s(program: &Program) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", program.child.id())).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // Fields 14 and 15 of the whole, in ticks of a hundredth.
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn at(sorted: &[f64], share: f64) -> f64 {
    let place = (share * sorted.len() as f64) as usize;
    sorted
        .get(place.min(sorted.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

fn say(line: &str) {
    println!("{line}");
}
