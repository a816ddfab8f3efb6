//! `volume-loader inspect` and `export`: known facts of known volumes, and series that other software reads alike.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(clippy::print_stdout, reason = "measured differences, and why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use support::nifti::Nifti;
use support::*;

/// Runs `volume-loader`, which must succeed; returns what it printed.
fn tool(world: &World, arguments: &[&str]) -> String {
    let output = world.output("volume-loader", arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// Runs `volume-loader`, which must fail with one paragraph that holds all `words`, between bars.
fn refused(world: &World, arguments: &[&str], words: &str) {
    let output = world.output("volume-loader", arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("volume-loader: error: ") && said.lines().count() == 1,
        "{said}"
    );
    for word in words.split(" | ") {
        assert!(said.contains(word), "{word:?} in: {said}");
    }
    assert_eq!(stdout(&output), "");
}

/// The generated patient at 6 mm.
fn patient(world: &World) -> PathBuf {
    let path = world.path("patient.nii.gz");
    tool(
        world,
        &["phantom", "--spacing-mm", "6", "--out", path.to_str().unwrap()],
    );
    path
}

/// A volume of noise with this map from voxels to mm RAS.
fn noise(world: &World, name: &str, rows: [[f32; 4]; 3]) -> PathBuf {
    let mut nifti = Nifti::noise();
    for (at, value) in rows.iter().flatten().enumerate() {
        nifti = nifti.f32(280 + 4 * at, *value);
    }
    let path = world.path(name);
    fs::write(&path, Vec::<u8>::from(nifti)).unwrap();
    path
}

#[test]
fn the_generated_patient_has_its_known_facts() {
    let world = World::new();
    let (path, png) = (patient(&world), world.path("patient.png"));
    let (path, png) = (path.to_str().unwrap(), png.to_str().unwrap());
    let text = tool(&world, &["inspect", path, "--json", "--png", png]);
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["dims"], serde_json::json!([60, 44, 60]));
    assert_eq!(summary["letters"], "LPS");
    assert_eq!(summary["handedness"], "right-handed");
    assert!(summary["tilt_degrees"].as_f64().unwrap() < 1e-9, "{text}");
    for axis in 0..3 {
        assert!((summary["spacing_mm"][axis].as_f64().unwrap() - 6.0).abs() < 1e-6);
    }
    assert_eq!(
        (&summary["hu"]["min"], &summary["voxels"]),
        (&(-1000).into(), &158_400.into())
    );
    assert_eq!(summary["warnings"], serde_json::json!([]));
    let texts = png_texts(Path::new(png));
    assert_eq!(texts["volume_hash"], summary["hash"].as_str().unwrap());
    let report = tool(&world, &["inspect", path]);
    for words in ["orientation    LPS: columns to left", "60 x 44 x 60 = 158400", "soft"] {
        assert!(report.contains(words), "{words}: {report}");
    }
}

#[test]
fn formats_that_cannot_be_are_refused_and_leave_nothing() {
    let world = World::new();
    let path = patient(&world);
    let path = path.to_str().unwrap();
    let target = |name: &str| world.path(name).to_str().unwrap().to_owned();
    refused(
        &world,
        &["export", path, &target("x.tif")],
        "x.tif: the ending .tif | .nii.gz",
    );
    let full = world.path("");
    let full = format!("dicom:{}", full.display());
    refused(&world, &["export", path, &full], "the folder is not empty");
    let slanted = noise(
        &world,
        "slanted.nii",
        [[-2.0, 0.5, 0.0, 0.0], [0.0, -2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]],
    );
    let slanted = slanted.to_str().unwrap();
    refused(
        &world,
        &["export", slanted, &target("s")],
        "rows and columns of the slices meet at",
    );
    refused(
        &world,
        &["inspect", &target("absent.nii")],
        "absent.nii: there is no such file",
    );
    assert_eq!(fs::read_dir(world.path("")).unwrap().count(), 2);
    // A copy is the same volume.
    tool(&world, &["export", path, &target("copy.nii")]);
    let hash = |path: &str| {
        let summary: Value = serde_json::from_str(&tool(&world, &["inspect", path, "--json"])).unwrap();
        summary["hash"].as_str().unwrap().to_owned()
    };
    assert_eq!(hash(path), hash(&target("copy.nii")));
}

/// What the script says of the series of `volume`.
fn checked(python: &Path, series: &Path, volume: &Path) -> Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_dicom_export.py");
    let output = Command::new(python).args([&script, series, volume]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{seen}");
    assert_eq!(seen["voxels_differ"], 0, "{seen}");
    assert_eq!(seen["named"], serde_json::json!([]), "{seen}");
    assert!(seen["corner_mm"].as_f64().unwrap() < 1e-6, "{seen}");
    for (tool, errors) in seen["validators"].as_object().unwrap() {
        assert_eq!(errors, &serde_json::json!([]), "{tool}");
    }
    seen
}

#[test]
fn other_software_reads_the_series_alike() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    let volume = patient(&world);
    for (name, more) in [
        ("plain", &[][..]),
        ("implicit", &["--syntax", "implicit-little"]),
        ("big", &["--syntax", "explicit-big"]),
        ("packed", &["--compress", "--shuffle-names", "7"]),
    ] {
        let series = world.path(name);
        let arguments = [&["export", volume.to_str().unwrap(), series.to_str().unwrap()], more].concat();
        tool(&world, &arguments);
        let seen = checked(&python, &series, &volume);
        assert_eq!((&seen["files"], &seen["tilt_degrees"]), (&60.into(), &Value::Null));
        for key in ["spacing_mm", "origin_mm", "direction"] {
            // NIfTI holds f32.
            assert!(seen[key].as_f64().unwrap() < 1e-5, "{key}: {seen}");
        }
    }
}

#[test]
fn tilted_and_mirrored_series_keep_every_place() {
    let Some(python) = python() else {
        return;
    };
    let world = World::new();
    // A gantry tilted by 18.5 degrees, in RAS; and slices that go down.
    let (s, c) = 18.5_f32.to_radians().sin_cos();
    let tilted = [
        [-2.0, 0.0, 0.0, 50.0],
        [0.0, -2.0 * c, 0.0, 60.0],
        [0.0, -2.0 * s, 2.5, 742.3],
    ];
    let mirrored = [[-2.0, 0.0, 0.0, 50.0], [0.0, -1.5, 0.0, 60.0], [0.0, 0.0, -2.5, 742.3]];
    for (name, rows, tilt) in [("tilted", tilted, Some(-18.5)), ("mirrored", mirrored, None)] {
        let (volume, series) = (noise(&world, &format!("{name}.nii"), rows), world.path(name));
        tool(&world, &["export", volume.to_str().unwrap(), series.to_str().unwrap()]);
        let seen = checked(&python, &series, &volume);
        match (seen["tilt_degrees"].as_f64(), tilt) {
            (None, None) => {}
            (Some(found), Some(tilt)) => assert!((found - tilt).abs() < 1e-4, "{seen}"),
            _ => panic!("{seen}"),
        }
    }
}
