//! `calib mesh`: surfaces of others, beside trimesh, and the published pelvis that VTK wrote.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use crate::support::{World, python, shared, stderr, stdout};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn peer(python: &Path, arguments: &[&str]) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/check_surfaces.py");
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// trimesh writes an ellipsoid that is on no axis, as text and as binary; `calib mesh` writes each again, and trimesh reads it at
/// the same places: turned by half a circle where the axes are others.
#[test]
fn surfaces_of_trimesh_come_back_where_they_lay() {
    let Some(python) = python() else { return };
    let world = World::new();
    let folder = world.path("surfaces");
    std::fs::create_dir(&folder).unwrap();
    let written = peer(&python, &["write", folder.to_str().unwrap()]);
    let written = written.as_array().unwrap();
    assert_eq!(written.len(), 5);
    let mut triples = Vec::new();
    for (path, place) in written.iter().zip(0..) {
        let path = path.as_str().unwrap();
        for (ending, axes) in [("stl", "ras"), ("ply", "lps"), ("obj", "ras")] {
            let out = world.path(&format!("{place}.{ending}"));
            let out = out.to_str().unwrap();
            let words = ["mesh", path, "--frame", "ras", "--axes", axes, "--out", out];
            let made = world.output("calib", &words);
            assert!(made.status.success(), "{path}: {}", stderr(&made));
            triples.push(serde_json::json!([
                path,
                out,
                if axes == "ras" { "same" } else { "turned" }
            ]));
        }
        // Nothing is guessed.
        let refused = world.output("calib", &["mesh", path]);
        assert_eq!(refused.status.code(), Some(1));
        assert!(
            stderr(&refused).contains("does not say whether its coordinates are LPS or RAS"),
            "{}",
            stderr(&refused)
        );
    }
    // In one go: to start Python takes longer than to compare.
    let compared = peer(&python, &["compare", &Value::from(triples).to_string()]);
    for (number, apart) in compared.as_array().unwrap().iter().enumerate() {
        // STL has single precision: half a unit in the last place of 1000 mm, once for each writer. The others have double.
        let most_mm = match number {
            _ if number % 3 == 0 || number < 6 => 1e-4,
            // Of a text PLY with 8 decimals trimesh makes single precision, which is what was written: half of the last decimal.
            9..12 => 1e-8,
            _ => 1e-9,
        };
        assert!(apart["apart_mm"].as_f64().unwrap() < most_mm, "{number}: {compared}");
        assert!(apart["faces"].as_u64().unwrap() >= 1000, "{compared}");
    }
}

#[test]
fn the_published_pelvis_is_read_whole_and_comes_back() {
    let Some(pelvis) = shared("data/pelvis-phantom/DeciPelvis.vtk") else {
        return;
    };
    let world = World::new();
    let pelvis = pelvis.to_str().unwrap();
    let read = world.output("calib", &["mesh", pelvis, "--frame", "lps"]);
    assert!(
        stdout(&read).contains("93003 triangles on 47831 points"),
        "{}{}",
        stdout(&read),
        stderr(&read)
    );
    let out = world.path("pelvis.ply");
    let out = out.to_str().unwrap();
    let made = world.output(
        "calib",
        &["mesh", pelvis, "--frame", "lps", "--out", out, "--axes", "ras"],
    );
    assert!(made.status.success(), "{}", stderr(&made));
    // It says its axes now, so that nobody has to.
    let again = world.output("calib", &["mesh", out]);
    let bounds = |output: &str| output.lines().skip(1).take(2).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(bounds(&stdout(&again)), bounds(&stdout(&read)), "{}", stderr(&again));
}
