//! What is derived from a DICOM series and written as DICOM, read by software that Trocar does not use and by Trocar itself.

#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]

use std::path::Path;

use crate::support::*;
use crate::volume_tools::script;
use serde_json::{Value, json};

/// A head of a phantom, whose gantry was tilted: the map from voxels is sheared.
const TILTED: &str = "ct-head-phantom-tilt-dicom";

fn labels(world: &World, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = world.output("volume-loader", &[&["labels"], arguments].concat());
    (output.status.code(), stdout(&output), stderr(&output))
}

/// The object belongs to the series, names all of its slices and nothing else, and the validator finds no error, where there is one.
fn belongs(seen: &Value) {
    assert_eq!(seen["strangers"], json!([]), "{seen}");
    assert_eq!(seen["references"], json!([seen["slices"], 0]), "{seen}");
    assert!(seen["errors"].is_null() || seen["errors"] == json!([]), "{seen}");
}

#[test]
fn a_segmentation_has_the_voxels_of_the_label_map_where_they_were() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let (world, series) = (World::new(), data.join(TILTED));
    let series = series.to_str().unwrap();
    let [theirs, truth, nrrd, ours] =
        ["theirs.dcm", "truth.npz", "map.seg.nrrd", "ours.dcm"].map(|name| world.path(name));
    let [theirs, truth, nrrd, ours] = [&theirs, &truth, &nrrd, &ours].map(|path| path.to_str().unwrap());
    // From a map of labels 1, 2 and 5, on a part of the planes, in the frame of the series: segments count from 1 without a gap.
    script(&python, "write_segmentation.py", &[series, theirs, "labelmap", truth]);
    let (code, list, said) = labels(&world, &[theirs, "--of", series, "--out", ours, "--json"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("label 5 is segment 3 there"), "{said}");
    let renumbered = script(&python, "write_segmentation.py", &[series, theirs, "binary", truth]);
    let seen = script(&python, "check_derived.py", &["segmentation", ours, series, truth]);
    belongs(&seen);
    assert_eq!(seen["differ"], 0, "{seen}");
    assert_eq!(
        seen["names"],
        json!({"1": "liver", "2": "Vena portae", "3": "lymph node"}),
        "{seen}"
    );
    // Decimal strings of 16 characters, and places of some hundred mm made of steps along axes.
    assert!(seen["off_mm"].as_f64().unwrap() < 1e-9, "{seen}");
    // And by Trocar: the same structures, on the same voxels.
    let (_, again, _) = labels(&world, &[ours, "--of", series, "--json"]);
    let rows = |text: &str| -> Vec<(Value, Value)> {
        let rows: Value = serde_json::from_str(text).unwrap();
        let row = |row: &Value| (row["name"].clone(), row["voxels"].clone());
        rows.as_array().unwrap().iter().map(row).collect()
    };
    assert_eq!(rows(&again), rows(&list));
    assert_eq!(rows(&again)[2].1, renumbered["voxels"]["3"]);
    // A map that does not say its frame goes in where it lies on all voxels, and not where it lies on a part of them.
    let (code, _, said) = labels(&world, &[ours, "--of", series, "--out", nrrd]);
    assert_eq!(code, Some(0), "{said}");
    let (code, _, said) = labels(&world, &[nrrd, "--of", series, "--out", ours, "--overwrite"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("a segmentation says that it is of the series") && said.contains("A PART OF"),
        "{said}"
    );
}

#[test]
fn a_segmentation_is_not_written_of_what_it_could_not_say() {
    let world = World::new();
    let [ct, map, out] = ["ct.nii.gz", "map.seg.nrrd", "out.dcm"].map(|name| world.path(name));
    let [ct, map, out] = [&ct, &map, &out].map(|path| path.to_str().unwrap());
    let made = world.output("volume-loader", &["phantom", "--spacing-mm", "6", "--out", ct]);
    assert!(made.status.success(), "{}", stderr(&made));
    let (code, _, said) = labels(&world, &["phantom", "--of", "phantom", "--out", map]);
    assert_eq!(code, Some(0), "{said}");
    for (arguments, words) in [
        (
            &[map, "--out", out][..],
            "a DICOM segmentation is of a series; name it by --of",
        ),
        (
            &[map, "--of", "phantom", "--out", out],
            "the generated patient is no DICOM series",
        ),
        (&[map, "--of", ct, "--out", out], "LABELS LIE ON ANOTHER GRID"),
    ] {
        let (code, _, said) = labels(&world, arguments);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains(words), "{words:?} in {said}");
        assert!(!Path::new(out).exists());
    }
}

#[test]
fn targets_are_written_as_a_structure_set_and_come_back() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let (world, series) = (World::new(), data.join(TILTED));
    let series = series.to_str().unwrap();
    let [plan, out, other] = ["plan.json", "targets.dcm", "other.json"].map(|name| world.path(name));
    let [plan, out, other] = [&plan, &out, &other].map(|path| path.to_str().unwrap());
    let run = |arguments: &[&str]| {
        let output = world.output("pilot", &[&["plan"], arguments].concat());
        (output.status.code(), stderr(&output))
    };
    let target = [
        "--target",
        "Knoten ä=-12.25,40.5,800.125",
        "--entry",
        "Knoten ä=-80,-20.75,812",
    ];
    let more = ["--target", "b=-41.523456789012,62.1,736.3", "--export", out];
    let (code, said) = run(&[&[plan, "--volume", series][..], &target, &more].concat());
    assert!(matches!(code, Some(0 | 3)), "{said}");
    let seen = script(&python, "check_derived.py", &["points", out, series]);
    belongs(&seen);
    assert_eq!(seen["points"]["Knoten ä"], json!([-12.25, 40.5, 800.125]), "{seen}");
    assert_eq!(
        seen["points"]["Knoten ä entry"],
        json!([-80.0, -20.75, 812.0]),
        "{seen}"
    );
    // Sixteen characters of a decimal string.
    let x = seen["points"]["b"][0].as_f64().unwrap();
    assert!((x + 41.523_456_789_012).abs() < 1e-9, "{seen}");
    let (code, said) = run(&[other, "--volume", series, "--import", out]);
    assert!(matches!(code, Some(0 | 3)), "{said}");
    assert!(
        said.contains("2 targets, 1 entries") && said.contains("in the frame of reference of the examination"),
        "{said}"
    );
    let targets = |path: &str| -> Value {
        serde_json::from_str::<Value>(&std::fs::read_to_string(path).unwrap()).unwrap()["targets"].clone()
    };
    let places = |all: &Value| -> Vec<(Value, Value)> {
        let place = |one: &Value| (one["name"].clone(), one["entry_ct_mm"].clone());
        all.as_array().unwrap().iter().map(place).collect()
    };
    assert_eq!(places(&targets(other)), places(&targets(plan)));
    // Of an examination that is no DICOM there is no frame of reference to say.
    let patient = world.path("none.json");
    let (code, said) = run(&[
        patient.to_str().unwrap(),
        "--volume",
        "phantom",
        "--target",
        "b=0,0,0",
        "--export",
        out,
        "--overwrite",
    ]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("the generated patient is no DICOM series") && !patient.exists(),
        "{said}"
    );
}
