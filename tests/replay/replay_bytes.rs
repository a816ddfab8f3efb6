//! The poses of a replay on the bus are those of the run on the bus, whole: nothing of a pose is changed, neither its stamps
//! nor its number.

use std::collections::BTreeMap;
use std::process::Stdio;

use crate::support::{Pilot, SMALL, World, wait_for};
use bus::Bus;
use bus::message::ToolPose;
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::{GROUND_TRUTH, TOOL_POSE};
use recorder::read::reader;

/// Every byte of a pose that has a meaning, field by field, doubles as their bits.
fn bytes(pose: &ToolPose) -> Vec<u8> {
    let p = *pose;
    // A field that is added is missing here, and this does not compile.
    let ToolPose {
        seq,
        t_device_ns,
        t_capture_ns,
        t_publish_ns,
        q,
        t_mm,
        covariance,
        fre_rms_mm,
        registration_id,
        status,
        visible,
        tip_mm,
        delay_ns,
        used,
        flags,
    } = p;
    let mut bytes = Vec::new();
    for stamp in [t_device_ns, t_capture_ns, t_publish_ns, delay_ns] {
        bytes.extend(stamp.to_le_bytes());
    }
    for id in [seq, registration_id] {
        bytes.extend(id.to_le_bytes());
    }
    for number in [status, visible, used, flags] {
        bytes.extend(number.to_le_bytes());
    }
    let doubles = q.iter().chain(&t_mm).chain(&covariance).chain([&fre_rms_mm, &tip_mm]);
    doubles.for_each(|number| bytes.extend(number.to_bits().to_le_bytes()));
    bytes
}

/// The poses of a topic by their number; one that comes again must be the same.
#[derive(Default)]
struct Heard(BTreeMap<u64, Vec<u8>>);

impl Heard {
    fn take(&mut self, pose: &ToolPose) {
        let bytes = bytes(pose);
        let before = self.0.insert(pose.seq, bytes.clone());
        assert!(before.is_none_or(|before| before == bytes), "pose {}", pose.seq);
    }

    fn listen(&mut self, poses: &Subscriber<ToolPose>) {
        while let Some(pose) = poses.next().unwrap() {
            self.take(&pose);
        }
    }
}

#[test]
fn poses_and_truths_on_the_bus_are_those_of_the_run_byte_for_byte() {
    let world = World::new();
    // With dropouts: lost poses, too.
    let scene = SMALL.replace("rate_hz = 60.0", "rate_hz = 60.0\ndropout = 0.05");
    let live = world.start(&world.file("small.toml", &scene), &world.path("live"), "default");
    let bus = Bus::join(&wait_for("the run", || {
        RunContext::load(&world.run_dir("default")).ok()
    }))
    .unwrap();
    let open = |bus: &Bus, topic| Subscriber::<ToolPose>::open(bus, topic, "", 4096).unwrap();
    let (tool, truth) = (open(&bus, &TOOL_POSE), open(&bus, &GROUND_TRUTH));
    let mut lived = [Heard::default(), Heard::default()];
    wait_for("a hundred poses", || {
        lived[0].listen(&tool);
        lived[1].listen(&truth);
        (lived[0].0.len() > 100).then_some(())
    });
    drop((tool, truth, bus));
    assert!(live.stop().success());

    let recording = world.path("live").join("session.mcap");
    let recorded = [recorder::wire::schema::TOOL_POSE, recorder::wire::schema::GROUND_TRUTH].map(|topic| {
        let mut heard = Heard::default();
        let poses = reader::poses(&recording, topic).unwrap();
        poses.for_each(|pose| heard.take(&pose.unwrap()));
        heard
    });
    for (lived, recorded) in lived.iter().zip(&recorded) {
        assert!(lived.0.iter().all(|(seq, bytes)| recorded.0.get(seq) == Some(bytes)));
    }
    let lost = reader::poses(&recording, recorder::wire::schema::TOOL_POSE).unwrap();
    let lost = lost.filter(|pose| pose.as_ref().unwrap().status != 0).count();
    assert!((1..recorded[0].0.len()).contains(&lost), "{lost} lost");

    // Again and again, so that every pose is heard by who comes late.
    let child = world
        .command("pilot")
        .args([
            "replay",
            &recording.to_string_lossy(),
            "--headless",
            "--loop",
            "--speed",
            "max",
        ])
        .args(["--run", "again", "--out", &world.path("again").to_string_lossy()])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let again = Pilot::of(&world, "again", child);
    let bus = Bus::join(&wait_for("the replay", || {
        RunContext::load(&world.run_dir("again")).ok()
    }))
    .unwrap();
    let (tool, truth) = (open(&bus, &TOOL_POSE), open(&bus, &GROUND_TRUTH));
    let mut replayed = [Heard::default(), Heard::default()];
    wait_for("every pose again", || {
        replayed[0].listen(&tool);
        replayed[1].listen(&truth);
        let all = |i: usize| replayed[i].0.len() == recorded[i].0.len();
        (all(0) && all(1)).then_some(())
    });
    drop((tool, truth, bus));
    assert!(again.stop().success());
    for (replayed, recorded) in replayed.iter().zip(&recorded) {
        assert!(replayed.0 == recorded.0);
    }
}
