//! How late poses are at a client of OpenIGTLink's C++ library, also while a volume goes out and while a client takes nothing.
//!
//! `cargo bench -p gateway-proc --bench gateway`; with `-- 4 poses` four times over, and of poses alone; with `-- 4 poses 60` at 60 Hz alone,
//! and with `TROCAR_BENCH_OTHER=PROGRAM` of another build of this program. As root also under `chrt -f 10`.
//! Wants g++ and libopenigtlink-dev. Times are from the publication on `tool-pose` to the unpacked message in the client's hands; those of
//! the library alone are from before its message is packed.

#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    dead_code,
    reason = "a measurement: it prints what it finds, and what is missing ends it"
)]

#[path = "../../tests/interop/peers.rs"]
mod peers;
#[path = "../../tests/interop/rig.rs"]
mod rig;

use std::io::{BufRead, BufReader, Lines};
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use geometry::{Affine, VolumeGrid};
use rig::{Rig, SCENE};

/// The examination of a wide thorax: 209.7 MB.
const DIMS: [i64; 3] = [512, 512, 400];

/// Set where this very program is the gateway: it is started by itself, so that no other has to be built.
const AS_GATEWAY: &str = "TROCAR_BENCH_GATEWAY";

/// Another build of this program, to be measured in place of this one.
const OTHER: &str = "TROCAR_BENCH_OTHER";

pub(crate) fn gateway() -> Command {
    let other = std::env::var_os(OTHER).map(Into::into);
    let mut command = Command::new(other.unwrap_or_else(|| std::env::current_exe().unwrap()));
    command.env(AS_GATEWAY, "1");
    command
}

pub(crate) fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().to_owned()
}

