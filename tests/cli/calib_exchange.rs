//! `calib import` and `calib export` beside SimpleITK, and on a published device set of PLUS.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use crate::support::{World, python, shared, stderr, stdout};
use calib::file::ToolFile;
use geometry::{Direction, Marker, Point, Rigid, Tool};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

const SAID: [&str; 6] = ["--shaft", "z", "--tip-error-mm", "0.5", "--axis-error-deg", "1"];
/// The tip and a point on the shaft, in the tool: what a frame says of a tool of revolution.
const ON_SHAFT: [[f64; 3]; 2] = [[0.0, 0.0, 0.0], [0.0, 0.0, -150.0]];

fn peer(python: &Path, arguments: &[&str]) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/check_exchange.py");
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// The tool that is made of a file.
fn imported(world: &World, path: &str, arguments: &[&str]) -> Rigid<Marker, Tool> {
    let out = world.path("tool.json");
    let words = ["import", path, "--out", out.to_str().unwrap(), "--overwrite"];
    let made = world.output("calib", &[&words[..], arguments].concat());
    assert!(made.status.success(), "{path}: {}", stderr(&made));
    let file = ToolFile::parse(&fs::read_to_string(&out).unwrap()).unwrap();
    file.marker_from_tool.transform()
}

fn off(found: Point<Marker>, expected: &Value) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| expected[i].as_f64().unwrap());
    found.distance(Point::new(x, y, z))
}

#[test]
fn transforms_that_simpleitk_writes_put_points_where_it_does() {
    let Some(python) = python() else { return };
    let world = World::new();
    let folder = world.path("transforms");
    fs::create_dir(&folder).unwrap();
    let written = peer(
        &python,
        &["transforms", folder.to_str().unwrap(), &json!(ON_SHAFT).to_string()],
    );
    let written = written.as_object().unwrap();
    assert_eq!(written.len(), 21);
    for (path, expected) in written {
        let tool = imported(&world, path, &[&["--holds", "marker-from-tool"], &SAID[..]].concat());
        for ([x, y, z], expected) in ON_SHAFT.iter().zip(expected.as_array().unwrap()) {
            let off = off(tool * Point::new(*x, *y, *z), expected);
            assert!(off < 1e-9, "{path}: {off}");
        }
        // Read as its inverse it is another tool.
        let other = imported(&world, path, &[&["--holds", "tool-from-marker"], &SAID[..]].concat());
        let apart = off(other * Point::new(0.0, 0.0, 0.0), &expected[0]);
        assert!(apart > 1.0, "{path}: {apart}");
    }
}

#[test]
fn simpleitk_puts_points_where_an_exported_transform_does() {
    let Some(python) = python() else { return };
    let world = World::new();
    let folder = world.path("transforms");
    fs::create_dir(&folder).unwrap();
    peer(&python, &["transforms", folder.to_str().unwrap(), "[]"]);
    let source = folder.join("composite.tfm");
    let tool = imported(
        &world,
        source.to_str().unwrap(),
        &[&["--holds", "marker-from-tool"], &SAID[..]].concat(),
    );
    let json = world.path("tool.json");
    let points = [[0.0, 0.0, 0.0], [30.0, -20.0, -150.0], [1e3, 2e3, -3e3]];
    for (holds, name) in [("marker-from-tool", "out.tfm"), ("tool-from-marker", "out.txt")] {
        let out = world.path(name);
        let words = [
            "export",
            json.to_str().unwrap(),
            "--holds",
            holds,
            "--out",
            out.to_str().unwrap(),
        ];
        let made = world.output("calib", &words);
        assert!(made.status.success(), "{}", stderr(&made));
        let mapped = peer(&python, &["map", out.to_str().unwrap(), &json!(points).to_string()]);
        for ([x, y, z], mapped) in points.iter().zip(mapped.as_array().unwrap()) {
            let found = match holds {
                "marker-from-tool" => (tool * Point::new(*x, *y, *z)).mm(),
                _ => (tool.inverse() * Point::new(*x, *y, *z)).mm(),
            };
            let apart = [0, 1, 2].map(|i| (found[i] - mapped[i].as_f64().unwrap()).abs());
            assert!(apart.iter().all(|apart| *apart < 1e-9), "{holds}: {apart:?}");
        }
    }
}

/// A device set of PLUS, read as XML by Python's own parser: it puts points of the tool where the calibration has them.
#[test]
fn another_parser_reads_the_transform_of_an_exported_device_set() {
    let Some(python) = python() else { return };
    let world = World::new();
    let folder = world.path("transforms");
    fs::create_dir(&folder).unwrap();
    peer(&python, &["transforms", folder.to_str().unwrap(), "[]"]);
    let source = folder.join("composite.tfm");
    let words = [&["--holds", "marker-from-tool"], &SAID[..]].concat();
    let tool = imported(&world, source.to_str().unwrap(), &words);
    let (json, out) = (world.path("tool.json"), world.path("stylus.xml"));
    let (json, out) = (json.to_str().unwrap(), out.to_str().unwrap());
    let made = world.output(
        "calib",
        &["export", json, "--from", "StylusTip", "--to", "Stylus", "--out", out],
    );
    assert!(made.status.success(), "{}", stderr(&made));
    let points = [[0.0, 0.0, 0.0], [30.0, -20.0, -150.0], [1e3, 2e3, -3e3]];
    let mapped = peer(
        &python,
        &["plus", out, "StylusTip", "Stylus", &json!(points).to_string()],
    );
    for ([x, y, z], mapped) in points.iter().zip(mapped.as_array().unwrap()) {
        assert!(off(tool * Point::new(*x, *y, *z), mapped) < 1e-9, "{mapped}");
    }
}

#[test]
fn the_published_stylus_of_plus_is_read() {
    let Some(set) = shared("data/plus-ultrasound/PlusDeviceSet_fCal_Sim_SpatialCalibration_2.0.xml") else {
        return;
    };
    let world = World::new();
    let frames = [
        "--from",
        "StylusTip",
        "--to",
        "Stylus",
        "--shaft",
        "x",
        "--tip-error-mm",
        "0.5",
        "--axis-error-deg",
        "1",
    ];
    let tool = imported(&world, set.to_str().unwrap(), &frames);
    assert!(off(tool * Point::new(0.0, 0.0, 0.0), &json!([194.844, -13.2023, -6.13342])) < 1e-9);
    // PLUS has the shaft along its first axis: the first column of its matrix, to the six digits it is written with.
    let shaft = (tool * Direction::<Tool>::Z).components();
    let apart = [0, 1, 2].map(|i| (shaft[i] - [0.997221, -0.06757, -0.0313912][i]).abs());
    assert!(apart.iter().all(|apart| *apart < 1e-5), "{apart:?}");
    // The pixels of an ultrasound image are no tool.
    let out = world.path("other.json");
    let words = ["import", set.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let pixels = ["--from", "TransducerOriginPixel", "--to", "TransducerOrigin"];
    let refused = world.output("calib", &[&words[..], &pixels, &SAID[..]].concat());
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("is not rigid"), "{}", stderr(&refused));
}
