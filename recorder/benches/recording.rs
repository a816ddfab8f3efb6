//! What recording costs: processor time and bytes per pose, and how long it takes to find a moment.
//!
//! `cargo bench -p recorder --bench recording -- [SECONDS] [MEGABYTES] [COMPRESSION]`: 4000 poses a second, each with its truth
//! and 24 raw emitters, are published for SECONDS (20; 0: not at all) to the recorder as a process of its own, once for each
//! compression or for the one named; then moments are looked for in a file of MEGABYTES (1000; 0: none), as a replay does, by
//! its index, and by reading from the start, and what a replay must know of it, likewise. Processor time is that of the recorder's process (`/proc/PID/stat`, 10 ms ticks),
//! and that of this one for moments; poses that come late are published at once, so that none is left out.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a program for people"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{EmitterFrame, EmitterSight, Heartbeat, ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic;
use geometry::{Ct, Rigid, Tool, Vector};
use recorder::read::seek::Session;
use recorder::read::{info, reader};
use recorder::replay::facts::{Facts, facts, facts_of_all};
use recorder::replay::tape::{Delivery, Tape};
use recorder::wire::schema::{EMITTERS, TOOL_POSE};
use rustix::time::{ClockId, clock_gettime};

const RATE_HZ: u64 = 4000;
const TICK_S: f64 = 0.01;

fn main() {
    let arguments: Vec<String> = std::env::args().filter(|a| !a.starts_with("--b")).collect();
    if arguments.get(1).is_some_and(|first| first == "record") {
        // This very program, as the recorder.
        assert_eq!(
            recorder::cli::main(|_| Err("nothing is followed here".into())),
            std::process::ExitCode::SUCCESS
        );
        return;
    }
    let number = |i: usize, otherwise: u64| arguments.get(i).map_or(otherwise, |text| text.parse().unwrap());
    let (seconds, megabytes) = (number(1, 20), number(2, 1000));
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!(
        "{RATE_HZ} poses a second with truth and 24 emitters, {seconds} s each; load {}",
        load.trim()
    );
    println!(
        "{:<6} {:>10} {:>10} {:>8} {:>12} {:>8}",
        "", "poses", "missing", "CPU %", "bytes/pose", "ratio"
    );
    let mut plain = None;
    let wanted = arguments.get(3);
    let chosen = |name: &&str| seconds > 0 && wanted.is_none_or(|wanted| wanted == name);
    for compression in ["none", "lz4", "zstd"].into_iter().filter(chosen) {
        let run = Recorded::make(compression, seconds);
        let plain = *plain.get_or_insert(run.cpu_percent);
        let Recorded {
            poses,
            missing,
            cpu_percent,
            bytes_per_pose,
        } = run;
        let ratio = cpu_percent / plain;
        println!("{compression:<6} {poses:>10} {missing:>10} {cpu_percent:>8.1} {bytes_per_pose:>12.0} {ratio:>8.2}");
    }
    if megabytes > 0 {
        seek(megabytes);
    }
}

struct Recorded {
    poses: u64,
    missing: u64,
    cpu_percent: f64,
    bytes_per_pose: f64,
}

