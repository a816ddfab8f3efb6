//! Poses that are good one by one and wrong as a stream: each is told on the images, counted, and in the report.

use std::time::Duration;

use crate::support::{Pilot, SMALL, World, report, wait_for};
use bus::Bus;
use bus::message::{ToolPose, Tracked};
use bus::port::Publisher;
use bus::run::RunContext;
use bus::topic::TOOL_POSE;
use geometry::{Rigid, Vector};
use serde_json::Value;

/// A localizer by hand, at 60 Hz.
struct Localizer {
    bus: Bus,
    poses: Publisher<ToolPose>,
    next: ToolPose,
}

impl Localizer {
    fn join(world: &World) -> Self {
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let bus = Bus::join(&context).unwrap();
        Self {
            poses: Publisher::open(&bus, &TOOL_POSE, "").unwrap(),
            bus,
            next: ToolPose::EMPTY,
        }
    }

    /// The tip at `x` mm.
    fn send(&mut self, x: f64) {
        let at = Rigid::from_rotation_vector(Vector::new(1.0, 0.5, 0.0), Vector::new(x, 0.0, 40.0));
        self.next.set(Tracked::Valid(at.unwrap()));
        self.next.seq += 1;
        self.next.t_capture_ns = self.bus.clock().now_ns();
        self.next.t_publish_ns = self.next.t_capture_ns;
        self.poses.send(self.next).unwrap();
        std::thread::sleep(Duration::from_micros(16_667));
    }

    /// Sends tips until the pilot's status is `ready`.
    fn until(&mut self, pilot: &Pilot<'_>, what: &str, tip: impl Fn(u64) -> f64, ready: impl Fn(&Value) -> bool) {
        wait_for(what, || {
            for _ in 0..20 {
                self.send(tip(self.next.seq));
            }
            pilot.status().filter(|status| ready(status))
        });
    }
}

fn all_views(state: &'static str) -> impl Fn(&Value) -> bool {
    move |status| {
        status["views"]
            .as_array()
            .unwrap()
            .iter()
            .all(|view| view["state"] == state)
    }
}

/// A localizer that had hung up stood LIVE on the images; so did a tip outside the CT that another program had not marked.
#[test]
fn a_measurement_that_stands_still_is_no_pose_and_a_tip_outside_is_said() {
    let world = World::new();
    let scene = SMALL.replace("[tracker]", "[tracker]\nsource = \"external\"");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    let mut localizer = Localizer::join(&world);
    localizer.until(&pilot, "live images", |seq| seq as f64 / 60.0, all_views("live"));
    localizer.until(&pilot, "a frozen localizer", |_| 7.0, all_views("lost"));
    let status = pilot.status().unwrap();
    assert_eq!(status["pose"]["state"], "FROZEN MEASUREMENT", "{status}");
    // The same, where the source has no noise.
    localizer.next.flags = ToolPose::NOISELESS;
    localizer.until(&pilot, "a tool at rest", |_| 7.0, all_views("live"));
    localizer.next.flags = 0;
    let outside = |status: &Value| status["pose"]["outside"] == true;
    localizer.until(&pilot, "a tip outside", |seq| 5000.0 + seq as f64, outside);
    assert_eq!(pilot.stop().code(), Some(3));
    let report = report(&world.path("out"));
    assert!(
        report["accuracy"]["lost"]["FROZEN MEASUREMENT"].as_u64().unwrap() > 0,
        "{report}"
    );
    assert!(report["accuracy"]["outside_share"].as_f64().unwrap() > 0.0, "{report}");
    assert!(
        report["problems"][0].as_str().unwrap().contains("FROZEN MEASUREMENT"),
        "{report}"
    );
}

#[test]
fn another_registration_and_another_count_are_told() {
    let world = World::new();
    let scene = SMALL.replace("[tracker]", "[tracker]\nsource = \"external\"");
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
    let mut localizer = Localizer::join(&world);
    let moving = |seq: u64| (seq % 1000) as f64 / 60.0;
    localizer.until(&pilot, "live images", moving, all_views("live"));
    localizer.next.registration_id = 7;
    localizer.send(1.5);
    localizer.next.seq = 1 << 50;
    localizer.send(2.5);
    localizer.next.seq = 0;
    localizer.until(&pilot, "live images again", moving, |status| {
        all_views("live")(status) && status["pose"]["seq"].as_u64().is_some_and(|seq| seq < 1 << 40)
    });
    assert_eq!(pilot.stop().code(), Some(3));
    let report = report(&world.path("out"));
    assert_eq!(report["poses"]["registration_changes"], 1, "{report}");
    assert_eq!(report["poses"]["counted_anew"], 2, "{report}");
    assert!(report["poses"]["missing"].as_u64().unwrap() < 1000, "{report}");
    let problems = report["problems"].to_string();
    assert!(
        problems.contains("REGISTRATION CHANGED") && problems.contains("began anew"),
        "{problems}"
    );
}
