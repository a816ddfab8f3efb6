//! A device of NDI behind a network that cuts its replies at every byte: what comes out is right, or a reason.

#![allow(clippy::print_stdout, reason = "how much was cut")]
#![allow(clippy::disallowed_methods, reason = "how long a test waits is its own time")]

use std::path::Path;
use std::time::{Duration, Instant};

use bus::message::{Lost, MarkerFrame};
use geometry::{Marker, Point, Reference};
use tracker_proc::operating_room::PosedRoom;

use super::ndi::{Simulator, follower_scene, frame_at, truth};
use crate::support::frames::{Watch, is_disconnected, is_seen, patient, tool};
use crate::support::proxy::{Fault, Proxy};
use crate::support::{Pilot, World, wait_for};

/// How a binary reply begins.
const BINARY: [u8; 2] = [0xC4, 0xA5];

/// Of a poll, with a frame in it.
fn is_frame(piece: &[u8]) -> bool {
    piece.starts_with(&BINARY) && piece.len() > 100
}

/// Of the set-up.
fn is_text(piece: &[u8]) -> bool {
    !piece.starts_with(&BINARY)
}

/// The version, which the client finds its place by.
fn is_version(piece: &[u8]) -> bool {
    is_text(piece) && piece.len() > 16
}

/// Each pose is that of the room at its stamp, and each missing one has a reason that fits.
struct Judge {
    room: PosedRoom,
    last_device_ns: i64,
    valid: usize,
}

impl Judge {
    fn frame(&mut self, frame: &MarkerFrame) {
        let reasons = [tool(frame).err(), patient(frame).err()];
        for reason in reasons.into_iter().flatten() {
            // Not seen: nothing is there before the device's first frame.
            assert!(matches!(reason, Lost::Disconnected | Lost::NotSeen), "{reason:?}");
        }
        if frame.t_device_ns == 0 {
            assert_eq!(reasons, [Some(Lost::Disconnected); 2]);
            return;
        }
        // One frame of the device is one frame of the bus, whatever was cut between.
        assert!(frame.t_device_ns >= self.last_device_ns, "a frame from before");
        self.last_device_ns = frame.t_device_ns;
        assert!(frame.t_capture_ns <= frame.t_arrival_ns + 1000);
        let truth = frame_at(&self.room, frame.t_device_ns);
        let is = |found: [f64; 3], truth: [f64; 3]| {
            let off = found.into_iter().zip(truth).map(|(a, b)| (a - b).abs());
            // The middle of 24 emitters of 0.15 mm.
            assert!(off.fold(0.0, f64::max) < 0.5, "{found:?} for {truth:?}");
        };
        if let Ok(pose) = tool(frame) {
            let middle = Point::<Marker>::new(0.0, 0.0, 0.0);
            is((pose * middle).mm(), (truth.tracker_from_marker * middle).mm());
            // Turned as the room has it: a point off the middle, where 0.01 rad are 1 mm.
            let tip = Point::<Marker>::new(0.0, 0.0, 100.0);
            assert!((pose * tip).distance(truth.tracker_from_marker * tip) < 1.5);
            self.valid += 1;
        }
        if let Ok(pose) = patient(frame) {
            let middle = Point::<Reference>::new(0.0, 0.0, 0.0);
            is(
                (pose * middle).mm(),
                (truth.tracker_from_reference.unwrap() * middle).mm(),
            );
        }
    }

    /// Waits until one comes of which this holds; each that comes is judged.
    fn until(&mut self, watch: &Watch, what: &str, wanted: impl Fn(&MarkerFrame) -> bool) {
        wait_for(what, || {
            // Closer than the usual look: there are some hundred of these.
            let began = Instant::now();
            while began.elapsed() < Duration::from_millis(500) {
                let frames = watch.come();
                frames.iter().for_each(|frame| self.frame(frame));
                if frames.iter().any(&wanted) {
                    return Some(());
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            None
        });
    }
}

/// A run that follows a device through a network.
struct Followed<'a> {
    network: Proxy,
    watch: Watch,
    judge: Judge,
    _pilot: Pilot<'a>,
    _simulator: Simulator,
}

impl<'a> Followed<'a> {
    /// Poses come.
    fn start(world: &'a World) -> Self {
        let simulator = Simulator::start(world, 0);
        let network = Proxy::to(simulator.port);
        let tools = [("ball", Path::new("tool.rom")), ("patient", Path::new("patient.rom"))];
        let scene = world.file("s.toml", &follower_scene(network.port, tools));
        let pilot = world.start(&scene, &world.path("out"), "default");
        let watch = Watch::open(world);
        let mut judge = Judge {
            room: truth(world),
            last_device_ns: 0,
            valid: 0,
        };
        judge.until(&watch, "poses", is_seen);
        Self {
            network,
            watch,
            judge,
            _pilot: pilot,
            _simulator: simulator,
        }
    }

    /// Makes these cuts, one after the other; the next poses are right.
    fn cut(&mut self, faults: &[Fault]) {
        self.network.set_all(faults);
        self.judge
            .until(&self.watch, "the end of the connection", is_disconnected);
        let is_over = |frame: &MarkerFrame| is_seen(frame) && self.network.is_through();
        self.judge.until(&self.watch, "a pose after it", is_over);
    }

    /// At each second byte of a frame, from this one on.
    fn cut_frames(&mut self, from: usize) {
        for at in (from..).step_by(2) {
            self.cut(&[Fault::Cut(at, is_frame)]);
            if at >= self.network.length() {
                break;
            }
        }
        println!("{} bytes, {} valid poses", self.network.length(), self.judge.valid);
        assert!(self.network.length() > 100);
    }
}

#[test]
fn a_frame_that_is_cut_at_an_even_byte_gives_no_wrong_pose() {
    Followed::start(&World::new()).cut_frames(0);
}

#[test]
fn a_frame_that_is_cut_at_an_odd_byte_gives_no_wrong_pose() {
    Followed::start(&World::new()).cut_frames(1);
}

#[test]
fn a_set_up_that_is_cut_begins_anew_and_a_slow_network_gives_no_wrong_pose() {
    let world = World::new();
    let mut run = Followed::start(&world);
    for (of, step) in [(is_text as fn(&[u8]) -> bool, 1), (is_version, 11)] {
        for at in (0..).step_by(step) {
            // A set-up is on a connection that is new.
            run.cut(&[Fault::Cut(0, is_frame), Fault::Cut(at, of)]);
            if at >= run.network.length() {
                break;
            }
        }
    }
    for fault in [
        Fault::Bytes,
        Fault::Delay(Duration::from_millis(40)),
        Fault::Stall,
        Fault::None,
    ] {
        run.network.set(fault);
        match fault {
            // It is given up, and nothing is shown meanwhile.
            Fault::Stall => run
                .judge
                .until(&run.watch, "the end of a silent device", is_disconnected),
            _ => (0..20).for_each(|_| run.judge.until(&run.watch, "poses through it", is_seen)),
        }
    }
}
