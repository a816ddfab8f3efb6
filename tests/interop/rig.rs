//! A run with a test as its tracker, its loader, its renderer and its pilot, and the gateway as a process.

#![allow(clippy::disallowed_methods, reason = "a test stands in for the pilot")]

use std::fs;
use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{FrameHeader, Guide, Heartbeat, Lost, MarkerFrame, ToolPose, Tracked, VolumeHeader, Workflow};
use bus::port::{FramePublisher, Publisher, Subscriber, VolumePublisher};
use bus::run::{ReplayOf, RunContext};
use bus::topic;
use bus::volume::{Hasher, Layout, Marks, SliceHash};
use geometry::{Ct, Rigid, Tool, Vector, VolumeGrid};
use igtl::{Decoder, Limits, Message};

const PATIENCE: Duration = Duration::from_secs(60);

/// Any free port of this machine.
pub(crate) const SCENE: &str = "[gateway]\naddress = \"127.0.0.1:0\"\n";

pub(crate) struct Rig {
    pub(crate) run: RunContext,
    pub(crate) tool: Publisher<ToolPose>,
    pub(crate) workflow: Publisher<Workflow>,
    pub(crate) guide: Publisher<Guide>,
    pub(crate) markers: Publisher<MarkerFrame>,
    beats: Subscriber<Heartbeat>,
    pub(crate) bus: Bus,
    pub(crate) address: SocketAddr,
    gateway: Child,
    _folder: tempfile::TempDir,
}

/// A pose that no other number has, on the patient's left and to his back.
pub(crate) fn place(seq: u64) -> Rigid<Ct, Tool> {
    let s = seq as f64;
    Rigid::from_rotation_vector(
        Vector::new(0.3 + 0.001 * s, -0.2, 0.9),
        Vector::new(40.0 + 0.25 * s, 30.0, -7.5),
    )
    .unwrap()
}

impl Rig {
    pub(crate) fn new() -> Self {
        Self::of(SCENE, |_| ())
    }

    /// A run of this scene; `change` makes it another kind of run.
    pub(crate) fn of(scene: &str, change: impl FnOnce(&mut RunContext)) -> Self {
        let closed = fs::Permissions::from_mode(0o700);
        let folder = tempfile::Builder::new().permissions(closed).tempdir_in("/tmp").unwrap();
        let mut run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        change(&mut run);
        run.store().unwrap();
        fs::write(run.scene_path(), scene).unwrap();
        let bus = Bus::keep(&run).unwrap();
        let beats = Subscriber::open(&bus, &topic::HEARTBEAT, "gateway", 1).unwrap();
        let gateway = super::gateway()
            .args(["--run-dir", folder.path().to_str().unwrap()])
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let mut rig = Self {
            tool: Publisher::open(&bus, &topic::TOOL_POSE, "").unwrap(),
            workflow: Publisher::open(&bus, &topic::WORKFLOW, "").unwrap(),
            guide: Publisher::open(&bus, &topic::GUIDE, "").unwrap(),
            markers: Publisher::open(&bus, &topic::MARKERS, "").unwrap(),
            beats,
            bus,
            address: SocketAddr::from(([0, 0, 0, 0], 0)),
            gateway,
            run,
            _folder: folder,
        };
        let note = rig.wait_for_note(|note| note.starts_with("127.0.0.1:"));
        let (address, _) = note.split_once(": ").unwrap();
        rig.address = address.parse().unwrap();
        rig.may(Workflow::IMAGES);
        rig
    }

    /// The run has come so far.
    pub(crate) fn may(&self, flags: u32) {
        let workflow = Workflow {
            stage: 6,
            flags,
            ..Workflow::default()
        };
        self.workflow.send(workflow).unwrap();
    }

    pub(crate) fn replayed(run: &mut RunContext) {
        run.replay = Some(ReplayOf {
            recording: "s.mcap".into(),
            volume_hash: None,
            tissue_again: false,
        });
    }

