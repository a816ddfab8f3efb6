//! A receiver with a valid certificate that declares and asks without end.

use std::mem::forget;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use tempfile::TempDir;
use zenoh::handlers::FifoChannel;
use zenoh::{Session, Wait};

use super::{program, receivers};
use crate::forger::config;
use crate::rig::{Program, Room, Second, alone, free_endpoint, keys, until, world};

/// What zenoh keeps or works at whether access control allows it or not.
const KINDS: [&str; 5] = ["interests", "wild", "subscribers", "queries", "clock"];

/// One thing more of this kind.
fn say(session: &Session, kind: &str, count: u64) {
    let long = "x".repeat(2000);
    match kind {
        // A publisher asks who follows its key: an interest, which no rule denies.
        "interests" => forget(
            session
                .declare_publisher(format!("trocar/1/pose/{count}"))
                .wait()
                .unwrap(),
        ),
        // The same with keys that each match all others.
        "wild" => forget(
            session
                .declare_publisher(format!("trocar/1/**/{count}/*"))
                .wait()
                .unwrap(),
        ),
        // Denied, each of them.
        "subscribers" => forget(
            session
                .declare_subscriber(format!("trocar/1/no/{count}"))
                .wait()
                .unwrap(),
        ),
        "queries" => drop(
            session
                .get("trocar/1/facts")
                .payload(long)
                .with(FifoChannel::new(1))
                .wait(),
        ),
        "clock" => drop(
            session
                .get("trocar/1/clock")
                .payload([0; 8])
                .with(FifoChannel::new(1))
                .wait(),
        ),
        other => panic!("{other}"),
    }
}

#[test]
#[ignore = "started by the tests beside it, as a process of its own"]
fn flooder() {
    let Ok(asked) = std::env::var("TROCAR_FLOOD") else {
        return;
    };
    let words: Vec<&str> = asked.split(' ').collect();
    let [kind, endpoint, keys]: [&str; 3] = words.try_into().unwrap();
    let config = config("client", endpoint, &receivers(Some(keys)), Path::new(keys));
    let session = zenoh::open(config).wait().unwrap();
    let mut count = 0;
    loop {
        say(&session, kind, count);
        count += 1;
    }
}

/// A sender that may be another program, to see what this one is held against.
fn sending(keys: &str) -> Command {
    let Ok(other) = std::env::var("TROCAR_OTHER_SENDER") else {
        return program("send", Some(keys));
    };
    let mut command = Command::new(other);
    command.args(["send", "--keys", keys]);
    command
}

/// A room with a good receiver and a flooder.
struct Flood {
    room: Room,
    second: Second,
    sender: Program,
    _receiver: Program,
    endpoint: String,
    keys: String,
    world: TempDir,
}

impl Flood {
    fn open() -> Self {
        let world = world();
        let keys = keys(world.path(), "localhost");
        let endpoint = free_endpoint().replace("tcp/127.0.0.1", "tls/localhost");
        let mut room = Room::open(world.path(), Duration::from_secs(1), [40, 30, 20], |_| {});
        let sender = room.send_by(sending(&keys), world.path(), &endpoint);
        let second = Second::open(world.path(), "second", &endpoint);
        let receiver = second.receive_by(program("receive", Some(&keys)), world.path(), &endpoint, &room.id());
        until("the first pose", || {
            room.serve_late_joiners();
            room.pose();
            second.poses.next().unwrap()
        });
        Self {
            room,
            second,
            sender,
            _receiver: receiver,
            endpoint,
            keys,
            world,
        }
    }

    fn start(&self, kind: &str) -> Program {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--ignored", "--exact", "forged::floods::flooder", "--nocapture"]);
        command.env("TROCAR_FLOOD", format!("{kind} {} {}", self.endpoint, self.keys));
        Program::start(self.world.path(), "flooder", command)
    }

    /// Publishes a pose, and adds to `came` what came of them.
    fn pose(&mut self, came: &mut Vec<u64>) -> u64 {
        let seq = self.room.pose().seq;
        std::thread::sleep(Duration::from_millis(16));
        while let Some(pose) = self.second.poses.next().unwrap() {
            came.push(pose.seq);
        }
        seq
    }

