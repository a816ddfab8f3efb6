//! A scene has the processes, views and topics that it names, and no others.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::support::{SMALL, World};

/// The services of a run as iceoryx2 writes them down, not as the code that makes them says.
fn services(run: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(run.join("i/services")).unwrap().flatten();
    let name = |path: std::path::PathBuf| {
        let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        let line = text
            .lines()
            .find_map(|line| line.split_once("service_name = ").map(|(_, name)| name.to_owned()));
        line.unwrap().trim().trim_matches('"').to_owned()
    };
    entries.map(|entry| name(entry.path())).collect()
}

fn processes(status: &serde_json::Value) -> BTreeSet<String> {
    let all = status["processes"].as_array().unwrap().iter();
    all.map(|process| process["name"].as_str().unwrap().to_owned())
        .collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

const ALWAYS: [&str; 10] = [
    "volume",
    "identity",
    "tool-pose",
    "emitters",
    "markers",
    "ground-truth",
    "us-image",
    "event/pilot",
    "guide",
    "workflow",
];

#[test]
fn a_run_has_the_topics_of_its_scene_and_no_others() {
    let world = World::new();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/one-view.toml");
    let pilot = world.start(&scene, &world.path("out"), "default");
    let status = pilot.wait_live();
    let names = ["tracker", "view-perpendicular", "volume-loader"];
    assert_eq!(processes(&status), set(&names));
    let mut expected = set(&ALWAYS);
    expected.extend(names.iter().map(|name| format!("heartbeat/{name}")));
    expected.extend(set(&[
        "view/perpendicular",
        "held/perpendicular",
        "look/perpendicular",
        "stamp/view-perpendicular",
        "command/pilot",
        "command/view-perpendicular",
    ]));
    assert_eq!(services(&world.run_dir("default")), expected);
    pilot.stop();
}

/// Three renderers, a recorder, and nothing of a clock.
#[test]
fn each_renderer_and_view_has_its_topics() {
    let world = World::new();
    let pilot = world.start(&world.file("s.toml", SMALL), &world.path("out"), "default");
    let status = pilot.wait_live();
    let renderers = ["view-axial", "view-frontal", "view-perpendicular"];
    let mut expected = set(&ALWAYS);
    expected.insert("command/pilot".to_owned());
    for renderer in renderers {
        expected.extend([format!("stamp/{renderer}"), format!("command/{renderer}")]);
    }
    let mut names = set(&renderers);
    names.extend(set(&["tracker", "recorder", "volume-loader"]));
    assert_eq!(processes(&status), names);
    expected.extend(names.iter().map(|name| format!("heartbeat/{name}")));
    for view in status["views"].as_array().unwrap() {
        let view = view["name"].as_str().unwrap();
        expected.extend(["view", "held", "look"].map(|topic| format!("{topic}/{view}")));
    }
    assert_eq!(services(&world.run_dir("default")), expected);
    pilot.stop();
}