    /// What the gateway says of itself, once that is what is waited for.
    pub(crate) fn wait_for_note(&self, wanted: impl Fn(&str) -> bool) -> String {
        let mut last = String::new();
        let deadline_ns = monotonic_ns() + bus::clock::ns(PATIENCE);
        while monotonic_ns() < deadline_ns {
            if let Some(beat) = self.beats.newest().unwrap() {
                last = beat.note_text();
                if wanted(&last) {
                    return last;
                }
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("the gateway did not say what was waited for within {PATIENCE:?}, but {last:?}");
    }

    pub(crate) fn now_ns(&self) -> i64 {
        self.bus.clock().now_ns()
    }

    fn sample(&self, seq: u64, tracked: Tracked) -> ToolPose {
        let mut pose = ToolPose {
            seq,
            t_capture_ns: self.now_ns(),
            ..ToolPose::EMPTY
        };
        pose.set(tracked);
        pose
    }

    /// Publishes [`place`] of this number.
    pub(crate) fn pose(&self, seq: u64) {
        self.tool.send(self.sample(seq, Tracked::Valid(place(seq)))).unwrap();
    }

    /// The same, of a frame that was captured then.
    pub(crate) fn pose_of(&self, seq: u64, t_capture_ns: i64) {
        let sample = self.sample(seq, Tracked::Valid(place(seq)));
        let sample = ToolPose { t_capture_ns, ..sample };
        self.tool.send(sample).unwrap();
    }

    /// The same, by this registration.
    pub(crate) fn pose_by(&self, seq: u64, registration_id: u64) {
        let sample = self.sample(seq, Tracked::Valid(place(seq)));
        self.tool
            .send(ToolPose {
                registration_id,
                ..sample
            })
            .unwrap();
    }

    pub(crate) fn lost(&self, seq: u64, reason: Lost) {
        self.tool.send(self.sample(seq, Tracked::Lost(reason))).unwrap();
    }

    /// Publishes poses at about this pace until the child has ended.
    pub(crate) fn poses_until(&self, pace: Duration, from: u64, mut child: Option<&mut Child>, most: u64) -> u64 {
        let mut seq = from;
        loop {
            self.pose(seq);
            seq += 1;
            let ended = child.as_mut().is_some_and(|child| child.try_wait().unwrap().is_some());
            if ended || seq - from >= most {
                return seq;
            }
            std::thread::sleep(pace);
        }
    }

    /// Publishes a volume whose voxels are what `value` says of their indices.
    pub(crate) fn volume(&self, grid: &VolumeGrid, value: impl Fn([u32; 3]) -> i16) -> VolumePublisher {
        let dims = grid.dims();
        let layout = Layout::choose(dims).unwrap();
        let publisher = VolumePublisher::open(&self.bus, &layout).unwrap();
        let mut loan = publisher.loan().unwrap();
        let mut hasher = Hasher::new(grid, -1024);
        for z in 0..dims[2] {
            let rows = (0..dims[1]).flat_map(|y| (0..dims[0]).map(move |x| [x, y, z]));
            let slice: Vec<i16> = rows.map(&value).collect();
            layout.scatter(z, &slice, loan.voxels_mut());
            hasher.update(SliceHash::of(&slice));
        }
        let header = VolumeHeader::new(grid, &layout, -1024, hasher.finish(), Marks::NONE);
        loan.publish(header).unwrap();
        publisher
    }

    /// The renderer's end of a view of so many bytes.
    pub(crate) fn view(&self, name: &str, bytes: usize) -> FramePublisher {
        FramePublisher::open(&self.bus, &topic::VIEW_FRAME, name, bytes).unwrap()
    }

    pub(crate) fn frame(&self, to: &FramePublisher, header: FrameHeader, rgba: &[u8]) {
        to.send(header, rgba, self.bus.clock(), i64::MAX).unwrap().unwrap();
    }

    /// A client of our own codec.
    pub(crate) fn client(&self) -> Raw {
        Raw::dial(self.address)
    }

    /// One that reads where its test does alone.
    pub(crate) fn bare(&self) -> Raw {
        Raw::bare(self.address)
    }

    /// Sends the gateway a signal.
    /// Open descriptors of the gateway, and its memory, KiB.
    pub(crate) fn held(&self) -> (usize, u64) {
        let own = format!("/proc/{}", self.gateway.id());
        let status = fs::read_to_string(format!("{own}/status")).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        let kib = line.split_whitespace().next().unwrap().parse().unwrap();
        (fs::read_dir(format!("{own}/fd")).unwrap().count(), kib)
    }

    pub(crate) fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.gateway);
        rustix::process::kill_process(pid, signal).unwrap();
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.gateway.try_wait().unwrap().is_none()
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.gateway.kill();
        let _ = self.gateway.wait();
        self.run.sweep();
    }
}

