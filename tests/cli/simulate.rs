//! The command `simulate`: shipped scenes, their certificates and pictures, and what it refuses.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{World, shared, stderr, stdout};
use serde_json::Value;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("config/solids")
}

fn scene(name: &str) -> String {
    scenes().join(name).to_string_lossy().into_owned()
}

/// Runs a scene into a folder of its own; `result.json`.
fn run(world: &World, scene: &str, out: &str) -> Value {
    let folder = world.path(out);
    let output = world.output("simulate", &["run", scene, "--out", &folder.to_string_lossy()]);
    assert!(output.status.success(), "{}", stderr(&output));
    let words = stdout(&output);
    assert!(words.contains("result.json"));
    assert!(
        words.contains("all certified") || words.contains("as they are placed"),
        "{words}"
    );
    serde_json::from_slice(&fs::read(folder.join("result.json")).unwrap()).unwrap()
}

/// Every certificate of a result holds: the criteria are those of the crate, the same in every scene and unit.
fn certify(result: &Value) -> usize {
    let mut certified = 0;
    for state in result["states"].as_array().unwrap() {
        let Some(certificate) = state.get("certificate") else {
            continue;
        };
        let number = |key: &str| certificate[key].as_f64().unwrap();
        assert_eq!(certificate["holds"], true, "{certificate}");
        assert_eq!(certificate["exact"], true, "{certificate}");
        assert!(certificate["verdict"].as_str().unwrap().starts_with("minimum"));
        assert!(number("complementarity") <= 1e-8, "{state}");
        assert!(number("free_force") <= 1e-8, "{state}");
        assert!(number("force_change") <= 1e-7, "{state}");
        assert!(number("violation") <= 1e-9, "{state}");
        assert!(number("force_balance") <= 1e-6, "{state}");
        assert!(number("least_determinant") > 0.0, "{state}");
        assert_eq!(certificate["falling"], 0, "{state}");
        certified += 1;
    }
    certified
}

#[test]
fn every_scene_is_checked_and_says_what_it_is_for() {
    let world = World::new();
    let mut found = 0;
    for entry in fs::read_dir(scenes()).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# "), "{} does not say what it is for", path.display());
        let scene = path.to_string_lossy().into_owned();
        let mut arguments = vec!["check", &scene];
        let is_of_space = text.contains("\n[space]");
        // Its label map is not part of the project, unless it is the generated patient's.
        let is_elsewhere = is_of_space && !text.contains("labels = \"phantom\"");
        let map = is_elsewhere.then(|| shared("data/ct-abdopelvis-nifti/example_seg_fast_force_split.nii.gz"));
        let map = map.flatten().map(|map| map.to_string_lossy().into_owned());
        match &map {
            Some(map) => arguments.extend(["--labels", map]),
            None if is_elsewhere => continue,
            None => {}
        }
        let output = world.output("simulate", &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        let words = stdout(&output);
        let what = if is_of_space { "organ " } else { "solid " };
        assert!(words.contains("unknowns") && words.contains(what), "{words}");
        found += 1;
    }
    assert!(found >= 15, "{found} scenes");
}

