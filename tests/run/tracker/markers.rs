//! A localizer that makes the poses of its markers: they go through the same links as those of a sequence, to the same bits, and
//! what is no frame is refused.

#![allow(clippy::print_stdout, reason = "why a test was skipped")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use crate::support::{SMALL, World, stderr, stdout, wait_for};
use bus::Bus;
use bus::message::{CaptureClock, Heartbeat, Lost, MarkerFrame, MarkerSight, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic::{HEARTBEAT, MARKERS, TOOL_POSE};
use calib::file::sequence::{self, Frame};
use geometry::{Frame as GeometryFrame, Marker, Reference, Rigid, Tracker};
use recorder::read::reader;
use recorder::wire::schema;

/// What follows on the markers' table of either source.
const LINKS: &str =
    "marker = \"ProbeToTracker\"\nreference = \"ReferenceToTracker\"\nnoise_mm = 0.1\nnoise_deg = 0.02\n";

fn scene(source: &str, table: &str, more: &str) -> String {
    let place = format!("[tracker.{source}.ct_from_reference]\ntranslation_mm = [10.0, 20.0, 30.0]\n");
    SMALL.replace("[tracker]\n", &format!("[tracker]\nsource = \"{source}\"\n"))
        + &format!("[tracker.{source}]\n{table}{place}{more}")
}

/// A localizer whose frames are those of a test.
struct Localizer {
    bus: Bus,
    frames: Publisher<MarkerFrame>,
    next: u64,
}

impl Localizer {
    fn open(world: &World) -> Self {
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let bus = Bus::join(&context).unwrap();
        Self {
            frames: Publisher::open(&bus, &MARKERS, "").unwrap(),
            bus,
            next: 0,
        }
    }

    /// The next frame, captured now.
    fn frame(&mut self, t_device_ns: i64, sights: &[MarkerSight]) -> MarkerFrame {
        let now_ns = self.bus.clock().now_ns();
        let mut frame = MarkerFrame {
            seq: self.next,
            t_device_ns,
            t_capture_ns: now_ns,
            t_arrival_ns: now_ns,
            t_publish_ns: now_ns,
            clock: CaptureClock::Arrival.code(),
            ..MarkerFrame::EMPTY
        }
        .of_device("a localizer");
        frame.set(sights).unwrap();
        self.next += 1;
        frame
    }
}

/// A marker of a frame of a sequence.
fn sight<M: GeometryFrame>(marker: u32, frame: &Frame) -> MarkerSight {
    let pose: Option<Rigid<Tracker, M>> = frame.poses[marker as usize].map(|pose| pose.rigid().unwrap());
    pose.map_or(MarkerSight::lost(marker, Lost::NotSeen, 20_000_000), |pose| {
        MarkerSight::seen(marker, pose, 0.0)
    })
}

fn header(file: &Path) -> Vec<Frame> {
    let bytes = std::fs::read(file).unwrap();
    let end = sequence::header_end(&bytes).unwrap();
    let text = std::str::from_utf8(&bytes[..end]).unwrap();
    sequence::frames(text, &["ProbeToTracker", "ReferenceToTracker"]).unwrap()
}

pub(super) fn poses(recording: &Path) -> BTreeMap<u64, ToolPose> {
    let poses = reader::poses(recording, schema::TOOL_POSE).unwrap();
    poses.map(|pose| pose.unwrap()).map(|pose| (pose.seq, pose)).collect()
}

/// The numbers of a pose that do not say when it was.
fn numbers(pose: &ToolPose) -> (u32, u32, Vec<u64>) {
    let all = pose.q.iter().chain(&pose.t_mm).chain(&pose.covariance);
    let all = all.chain([&pose.fre_rms_mm, &pose.tip_mm]);
    (pose.status, pose.flags, all.map(|x| x.to_bits()).collect())
}

pub(super) fn recompute(world: &World, recording: &Path) -> Output {
    let arguments = ["replay", "--recompute", "--headless", "--out"].map(Path::new);
    let (again, recording) = (world.path("again"), recording.to_owned());
    let all: Vec<PathBuf> = [arguments.map(Path::to_owned).to_vec(), vec![again, recording]].concat();
    let all: Vec<&str> = all.iter().map(|path| path.to_str().unwrap()).collect();
    world.output("pilot", &all)
}

#[test]
fn markers_give_the_poses_of_the_sequence_and_again_when_recomputed() {
    let name = "data/tracker-plus/TransformInterpolationTest.igs.mha";
    let Some(file) = crate::support::shared(name) else {
        return;
    };
    let world = World::new();
    let played = scene("sequence", &format!("file = {file:?}\n{LINKS}"), "");
    let out = world.path("sequence");
    world.navigate(&world.file("p.toml", &played), &out, &["--for", "5s", "--speed", "max"]);
    let expected = poses(&out.join("session.mcap"));
    assert!(expected.len() > 200, "{}", expected.len());

    let out = world.path("markers");
    let pilot = world.start(&world.file("s.toml", &scene("markers", LINKS, "")), &out, "default");
    pilot.wait_for("the tracker", |status| {
        let processes = status["processes"].as_array().unwrap();
        processes
            .iter()
            .any(|p| p["name"] == "tracker" && p["note"] == "localizer silent")
    });
    let mut localizer = Localizer::open(&world);
    let found = Subscriber::<ToolPose>::open(&localizer.bus, &TOOL_POSE, "", 1024).unwrap();
    for frame in header(&file).iter().take(200) {
        let t_ns = bus::clock::seconds(frame.t_s.unwrap());
        // The tool stands behind the reference: a marker is known by its number.
        let sights = [sight::<Reference>(1, frame), sight::<Marker>(0, frame)];
        let message = localizer.frame(t_ns, &sights);
        localizer.frames.send(message).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut seen = 0;
    wait_for("the last pose", || {
        seen += std::iter::from_fn(|| found.next().unwrap()).count();
        (seen == 200).then_some(())
    });
    assert!(pilot.stop().success());
    let recording = out.join("session.mcap");
    let found = poses(&recording);
    assert_eq!(found.len(), 200);
    let lost: Vec<u64> = found
        .values()
        .filter(|pose| pose.status != 0)
        .map(|pose| pose.seq)
        .collect();
    assert_eq!(lost, [7]);
    for (seq, pose) in &found {
        assert_eq!(numbers(pose), numbers(&expected[seq]), "{seq}");
    }
    let frames: Vec<MarkerFrame> = reader::markers(&recording).unwrap().map(Result::unwrap).collect();
    assert_eq!((frames.len(), frames[9].device_name().as_str()), (200, "a localizer"));

    let output = recompute(&world, &recording);
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    let again = poses(&world.path("again").join("recomputed.mcap"));
    assert!(found.values().eq(again.values()), "other poses were made again");
}

/// What is wrong with a frame, and whether a pose that says so is published for it.
type Damage = (fn(&mut MarkerFrame), bool);
const DAMAGES: [Damage; 9] = [
    (|f| f.sights[0].t_mm[1] = f64::NAN, true),
    (|f| f.sights[0].q = [0.0; 4], true),
    (|f| f.sights[1].q[0] *= 1.01, true),
    (|f| f.sights[0].age_ns = 1, true),
    (|f| f.sights[1].age_ns = 16_000_000, true),
    (|f| f.sights[0].status = 77, true),
    (|f| f.count = 17, false),
    (|f| f.sights[1].marker = 0, false),
    (|f| f.t_capture_ns += 10_000_000_000, false),
];

/// Reasons of the localizer, and what the pose says then.
const REASONS: [(u32, Lost, Lost); 7] = [
    (0, Lost::NotSeen, Lost::NotSeen),
    (0, Lost::OutOfVolume, Lost::OutOfVolume),
    (0, Lost::Interference, Lost::Interference),
    (0, Lost::Disconnected, Lost::Disconnected),
    (0, Lost::TooFew, Lost::TooFew),
    (1, Lost::OutOfVolume, Lost::Reference),
    (1, Lost::Disconnected, Lost::Reference),
];

/// The state of the tracker, as its sign of life has it.
fn is_noted(beats: &Subscriber<Heartbeat>, words: &str) {
    let mut noted = None;
    wait_for(words, || {
        let beat = beats.newest().unwrap();
        noted = beat.map(|beat| beat.note_text()).or_else(|| noted.take());
        (noted.as_deref() == Some(words)).then_some(())
    });
}

#[test]
fn what_is_no_frame_is_refused_and_what_the_localizer_says_is_told() {
    let world = World::new();
    let text = scene("markers", &format!("{LINKS}max_error_mm = 0.5\n"), "");
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    let mut localizer = Localizer::open(&world);
    let beats = Subscriber::<Heartbeat>::open(&localizer.bus, &HEARTBEAT, "tracker", 1).unwrap();
    let poses = Subscriber::<ToolPose>::open(&localizer.bus, &TOOL_POSE, "", 1024).unwrap();
    is_noted(&beats, "localizer silent");
    let mut found = BTreeMap::new();
    let mut state = |localizer: &mut Localizer, message: MarkerFrame| {
        let seq = message.seq;
        localizer.frames.send(message).unwrap();
        // Each frame after the one before has been taken: two that wait together keep their order.
        std::thread::sleep(Duration::from_millis(8));
        found.extend(std::iter::from_fn(|| poses.next().unwrap()).map(|pose| (pose.seq, pose)));
        seq
    };
    let at = |x: f64| {
        Rigid::<Tracker, Marker>::from_parts(
            geometry::rotation::Rotation::IDENTITY,
            geometry::Vector::new(x, 0.0, -1500.0),
        )
    };
    let on_patient = Rigid::<Tracker, Reference>::identity();
    let both = |x: f64| [MarkerSight::seen(0, at(x), 0.2), MarkerSight::seen(1, on_patient, 0.2)];
    let mut expected: BTreeMap<u64, Option<Lost>> = BTreeMap::new();
    for (i, (damage, published)) in DAMAGES.iter().enumerate() {
        let mut message = localizer.frame(0, &both(i as f64));
        damage(&mut message);
        let seq = state(&mut localizer, message);
        if *published {
            expected.insert(seq, Some(Lost::Refused));
        }
    }
    for (marker, reason, said) in REASONS {
        let mut sights = both(20.0 + f64::from(reason.code()));
        sights[marker as usize] = MarkerSight::lost(marker, reason, MarkerSight::NEVER);
        let message = localizer.frame(0, &sights);
        expected.insert(state(&mut localizer, message), Some(said));
    }
    // A marker that fits worse than the scene allows, and one that the frame does not have.
    let mut sights = both(40.0);
    sights[0].error_mm = 0.6;
    let message = localizer.frame(0, &sights);
    expected.insert(state(&mut localizer, message), Some(Lost::Residual));
    let message = localizer.frame(0, &both(41.0)[..1]);
    expected.insert(state(&mut localizer, message), Some(Lost::Reference));
    let message = localizer.frame(0, &[]);
    expected.insert(state(&mut localizer, message), Some(Lost::NotSeen));
    let good = localizer.frame(0, &both(42.0));
    expected.insert(state(&mut localizer, good), None);
    // The same again is left out.
    state(&mut localizer, good);
    is_noted(&beats, "tip outside the CT");
    let wanted = DAMAGES.len() as u64 + 1;
    wait_for("the counters", || {
        beats.newest().unwrap().filter(|beat| beat.counters.refused == wanted)
    });
    // A busy tracker answers later than was waited for each.
    found.extend(std::iter::from_fn(|| poses.next().unwrap()).map(|pose| (pose.seq, pose)));
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (seq, reason) in expected {
        let tracked = found[&seq].tracked().unwrap();
        assert_eq!(tracked_reason(tracked), reason, "{seq}");
    }
    let message = localizer.frame(0, &[MarkerSight::lost(0, Lost::Disconnected, 0)]);
    localizer.frames.send(message).unwrap();
    is_noted(&beats, "localizer disconnected");
    assert!(pilot.stop().success());
}

/// Stated: tracking, for ever. True: the marker on the patient had hung up beside a tool that moved: its last pose came as a matrix and
/// as a quaternion in turn, 1e-7 apart, so that no two frames one after the other had the same numbers of it.
#[test]
fn a_marker_on_the_patient_that_has_hung_up_beside_a_tool_that_moves_is_frozen() {
    let world = World::new();
    let scene = world.file("s.toml", &scene("markers", LINKS, ""));
    let pilot = world.start(&scene, &world.path("out"), "default");
    let mut localizer = Localizer::open(&world);
    let beats = Subscriber::<Heartbeat>::open(&localizer.bus, &HEARTBEAT, "tracker", 1).unwrap();
    let poses = Subscriber::<ToolPose>::open(&localizer.bus, &TOOL_POSE, "", 1024).unwrap();
    is_noted(&beats, "localizer silent");
    let at = |x: f64| geometry::Vector::new(x, 0.0, -1500.0);
    let mut found = Vec::new();
    for k in 0..200 {
        let rounded = geometry::Vector::new(0.0, 0.0, 0.2 + 1e-7 * f64::from(k % 2));
        let sights = [
            MarkerSight::seen(
                0,
                Rigid::<Tracker, Marker>::from_rotation_vector(rounded, at(f64::from(k))).unwrap(),
                0.0,
            ),
            MarkerSight::seen(
                1,
                Rigid::<Tracker, Reference>::from_rotation_vector(rounded, at(-90.0)).unwrap(),
                0.0,
            ),
        ];
        let message = localizer.frame(0, &sights);
        localizer.frames.send(message).unwrap();
        std::thread::sleep(Duration::from_millis(5));
        found.extend(std::iter::from_fn(|| poses.next().unwrap()));
    }
    // By the default of `limits.frozen_ms`, since the first of the other of the two.
    let is_other = |pose: &&ToolPose| pose.seq % 2 != found[0].seq % 2;
    let since_ns = found.iter().find(is_other).unwrap().t_capture_ns;
    let mut frozen = 0;
    for pose in &found {
        let expected = (pose.t_capture_ns - since_ns > 500_000_000).then_some(Lost::Frozen);
        assert_eq!(tracked_reason(pose.tracked().unwrap()), expected, "{}", pose.seq);
        frozen += usize::from(expected.is_some());
    }
    assert!(frozen > 10, "{frozen}");
    // That it was frozen is a problem of the run.
    assert!(!pilot.stop().success());
}

fn tracked_reason(tracked: Tracked) -> Option<Lost> {
    match tracked {
        Tracked::Lost(reason) => Some(reason),
        Tracked::Valid(_) => None,
    }
}