/// The latencies that a client printed, us, in order.
fn latencies(child: Child) -> Vec<f64> {
    let mut all: Vec<f64> = peers::lines(child)
        .iter()
        .map(|line| line.parse::<f64>().unwrap() / 1e3)
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

fn share(sorted: &[f64], share: f64) -> f64 {
    let at = (sorted.len() as f64 * share).ceil() as usize;
    sorted[at.clamp(1, sorted.len()) - 1]
}

fn said(what: &str, sorted: &[f64]) -> f64 {
    let p99 = share(sorted, 0.99);
    println!(
        "{what:<56} p50 {:>7.0} us  p90 {:>7.0}  p99 {p99:>7.0}  max {:>8.0}  n {}  load {}",
        share(sorted, 0.5),
        share(sorted, 0.9),
        sorted[sorted.len() - 1],
        sorted.len(),
        load()
    );
    p99
}

/// Publishes at this pace until the client has all that it waits for.
fn measured(rig: &Rig, peer: &Path, (hz, count): (u64, usize), seq: &mut u64) -> Vec<f64> {
    let mut child = peers::start(peer, rig.address, &["latency", &count.to_string()]);
    let pace = Duration::from_nanos(1_000_000_000 / hz);
    *seq = rig.poses_until(pace, *seq, Some(&mut child), u64::MAX);
    latencies(child)
}

/// How long the C++ client waits for the volume of this server, as it says itself.
fn volume(peer: &Path, address: SocketAddr) -> Child {
    peers::start(peer, address, &["volume"])
}

/// The C++ library as the server, once it listens; where, and what it prints from then on.
fn served(peer: &Path, arguments: &[&str]) -> (Child, SocketAddr, Lines<BufReader<ChildStdout>>) {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut server = Command::new(peer)
        .args(["127.0.0.1", &free.port().to_string()])
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(server.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "listening");
    (server, free, lines)
}

/// The alternative: a server made of the library alone, which has its poses from nobody, to the same client.
fn library(peer: &Path, (hz, count): (u64, usize)) -> Vec<f64> {
    let (mut server, address, _lines) = served(peer, &["beat", &hz.to_string()]);
    let all = latencies(peers::start(peer, address, &["latency", &count.to_string()]));
    // It ends with its client.
    server.wait().unwrap();
    all
}

fn anchor(peer: &Path) {
    let (mut server, free, mut lines) = served(peer, &["anchor"]);
    let client = peers::lines(volume(peer, free));
    println!(
        "C++ library to C++ library, 209.7 MB: {}; {}",
        client[0],
        lines.next().unwrap().unwrap()
    );
    server.wait().unwrap();
}

fn main() -> std::process::ExitCode {
    if std::env::var_os(AS_GATEWAY).is_some() {
        return gateway_proc::cli::main();
    }
    measure();
    std::process::ExitCode::SUCCESS
}

fn measure() {
    let Some(peer) = peers::cxx() else { return };
    let rounds: usize = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(1);
    let rig = Rig::of(SCENE, |_| ());
    let mut seq = 0;
    // Of one pace alone, in Hz, for short comparisons; what a client prints must fit into a pipe.
    if let Some(hz) = std::env::args().nth(3).and_then(|hz| hz.parse().ok()) {
        for _ in 0..rounds {
            said(
                &format!("{hz} Hz"),
                &measured(&rig, peer, (hz, (15 * hz as usize).min(8000)), &mut seq),
            );
        }
        return;
    }
    for _ in 0..rounds {
        measured(&rig, peer, (60, 100), &mut seq);
        said("60 Hz", &measured(&rig, peer, (60, 900), &mut seq));
        said("500 Hz", &measured(&rig, peer, (500, 4000), &mut seq));
        said(
            "4000 Hz (as fast as it can, newest wins)",
            &measured(&rig, peer, (4000, 8000), &mut seq),
        );
        for (what, pace) in [
            ("60 Hz, C++ library to C++ library, no bus", (60, 900)),
            ("4000 Hz, C++ library to C++ library, no bus", (4000, 8000)),
        ] {
            said(what, &library(peer, pace));
        }
    }
    // For a comparison of two builds in turns.
    if std::env::args().nth(2).is_some_and(|what| what == "poses") {
        return;
    }
    let rows = [[0.7, 0.0, 0.0, -180.0], [0.0, 0.7, 0.0, -180.0], [0.0, 0.0, 1.0, 0.0]];
    let grid = VolumeGrid::checked(DIMS, Affine::from_rows(rows)).unwrap();
    let loader = rig.volume(&grid, |[x, y, z]| ((x + 3 * y + 7 * z) % 4096) as i16 - 1024);
    loader.serve_late_joiners();
    std::thread::sleep(Duration::from_millis(500));
    for _ in 0..rounds {
        anchor(peer);
        let quiet = said("60 Hz, before the volume", &measured(&rig, peer, (60, 600), &mut seq));
        // While one client is sent the volume again and again, another follows poses.
        let mut busy = volume(peer, rig.address);
        let mut follower = peers::start(peer, rig.address, &["latency", "600"]);
        let mut said_of = Vec::new();
        while follower.try_wait().unwrap().is_none() {
            rig.pose(seq);
            seq += 1;
            if busy.try_wait().unwrap().is_some() {
                said_of.extend(peers::lines(std::mem::replace(&mut busy, volume(peer, rig.address))));
            }
            std::thread::sleep(Duration::from_millis(16));
        }
        said_of.extend(peers::lines(busy));
        let during = said("60 Hz, while another client is sent 209.7 MB", &latencies(follower));
        println!("  p99 {:.2} times that before", during / quiet);
        said_of
            .iter()
            .for_each(|line| println!("  gateway to C++ library, 209.7 MB: {line}"));
        // What the machine itself loses to two processes that copy: the same with the library's own server beside.
        let mut follower = peers::start(peer, rig.address, &["latency", "400"]);
        let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let (theirs, own) = (std::sync::Arc::clone(&stop), peer.to_owned());
        let others = std::thread::spawn(move || {
            while !theirs.load(std::sync::atomic::Ordering::Relaxed) {
                anchor(&own);
            }
        });
        seq = rig.poses_until(Duration::from_millis(16), seq, Some(&mut follower), u64::MAX);
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
        others.join().unwrap();
        said(
            "60 Hz, while two others exchange 209.7 MB by the library",
            &latencies(follower),
        );
    }
    for _ in 0..rounds {
        let quiet = said(
            "500 Hz, before a client stops reading",
            &measured(&rig, peer, (500, 4000), &mut seq),
        );
        let mut deaf = rig.bare();
        rustix::net::sockopt::set_socket_recv_buffer_size(&deaf.stream, 2048).unwrap();
        deaf.wait_for("anything", |_| Some(()));
        let beside = said(
            "500 Hz, while one stops reading",
            &measured(&rig, peer, (500, 4000), &mut seq),
        );
        println!(
            "  p99 {:.2} times that before; {}",
            beside / quiet,
            rig.wait_for_note(|_| true)
        );
    }
}
