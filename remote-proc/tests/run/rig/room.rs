//! A run that navigates, made by hand.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{Event, FrameStamp, Guide, Identity, Level, ToolPose, Tracked, VolumeHash, VolumeHeader, Workflow};
use bus::port::{Publisher, VolumePublisher};
use bus::run::{RunContext, RunLock};
use bus::topic::{EVENT, FRAME_STAMP, GUIDE, IDENTITY, TOOL_POSE, WORKFLOW};
use bus::volume::{Hasher, Layout, Marks, SliceHash};
use geometry::{Affine, Rigid, VolumeGrid};

use super::{Program, SCENE, run, verb};

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
    scene: &'static str,
    seq: u64,
}

impl Room {
    /// Its clock began `age` ago. `lie` changes the header that is published.
    pub(crate) fn open(world: &Path, age: Duration, dims: [u32; 3], lie: impl FnOnce(&mut VolumeHeader)) -> Self {
        Self::showing(SCENE, world, age, dims, lie)
    }

    /// The same, of another scene than [`SCENE`].
    pub(crate) fn showing(
        scene: &'static str,
        world: &Path,
        age: Duration,
        dims: [u32; 3],
        lie: impl FnOnce(&mut VolumeHeader),
    ) -> Self {
        let epoch_ns = monotonic_ns() - bus::clock::ns(age);
        let (lock, run, bus) = run((world, "room", scene), epoch_ns, |_| {});
        let Voxels {
            layout,
            stored,
            mut header,
        } = Voxels::made(dims);
        let volumes = VolumePublisher::open(&bus, &layout).unwrap();
        let mut loan = volumes.loan().unwrap();
        loan.voxels_mut().copy_from_slice(&stored);
        let hash = header.volume_hash();
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
            scene,
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
        format!("{:016x}", remote_proc::send::run_id(&self.run, self.scene))
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

/// An examination as it lies in memory.
pub(crate) struct Voxels {
    pub(crate) layout: Layout,
    pub(crate) stored: Vec<i16>,
    pub(crate) header: VolumeHeader,
}

impl Voxels {
    /// Voxels whose values say where they lie.
    pub(crate) fn made(dims: [u32; 3]) -> Self {
        let (grid, layout) = (grid(dims), Layout::choose(dims).unwrap());
        let mut stored = vec![0; layout.stored() as usize];
        let mut hasher = Hasher::new(&grid, -1000);
        let [nx, ny, nz] = dims;
        for k in 0..nz {
            let slice: Vec<i16> = (0..nx * ny).map(|i| (i.wrapping_mul(7) + k * 31) as i16).collect();
            layout.scatter(k, &slice, &mut stored);
            hasher.update(SliceHash::of(&slice));
        }
        let header = VolumeHeader::new(&grid, &layout, -1000, hasher.finish(), Marks::NONE);
        Self { layout, stored, header }
    }
}

pub(crate) fn grid(dims: [u32; 3]) -> VolumeGrid {
    let rows = [[0.7, 0.0, 0.0, -9.0], [0.0, 0.7, 0.0, 5.0], [0.0, 0.1, 1.5, 2.0]];
    VolumeGrid::checked(dims.map(i64::from), Affine::from_rows(rows)).unwrap()
}