#[test]
fn a_scene_in_space_without_its_label_map_says_how_to_get_it() {
    let world = World::new();
    let kidney = scene("kidney.toml");
    let output = world.output("simulate", &["check", &kidney, "--labels", "/no/such.nii.gz"]);
    assert_eq!(output.status.code(), Some(1));
    for words in [
        "key space.labels",
        "/no/such.nii.gz",
        "--labels FILE",
        "TotalSegmentator",
    ] {
        assert!(
            stderr(&output).contains(words),
            "{words:?} is not in: {}",
            stderr(&output)
        );
    }
    let output = world.output("simulate", &["check", &scene("tube.toml"), "--labels", "a.nii"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("scenes in space"), "{}", stderr(&output));
}

#[test]
fn scenes_come_to_rest_and_give_the_same_pictures_each_time() {
    let world = World::new();
    for (name, equilibria, pictures) in [
        ("figure-32.toml", 1, &["start.png", "shape.png"][..]),
        (
            "figure-36.toml",
            51,
            &["start.png", "shape.png", "strip.png", "film.png"],
        ),
        (
            "figure-39.toml",
            1,
            &["start.png", "shape.png", "energy.png", "von-mises.png"],
        ),
        ("figure-28.toml", 0, &["start.png", "shape.png"]),
    ] {
        let (first, second) = (
            run(&world, &scene(name), &format!("{name}-1")),
            run(&world, &scene(name), &format!("{name}-2")),
        );
        assert_eq!(certify(&first), equilibria, "{name}");
        assert_eq!(certify(&second), equilibria);
        let listed: Vec<&str> = first["pictures"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| p.as_str().unwrap())
            .collect();
        assert_eq!(listed, pictures, "{name}");
        for picture in pictures {
            let bytes = |run: u32| fs::read(world.path(&format!("{name}-{run}")).join(picture)).unwrap();
            assert!(bytes(1) == bytes(2), "{name}: {picture} differs from run to run");
            let image = image::load_from_memory(&bytes(1)).unwrap().to_rgb8();
            let dark = image.pixels().filter(|p| p.0.iter().all(|c| *c < 80)).count();
            assert!(dark > 500, "{name}: {picture} shows nothing");
        }
    }
    // The T stands on both corners of its foot, each with half of its weight: area 0.82.
    let result: Value = serde_json::from_slice(&fs::read(world.path("figure-32.toml-1/result.json")).unwrap()).unwrap();
    let contacts = result["states"][1]["contacts"].as_array().unwrap();
    let forces: Vec<f64> = contacts
        .iter()
        .map(|c| c["force"][1].as_f64().unwrap())
        .filter(|f| *f > 1e-6)
        .collect();
    assert_eq!(forces.len(), 2);
    assert!(forces.iter().all(|f| (f - 0.41).abs() < 1e-6), "{forces:?}");
}

/// The scenes with steps, and those that touch in a few points: every state in exact contact.
#[test]
fn every_state_on_the_way_is_certified() {
    let world = World::new();
    for (name, states) in [
        ("figure-33.toml", 1),
        ("figure-35.toml", 1),
        ("figure-37.toml", 1),
        ("figure-40.toml", 41),
    ] {
        let result = run(&world, &scene(name), name);
        assert_eq!(certify(&result), states, "{name}");
        assert_eq!(result["certified"], true, "{name}");
    }
}

/// The ring in the ring may roll, and lies along a long stretch of near equal curvature; the way of its search is shown.
#[test]
fn a_ring_that_rolls_in_another_is_certified_and_its_way_is_shown() {
    let world = World::new();
    let folder = world.path("rings");
    let output = world.output(
        "simulate",
        &["run", &scene("figure-38.toml"), "--out", &folder.to_string_lossy()],
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let result: Value = serde_json::from_slice(&fs::read(folder.join("result.json")).unwrap()).unwrap();
    let states = result["states"].as_array().unwrap();
    let certificate = &states[states.len() - 1]["certificate"];
    assert_eq!(certificate["holds"], true, "{certificate}");
    assert_eq!(result["certified"], true);
    assert!(states.len() > 10 && folder.join("strip.png").exists() && folder.join("film.png").exists());
}

const OVERLAPPING: &str = r#"title = "two plates"
units = { length = "mm", stress = "kPa" }
[[solids]]
name = "a"
weight = [0, -1]
polygon = { vertices = [[0, 0], [1, 0], [1, 1], [0, 1]] }
[[solids]]
name = "b"
polygon = { vertices = [[0.8, 0.5], [2, 0.5], [2, 2], [0.8, 2]] }
[contact]
"#;

#[test]
fn what_cannot_be_is_refused_by_line_and_name_and_leaves_nothing() {
    let world = World::new();
    let refused = |text: &str, command: &[&str], words: &[&str]| {
        let file = world.file("scene.toml", text);
        let mut all = vec![command[0], file.to_str().unwrap()];
        all.extend(&command[1..]);
        let output = world.output("simulate", &all);
        assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
        assert_eq!(stdout(&output), "");
        let error = stderr(&output);
        for word in words.iter().chain(&["simulate: error:"]) {
            assert!(error.contains(word), "{word:?} is not in: {error}");
        }
    };
    let out = world.path("out").to_string_lossy().into_owned();
    let run = ["run", "--out", &out];
    refused(OVERLAPPING, &run, &["line 3", "\"b\" in \"a\"", "contact.overlaps"]);
    refused(
        &OVERLAPPING.replace("[0, -1]", "[0, nan]"),
        &["check"],
        &["line 5", "solids.0.weight", "NaN"],
    );
    refused(
        &OVERLAPPING.replace("[contact]", "[contacts]"),
        &["check"],
        &["line 10", "contacts"],
    );
    assert!(!world.path("out").exists());
}

#[test]
fn no_equilibrium_is_an_answer_with_what_was_found() {
    let world = World::new();
    let file = world.file("falls.toml", &OVERLAPPING.replace("[contact]\n", ""));
    let out = world.path("out");
    let arguments = ["run", file.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = world.output("simulate", &arguments);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("no equilibrium exists"), "{}", stderr(&output));
    let result: Value = serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    assert!(
        result["refused"].as_str().unwrap().contains("no equilibrium"),
        "{result}"
    );
    assert!(out.join("shape.png").exists());
    // The folder has results now.
    let again = world.output("simulate", &arguments);
    assert_eq!(again.status.code(), Some(1));
    assert!(
        stderr(&again).contains("not empty") && stderr(&again).contains("--overwrite"),
        "{}",
        stderr(&again)
    );
}
