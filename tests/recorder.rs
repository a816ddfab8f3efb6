//! The recorder process: what is published is on disk, whatever kills it, and other programs can read it.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{Heartbeat, ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic;
use geometry::{Ct, Rigid, Tool, Vector};
use recorder::schema::{GROUND_TRUTH, TF, TOOL_POSE};
use recorder::{info, paths, reader};
use rustix::process::{Pid, Signal, kill_process};

const PATIENCE: Duration = Duration::from_secs(20);
const CHUNK_S: f64 = 0.1;

/// A run with this test as its tracker.
struct Rig {
    tmp: tempfile::TempDir,
    run: RunContext,
    tool: Publisher<ToolPose>,
    truth: Publisher<ToolPose>,
    beats: Subscriber<Heartbeat>,
    _bus: Bus,
}

impl Rig {
    fn new() -> Self {
        let tmp = tempfile::tempdir_in("/tmp").unwrap();
        let run = RunContext::new(tmp.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        fs::write(run.scene_path(), format!("[recording]\nchunk_s = {CHUNK_S}\n")).unwrap();
        let bus = Bus::join(&run).unwrap();
        Self {
            tool: Publisher::open(&bus, &topic::TOOL_POSE, "").unwrap(),
            truth: Publisher::open(&bus, &topic::GROUND_TRUTH, "").unwrap(),
            beats: Subscriber::open(&bus, &topic::HEARTBEAT, "recorder", 1).unwrap(),
            _bus: bus,
            tmp,
            run,
        }
    }

    fn out(&self) -> PathBuf {
        self.tmp.path().join("s.mcap")
    }

    /// A recorder that is ready.
    fn start(&self) -> Recorder {
        // What a dead one said last.
        let _ = self.beats.newest().unwrap();
        let run_dir = self.tmp.path().to_str().unwrap();
        let out = self.out();
        let mut command = command(&["record", "--run-dir", run_dir, "--out", out.to_str().unwrap()]);
        let recorder = Recorder(command.spawn().unwrap());
        self.wait_for_beat(|beat| beat.process_state() == ProcessState::Ready && beat.pid == recorder.0.id());
        recorder
    }

    fn wait_for_beat(&self, wanted: impl Fn(&Heartbeat) -> bool) -> Heartbeat {
        let deadline_ns = monotonic_ns() + bus::clock::ns(PATIENCE);
        while monotonic_ns() < deadline_ns {
            match self.beats.newest().unwrap() {
                Some(beat) if wanted(&beat) => return beat,
                _ => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        panic!("the recorder did not say what was waited for within {PATIENCE:?}");
    }

    fn publish(&self, seqs: std::ops::Range<u64>) {
        for seq in seqs {
            self.tool.send(pose(seq)).unwrap();
            self.truth.send(pose(seq)).unwrap();
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.run.sweep();
    }
}

struct Recorder(Child);

impl Recorder {
    fn terminate(mut self) {
        let pid = Pid::from_raw(self.0.id().cast_signed()).unwrap();
        kill_process(pid, Signal::TERM).unwrap();
        assert!(self.0.wait().unwrap().success());
    }

    fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // Dead already unless the test failed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[expect(clippy::disallowed_methods, reason = "a test stands in for the pilot")]
fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_recorder"));
    command.args(args);
    command
}

fn said(args: &[&str]) -> Output {
    command(args).output().unwrap()
}

fn pose(seq: u64) -> ToolPose {
    let s = seq as f64 / 60.0;
    let ct_from_tool: Rigid<Ct, Tool> =
        Rigid::from_rotation_vector(Vector::new(s.sin(), -1.2, 0.7), Vector::new(12.5 + s, -40.0, 300.0 - s)).unwrap();
    let mut pose = ToolPose {
        seq,
        t_capture_ns: bus::clock::seconds(s),
        t_publish_ns: bus::clock::seconds(s) + 1_000_000,
        registration_id: 0xfeed_0000_0000_0042,
        visible: 24,
        covariance: std::array::from_fn(|i| 1e-4 * i as f64),
        fre_rms_mm: -0.0,
        ..ToolPose::EMPTY
    };
    pose.set(Tracked::Valid(ct_from_tool));
    pose
}

fn poses(path: &Path, topic: &str) -> Vec<ToolPose> {
    reader::poses(path, topic).unwrap().map(Result::unwrap).collect()
}

fn expected(n: u64) -> Vec<ToolPose> {
    (0..n).map(pose).collect()
}

#[test]
fn asked_to_stop_it_completes_the_file() {
    let rig = Rig::new();
    let recorder = rig.start();
    assert!(paths::recording(&rig.out()).exists() && !rig.out().exists());
    rig.publish(0..200);
    recorder.terminate();
    assert!(!paths::recording(&rig.out()).exists());
    assert_eq!(poses(&rig.out(), TOOL_POSE), expected(200));
    assert_eq!(poses(&rig.out(), GROUND_TRUTH), expected(200));
    let info = info::info(&rig.out()).unwrap();
    assert!(info.damage.is_empty());
    assert_eq!(info.tally.topics[TF].messages, 400);
    let beside = reader::beside(&rig.out()).unwrap();
    assert!(beside.scene.unwrap().contains("chunk_s"));
    assert_eq!(beside.run.unwrap().metadata["registration_id"], "feed000000000042");
}

#[test]
fn killed_it_loses_nothing_that_it_acknowledged() {
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..400);
    let acknowledged = rig.wait_for_beat(|beat| beat.counters.recorded > 300).counters.recorded;
    recorder.kill();
    rig.publish(400..410);
    let second = rig.start();
    rig.publish(410..450);
    second.terminate();
    let part = poses(&paths::part(&rig.out(), 1), TOOL_POSE);
    assert!(
        2 * part.len() as u64 >= acknowledged,
        "{} of {acknowledged}",
        2 * part.len()
    );
    assert_eq!(part, expected(part.len() as u64));
    // The last of the poses sent in between comes from the topic's history.
    let rest = poses(&rig.out(), TOOL_POSE);
    assert_eq!(rest, (409..450).map(pose).collect::<Vec<_>>());
    assert!(!paths::recording(&rig.out()).exists());
}

#[test]
fn an_unfinished_file_is_shown_and_recovered() {
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..100);
    rig.wait_for_beat(|beat| beat.counters.recorded == 200);
    recorder.kill();
    let growing = paths::recording(&rig.out());
    let growing = growing.to_str().unwrap();

    let shown = said(&["info", growing]);
    let text = String::from_utf8(shown.stdout).unwrap();
    assert!(
        shown.status.success() && text.contains("its recording was never finished"),
        "{text}"
    );

    let recovered = said(&["recover", growing]);
    let text = String::from_utf8(recovered.stdout).unwrap();
    assert!(recovered.status.success(), "{text}");
    assert!(text.starts_with("recovered 400 messages into "), "{text}");
    assert_eq!(poses(&rig.out(), TOOL_POSE), expected(100));

    let again = said(&["recover", growing]);
    let text = String::from_utf8(again.stderr).unwrap();
    assert!(!again.status.success() && text.contains("exists already"), "{text}");
    assert!(said(&["recover", growing, "--force"]).status.success());
}

#[test]
fn a_folder_that_is_not_there_is_explained() {
    let rig = Rig::new();
    let run_dir = rig.tmp.path().to_str().unwrap();
    let said = said(&["record", "--run-dir", run_dir, "--out", "/nonexistent/s.mcap"]);
    let text = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(1));
    assert!(
        text.contains("creating /nonexistent/s.mcap.recording: No such file"),
        "{text}"
    );
}

/// Runs the public Python readers over `path`.
#[expect(
    clippy::disallowed_methods,
    reason = "an independent reader is the point of the test"
)]
fn python(interpreter: &str, path: &Path) -> Output {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_mcap.py");
    Command::new(interpreter).arg(script).arg(path).output().unwrap()
}