    /// Seconds of processor time that the sender took.
    fn processor_s(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.sender.child.id())).unwrap();
        let numbers: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
        // Of 100 a second, in user's and in system's time.
        (numbers[11].parse::<f64>().unwrap() + numbers[12].parse::<f64>().unwrap()) / 100.0
    }

    /// A number of `/proc/PID/status` of the sender.
    fn status(&self, name: &str) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.sender.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        line.split_whitespace().next().unwrap().parse().unwrap()
    }
}

#[test]
fn who_declares_or_asks_without_end_is_cut_off_and_the_others_go_on() {
    let _alone = alone();
    for kind in KINDS {
        let mut flood = Flood::open();
        let flooder = flood.start(kind);
        let mut came = Vec::new();
        until("the end of its link", || {
            flood.pose(&mut came);
            flood.sender.said().contains("cut off").then_some(())
        });
        // It dials again and again, and is not let in: whoever could go on would take more and more.
        let kib = flood.status("RssAnon:");
        let cut_off = Instant::now();
        for _ in 0..200 {
            flood.pose(&mut came);
        }
        let newest = flood.pose(&mut came);
        until("a pose of after it", || {
            flood.pose(&mut came);
            (came.last() > Some(&newest)).then_some(())
        });
        let grown = flood.status("RssAnon:").saturating_sub(kib);
        assert!(kib < 64 << 10 && grown < 8 << 10, "{kind}: {kib} KiB, and {grown} more");
        // After a minute it may begin anew.
        let times = flood.sender.said().matches("cut off").count();
        assert!(
            times == 1 || cut_off.elapsed() > Duration::from_secs(50),
            "{kind}: {times} times"
        );
        drop(flooder);
    }
}

#[test]
fn the_senders_memory_has_a_bound() {
    let _alone = alone();
    let flood = Flood::open();
    let limits = std::fs::read_to_string(format!("/proc/{}/limits", flood.sender.child.id())).unwrap();
    let line = limits.lines().find(|line| line.starts_with("Max data size")).unwrap();
    let bound: u64 = line.split_whitespace().nth(3).unwrap().parse().unwrap();
    assert_eq!(bound, remote_proc::link::watch::MOST_MEMORY);
    // What counts against it, in KiB, is far from it.
    assert!(
        flood.status("VmData:") << 10 < bound / 4,
        "{} KiB",
        flood.status("VmData:")
    );
}

/// `TROCAR_FLOOD_S=20 cargo test --test run -- --ignored --nocapture what_a_flood_costs`, also with `TROCAR_OTHER_SENDER=PROGRAM`.
#[test]
#[ignore = "prints what each flood costs, for half a minute each"]
fn what_a_flood_costs_is_printed() {
    let _alone = alone();
    let seconds = std::env::var("TROCAR_FLOOD_S").map_or(20, |text| text.parse().unwrap());
    for kind in KINDS {
        let mut flood = Flood::open();
        let (before, processor_s) = (flood.status("RssAnon:"), flood.processor_s());
        let flooder = flood.start(kind);
        let (began, mut came, mut sent, mut most) = (Instant::now(), Vec::new(), 0, 0);
        while began.elapsed() < Duration::from_secs(seconds) {
            flood.pose(&mut came);
            sent += 1;
            most = most.max(flood.status("RssAnon:"));
        }
        let processor_s = flood.processor_s() - processor_s;
        drop(flooder);
        until("the end of it", || {
            let seq = flood.pose(&mut came);
            (came.last() == Some(&seq)).then_some(())
        });
        let gaps = came.windows(2).filter(|two| two[1] != two[0] + 1).count();
        let load = std::fs::read_to_string("/proc/loadavg").unwrap();
        println!(
            "{kind}: {sent} poses in {seconds} s, {} came by the end, {gaps} gaps; sender {before} KiB, then at most {most}, {processor_s} s of \
             processor; load {load}{}",
            came.len(),
            flood.sender.said()
        );
    }
}
