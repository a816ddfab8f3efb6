//! A run that is shown, made by hand so that it can lie, and one that shows it.

use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{
    ClockLaw, Event, FrameStamp, Guide, Heartbeat, Identity, Level, ToolPose, Tracked, VolumeHash, VolumeHeader,
    Workflow,
};
use bus::port::{Publisher, Subscriber, VolumePublisher, VolumeSubscriber};
use bus::run::{RUNTIME_DIR_VARIABLE, RemoteOf, RunContext, RunLock};
use bus::topic::{EVENT, FRAME_STAMP, GUIDE, HEARTBEAT, IDENTITY, SESSION_CLOCK, TOOL_POSE, WORKFLOW};
use bus::volume::{Hasher, Layout, Marks, SliceHash};
use geometry::{Affine, Rigid, VolumeGrid};
use tempfile::TempDir;

/// Far beyond what anything takes on a busy machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
const SCENE: &str = "[tracker]\nsource = \"external\"\n[tissue]\norgans = \"organs.toml\"\n";

/// One at a time: each has processes and links of its own, and two cores are all there are.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder for all runs of a test, with a short path.
pub(crate) fn world() -> TempDir {
    tempfile::Builder::new().prefix("tr").tempdir_in("/tmp").unwrap()
}

/// A port of the loopback that nobody listens at.
pub(crate) fn free_endpoint() -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}")
}

/// Looks again and again until `is` gives something.
pub(crate) fn until<T>(what: &str, mut is: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = is() {
            return found;
        }
        assert!(
            began.elapsed() < PATIENCE,
            "{what}: not within {} s",
            PATIENCE.as_secs()
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn run(world: &Path, name: &str, epoch_ns: i64, change: impl FnOnce(&mut RunContext)) -> (RunLock, RunContext, Bus) {
    let dir = world.join(name);
    let lock = RunLock::acquire(&dir).unwrap();
    let mut run = RunContext::new(&dir, epoch_ns).unwrap();
    change(&mut run);
    run.store_scene(SCENE).unwrap();
    let bus = Bus::keep(&run).unwrap();
    run.store().unwrap();
    (lock, run, bus)
}

/// A process under test; killed with the test. What it says is kept.
pub(crate) struct Program {
    pub(crate) child: Child,
    said: PathBuf,
}

impl Program {
    pub(crate) fn start(world: &Path, name: &str, mut command: Command) -> Self {
        let said = world.join(format!("{name}.log"));
        command
            .env(RUNTIME_DIR_VARIABLE, world)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        command.stderr(std::fs::File::create(&said).unwrap());
        Self {
            child: command.spawn().unwrap(),
            said,
        }
    }

    pub(crate) fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap()
    }

    pub(crate) fn ended(&mut self) -> ExitStatus {
        self.ended_while(|| {})
    }

    /// `meanwhile` is done again and again.
    pub(crate) fn ended_while(&mut self, meanwhile: impl Fn()) -> ExitStatus {
        until("the end of a process", || {
            meanwhile();
            self.child.try_wait().unwrap()
        })
    }

    pub(crate) fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).unwrap();
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            println!("{}:\n{}", self.said.display(), self.said());
        }
    }
}

pub(crate) fn remote_proc() -> Command {
    Command::new(env!("CARGO_BIN_EXE_remote-proc"))
}

fn verb(verb: &str) -> Command {
    let mut command = remote_proc();
    command.arg(verb);
    command
}

/// A folder with keys for a sender at `host`.
pub(crate) fn keys(world: &Path, host: &str) -> String {
    let out = world.join("keys");
    let mut command = remote_proc();
    let made = command
        .arg("keys")
        .arg("--out")
        .arg(&out)
        .args(["--host", host])
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    out.to_string_lossy().into_owned()
}

/// A run that navigates, as far as others can see: examination, poses, states.
pub(crate) struct Room {
    pub(crate) run: RunContext,
    _lock: RunLock,
    pub(crate) bus: Bus,
    stamps: Publisher<FrameStamp>,
    pub(crate) poses: Publisher<ToolPose>,
    pub(crate) guides: Publisher<Guide>,
    pub(crate) workflows: Publisher<Workflow>,
    pub(crate) identities: Publisher<Identity>,
    pub(crate) events: Publisher<Event>,
    volumes: VolumePublisher,
    pub(crate) hash: VolumeHash,
    pub(crate) header: VolumeHeader,
    seq: u64,
}

impl Room {
    /// Its clock began `age` ago. `lie` changes the header that is published.
    pub(crate) fn open(world: &Path, age: Duration, dims: [u32; 3], lie: impl FnOnce(&mut VolumeHeader)) -> Self {
        let epoch_ns = monotonic_ns() - bus::clock::ns(age);
        let (lock, run, bus) = run(world, "room", epoch_ns, |_| {});
        let layout = Layout::choose(dims).unwrap();
        let volumes = VolumePublisher::open(&bus, &layout).unwrap();
        let (grid, mut loan) = (grid(dims), volumes.loan().unwrap());
        let mut hasher = Hasher::new(&grid, -1000);
        let [nx, ny, nz] = dims;
        for k in 0..nz {
            let slice: Vec<i16> = (0..nx * ny).map(|i| (i.wrapping_mul(7) + k * 31) as i16).collect();
            layout.scatter(k, &slice, loan.voxels_mut());
            hasher.update(SliceHash::of(&slice));
        }
        let hash = hasher.finish();
        let mut header = VolumeHeader::new(&grid, &layout, -1000, hash, Marks::NONE);
        lie(&mut header);
        loan.publish(header).unwrap();
        let room = Self {
            stamps: Publisher::open(&bus, &FRAME_STAMP, "view-axial").unwrap(),
            poses: Publisher::open(&bus, &TOOL_POSE, "").unwrap(),
            guides: Publisher::open(&bus, &GUIDE, "").unwrap(),
            workflows: Publisher::open(&bus, &WORKFLOW, "").unwrap(),
            identities: Publisher::open(&bus, &IDENTITY, "").unwrap(),
            events: Publisher::open(&bus, &EVENT, "pilot").unwrap(),
            _lock: lock,
            volumes,
            hash,
            header,
            run,
            bus,
            seq: 0,
        };
        room.shows(room.header.volume_hash());
        room
    }

