//! `volume-loader labels`, and label maps of a plan, with DICOM segmentations that other software wrote.

#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]

use std::path::Path;

use crate::support::*;
use crate::volume_tools::script;
use serde_json::Value;

/// A head of a phantom, whose gantry was tilted: the map from voxels is sheared.
const TILTED: &str = "ct-head-phantom-tilt-dicom";

fn listed(world: &World, arguments: &[&str]) -> Value {
    let output = world.output("volume-loader", &[&["labels", "--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn segmentations_of_other_software_have_their_voxels_at_their_places() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let (world, series) = (World::new(), data.join(TILTED));
    let series = series.to_str().unwrap();
    let [file, truth, output] = ["organs.dcm", "truth.npz", "organs.seg.nrrd"].map(|name| world.path(name));
    let [file, truth, output] = [&file, &truth, &output].map(|path| path.to_str().unwrap());
    for (kind, numbers) in [
        ("binary", [1, 2, 3]),
        ("binary-all", [1, 2, 3]),
        ("fractional", [1, 2, 3]),
        ("labelmap", [1, 2, 5]),
    ] {
        let made = script(&python, "write_segmentation.py", &[series, file, kind, truth]);
        let rows = listed(&world, &[file, "--of", series, "--out", output]);
        let names = ["liver", "Vena portae", "lymph node"];
        for ((row, number), name) in rows.as_array().unwrap().iter().zip(numbers).zip(names) {
            assert_eq!((&row["label"], &row["name"]), (&number.into(), &name.into()), "{kind}");
            assert_eq!(row["voxels"], made["voxels"][number.to_string()], "{kind}");
        }
        let seen = script(&python, "check_labels.py", &[output, truth]);
        assert_eq!(seen["differ"], 0, "{kind}: {seen}");
        // Places of a hundred mm, as doubles.
        assert!(seen["off_mm"].as_f64().unwrap() < 1e-9, "{kind}: {seen}");
        assert_eq!(seen["names"][numbers[2].to_string()], "lymph node", "{kind}: {seen}");
        // What was written is read as what it was written of.
        assert_eq!(listed(&world, &[output]), rows, "{kind}");
    }
}

#[test]
fn a_plan_names_the_structures_of_a_segmentation_and_refuses_one_of_another_scan() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let (world, series) = (World::new(), data.join(TILTED));
    let [file, truth] = ["organs.dcm", "truth.npz"].map(|name| world.path(name));
    let [file, truth] = [&file, &truth].map(|path| path.to_str().unwrap());
    script(
        &python,
        "write_segmentation.py",
        &[series.to_str().unwrap(), file, "binary", truth],
    );
    let plan = |ct: &Path, more: &[&str]| {
        let (name, ct) = (world.path("plan.json"), ct.to_str().unwrap());
        let all = [&["plan", name.to_str().unwrap(), "--volume", ct], more].concat();
        world.output("pilot", &all)
    };
    let rows = listed(&world, &[file, "--of", series.to_str().unwrap()]);
    println!("{rows}");
    let made = plan(&series, &["--target", "n=0,0,0", "--entry", "n=0,-40,0"]);
    assert!(
        stdout(&made).contains("NOT CHECKED, there is no label map"),
        "{}",
        stdout(&made)
    );
    let beside = plan(&series, &["--labels", file]);
    let said = stdout(&beside);
    assert!(said.contains("liver (label 1)"), "{said}\n{}", stderr(&beside));
    // The planes without a structure have no frame: the map lies on a part of the CT, and is its own.
    assert!(!said.contains("ANOTHER GRID") && !said.contains("MOVED"), "{said}");
    let other = plan(&data.join("ct-lego-phantom-dicom"), &["--labels", file]);
    assert_eq!(other.status.code(), Some(1), "{}", stdout(&other));
}
