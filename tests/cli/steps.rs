//! Calibration, registration and check of a run, step by step, by the simulated hand: from the command line, as a person's screen asks for
//! it too.

mod practice;

use std::path::Path;

use crate::support::{Pilot, World, kill_9, stderr, stdout, wait_for};
use geometry::{Ct, Marker, Point, Reference, Rigid, Tool, Uncertain, checked};
use scene::{Scene, TrackerSource};
use serde_json::Value;

/// A patient of few voxels, one image, and the whole way. Points of a box about the target.
const SCENE: &str = "seed = 3\n[volume]\nspacing_mm = 6.0\n[workflow]\nstrict = true\ncheck_mm = 2.5\n[steps]\ncalibrate = \"pivot\"\n\
    turn_s = 4.0\ntouch_s = 0.5\npoints = [{ name = \"one\", ct_mm = [90, -60, -30] }, { name = \"two\", ct_mm = [-90, -60, 0] }, \
    { name = \"three\", ct_mm = [80, -70, 120] }, { name = \"four\", ct_mm = [-70, 60, 110] }]\n\
    check_points = [{ name = \"five\", ct_mm = [0, -80, 0] }, { name = \"six\", ct_mm = [50, 50, 60] }, \
    { name = \"seven\", ct_mm = [-50, -40, 90] }]\n[tracker]\nsource = \"operating-room\"\n[tracker.calibration]\n\
    file = \"tool.json\"\n[tracker.calibration.gates]\nmax_tip_error_mm = 0.5\n[tracker.registration]\nfile = \"registration.json\"\n\
    [tracker.registration.gates]\nmax_fre_mm = 2.0\nmax_tre_mm = 4.0\n[tracker.room.marker]\ncone_deg = 80.0\n\
    [tracker.room.reference]\ncone_deg = 80.0\n[tracker.room.practice]\ndivot_ct_mm = [150, -60, 0]\n\
    [[targets]]\nname = \"node\"\nct_mm = [10, 0, 60]\n\
    [[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\nsize = [64, 64]\n\
    [limits]\nsilent_s = 30.0\nstop_s = 30.0\nrestart_window_s = 3600.0";
const TIP: Point<Tool> = Point::new(0.0, 0.0, 0.0);
const TARGET: Point<Ct> = Point::new(10.0, 0.0, 60.0);

fn start(world: &World) -> Pilot<'_> {
    started(world, &world.file("s.toml", SCENE))
}

/// The run of a scene, once its steps can be gone.
fn started<'a>(world: &'a World, scene: &Path) -> Pilot<'a> {
    let pilot = world.start(scene, &world.path("out"), "default");
    pilot.wait_for("the calibrator", |status| {
        crate::support::pid_in(status, "calib").is_some()
    });
    // The tracker starts when everybody else is ready.
    pilot.wait_for("the first frame", |status| status["pose"].is_object());
    stage(&pilot, "LOADED");
    wait_for("the steps", || {
        let said = world.output("pilot", &["steps", "--json"]);
        said.status.success().then_some(())
    });
    pilot
}

/// What a step says that is carried out.
fn steps(world: &World, words: &str) -> String {
    let mut all = vec!["steps"];
    all.extend(words.split(' '));
    let output = world.output("pilot", &all);
    assert!(
        output.status.success(),
        "{words}: {}{}",
        stdout(&output),
        stderr(&output)
    );
    stdout(&output)
}

fn refused(world: &World, words: &str, why: &str) {
    let all: Vec<&str> = words.split(' ').collect();
    let output = world.output("pilot", &all);
    assert_eq!(output.status.code(), Some(1), "{words}: {}", stdout(&output));
    assert!(stderr(&output).contains(why), "{words}: {}", stderr(&output));
}

