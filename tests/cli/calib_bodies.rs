//! `calib marker`, `calib base`, `calib seat`, `calib rom` and `calib f2554` as programs: results, every kind of bad input
//! refused with a name and exit code 1.

#![allow(clippy::print_stdout, reason = "what SciPy finds, and why a test was skipped")]
#![allow(clippy::disallowed_methods, reason = "tests start Python")]

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::*;
use calib_cli::{CalibrationFile, Kind};
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Base, Marker, Point, Rigid, Tool, Tracker, Vector};

const EMITTERS: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [60.0, 0.0, 0.0],
    [0.0, 45.0, 0.0],
    [-30.0, -20.0, 12.0],
    [20.0, 30.0, -15.0],
    [45.0, -35.0, 5.0],
];

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// Thirty frames of all emitters; `change` may exchange, mirror or drop.
fn frames(change: impl Fn(usize, usize, [f64; 3]) -> Option<(usize, [f64; 3])>) -> String {
    let mut text = "frame,emitter,x,y,z\n".to_owned();
    for frame in 0..30 {
        let a = frame as f64;
        let rotation = turn([0.8 * (0.4 * a).sin(), 0.3 * a, 0.7 * (0.2 * a).cos()]);
        for (emitter, b) in EMITTERS.iter().enumerate() {
            let [x, y, z] = rotation.apply(*b);
            if let Some((e, [x, y, z])) = change(frame, emitter, [x, y, z - 1900.0]) {
                let _ = writeln!(text, "{frame},{e},{x},{y},{z}");
            }
        }
    }
    text
}

const DRAWING: &str = "\
[plane]
at_mm = [0, 0, 0]
normal = [0, 0, 1]
[[groove]]
start_mm = [15, 0, -4]
end_mm = [60, 0, -4]
half_angle_deg = 45
[[groove]]
start_mm = [-3, 15, -4]
end_mm = [-10, 60, -4]
half_angle_deg = 45
[[groove]]
start_mm = [-15, -15, -4]
end_mm = [-45, -45, -4]
half_angle_deg = 45
[seat]
quaternion = [1, 0, 0, 0]
translation_mm = [0, 0, 80]
";

fn place() -> Rigid<Tracker, Base> {
    Rigid::from_parts(turn([0.4, -0.9, 1.3]), Vector::new(120.0, -60.0, -1850.0))
}

/// Exact touches, the groups under these names.
fn touches(names: [&str; 4]) -> String {
    let mut text = "on,x,y,z\n".to_owned();
    for i in 0..12 {
        let s = (f64::from(i) + 0.5) / 12.0;
        let (c, t) = ((2.4 * f64::from(i)).cos(), (2.4 * f64::from(i)).sin());
        let at = [
            [50.0 * s.sqrt() * c, 50.0 * s.sqrt() * t, 0.0],
            [15.0 + 45.0 * s, 0.0, -4.0],
            [-3.0 - 7.0 * s, 15.0 + 45.0 * s, -4.0],
            [-15.0 - 30.0 * s, -15.0 - 30.0 * s, -4.0],
        ];
        for (name, [x, y, z]) in names.iter().zip(at) {
            let [x, y, z] = (place() * Point::<Base>::new(x, y, z)).mm();
            let _ = writeln!(text, "{name},{x},{y},{z}");
        }
    }
    text
}

const SAID: [&str; 4] = ["plane", "groove 0", "groove 1", "groove 2"];

fn path(world: &World, name: &str, text: &str) -> String {
    world.file(name, text).to_str().unwrap().to_owned()
}

