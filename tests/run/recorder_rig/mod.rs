//! A run with a test as its tracker, and the recorder as a process.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "shared by several tests, each of which uses a part; a step that fails here is a test that fails"
)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::EmitterSight;
use bus::message::{EmitterFrame, Heartbeat, ProcessState, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic;
use geometry::{Ct, Rigid, Tool, Vector};
use rustix::process::{Pid, Signal, kill_process};

pub const PATIENCE: Duration = Duration::from_secs(180);
pub const CHUNK_S: f64 = 0.1;

/// A run with this test as its tracker.
pub struct Rig {
    pub tmp: tempfile::TempDir,
    pub run: RunContext,
    pub tool: Publisher<ToolPose>,
    pub truth: Publisher<ToolPose>,
    pub emitters: Publisher<EmitterFrame>,
    pub beats: Subscriber<Heartbeat>,
    bus: Bus,
}

impl Rig {
    pub fn new() -> Self {
        Self::of(&format!("[recording]\nchunk_s = {CHUNK_S}\n"))
    }

    /// A run of this scene.
    pub fn of(scene: &str) -> Self {
        // Closed to others, as every run's folder is.
        let closed = fs::Permissions::from_mode(0o700);
        let tmp = tempfile::Builder::new().permissions(closed).tempdir_in("/tmp").unwrap();
        let run = RunContext::new(tmp.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        fs::write(run.scene_path(), scene).unwrap();
        let bus = Bus::keep(&run).unwrap();
        Self {
            tool: Publisher::open(&bus, &topic::TOOL_POSE, "").unwrap(),
            truth: Publisher::open(&bus, &topic::GROUND_TRUTH, "").unwrap(),
            emitters: Publisher::open(&bus, &topic::EMITTERS, "").unwrap(),
            beats: Subscriber::open(&bus, &topic::HEARTBEAT, "recorder", 1).unwrap(),
            bus,
            tmp,
            run,
        }
    }

    pub fn out(&self) -> PathBuf {
        self.tmp.path().join("s.mcap")
    }

    /// A recorder that is ready.
    pub fn start(&self) -> Recorder {
        self.start_logging_to(Stdio::inherit())
    }

    /// A recorder that is ready, with its stderr there.
    pub fn start_logging_to(&self, log: Stdio) -> Recorder {
        // As the pilot does: the places of one that was killed are free again.
        self.bus.remove_dead_processes();
        // What a dead one said last.
        let _ = self.beats.newest().unwrap();
        let run_dir = self.tmp.path().to_str().unwrap();
        let out = self.out();
        let mut command = command(&["record", "--run-dir", run_dir, "--out", out.to_str().unwrap()]);
        let recorder = Recorder(command.stderr(log).spawn().unwrap());
        self.wait_for_beat(|beat| beat.process_state() == ProcessState::Ready && beat.pid == recorder.0.id());
        recorder
    }

    pub fn wait_for_beat(&self, wanted: impl Fn(&Heartbeat) -> bool) -> Heartbeat {
        let deadline_ns = monotonic_ns() + bus::clock::ns(PATIENCE);
        while monotonic_ns() < deadline_ns {
            match self.beats.newest().unwrap() {
                Some(beat) if wanted(&beat) => return beat,
                _ => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        panic!("the recorder did not say what was waited for within {PATIENCE:?}");
    }

    /// The folder of the run, as text.
    pub fn run_dir(&self) -> &str {
        self.tmp.path().to_str().unwrap()
    }

    pub fn publish(&self, seqs: std::ops::Range<u64>) {
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

pub struct Recorder(pub Child);

impl Recorder {
    pub fn terminate(mut self) {
        let pid = Pid::from_raw(self.0.id().cast_signed()).unwrap();
        kill_process(pid, Signal::TERM).unwrap();
        assert!(self.0.wait().unwrap().success());
    }

    pub fn kill(mut self) {
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
pub fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_recorder"));
    command.args(args);
    command
}

pub fn said(args: &[&str]) -> Output {
    command(args).output().unwrap()
}

pub fn pose(seq: u64) -> ToolPose {
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

/// What the localizer saw for the pose of this number: 24 emitters of the tool, 4 on the patient.
pub fn frame(seq: u64) -> EmitterFrame {
    let pose = pose(seq);
    let sight = |emitter: u32| EmitterSight {
        place_mm: [f64::from(emitter), 100.0 / (1.0 + seq as f64), 2000.0],
        emitter,
        reserved: 0,
    };
    let mut frame = EmitterFrame {
        seq,
        t_capture_ns: pose.t_capture_ns,
        t_publish_ns: pose.t_publish_ns,
        ..EmitterFrame::EMPTY
    };
    let (tool, reference): (Vec<_>, Vec<_>) = ((0..24).map(sight).collect(), (0..4).map(sight).collect());
    frame.set(tool.into_iter(), reference.into_iter()).unwrap();
    frame
}
