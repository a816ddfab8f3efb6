//! A localizer that is another program: its frames become poses by the same chain, and what is no frame is refused.

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::{SMALL, World, wait_for};
use bus::Bus;
use bus::message::{EmitterFrame, EmitterSight, Heartbeat, Lost, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic::{EMITTERS, HEARTBEAT, TOOL_POSE};
use geometry::{Point, Tool, Tracker};
use scene::operating_room::Room;
use scene::{Scene, TrackerSource};
use tracker_proc::operating_room::{Frame, OperatingRoom, Script};

/// Where the room's localizer stands, which its poses rest on.
const PLACE: &str = "[tracker.ct_from_tracker]\nquaternion = [0.9486832980505138, 0.0, -0.31622776601683794, 0.0]\n\
                     translation_mm = [1380.0, 0.0, -1840.0]\n";

fn room(scene: &Scene) -> OperatingRoom {
    let TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
        panic!("an operating room")
    };
    let room: &Room = room;
    let script = Script::of_room(room, &scene.targets, None).unwrap();
    OperatingRoom::new(script, room, &scene.tracker.ct_from_tracker, 3, 60.0).unwrap()
}

/// A localizer in front of which the room's gesture is made.
struct Localizer {
    room: OperatingRoom,
    bus: Bus,
    frames: Publisher<EmitterFrame>,
    next: u64,
}

impl Localizer {
    /// The next frame, captured now.
    fn frame(&mut self) -> (EmitterFrame, Frame) {
        let frame = self.room.frame(self.next);
        let now = self.bus.clock().now_ns();
        let sight = |(place, emitter): (Point<Tracker>, usize)| EmitterSight {
            place_mm: place.mm(),
            emitter: emitter as u32,
            reserved: 0,
        };
        let mut message = EmitterFrame {
            seq: self.next,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: now,
            t_publish_ns: now,
            ..EmitterFrame::EMPTY
        };
        let tool = frame.tool.iter().map(|s| sight((s.place, s.emitter)));
        let reference = frame.reference.iter().map(|s| sight((s.place, s.emitter)));
        message.set(tool, reference).unwrap();
        self.next += 1;
        (message, frame)
    }
}

/// What is wrong with a frame, and whether a pose that says so is published for it.
type Damage = (fn(&mut EmitterFrame), bool);
const DAMAGES: [Damage; 7] = [
    (|f| f.tool_sights[1].place_mm[2] = f64::NAN, true),
    (|f| f.tool_sights[0].emitter = 24, true),
    (|f| f.tool_sights[0].place_mm[0] = f64::INFINITY, true),
    (|f| f.tool_seen = 33, false),
    (|f| f.reference_seen = u32::MAX, false),
    (|f| f.t_device_ns -= 1_000_000_000, false),
    (|f| f.t_capture_ns += 10_000_000_000, false),
];

#[test]
fn frames_of_another_program_become_poses_and_what_is_no_frame_is_refused() {
    let world = World::new();
    let own = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"emitters\"\n") + PLACE;
    let simulated = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n")
        + "[tracker.room.marker]\ncone_deg = 180.0\n[tracker.room.handle]\nradius_mm = 0.0\n";
    let scene = Scene::parse(&simulated, Path::new("s.toml")).unwrap();
    let pilot = world.start(&world.file("s.toml", &own), &world.path("out"), "default");
    let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
    pilot.wait_for("the tracker", |status| {
        let processes = status["processes"].as_array().unwrap();
        processes
            .iter()
            .any(|p| p["name"] == "tracker" && p["note"] == "localizer silent")
    });
    let bus = Bus::join(&context).unwrap();
    let poses = Subscriber::<ToolPose>::open(&bus, &TOOL_POSE, "", 1024).unwrap();
    let beats = Subscriber::<Heartbeat>::open(&bus, &HEARTBEAT, "tracker", 1).unwrap();
    let mut localizer = Localizer {
        room: room(&scene),
        frames: Publisher::open(&bus, &EMITTERS, "").unwrap(),
        bus,
        next: 0,
    };
    let (mut truths, mut refused) = (BTreeMap::new(), BTreeMap::new());
    for i in 0..120_usize {
        let (mut message, frame) = localizer.frame();
        match DAMAGES.get(i.wrapping_sub(40)) {
            Some((damage, published)) => {
                damage(&mut message);
                refused.insert(message.seq, *published);
            }
            None => drop(truths.insert(message.seq, frame)),
        }
        localizer.frames.send(message).unwrap();
        // The same frame again is left out as well.
        if i == 60 {
            localizer.frames.send(message).unwrap();
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let mut found = BTreeMap::new();
    wait_for("the last pose", || {
        found.extend(std::iter::from_fn(|| poses.next().unwrap()).map(|pose| (pose.seq, pose)));
        found.contains_key(&119).then_some(())
    });
    let all = |beat: &Heartbeat| beat.counters.published as usize == found.len();
    let beat = wait_for("the counters", || beats.newest().unwrap().filter(all));
    assert_eq!(beat.counters.refused, DAMAGES.len() as u64 + 1);
    check(&found, &truths, &refused);
    assert!(pilot.stop().success());
}

fn check(found: &BTreeMap<u64, ToolPose>, truths: &BTreeMap<u64, Frame>, refused: &BTreeMap<u64, bool>) {
    let mut valid = 0;
    for (seq, published) in refused {
        let state = found.get(seq).map(|pose| pose.tracked().unwrap());
        assert_eq!(state, published.then_some(Tracked::Lost(Lost::Refused)), "{seq}");
    }
    for (seq, truth) in truths {
        let pose = &found[seq];
        assert_eq!(pose.visible as usize, truth.tool.len());
        let Tracked::Valid(at) = pose.tracked().unwrap() else {
            continue;
        };
        let tip = Point::<Tool>::new(0.0, 0.0, 0.0);
        let off = (at * tip).distance(truth.ct_from_tool * tip);
        // Emitters of 0.1 and 0.15 mm on a ball of 50 mm, thrown 290 mm: a few tenths.
        assert!(off < 3.0, "{seq}: {off} mm");
        // The scene's own constants say nothing of their errors, so none is predicted.
        assert_eq!((pose.tip_95_mm(), pose.covariance), (None, [0.0; 21]));
        valid += 1;
    }
    assert!(valid > 100, "{valid}");
}
