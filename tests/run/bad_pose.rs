//! What is no pose, on the pose topic: never shown, counted, and the run says so.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use crate::support::room::Room;
use crate::support::{Pilot, SMALL, report, wait_for};
use bus::Bus;
use bus::message::{FrameStamp, FrameState, Lost, ToolPose, Tracked};
use bus::port::{Publisher, Subscriber};
use bus::run::RunContext;
use bus::topic::{FRAME_STAMP, TOOL_POSE};
use geometry::{Rigid, Vector};
use serde_json::Value;

/// What a localizer may publish, by number; only the first is a pose.
const KINDS: [fn(&mut ToolPose); 10] = [
    |_| {},
    |pose| pose.t_mm[1] = f64::NAN,
    |pose| pose.q[3] = f64::INFINITY,
    |pose| pose.q = [1.0, 0.1, 0.0, 0.0],
    |pose| pose.q = [0.0; 4],
    |pose| pose.status = 77,
    // It would never grow old.
    |pose| pose.t_capture_ns += 10_000_000_000,
    // Older than the one before.
    |pose| pose.t_capture_ns -= 200_000_000,
    |pose| pose.t_mm[0] = 1e300,
    |pose| (pose.flags, pose.tip_mm) = (ToolPose::TIP_KNOWN, -1.0),
];

fn sample(seq: u64, now: i64) -> ToolPose {
    let tip = Vector::new(seq as f64 / 60.0, 0.0, 40.0);
    let pose = Rigid::from_rotation_vector(Vector::new(1.0, 0.5, 0.0), tip).unwrap();
    let mut sample = ToolPose {
        seq,
        t_capture_ns: now,
        t_publish_ns: now,
        ..ToolPose::EMPTY
    };
    sample.set(Tracked::Valid(pose));
    sample
}

/// Publishes at 60 Hz until told to stop. Returns which samples were no poses, and the stamps of all images.
fn localizer(context: &RunContext, kind: &AtomicUsize, stop: &AtomicBool) -> (Vec<u64>, Vec<FrameStamp>) {
    let bus = Bus::join(context).unwrap();
    let publisher = Publisher::open(&bus, &TOOL_POSE, "").unwrap();
    let open = |view| Subscriber::<FrameStamp>::open(&bus, &FRAME_STAMP, view, 64).unwrap();
    let stamps = ["view-axial", "view-frontal", "view-perpendicular"].map(open);
    let (mut bad, mut seen) = (Vec::new(), Vec::new());
    for seq in 0.. {
        let kind = kind.load(Relaxed);
        let mut sample = sample(seq, bus.clock().now_ns());
        KINDS[kind](&mut sample);
        bad.extend((kind > 0).then_some(seq));
        publisher.send(sample).unwrap();
        std::thread::sleep(Duration::from_micros(16_667));
        for stamps in &stamps {
            seen.extend(std::iter::from_fn(|| stamps.next().unwrap()));
        }
        if stop.load(Relaxed) {
            break;
        }
    }
    (bad, seen)
}

/// Also when a check fails: its scope waits for the thread.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

/// Publishes each kind until every view says so, with good poses in between.
fn publish_all_kinds(pilot: &Pilot<'_>, context: &RunContext) -> (Vec<u64>, Vec<FrameStamp>) {
    let (kind, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let is_lost = |view: &Value| view["state"] == "lost";
    std::thread::scope(|scope| {
        let source = scope.spawn(|| localizer(context, &kind, &stop));
        let stop = StopOnDrop(&stop);
        pilot.wait_live();
        let bus = Bus::join(context).unwrap();
        let second = Publisher::<ToolPose>::open(&bus, &TOOL_POSE, "").unwrap_err();
        assert!(
            second.to_string().starts_with("opening topic \"tool-pose\" to publish"),
            "{second}"
        );
        for bad in 1..KINDS.len() {
            kind.store(bad, Relaxed);
            pilot.wait_for("views without a pose", |s| {
                s["views"].as_array().unwrap().iter().all(is_lost)
            });
            kind.store(0, Relaxed);
            pilot.wait_live();
        }
        drop(stop);
        source.join().unwrap()
    })
}

#[test]
fn what_is_no_pose_is_never_shown() {
    let room = Room::new();
    let scene = SMALL.replace("[tracker]", "[tracker]\nsource = \"external\"");
    let pilot = room.start(&room.file("scene.toml", &scene), &room.out, "default");
    let context = wait_for("the run", || RunContext::load(&room.run_dir("default")).ok());
    let (bad, seen) = publish_all_kinds(&pilot, &context);
    assert_eq!(pilot.stop().code(), Some(3));
    let refused = FrameState::Lost(Lost::Refused).code();
    let of_bad: Vec<_> = seen.iter().filter(|stamp| bad.contains(&stamp.seq)).collect();
    assert!(of_bad.len() >= KINDS.len() - 1, "{of_bad:?}");
    assert!(of_bad.iter().all(|stamp| stamp.state == refused), "{of_bad:?}");
    let report = report(&room.out);
    assert_eq!(report["poses"]["refused"], bad.len());
    let problem = format!("{} samples on the pose topic were not poses", bad.len());
    assert!(
        report["problems"][0].as_str().unwrap().starts_with(&problem),
        "{report}"
    );
    room.nothing_is_left();
}