fn hex(value: f64) -> String {
    format!("{:016x}", value.to_bits())
}

#[test]
fn python_reads_every_field() {
    let Ok(interpreter) = std::env::var("TROCAR_PYTHON") else {
        println!("skipped: TROCAR_PYTHON names no interpreter with mcap and mcap-protobuf-support");
        return;
    };
    let rig = Rig::new();
    let recorder = rig.start();
    rig.publish(0..50);
    rig.wait_for_beat(|beat| beat.counters.recorded == 100);
    // Python's reader wants the index: before it is there, it reads nothing.
    let unfinished = python(&interpreter, &paths::recording(&rig.out()));
    assert!(!unfinished.status.success());
    recorder.terminate();

    let read = python(&interpreter, &rig.out());
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let seen: serde_json::Value = serde_json::from_slice(&read.stdout).unwrap();
    assert_eq!(
        seen["counts"],
        serde_json::json!({ TOOL_POSE: 50, GROUND_TRUTH: 50, TF: 100 })
    );
    let (found, sent) = (&seen["first"][TOOL_POSE], pose(0));
    assert_eq!(found["registration_id"], sent.registration_id);
    assert_eq!(found["t_publish_ns"], sent.t_publish_ns);
    assert_eq!(found["q"], serde_json::json!(sent.q.map(hex)));
    assert_eq!(found["t_mm"], serde_json::json!(sent.t_mm.map(hex)));
    assert_eq!(found["covariance"], serde_json::json!(sent.covariance.map(hex)));
    assert_eq!(found["fre_rms_mm"], hex(-0.0));
    assert_eq!(seen["metadata"][0]["record"], "run");
    let tf = &seen["first"][TF];
    assert_eq!(tf["t_metres"], serde_json::json!(sent.t_mm.map(|mm| hex(mm / 1e3))));
    let [w, x, y, z] = sent.q;
    assert_eq!(tf["q_xyzw"], serde_json::json!([x, y, z, w].map(hex)));
}
