//! `calib pivot`, `calib spin` and `calib tool`: from recordings to the tool's frame, a published recording, and every kind
//! of bad input refused with a name and exit code 1.

#![allow(
    clippy::print_stdout,
    reason = "what was found beside the published answer, and why a test was skipped"
)]

use std::fs;
use std::path::Path;

use crate::support::*;
use calib_cli::{CalibrationFile, Kind};
use geometry::rotation::{Rotation, RotationVector};

const TIP: [f64; 3] = [4.0, -3.0, 160.0];
const HEADER: &str = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm,status\n";

fn turn(v: [f64; 3]) -> Rotation {
    Rotation::from_vector(RotationVector::new(v).unwrap())
}

/// A frame in which the tip is at `tip` in the tracker.
fn row(t: f64, rotation: Rotation, tip: [f64; 3]) -> String {
    let lever = rotation.apply(TIP);
    let [w, x, y, z] = rotation.quaternion();
    let [a, b, c] = [0, 1, 2].map(|i| tip[i] - lever[i]);
    format!("{t},{w},{x},{y},{z},{a},{b},{c},OK\n")
}

fn recording(world: &World, name: &str, turns: impl Fn(f64) -> [f64; 3]) -> String {
    let rows = (0..60).map(|i| row(0.02 * f64::from(i), turn(turns(f64::from(i))), [100.0, -50.0, 1900.0]));
    let path = world.file(name, &(HEADER.to_owned() + &rows.collect::<String>()));
    path.to_str().unwrap().to_owned()
}

/// The words on stderr of a command that must fail without a result on stdout.
fn refusal(world: &World, arguments: &[&str]) -> String {
    let output = world.output("calib", arguments);
    assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
    assert_eq!(stdout(&output), "");
    stderr(&output)
}

#[test]
fn from_recordings_to_the_tools_frame() {
    let world = World::new();
    let pivot = recording(&world, "pivot.csv", |a| {
        [0.5 * (0.7 * a).sin(), 0.5 * (1.1 * a).cos(), 0.1]
    });
    let spin = recording(&world, "spin.csv", |a| [0.0, 0.0, 0.05 * a]);
    let at = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let (tip, axis, tool) = (at("tip.json"), at("axis.json"), at("tool.json"));
    for arguments in [
        vec!["pivot", "--poses", &pivot, "--max-rms-mm", "0.1", "--out", &tip],
        vec!["spin", "--poses", &spin, "--tip", &tip, "--out", &axis],
        vec!["tool", "--pivot", &tip, "--spin", &axis, "--out", &tool],
    ] {
        let output = world.output("calib", &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(stdout(&output).contains("written to"), "{}", stdout(&output));
    }
    let frame = CalibrationFile::read(Path::new(&tool), Kind::Tool)
        .unwrap()
        .tool_frame
        .unwrap();
    // Coordinates of 1900 mm are written to the last digit, 2e-13 mm.
    assert!(
        (0..3).all(|i| (frame.translation_mm[i] - TIP[i]).abs() < 1e-9),
        "{frame:?}"
    );
    // Only the file that was written is accepted.
    let text = fs::read_to_string(&tip).unwrap();
    fs::write(&tip, text.replacen("160.0", "161.0", 1).replacen("159.9", "160.9", 1)).unwrap();
    let error = refusal(&world, &["tool", "--pivot", &tip, "--spin", &axis]);
    assert!(error.contains("it was changed after it was written"), "{error}");
}

#[test]
fn the_published_tip_of_a_real_recording() {
    let Some(path) = shared("data/pivot-sks") else { return };
    let world = World::new();
    let out = world.path("tip.json");
    let common = [
        "pivot",
        "--poses",
        path.to_str().unwrap(),
        "--overwrite",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = world.output("calib", &[&common[..], &["--method", "algebraic"]].concat());
    let text = stdout(&output);
    // The publication's three decimals: tip, pivot, and the root mean square of the 171 components.
    for number in [
        "-14.473",
        "394.634",
        "-7.407",
        "-804.742",
        "-85.474",
        "-2112.131",
        "1.761 mm per component",
    ] {
        assert!(text.contains(number), "{number}: {text}");
    }
    println!("{text}");
    let output = world.output("calib", &common);
    assert!(output.status.success(), "{}", stderr(&output));
    let found = CalibrationFile::read(&out, Kind::Pivot).unwrap().pivot.unwrap();
    assert!(found.inliers < 57 && found.rms_mm < found.rms_all_mm, "{found:?}");
}

#[test]
fn bad_recordings_are_refused_by_name() {
    let world = World::new();
    let one = recording(&world, "one.csv", |a| [0.0, 0.5 * a.sin(), 0.0]);
    let still = recording(&world, "still.csv", |_| [0.1, 0.2, 0.3]);
    let text = |name: &str, text: &str| world.file(name, text).to_str().unwrap().to_owned();
    let frame = "Seq_Frame0000_AToBTransform = 1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1\n";
    let end = "ElementDataFile = LOCAL\n";
    for (path, words) in [
        (one, "one axis only, the marker's y axis"),
        (still, "at least 3 are needed"),
        (
            text("nan.csv", &format!("{HEADER}0,1,0,0,0,NaN,2,3,OK\n")),
            "line 2, column 11 (tx_mm)",
        ),
        (
            text("far.csv", &format!("{HEADER}0,2,0,0,0,1,2,3,OK\n")),
            "the rotation is off by",
        ),
        (
            text("lost.csv", &format!("{HEADER}0,,,,,,,,INVALID\n")),
            "none of its 1 frames holds a valid pose",
        ),
        (text("empty.csv", ""), "the file is empty"),
        (text("short.mha", frame), "ElementDataFile"),
        (
            text("two.mha", &format!("{frame}{}{end}", frame.replace("AToB", "CToB"))),
            "choose one with --transform",
        ),
        (world.path("nothing").to_str().unwrap().to_owned(), "nothing"),
    ] {
        let error = refusal(&world, &["pivot", "--poses", &path]);
        assert!(error.contains(words), "{path}: {error}");
    }
    let backwards = format!("{HEADER}2,1,0,0,0,1,2,3,OK\n1,0,1,0,0,1,2,4,OK\n");
    let path = text("backwards.csv", &backwards);
    let error = refusal(&world, &["pivot", "--poses", &path, "--strict"]);
    assert!(error.contains("1 time stamps go backwards"), "{error}");
}

#[test]
fn a_gate_that_is_not_kept_is_exit_code_1_and_no_file() {
    let world = World::new();
    let pivot = recording(&world, "pivot.csv", |a| {
        [0.1 * (0.7 * a).sin(), 0.1 * (1.1 * a).cos(), 0.1]
    });
    let out = world.path("tip.json");
    let arguments = [
        "pivot",
        "--poses",
        &pivot,
        "--min-cone-deg",
        "20",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = world.output("calib", &arguments);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("rotate more about"), "{}", stdout(&output));
    assert!(
        stderr(&output).contains("--min-cone-deg 20: found 7."),
        "{}",
        stderr(&output)
    );
    assert!(!out.exists());
}
