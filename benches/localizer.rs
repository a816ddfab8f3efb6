//! How long a pose takes from a localizer's socket to the run, beside a socket alone.
//!
//! `cargo bench --bench localizer -- [SECONDS] [cut CYCLES] [pulled CYCLES] [grown CYCLES]` (20 s for each rate): a server in this process sends TRANSFORMs of a tool with a
//! status at 60, 500 and 4000 Hz, to `localizer-proc` of a real run and, in the same moment, to a thread that only reads its
//! socket. The time is from the end of the server's write to the stamp of publication on `tool-pose`, or to the reader's clock. With `cut`,
//! the connection is closed so many times, and the localizer's descriptors and memory are counted before and after. With `pulled`, a peer that
//! is a process of its own is stopped, dies, or (as root, with `ip`) has its cable pulled, so many times each: printed is when the images said so,
//! and when they were live again. With `grown`, such a peer is stopped and pulled in turn, each time for longer than the connection lasts, and what every process
//! of the run holds is printed after 20, 200 and all cycles; it fails where descriptors or memory have grown.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "durations for people, which never reach a bus")]

#[path = "localizer/grown.rs"]
mod grown;
#[path = "localizer/pulled.rs"]
mod pulled;
#[path = "../tests/support/mod.rs"]
mod support;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::thread;
use std::time::Duration;

use bus::Bus;
use bus::clock::{Clock, monotonic_ns, ms};
use bus::message::{MarkerFrame, ToolPose};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{MARKERS, TOOL_POSE};
use igtl::{Body, DeviceName, Matrix, Message, Metadata, Stamp, TRANSFORM_STATUS, Text, US_ASCII, Version};
use support::{Pilot, SMALL, World, pid_in, wait_for};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let seconds = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(20.0);
    let after = |word: &str| {
        let place = arguments.iter().position(|a| a == word);
        place.and_then(|place| arguments.get(place + 1)?.parse::<u64>().ok())
    };
    if let Some(port) = after("peer") {
        return pulled::peer(&arguments[2], port as u16);
    }
    let cycles = after("cut");
    let load = std::fs::read_to_string("/proc/loadavg").unwrap();
    println!("load {}", load.split_whitespace().take(2).collect::<Vec<_>>().join(" "));
    if let Some(cycles) = after("grown") {
        return grown::measure(cycles);
    }
    if let Some(cycles) = after("pulled") {
        return pulled::measure(cycles);
    }
    let bench = Bench::start();
    match cycles {
        Some(cycles) => bench.cut(cycles),
        None => [60.0, 500.0, 4000.0].into_iter().for_each(|hz| bench.rate(hz, seconds)),
    }
}

/// A run that follows a server of this process.
struct Bench {
    // The pilot goes before its world.
    pid: u64,
    clock: Clock,
    bus: Bus,
    listener: TcpListener,
    _world: &'static World,
    _pilot: Pilot<'static>,
}