/// The words on stderr of a command that must fail.
fn refusal(world: &World, arguments: &[&str]) -> String {
    let output = world.output("calib", arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", stdout(&output));
    stderr(&output)
}

fn done(world: &World, arguments: &[&str]) -> String {
    let output = world.output("calib", arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

#[test]
fn from_frames_and_touches_to_the_tools_frame() {
    let world = World::new();
    let at = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let recorded = path(&world, "frames.csv", &frames(|_, e, p| Some((e, p))));
    let text = done(
        &world,
        &["marker", &recorded, "--marker", "plate", "--out", &at("plate.json")],
    );
    assert!(text.contains("[tracker.room.marker]"), "{text}");
    let marker = CalibrationFile::read(Path::new(&at("plate.json")), Kind::Marker).unwrap();
    assert_eq!(marker.marker_body.unwrap().emitters.len(), 6);
    let (drawing, touched) = (
        path(&world, "base.toml", DRAWING),
        path(&world, "touches.csv", &touches(SAID)),
    );
    done(
        &world,
        &["base", &touched, "--drawing", &drawing, "--out", &at("base.json")],
    );
    let seat: Rigid<Base, Tool> = Rigid::from_parts(Rotation::IDENTITY, Vector::new(0.0, 0.0, 80.0));
    let by: Rigid<Marker, Tool> = Rigid::from_parts(turn([0.2, 0.1, -0.5]), Vector::new(10.0, -20.0, 140.0));
    let pose = place() * seat * by.inverse();
    let ([w, x, y, z], [a, b, c]) = (pose.quaternion(), pose.translation_mm());
    let poses = format!("t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n0,{w},{x},{y},{z},{a},{b},{c}\n");
    let seated = path(&world, "seated.csv", &poses);
    done(
        &world,
        &[
            "seat",
            "--base",
            &at("base.json"),
            "--poses",
            &seated,
            "--out",
            &at("tool.json"),
        ],
    );
    let tool = CalibrationFile::read(Path::new(&at("tool.json")), Kind::Tool).unwrap();
    let found = tool.tool_frame.unwrap().translation_mm;
    let planted = by.translation_mm();
    // Coordinates of 1900 mm are written to the last digit, and a turn of 1e-13 is carried over 200 mm.
    assert!((0..3).all(|i| (found[i] - planted[i]).abs() < 1e-8), "{found:?}");
}

#[test]
fn bad_frames_of_a_marker_are_exit_code_1() {
    let world = World::new();
    let good = path(&world, "good.csv", &frames(|_, e, p| Some((e, p))));
    let plate = world.path("plate.json").to_str().unwrap().to_owned();
    done(&world, &["marker", &good, "--out", &plate]);
    let swap = |e: usize| [1, 0, 2, 3, 4, 5][e];
    for (name, text, drawn, words) in [
        (
            "two.csv",
            frames(|_, e, p| (e < 2).then_some((e, p))),
            false,
            "three emitters off a line",
        ),
        (
            "swapped.csv",
            frames(|frame, e, p| Some((if frame == 4 { swap(e) } else { e }, p))),
            false,
            "emitter 0 is at the place of emitter 1 in 1 views (4)",
        ),
        (
            "wrong.csv",
            frames(|_, e, p| Some((swap(e), p))),
            true,
            "emitter 0 is at the place of emitter 1",
        ),
        (
            "mirrored.csv",
            frames(|_, e, [x, y, z]| Some((e, [-x, y, z]))),
            true,
            "the marker is the mirror image of its drawing",
        ),
        (
            "nan.csv",
            "frame,emitter,x,y,z\n0,0,nan,1,2\n".to_owned(),
            false,
            "line 2, column 5 (x): found \"nan\"",
        ),
    ] {
        let bad = path(&world, name, &text);
        let mut arguments = vec!["marker", bad.as_str()];
        if drawn {
            arguments.extend(["--drawing", plate.as_str()]);
        }
        let error = refusal(&world, &arguments);
        assert!(error.contains(words), "{name}: {error}");
    }
    let error = refusal(&world, &["marker", &good, "--min-views", "31"]);
    assert!(error.contains("--min-views 31: found 30"), "{error}");
}

#[test]
fn bad_touches_are_exit_code_1() {
    let world = World::new();
    let drawing = path(&world, "base.toml", DRAWING);
    let wrong = path(
        &world,
        "wrong.csv",
        &touches(["plane", "groove 2", "groove 1", "groove 0"]),
    );
    let error = refusal(&world, &["base", &wrong, "--drawing", &drawing]);
    let words = "touched in another order than said: said (plane, groove 2, groove 1, groove 0), but the touches fit (plane, \
                 groove 0, groove 1, groove 2)";
    assert!(error.contains(words), "{error}");
    let parallel: String = DRAWING
        .replace("[-3, 15, -4]", "[15, 30, -4]")
        .replace("[-10, 60, -4]", "[60, 30, -4]")
        .replace("[-15, -15, -4]", "[15, -30, -4]")
        .replace("[-45, -45, -4]", "[60, -30, -4]");
    let (good, parallel) = (
        path(&world, "good.csv", &touches(SAID)),
        path(&world, "parallel.toml", &parallel),
    );
    let error = refusal(&world, &["base", &good, "--drawing", &parallel]);
    assert!(error.contains("a slide along (1.00, 0.00, 0.00)"), "{error}");
}

#[test]
fn tool_definitions_and_damaged_ones() {
    let world = World::new();
    let error = refusal(&world, &["rom", "info", &path(&world, "text.rom", "no tool")]);
    assert!(
        error.contains("found 7 bytes, an NDI tool definition has 752"),
        "{error}"
    );
    let Some(folder) = shared("data/tracker-plus/NdiToolDefinitions") else {
        return;
    };
    let probe = folder.join("8700340.rom");
    let text = done(&world, &["marker", "--rom", probe.to_str().unwrap(), "--toml"]);
    assert!(
        text.contains("{ at_mm = [0.0000, -25.0000, 135.0000], normal = [1.000000, 0.000000, 0.000000] }"),
        "{text}"
    );
    let rod = folder.join("8700248.rom");
    let error = refusal(&world, &["marker", "--rom", rod.to_str().unwrap()]);
    assert!(error.contains("8700248") && error.contains("line"), "{error}");
    let mut bytes = fs::read(&probe).unwrap();
    bytes[100] ^= 1;
    let damaged = world.path("damaged.rom");
    fs::write(&damaged, bytes).unwrap();
    let error = refusal(&world, &["rom", "info", damaged.to_str().unwrap()]);
    assert!(error.contains("byte 4 (checksum)"), "{error}");
}

#[test]
fn a_pointers_report_and_its_gate() {
    let world = World::new();
    let png = world.path("turns.png").to_str().unwrap().to_owned();
    let text = done(&world, &["f2554", "--simulate", "3", "--png", &png]);
    assert!(text.contains("distance") && Path::new(&png).exists(), "{text}");
    let error = refusal(&world, &["f2554", "--simulate", "3", "--max-single-mm", "0.001"]);
    assert!(error.contains("--max-single-mm 0.001: found"), "{error}");
    let error = refusal(&world, &["f2554", "--simulate", "3", "--sigma-mm", "5000"]);
    assert!(error.contains("across_mm is 5000"), "{error}");
}

/// Runs a script of `tests/python` on files; what it prints.
fn checked(script: &str, files: &[&str]) -> Option<serde_json::Value> {
    let python = python()?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python").join(script);
    let output = Command::new(python).arg(script).args(files).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let seen: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{seen}");
    Some(seen)
}

/// Numbers between -1 and 1 without a pattern, always the same.
fn noise(i: usize) -> f64 {
    (12.9898 * i as f64).sin() * 43758.5453 % 1.0
}

#[test]
fn scipy_finds_the_same_base_and_marker() {
    let world = World::new();
    let at = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let shaken: String = touches(SAID)
        .lines()
        .enumerate()
        .map(|(i, line)| match line.rsplit_once(',') {
            Some((rest, z)) if i > 0 => format!("{rest},{}\n", z.parse::<f64>().unwrap() + 0.3 * noise(i)),
            _ => format!("{line}\n"),
        })
        .collect();
    let (drawing, touched) = (path(&world, "base.toml", DRAWING), path(&world, "touches.csv", &shaken));
    done(
        &world,
        &["base", &touched, "--drawing", &drawing, "--out", &at("base.json")],
    );
    let recorded = path(
        &world,
        "frames.csv",
        &frames(|frame, e, [x, y, z]| {
            // SciPy differentiates by differences: more frames take minutes.
            (frame < 12).then(|| (e, [x + 0.2 * noise(31 * frame + e), y, z]))
        }),
    );
    done(
        &world,
        &["marker", &recorded, "--sigma-mm", "0.2", "--out", &at("plate.json")],
    );
    let Some(base) = checked("check_base.py", &[&touched, &drawing, &at("base.json")]) else {
        return;
    };
    let number = |seen: &serde_json::Value, key: &str| seen[key].as_f64().unwrap();
    // SciPy stops where a step changes the sum of squares by 1e-15 of it, which is 3e-8 of a deviation of 0.1 mm.
    assert!(number(&base, "apart_mm") < 1e-6, "{base}");
    // Its derivatives are differences of residuals near 1850 mm: eight digits of 1e-3 of a turn.
    assert!(number(&base, "covariance") < 1e-4, "{base}");
    let marker = checked("check_marker.py", &[&recorded, &at("plate.json")]).unwrap();
    assert!(
        number(&marker, "distances_mm") < 1e-5 && number(&marker, "rms_mm") < 1e-8,
        "{marker}"
    );
}