/// A client on a bare socket, whose messages are read by our own codec.
pub(crate) struct Raw {
    pub(crate) stream: TcpStream,
    decoder: Decoder,
    /// What was read of the socket and is not in the decoder yet.
    rest: Vec<u8>,
    pump: Option<Pump>,
}

/// A thread that reads whatever comes, as the server closes who leaves it unread.
struct Pump {
    stream: TcpStream,
    bytes: Receiver<Vec<u8>>,
}

impl Pump {
    fn of(stream: &TcpStream) -> Self {
        let mut reading = stream.try_clone().unwrap();
        let (to, bytes) = mpsc::channel();
        std::thread::spawn(move || {
            let mut space = vec![0; 1 << 16];
            loop {
                match reading.read(&mut space) {
                    Ok(0) => return,
                    Ok(count) => {
                        if to.send(space[..count].to_vec()).is_err() {
                            return;
                        }
                    }
                    Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                    Err(_) => return,
                }
            }
        });
        let stream = stream.try_clone().unwrap();
        Self { stream, bytes }
    }
}

impl Drop for Pump {
    fn drop(&mut self) {
        // The thread has the connection too.
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

impl Raw {
    /// One that reads all the time, whatever its test does.
    pub(crate) fn dial(address: SocketAddr) -> Self {
        let mut raw = Self::bare(address);
        raw.pump = Some(Pump::of(&raw.stream));
        raw
    }

    /// One that reads where its test does, and is else deaf.
    pub(crate) fn bare(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        Self {
            stream,
            decoder: Decoder::new(Limits::VOLUMES),
            rest: Vec::new(),
            pump: None,
        }
    }

    pub(crate) fn send(&mut self, message: &Message<'_>) {
        self.stream.write_all(&message.to_vec().unwrap()).unwrap();
    }

    /// The next message; `None` where the server has closed.
    pub(crate) fn next(&mut self) -> Option<Message<'static>> {
        loop {
            if let Some(message) = self.decoder.take() {
                return Some(message.unwrap().into_owned());
            }
            if !self.fill() {
                return None;
            }
        }
    }

    /// The next message, `meanwhile` again and again until it comes; `None` where the server has closed.
    pub(crate) fn next_while(&mut self, mut meanwhile: impl FnMut()) -> Option<Message<'static>> {
        let deadline_ns = monotonic_ns() + bus::clock::ns(PATIENCE);
        let pump = self.pump.as_ref().unwrap();
        while self.rest.is_empty() && monotonic_ns() < deadline_ns {
            match pump.bytes.recv_timeout(Duration::from_millis(1)) {
                Ok(bytes) => self.rest = bytes,
                Err(RecvTimeoutError::Timeout) => meanwhile(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        self.next()
    }

    /// Gives the decoder what comes next; whether anything does.
    fn fill(&mut self) -> bool {
        if let Some(pump) = self.pump.as_ref().filter(|_| self.rest.is_empty()) {
            match pump.bytes.recv_timeout(PATIENCE) {
                Ok(bytes) => self.rest = bytes,
                Err(RecvTimeoutError::Disconnected) => return false,
                Err(RecvTimeoutError::Timeout) => panic!("nothing came for {PATIENCE:?}"),
            }
        }
        let space = self.decoder.space();
        let count = if self.pump.is_some() {
            let count = space.len().min(self.rest.len());
            space[..count].copy_from_slice(&self.rest[..count]);
            self.rest.drain(..count);
            count
        } else {
            match self.stream.read(space) {
                Ok(count) => count,
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => 0,
                Err(error) => panic!("{error}"),
            }
        };
        self.decoder.filled(count);
        count > 0
    }

    /// The next message that is what is waited for.
    pub(crate) fn wait_for<T>(&mut self, what: &str, found: impl Fn(&Message<'_>) -> Option<T>) -> T {
        let deadline_ns = monotonic_ns() + bus::clock::ns(PATIENCE);
        loop {
            let message = self
                .next()
                .unwrap_or_else(|| panic!("the server closed; waited for {what}"));
            if let Some(found) = found(&message) {
                return found;
            }
            assert!(monotonic_ns() < deadline_ns, "waited {PATIENCE:?} for {what}");
        }
    }
}