    /// Publishes the next pose; what went out.
    pub(crate) fn pose(&mut self) -> ToolPose {
        let now = self.bus.clock().now_ns();
        let mut pose = ToolPose {
            seq: self.seq,
            t_capture_ns: now,
            t_publish_ns: now,
            t_device_ns: i64::MAX - self.seq as i64,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(Rigid::identity()));
        pose.t_mm[0] = self.seq as f64 / 3.0;
        self.seq += 1;
        self.poses.send(pose).unwrap();
        pose
    }

    pub(crate) fn serve_late_joiners(&self) {
        self.volumes.serve_late_joiners();
        self.stamps.serve_late_joiners();
        self.guides.serve_late_joiners();
        self.workflows.serve_late_joiners();
        self.identities.serve_late_joiners();
        self.events.serve_late_joiners();
    }

    pub(crate) fn event(&self, seq: u64, words: &str) {
        let event = Event::new(seq, self.bus.clock().now_ns(), Level::Info, words);
        self.events.send(event).unwrap();
    }

    /// The sender beside it.
    pub(crate) fn send(&self, world: &Path, endpoint: &str) -> Program {
        self.send_by(verb("send"), world, endpoint)
    }

    pub(crate) fn send_by(&self, mut command: Command, world: &Path, endpoint: &str) -> Program {
        command.args(["--run", "room", "--listen", endpoint]);
        Program::start(world, "send", command)
    }

    /// As [`remote_proc::protocol::Facts::run_id`] has it.
    pub(crate) fn id(&self) -> String {
        format!("{:016x}", remote_proc::send::run_id(&self.run, SCENE))
    }

    /// An image of this examination is shown.
    pub(crate) fn shows(&self, hash: VolumeHash) {
        let stamp = FrameStamp {
            volume_hash: hash.0,
            ..FrameStamp::default()
        };
        self.stamps.send(stamp).unwrap();
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        self.run.sweep();
    }
}

pub(crate) fn grid(dims: [u32; 3]) -> VolumeGrid {
    let rows = [[0.7, 0.0, 0.0, -9.0], [0.0, 0.7, 0.0, 5.0], [0.0, 0.1, 1.5, 2.0]];
    VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(rows)).unwrap()
}

/// A run of another machine, as far as this test can see: what `pilot remote` would have made.
pub(crate) struct Second {
    pub(crate) run: RunContext,
    _lock: RunLock,
    pub(crate) bus: Bus,
    pub(crate) volumes: VolumeSubscriber,
    pub(crate) poses: Subscriber<ToolPose>,
    pub(crate) laws: Subscriber<ClockLaw>,
    pub(crate) beats: Subscriber<Heartbeat>,
    pub(crate) guides: Subscriber<Guide>,
    pub(crate) workflows: Subscriber<Workflow>,
    pub(crate) identities: Subscriber<Identity>,
    pub(crate) events: Subscriber<Event>,
}

impl Second {
    pub(crate) fn open(world: &Path, name: &str, endpoint: &str) -> Self {
        let (lock, run, bus) = run(world, name, monotonic_ns(), |run| {
            run.remote = Some(RemoteOf {
                endpoint: endpoint.to_owned(),
                run: "room".to_owned(),
            });
        });
        Self {
            volumes: VolumeSubscriber::open(&bus).unwrap(),
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap(),
            laws: Subscriber::open(&bus, &SESSION_CLOCK, "", 1).unwrap(),
            beats: Subscriber::open(&bus, &HEARTBEAT, "remote", 1).unwrap(),
            guides: Subscriber::open(&bus, &GUIDE, "", GUIDE.buffer).unwrap(),
            workflows: Subscriber::open(&bus, &WORKFLOW, "", WORKFLOW.buffer).unwrap(),
            identities: Subscriber::open(&bus, &IDENTITY, "", 1).unwrap(),
            events: Subscriber::open(&bus, &EVENT, "remote", EVENT.buffer).unwrap(),
            _lock: lock,
            run,
            bus,
        }
    }

    /// The receiver in it.
    pub(crate) fn receive(&self, world: &Path, endpoint: &str, id: &str) -> Program {
        self.receive_by(verb("receive"), world, endpoint, id)
    }

    pub(crate) fn receive_by(&self, mut command: Command, world: &Path, endpoint: &str, id: &str) -> Program {
        command
            .args([endpoint, "--session", id, "--run-dir"])
            .arg(&self.run.dir);
        Program::start(world, &self.run.name, command)
    }

    /// What the receiver says of itself.
    pub(crate) fn note(&self) -> Option<String> {
        self.beats.newest().unwrap().map(|beat| beat.note_text())
    }
}

impl Drop for Second {
    fn drop(&mut self) {
        self.run.sweep();
    }
}

/// All that `command` says on stderr; it must fail.
pub(crate) fn refused(mut command: Command) -> String {
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(!child.wait().unwrap().success(), "{said}");
    said
}