impl Bench {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let scene = SMALL
            .replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
            .replace("[recording]\n", "")
            + &format!(
                "[tracker.markers]\nmarker = \"T\"\n[localizer]\nkind = \"openigtlink\"\npeer = \"plus\"\naddress = \"127.0.0.1:{port}\"\n"
            );
        let world: &'static World = Box::leak(Box::new(World::new()));
        let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let status = pilot.wait_for("the localizer", |status| pid_in(status, "localizer").is_some());
        let bus = Bus::join(&context).unwrap();
        Self {
            pid: pid_in(&status, "localizer").unwrap(),
            clock: bus.clock().clone(),
            bus,
            listener,
            _world: world,
            _pilot: pilot,
        }
    }

    fn rate(&self, hz: f64, seconds: f64) {
        let (mut stream, _) = self.listener.accept().unwrap();
        stream.set_nodelay(true).unwrap();
        let poses = Subscriber::<ToolPose>::open(&self.bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap();
        // What was there before is none of this rate.
        while poses.next().unwrap().is_some() {}
        let count = (hz * seconds) as usize;
        let (mut alone, read) = reader(count);
        let busy = cpu_s(self.pid);
        let began = self.clock.now_ns();
        let (mut sent, mut taken) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut stamps: Vec<i64> = Vec::with_capacity(count);
        for i in 0..count {
            self.clock.sleep_until(began + (i as f64 / hz * 1e9) as i64);
            let stamp_ns = STAMP_NS + self.clock.now_ns();
            stamps.push(stamp_ns);
            let message = message(i, stamp_ns);
            alone.write_all(&message).unwrap();
            let alone_ns = monotonic_ns();
            stream.write_all(&message).unwrap();
            sent.push([alone_ns, self.clock.now_ns()]);
            taken.extend(std::iter::from_fn(|| poses.next().unwrap()));
        }
        thread::sleep(Duration::from_millis(200));
        taken.extend(std::iter::from_fn(|| poses.next().unwrap()));
        let share = (cpu_s(self.pid) - busy) / ms(self.clock.now_ns() - began) * 1e3;
        // A pose has its message's stamp.
        let of = |pose: &ToolPose| stamps.binary_search(&pose.t_device_ns).ok();
        let ours: Vec<i64> = taken
            .iter()
            .filter_map(|pose| Some(pose.t_publish_ns - sent.get(of(pose)?)?[1]))
            .collect();
        let socket: Vec<i64> = read
            .join()
            .unwrap()
            .iter()
            .zip(&sent)
            .map(|(at, sent)| at - sent[0])
            .collect();
        println!(
            "{hz:>6.0} Hz: {count} sent, {} poses, {} lost; to tool-pose {}; a socket alone {}; {:.1} % of a core",
            ours.len(),
            count - ours.len(),
            spread(ours),
            spread(socket),
            100.0 * share
        );
    }

    fn cut(&self, cycles: u64) {
        let frames = Subscriber::<MarkerFrame>::open(&self.bus, &MARKERS, "", MARKERS.buffer).unwrap();
        let mut back = Vec::new();
        let before = resources(self.pid);
        for _ in 0..cycles {
            let (mut stream, _) = self.listener.accept().unwrap();
            let accepted_ns = self.clock.now_ns();
            stream.write_all(&message(0, STAMP_NS)).unwrap();
            wait_for("a frame", || {
                std::iter::from_fn(|| frames.next().unwrap())
                    .find(|frame| frame.sights().is_ok_and(|s| s[0].status == 0))
            });
            back.push(self.clock.now_ns() - accepted_ns);
        }
        let after = resources(self.pid);
        println!(
            "{cycles} connections: a pose {} after each; descriptors and KiB {before:?} before, {after:?} after",
            spread(back)
        );
    }
}

/// The server's clock: some day in 2026.
const STAMP_NS: i64 = 1_790_000_000_000_000_000;

fn message(i: usize, stamp_ns: i64) -> Vec<u8> {
    let text = Text {
        encoding: US_ASCII,
        bytes: b"OK".to_vec(),
    };
    // No two alike.
    let place = [(i % 1000) as f32 / 7.0, (i / 1000) as f32, -1500.0];
    let matrix = Matrix {
        translation: place,
        ..Matrix::IDENTITY
    };
    let mut message = Message::new(DeviceName::new("T").unwrap(), Body::Transform(matrix)).in_version(Version::Two);
    message.stamp = Stamp::of_ns(stamp_ns.unsigned_abs()).unwrap();
    message.metadata = Metadata::EMPTY.with(TRANSFORM_STATUS, text);
    message.to_vec().unwrap()
}

/// A socket alone: when each of `count` messages had come.
fn reader(count: usize) -> (TcpStream, thread::JoinHandle<Vec<i64>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let sender = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    sender.set_nodelay(true).unwrap();
    let (mut receiver, _) = listener.accept().unwrap();
    let mut room = vec![0; message(0, STAMP_NS).len()];
    let read = thread::spawn(move || {
        let one = |_| {
            receiver.read_exact(&mut room).unwrap();
            monotonic_ns()
        };
        (0..count).map(one).collect()
    });
    (sender, read)
}

fn spread(mut ns: Vec<i64>) -> String {
    ns.sort_unstable();
    let at = |share: f64| {
        ns.get((share * (ns.len().max(1) - 1) as f64) as usize)
            .map_or(f64::NAN, |ns| *ns as f64 / 1e3)
    };
    format!("p50 {:.0} p99 {:.0} most {:.0} us", at(0.5), at(0.99), at(1.0))
}

/// Seconds of processor time.
fn cpu_s(pid: u64) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    // User and system time are the 14th and 15th field, in hundredths.
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

/// Open descriptors, and KiB in memory.
fn resources(pid: u64) -> (usize, u64) {
    let descriptors = std::fs::read_dir(Path::new("/proc").join(pid.to_string()).join("fd"))
        .unwrap()
        .count();
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    (descriptors, line.split_whitespace().next().unwrap().parse().unwrap())
}
