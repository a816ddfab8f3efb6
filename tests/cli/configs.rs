//! The shipped scenes: each loads, says what it is for, and starts what it promises.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use crate::support::{World, stderr, stdout};
use bus::Bus;
use bus::message::{ToolPose, Tracked};
use bus::port::Publisher;
use bus::run::RunContext;
use bus::topic::TOOL_POSE;
use geometry::{Ct, Rigid, Tool, Vector};
use scene::{Plane, Scene, TrackerSource};

fn config(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(name)
}

fn scene(name: &str) -> Scene {
    Scene::load(&config(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// What `pilot check` says of a scene, without its name.
fn checked(scene: Option<&Path>) -> String {
    let world = World::new();
    let scene = scene.map(|path| path.to_string_lossy().into_owned());
    let arguments: Vec<&str> = ["check", "--quick"].into_iter().chain(scene.as_deref()).collect();
    let output = world.output("pilot", &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    text.split_once('\n').map(|(_, rest)| rest.to_owned()).unwrap()
}

/// The processes that a scene starts, in order.
fn starts(name: &str) -> Vec<String> {
    let text = checked(Some(&config(name)));
    let lines = text.lines().filter_map(|line| line.strip_prefix("starts "));
    lines
        .map(|line| line.split_whitespace().next().unwrap().to_owned())
        .collect()
}

#[test]
fn every_scene_loads_and_says_what_it_is_for() {
    let folder = config("");
    let mut found = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            // Scenes of solids: the tests of `simulate` read them.
            continue;
        }
        assert_eq!(path.extension().unwrap(), "toml", "{}", path.display());
        Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        checked(Some(&path));
        let text = std::fs::read_to_string(&path).unwrap();
        let header: String = text.lines().take_while(|line| line.starts_with('#')).collect();
        assert!(
            header.len() > 80,
            "{}: a scene begins with what it is for",
            path.display()
        );
        found += 1;
    }
    assert!(found >= 3, "found only {found}");
}

/// What is practised with: each scene is good, and its beads are of the patient that it generates.
#[test]
fn the_scenes_for_practice_can_be_gone_through() {
    for name in ["pivot", "pivot-and-spin", "base"] {
        let text = checked(Some(&config(&format!("practice/{name}.toml"))));
        assert!(text.contains("starts calib"), "{text}");
    }
    let spins = scene("practice/pivot-and-spin.toml");
    let Some(scene::steps::Registering::Beads(path)) = spins.steps.unwrap().register else {
        panic!("no beads")
    };
    let beads: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let patient = phantom::Phantom::new(spins.seed);
    let known: Vec<[f64; 3]> = patient.beads().iter().map(|bead| bead.centre.mm()).collect();
    for bead in beads["beads"].as_array().unwrap() {
        let at: Vec<f64> = bead["centre_mm"]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect();
        let off = |mm: &[f64; 3]| mm.iter().zip(&at).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let nearest = known.iter().map(off).fold(f64::INFINITY, f64::min);
        // docs/beads.md: within 0.05 mm in such voxels.
        assert!(nearest < 0.05, "{at:?} is {nearest} mm from a bead");
    }
}

#[test]
fn the_embedded_demonstration_is_the_shipped_file() {
    assert_eq!(checked(None), checked(Some(&config("demo.toml"))));
}

#[test]
fn the_demonstration_is_the_thesis_recorded() {
    let demo = scene("demo.toml");
    assert_eq!(demo.views, Scene::parse("", Path::new("")).unwrap().views);
    assert!(demo.recording.is_some());
}

#[test]
fn one_view_is_one_renderer() {
    let one = scene("one-view.toml");
    assert_eq!(one.renderers(), [(Plane::Perpendicular, vec![0])]);
    assert_eq!(one.tracker.rate_hz, 120.0);
    assert_eq!(
        starts("one-view.toml"),
        ["volume-loader", "view-perpendicular", "tracker"]
    );
}

#[test]
fn an_overview_is_a_renderer_of_its_own_and_the_demonstration_has_none() {
    assert_eq!(
        starts("surface.toml"),
        [
            "volume-loader",
            "view-surface",
            "view-axial",
            "view-perpendicular",
            "tracker"
        ]
    );
    assert!(!starts("demo.toml").contains(&"view-surface".to_owned()));
}

#[test]
fn an_organ_is_moved_by_a_process_of_its_own_and_the_demonstration_moves_none() {
    let all = starts("tissue.toml");
    assert!(all.contains(&"tissue".to_owned()) && !starts("demo.toml").contains(&"tissue".to_owned()));
}

#[test]
fn an_external_tracker_is_not_started() {
    assert_eq!(scene("external-tracker.toml").tracker.source, TrackerSource::External);
    assert!(!starts("external-tracker.toml").contains(&"tracker".to_owned()));
}

/// A pose at the patient's middle, captured now.
fn pose(seq: u64, bus: &Bus, registration_id: u64) -> ToolPose {
    let now = bus.clock().now_ns();
    let mut pose = ToolPose {
        seq,
        t_device_ns: now,
        t_capture_ns: now,
        t_publish_ns: now,
        registration_id,
        ..ToolPose::EMPTY
    };
    let ct_from_tool: Rigid<Ct, Tool> =
        Rigid::from_rotation_vector(Vector::new(0.3, -0.2, 0.1), Vector::new(20.0, 5.0, 40.0)).unwrap();
    pose.set(Tracked::Valid(ct_from_tool));
    pose
}

/// A program that publishes 50 poses a second until it is dropped.
struct Publishing {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Publishing {
    fn start(run_dir: PathBuf) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = thread::spawn(move || {
            let bus = Bus::join(&RunContext::load(&run_dir).unwrap()).unwrap();
            let publisher = Publisher::open(&bus, &TOOL_POSE, "").unwrap();
            let registration_id = scene("external-tracker.toml").registration_id();
            for seq in 0.. {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                publisher.send(pose(seq, &bus, registration_id)).unwrap();
                bus.clock().sleep_until(bus.clock().now_ns() + 20_000_000);
            }
        });
        Self {
            stop,
            thread: Some(thread),
        }
    }
}

impl Drop for Publishing {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || thread::panicking(), "the publisher failed");
        }
    }
}

#[test]
fn another_program_can_publish_the_poses() {
    let world = World::new();
    let out = world.path("out");
    // The shipped scene, with limits that a busy machine keeps.
    let text = std::fs::read_to_string(config("external-tracker.toml")).unwrap();
    let busy = text.replace("stale_ms = 100.0", "stale_ms = 1000.0\nsilent_s = 30.0\nstop_s = 30.0");
    assert_ne!(text, busy);
    let pilot = world.start(&world.file("external-tracker.toml", &busy), &out, "ext");
    pilot.wait_for("the renderers to say that there is no pose", |status| {
        let views = status["views"].as_array().unwrap();
        views.iter().all(|view| view["state"] == "lost")
    });

    // On a thread of its own: while somebody asks for the status, poses must go on, or they grow old.
    let publishing = Publishing::start(world.run_dir("ext"));
    pilot.wait_live();
    drop(publishing);
    let ended = pilot.stop();
    let report = crate::support::report(&out);
    assert!(ended.success(), "{}", report["problems"]);
    assert_eq!(report["poses"]["refused"], 0);
    assert_eq!(report["problems"], serde_json::json!([]));
    assert!(out.join("axial-local.png").exists());
}