impl Recorded {
    fn make(compression: &str, seconds: u64) -> Self {
        // Closed to others, as every run's folder is.
        let closed = std::os::unix::fs::PermissionsExt::from_mode(0o700);
        let tmp = tempfile::Builder::new().permissions(closed).tempdir_in("/tmp").unwrap();
        let run = RunContext::new(tmp.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        fs::write(
            run.scene_path(),
            format!("[recording]\ncompression = \"{compression}\"\n"),
        )
        .unwrap();
        let bus = Bus::join(&run).unwrap();
        let beats: Subscriber<Heartbeat> = Subscriber::open(&bus, &topic::HEARTBEAT, "recorder", 1).unwrap();
        let out = tmp.path().join("s.mcap");
        let publishers = Publishers::open(&bus);
        let mut recorder = start(tmp.path(), &out);
        while !beats
            .newest()
            .unwrap()
            .is_some_and(|beat| beat.process_state() == ProcessState::Ready)
        {
            std::thread::sleep(Duration::from_millis(20));
        }
        let before = cpu_s(recorder.id());
        publishers.publish(&bus, RATE_HZ * seconds);
        let cpu = cpu_s(recorder.id()) - before;
        rustix::process::kill_process(
            rustix::process::Pid::from_raw(recorder.id().cast_signed()).unwrap(),
            rustix::process::Signal::TERM,
        )
        .unwrap();
        assert!(recorder.wait().unwrap().success());
        let made = Self::of(&out, 100.0 * cpu / seconds as f64);
        run.sweep();
        made
    }

    fn of(out: &Path, cpu_percent: f64) -> Self {
        let found = info::info(out).unwrap();
        assert!(found.damage.is_empty());
        let topics = &found.tally.topics;
        let poses = topics[TOOL_POSE].messages;
        assert_eq!(
            topics[EMITTERS].messages + topics[EMITTERS].seqs.missing,
            poses + topics[TOOL_POSE].seqs.missing
        );
        Self {
            poses,
            missing: topics.values().map(|topic| topic.seqs.missing).sum(),
            cpu_percent,
            bytes_per_pose: fs::metadata(out).unwrap().len() as f64 / poses as f64,
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a benchmark stands in for the pilot")]
fn start(run_dir: &Path, out: &Path) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["record", "--run-dir"])
        .arg(run_dir)
        .arg("--out")
        .arg(out)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

/// Processor time that the process has taken, user and system.
fn cpu_s(pid: u32) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    fields[11..13]
        .iter()
        .map(|ticks| ticks.parse::<f64>().unwrap() * TICK_S)
        .sum()
}

struct Publishers {
    tool: Publisher<ToolPose>,
    truth: Publisher<ToolPose>,
    emitters: Publisher<EmitterFrame>,
}

impl Publishers {
    fn open(bus: &Bus) -> Self {
        Self {
            tool: Publisher::open(bus, &topic::TOOL_POSE, "").unwrap(),
            truth: Publisher::open(bus, &topic::GROUND_TRUTH, "").unwrap(),
            emitters: Publisher::open(bus, &topic::EMITTERS, "").unwrap(),
        }
    }

    fn publish(&self, bus: &Bus, n: u64) {
        let clock = bus.clock();
        let (began, mut noise) = (clock.now_ns(), Noise(7));
        for seq in 0..n {
            clock.sleep_until(began + (seq * 1_000_000_000 / RATE_HZ).cast_signed());
            let (frame, pose, truth) = sample(seq, clock.now_ns(), &mut noise);
            self.emitters.send(frame).unwrap();
            self.tool.send(pose).unwrap();
            self.truth.send(truth).unwrap();
        }
        // The last ones are taken.
        std::thread::sleep(Duration::from_millis(1500));
    }
}

/// Uniform in -1..1: measurements differ in all their digits, so that nothing compresses better than it would.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn sample(seq: u64, now_ns: i64, noise: &mut Noise) -> (EmitterFrame, ToolPose, ToolPose) {
    let s = seq as f64 / RATE_HZ as f64;
    let mut pose = |size: f64| {
        let turn = Vector::new(0.3 * s.sin() + size * 1e-4 * noise.next(), -1.2, 0.7);
        let place = Vector::new(12.5 + size * noise.next(), -40.0 + 10.0 * s.cos(), 300.0 - s);
        let ct_from_tool: Rigid<Ct, Tool> = Rigid::from_rotation_vector(turn, place).unwrap();
        let mut pose = ToolPose {
            seq,
            t_device_ns: now_ns,
            t_capture_ns: now_ns,
            t_publish_ns: now_ns + 50_000,
            registration_id: 0xfeed,
            visible: 24,
            used: 24,
            fre_rms_mm: 0.2 + size * 0.05 * noise.next(),
            covariance: std::array::from_fn(|i| size * 1e-4 * (i as f64 + noise.next())),
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(ct_from_tool));
        pose
    };
    let (tool, truth) = (pose(0.1), pose(0.0));
    let mut sight = |emitter: u32| EmitterSight {
        place_mm: [f64::from(emitter) + noise.next(), noise.next(), 2000.0 + noise.next()],
        emitter,
        reserved: 0,
    };
    let sights: Vec<_> = (0..24).map(&mut sight).collect();
    let mut frame = EmitterFrame {
        seq,
        t_device_ns: now_ns,
        t_capture_ns: now_ns,
        t_publish_ns: now_ns,
        ..EmitterFrame::EMPTY
    };
    frame.set(sights.into_iter(), std::iter::empty()).unwrap();
    (frame, tool, truth)
}

/// Moments that are looked for.
const MOMENTS: u64 = 500;

/// Finds moments in a large file, made here without the bus.
fn seek(megabytes: u64) {
    let tmp = tempfile::tempdir_in("/tmp").unwrap();
    let path = large(tmp.path(), megabytes * 1_000_000);
    let length = fs::metadata(&path).unwrap().len() as f64 / 1e6;
    let (_, last) = Session::open(&path).unwrap().span_ns().unwrap();
    println!("looking for moments in a file of {length:.0} MB, ms:");
    println!("{:<44} {:>7} {:>7} {:>7} {:>9}", "", "p50", "p95", "most", "CPU, mean");
    let mut tape = Tape::open(&path).unwrap();
    let going = looked("poses, in a replay that is going (seek, loop)", last, |at_ns| {
        find(&mut tape, at_ns)
    });
    let mut tape = Tape::with_frames(&path, Delivery::Emitters).unwrap();
    looked("the same with the emitters (--recompute)", last, |at_ns| {
        find(&mut tape, at_ns)
    });
    looked("poses, the file opened for it (--from)", last, |at_ns| {
        find(&mut Tape::open(&path).unwrap(), at_ns);
    });
    let linear = timed(|| {
        let mut poses = reader::poses(&path, TOOL_POSE).unwrap();
        let found = poses.find(|pose| pose.as_ref().unwrap().t_capture_ns >= (last / 2).cast_signed());
        assert!(found.is_some());
    });
    let ratio = linear / going;
    println!("reading it from its start to its middle: {linear:.0} ms, {ratio:.0} times the first p50");
    known(&path);
}

/// What a replay must know before it starts: by the index, and by every message.
fn known(path: &Path) {
    let (mut by_index, mut by_all) = (Ok(Facts::default()), Ok(Facts::default()));
    let mut took: Vec<f64> = (0..10).map(|_| timed(|| by_index = facts(path))).collect();
    took.sort_by(f64::total_cmp);
    let whole = timed(|| by_all = facts_of_all(path));
    assert_eq!(by_index.unwrap(), by_all.unwrap());
    let (median, most) = (took[5], took[9]);
    println!(
        "facts of it by its index: p50 {median:.1} ms, most {most:.1} ms; by all of it: {whole:.0} ms, {:.0} times",
        whole / median
    );
}

/// Prints how long `find` takes for moments all over the file, in no order; returns the median, ms.
fn looked(what: &str, last: u64, mut find: impl FnMut(i64)) -> f64 {
    let before = clock_gettime(ClockId::ProcessCPUTime);
    let moment = |i: u64| (last / MOMENTS * (i * 211 % MOMENTS)).cast_signed();
    let mut took: Vec<f64> = (0..MOMENTS).map(|i| timed(|| find(moment(i)))).collect();
    let after = clock_gettime(ClockId::ProcessCPUTime);
    let cpu_ns = (after.tv_sec - before.tv_sec) * 1_000_000_000 + after.tv_nsec - before.tv_nsec;
    took.sort_by(f64::total_cmp);
    let rank = |percent: usize| took[(took.len() * percent).div_ceil(100) - 1];
    let cpu_ms = cpu_ns as f64 / 1e6 / MOMENTS as f64;
    println!(
        "{what:<44} {:>7.1} {:>7.1} {:>7.1} {cpu_ms:>9.1}",
        rank(50),
        rank(95),
        rank(100)
    );
    rank(50)
}

/// Goes to the first pose that was published at `at_ns` or later, as the replayer does.
fn find(tape: &mut Tape, at_ns: i64) {
    tape.near(at_ns).unwrap();
    while tape.peek().is_some_and(|next| next.due_ns() < at_ns) {
        tape.take();
    }
    assert!(tape.peek().is_some());
}

fn timed(work: impl FnOnce()) -> f64 {
    let began = monotonic_ns();
    work();
    (monotonic_ns() - began) as f64 / 1e6
}

fn large(folder: &Path, bytes: u64) -> PathBuf {
    use recorder::wire::schema::{RunFacts, Source};
    use recorder::write::pose_log::Entry;
    use recorder::write::session_file::{Content, SessionFile};
    let scene = folder.join("scene.toml");
    fs::write(&scene, "seed = 1\n").unwrap();
    let facts = RunFacts {
        name: "bench".to_owned(),
        epoch_ns: 0,
        registration_id: None,
        volume_hash: None,
        remade_from: None,
    };
    let mut file = SessionFile::create(&folder.join("large.mcap"), &Content::new(&scene, &facts)).unwrap();
    let mut noise = Noise(3);
    for seq in 0.. {
        if file.bytes() >= bytes {
            break;
        }
        let now_ns = (seq * 1_000_000_000 / RATE_HZ).cast_signed();
        let (frame, pose, truth) = sample(seq, now_ns, &mut noise);
        let frame = recorder::wire::proto::EmitterFrame::try_from(&frame).unwrap();
        file.put(Entry::Emitters(&frame)).unwrap();
        file.put(Entry::Pose(Source::Tool, &pose)).unwrap();
        file.put(Entry::Pose(Source::Truth, &truth)).unwrap();
        if seq % (RATE_HZ / 2) == 0 {
            file.flush().unwrap();
        }
    }
    file.finish().unwrap().path
}
