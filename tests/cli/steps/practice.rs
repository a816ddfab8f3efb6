//! The scenes that are shipped to practise with, gone through to the navigation as a beginner goes: each step until it can be accepted.

use std::fs;

use geometry::Point;
use scene::{Scene, TrackerSource};

use super::{TIP, check, confirm, is_true, json, refused, stage, started, steps, target_is_true};
use crate::support::{World, stderr, stdout};

/// No task of a practice has more steps: the base has 28 touches, a pivoting before them and a seat behind.
const MOST_STEPS: usize = 40;
/// One small image, as nothing here looks at any.
const ONE_VIEW: &str = "\n[[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\nsize = [64, 64]\n";

/// Begins a task and listens until what was found can be accepted, and accepts it.
fn practise(world: &World, task: &str) -> usize {
    steps(world, task);
    for count in 1..=MOST_STEPS {
        let output = world.output("pilot", &["steps", "begin", "--wait"]);
        let said = stdout(&output);
        assert!(
            output.status.success() && !said.contains("REFUSED"),
            "{task}, step {count}: {said}{}",
            stderr(&output)
        );
        if said.contains("can be accepted") {
            steps(world, "accept");
            return count;
        }
    }
    panic!("{task} does not end");
}

/// Goes through `config/practice/{name}.toml` as it is shipped, but for its images; how many steps calibration and registration have. A point
/// of the shaft 100 mm behind the tip is known to `most_rms_mm`.
fn go_through(name: &str, most_rms_mm: f64) -> [usize; 2] {
    let world = World::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/config/practice");
    fs::create_dir(world.path("practice")).unwrap();
    for entry in fs::read_dir(shipped).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), world.path("practice").join(entry.file_name())).unwrap();
    }
    let path = world.path(&format!("practice/{name}.toml"));
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text + ONE_VIEW).unwrap();
    let scene = Scene::load(&path).unwrap();
    let TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
        panic!("no room")
    };
    let pilot = started(&world, &path);

    let calibrated = practise(&world, "calibrate");
    let tool = json(&world.path("practice/tool.json"));
    is_true(&tool, room.marker_from_tool, TIP, 0.5);
    is_true(&tool, room.marker_from_tool, Point::new(0.0, 0.0, -100.0), most_rms_mm);
    let registered = practise(&world, "register");
    let patient = phantom::Phantom::new(scene.seed);
    let target = patient.targets().iter().find(|node| node.name == "para-aortic-left");
    target_is_true(
        &json(&world.path("practice/registration.json")),
        room.reference.as_ref().unwrap().ct_from_reference,
        target.unwrap().centre,
    );

    confirm(&world, "practice/registration.json");
    stage(&pilot, "REGISTERED");
    refused(&world, "navigate", "the registration was not checked");
    check(&world);
    stage(&pilot, "CHECKED");
    assert!(world.output("pilot", &["navigate"]).status.success());
    stage(&pilot, "NAVIGATING");
    assert_eq!(pilot.stop().code(), Some(0));
    [calibrated, registered]
}

/// A tip, then 28 touches, then the seat; four of five points in their order.
#[test]
fn the_practice_on_the_calibration_base_leads_to_a_navigation() {
    assert_eq!(go_through("base", 0.5), [30, 4]);
}

/// A tip, then the shaft; beads in any order, until there are enough.
#[test]
fn the_practice_with_a_spin_and_beads_leads_to_a_navigation() {
    let [calibrated, registered] = go_through("pivot-and-spin", 1.0);
    assert!(calibrated == 2 && registered >= 4, "{calibrated} {registered}");
}