fn stage(pilot: &Pilot<'_>, wanted: &str) {
    pilot.wait_for(wanted, |status| status["guiding"]["stage"] == wanted);
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

/// A point of the tool lies where the simulated room has it, within the covariance that was found.
fn is_true(file: &Value, truth: Rigid<Marker, Tool>, point: Point<Tool>, most_rms_mm: f64) {
    let frame = &file["tool_frame"];
    let found: Rigid<Marker, Tool> = checked::rigid(
        numbers(&frame["quaternion_wxyz"]),
        numbers(&frame["translation_mm"]),
        1e-9,
    )
    .unwrap();
    let found = Uncertain::from_upper(found, numbers(&frame["covariance_upper"])).unwrap();
    let (off, rms) = (
        (found.transform() * point).distance(truth * point),
        (found * point).rms_mm(),
    );
    // Beyond four times its root mean square an error has a chance of 1e-6.
    assert!(off < 4.0 * rms && rms < most_rms_mm, "{point:?}: {off} mm, {rms} mm");
}

/// The registration places the target where it is, by the room's own truth.
fn target_is_true(file: &Value, truth: Rigid<Ct, Reference>, target: Point<Ct>) {
    assert_eq!((&file["to"], &file["from"]), (&"ct".into(), &"reference".into()));
    let transform = &file["transform"];
    let found: Rigid<Ct, Reference> = checked::rigid(
        numbers(&transform["quaternion_wxyz"]),
        numbers(&transform["translation_mm"]),
        1e-9,
    )
    .unwrap();
    let off = (found * (truth.inverse() * target)).distance(target);
    let stated = file["predicted_tre"].as_array().unwrap();
    let rms = stated.iter().find(|tre| tre["at"] == "target").unwrap()["rms_mm"]
        .as_f64()
        .unwrap();
    // A chance of 1e-6, and the touches of this seed err by 0.3 mm along each axis as the prediction has it.
    assert!(off < 4.0 * rms && rms < 1.5, "{off} mm, {rms} mm");
}

#[test]
#[allow(clippy::print_stdout, reason = "the error that was reached")]
fn the_whole_way_is_gone_step_by_step_and_what_was_made_is_true() {
    let world = World::new();
    let pilot = start(&world);
    let scene = Scene::load(&world.path("s.toml")).unwrap();
    let TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
        panic!("no room")
    };

    refused(&world, "navigate", "LOADED");
    refused(&world, "steps begin", "no task was begun");
    steps(&world, "calibrate");
    assert!(steps(&world, "begin --wait").contains("can be accepted"));
    assert!(
        !world.path("tool.json").exists(),
        "nothing is used before it is accepted"
    );
    steps(&world, "accept");
    let tool = json(&world.path("tool.json"));
    is_true(&tool, room.marker_from_tool, TIP, 0.5);

    steps(&world, "register");
    refused(
        &world,
        "steps accept",
        "0 of 4 points were touched; at least 4 are needed",
    );
    for _ in 0..4 {
        steps(&world, "begin --wait");
    }
    refused(&world, "steps begin", "every point was touched");
    let shown: Value = serde_json::from_str(&steps(&world, "--json")).unwrap();
    assert_eq!(shown["can_accept"], true, "{shown}");
    assert_eq!(shown["points"].as_array().unwrap().len(), 4);
    assert!(shown["target"]["radius_95_mm"].as_f64().unwrap() > 0.0, "{shown}");
    steps(&world, "accept");
    target_is_true(
        &json(&world.path("registration.json")),
        room.reference.as_ref().unwrap().ct_from_reference,
        TARGET,
    );

    confirm(&world, "registration.json");
    stage(&pilot, "REGISTERED");
    refused(&world, "navigate", "the registration was not checked");
    check(&world);
    stage(&pilot, "CHECKED");
    world.output("pilot", &["navigate"]);
    stage(&pilot, "NAVIGATING");
    refused(&world, "steps check", "the run navigates");

    // The marker on the patient was moved: nothing is followed before it was checked again.
    assert!(world.output("pilot", &["moved"]).status.success());
    stage(&pilot, "REGISTERED");
    refused(&world, "navigate", "the marker on the patient was pushed");
    check(&world);
    stage(&pilot, "CHECKED");

    // A calibrator that dies comes back; what was accepted stands.
    kill_9(pilot.pid("calib").unwrap());
    wait_for("the calibrator again", || {
        let said = world.output("pilot", &["steps"]);
        stdout(&said).contains("nothing is begun").then_some(())
    });
    stage(&pilot, "CHECKED");
    let touched = world.path("out/steps/touched.csv");
    assert_eq!(std::fs::read_to_string(touched).unwrap().lines().count(), 6);
    // It ended once without being asked.
    assert_eq!(pilot.stop().code(), Some(3));
}

/// Says that the examination is the patient's, by the hash that the registration is of.
fn confirm(world: &World, registration: &str) {
    let hash = json(&world.path(registration))["ct_hash"].as_str().unwrap().to_owned();
    let said = world.output("pilot", &["confirm", &hash]);
    assert!(said.status.success(), "{}", stderr(&said));
}

fn check(world: &World) {
    steps(world, "check");
    for _ in 0..3 {
        steps(world, "begin --wait");
    }
}

#[test]
fn a_check_that_fails_keeps_the_run_from_navigating() {
    let world = World::new();
    let pilot = start(&world);
    steps(&world, "calibrate");
    steps(&world, "begin --wait");
    steps(&world, "accept");
    steps(&world, "register");
    for _ in 0..4 {
        steps(&world, "begin --wait");
    }
    steps(&world, "accept");
    confirm(&world, "registration.json");
    stage(&pilot, "REGISTERED");
    // The registration that is in use is replaced by one that is off by 8 mm, of the same examination.
    let path = world.path("registration.json");
    let mut file = json(&path);
    let x = file["transform"]["translation_mm"][0].as_f64().unwrap();
    file["transform"]["translation_mm"][0] = (x + 8.0).into();
    file["transform"]["matrix"][0][3] = (x + 8.0).into();
    std::fs::write(world.path("new.json"), file.to_string()).unwrap();
    std::fs::rename(world.path("new.json"), &path).unwrap();
    // The tracker looks once a second: a touch meanwhile is of neither registration, or of the one that goes.
    wait_for("the failure", || {
        steps(&world, "check");
        world.output("pilot", &["steps", "begin", "--wait"]);
        let said = stderr(&world.output("pilot", &["navigate"]));
        said.contains("the check of the registration failed").then_some(())
    });
    stage(&pilot, "REGISTERED");
    // Another registration came while poses were published, which a run's report says.
    assert_eq!(pilot.stop().code(), Some(3));
}
