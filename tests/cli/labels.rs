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
        let rows = listed(&world, &[file, "--of", series, "--out", output, "--overwrite"]);
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
        // Nothing is replaced unasked, and what is read never.
        let refused = |out: &str, more: &[&str]| {
            let all = [&["labels", file, "--of", series, "--out", out][..], more].concat();
            let output = world.output("volume-loader", &all);
            assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
            stderr(&output)
        };
        assert!(refused(output, &[]).contains("there is a file of this name"));
        let own = world.path("own.nrrd");
        std::os::unix::fs::symlink(file, &own).unwrap();
        assert!(refused(own.to_str().unwrap(), &["--overwrite"]).contains("this is the label map"));
        std::fs::remove_file(own).unwrap();
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
    // Along the rows of one plane into the middle of the liver, from before it.
    let made = plan(
        &series,
        &["--target", "n=-41.5,62.1,736.3", "--entry", "n=-41.5,2.7,756.2"],
    );
    assert!(
        stdout(&made).contains("NOT CHECKED, there is no label map"),
        "{}",
        stdout(&made)
    );
    let beside = plan(&series, &["--labels", file]);
    let said = stdout(&beside);
    assert!(said.contains("CUTS liver (label 1)"), "{said}\n{}", stderr(&beside));
    // The planes without a structure have no frame: the map lies on a part of the CT, and is its own.
    assert!(!said.contains("LABELS LIE") && !said.contains("MOVED"), "{said}");
    assert!(!said.contains("! the label map: "), "{said}");
    for (status, words) in [
        (
            "UNAPPROVED",
            "! the label map: (300E,0002) ApprovalStatus is UNAPPROVED",
        ),
        ("REJECTED", "ApprovalStatus: found REJECTED"),
    ] {
        let of_status = world.path("of_status.dcm");
        let of_status = of_status.to_str().unwrap();
        let arguments = [series.to_str().unwrap(), of_status, "binary", truth, status];
        script(&python, "write_segmentation.py", &arguments);
        let asked = plan(&series, &["--labels", of_status]);
        let code = if status == "REJECTED" { 1 } else { 3 };
        let said = stdout(&asked) + &stderr(&asked);
        assert_eq!(asked.status.code(), Some(code), "{said}");
        assert!(said.contains(words), "{said}");
    }
    std::fs::remove_file(world.path("plan.json")).unwrap();
    let other = plan(&data.join("ct-chest-lidc-dicom"), &["--labels", file]);
    assert_eq!(other.status.code(), Some(1), "{}", stdout(&other));
    let said = stderr(&other);
    // Of another person too, which is looked for before the frame of reference.
    assert!(
        said.contains("PatientID: found another than the examination's"),
        "{said}"
    );
}

#[test]
fn points_of_a_structure_set_are_targets_of_the_scan_that_they_are_in() {
    let (Some(python), Some(data)) = (python(), shared("data")) else {
        return;
    };
    let (world, series) = (World::new(), data.join(TILTED));
    let file = world.path("points.dcm");
    let folder = series.join("S21610/S2010");
    let slices = std::fs::read_dir(&folder).unwrap();
    let slice = slices.filter_map(Result::ok).map(|entry| entry.path()).min().unwrap();
    let points = ["Knoten ä=-12.25,40.5,800.125", "Knoten ä entry=-80,-20.75,812"];
    let [slice, file] = [&slice, &file].map(|path| path.to_str().unwrap());
    let written = script(
        &python,
        "write_structure_set.py",
        &[&[slice, file][..], &points].concat(),
    );
    let plan = |ct: &str, name: &str| {
        let (name, ct) = (world.path(name), data.join(ct));
        let all = [
            "plan",
            name.to_str().unwrap(),
            "--volume",
            ct.to_str().unwrap(),
            "--import",
            file,
        ];
        let output = world.output("pilot", &all);
        (
            output.status.code(),
            stderr(&output),
            std::fs::read_to_string(&name).ok(),
        )
    };
    let (code, said, text) = plan(TILTED, "plan.json");
    assert!(matches!(code, Some(0 | 3)), "{code:?}: {said}");
    assert!(
        said.contains("1 targets, 1 entries") && said.contains("in the frame of reference of the examination"),
        "{said}"
    );
    assert!(said.contains("2 regions of interest are no points"), "{said}");
    for words in [
        "(300E,0002) ApprovalStatus is UNAPPROVED",
        "it is of another study than the examination",
    ] {
        assert!(said.contains(&format!("points.dcm: warning: {words}")), "{said}");
    }
    let made: Value = serde_json::from_str(&text.unwrap()).unwrap();
    assert_eq!(made["targets"][0]["name"], "Knoten ä", "{made}");
    assert_eq!(made["targets"][0]["ct_mm"], written["Knoten ä"], "{made}");
    assert_eq!(made["targets"][0]["entry_ct_mm"], written["Knoten ä entry"], "{made}");
    let (code, said, text) = plan("ct-chest-lidc-dicom", "other.json");
    assert_eq!((code, text), (Some(1), None), "{said}");
    assert!(said.contains("another frame of reference"), "{said}");
}
