//! Calibrating while a run goes on: the pilot listens to the emitters, and the tracker takes the file within a second.

#![allow(clippy::print_stdout, reason = "the figures of the calibration")]

use std::path::Path;
use std::process::Output;

use crate::support::links::{MARKER_FROM_TOOL_MM, volume_hash};
use crate::support::{Pilot, SMALL, World, stderr, stdout};
use bus::Bus;
use bus::run::RunContext;
use serde_json::Value;

/// Where the tip stands in the patient.
const TIP_CT_MM: [f64; 3] = [12.0, -8.0, 20.0];
/// Where the marker on the patient sits unless a scene says otherwise.
const REFERENCE_MM: [f64; 3] = [150.0, -120.0, -150.0];

/// A gesture about a tip that stays: the tool turns about its x and y axes by up to `angle` radians.
fn pivoting(angle: f64) -> String {
    let mut csv = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    let [x, y, z] = TIP_CT_MM;
    for i in 0..200 {
        let a = f64::from(i);
        let (u, v) = (angle * (0.21 * a).sin(), angle * (0.34 * a).cos());
        let half = u.hypot(v) / 2.0;
        let share = if half > 0.0 { half.sin() / (2.0 * half) } else { 0.5 };
        csv += &format!(
            "{},{},{},{},0,{x},{y},{z}\n",
            0.05 * a,
            half.cos(),
            share * u,
            share * v
        );
    }
    csv
}

/// A room with a marker on a patient that breathes, a tool that pivots, and a calibration that is not there yet.
fn scene(more: &str) -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n")
        + "[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n[tracker.room.marker]\ncone_deg = 180.0\n\
           [tracker.room.handle]\nradius_mm = 0.0\n[tracker.room.reference]\ncone_deg = 180.0\n\
           [tracker.room.patient.breathing]\n[tracker.room.gesture]\nfile = \"pivot.csv\"\nat_end = \"loop\"\n"
        + more
}

/// Starts a scene and waits until its tracker says `words`.
fn started<'a>(world: &'a World, scene: &str, words: &str) -> Pilot<'a> {
    // A session of before is not replaced unasked.
    let out = world.path(&format!("out-{}", scene.len()));
    let pilot = world.start(&world.file("s.toml", scene), &out, "default");
    pilot.wait_for(words, |status| {
        let processes = status["processes"].as_array().unwrap();
        let tracker = processes.iter().find(|p| p["name"] == "tracker").unwrap();
        tracker["note"].as_str().unwrap().contains(words)
    });
    pilot
}

fn calibrate(world: &World, line: &[&str]) -> Output {
    world.output("pilot", &[&["calibrate"], line].concat())
}

/// One paragraph with all of `words`, exit code 1, and no file.
fn is_refused(output: &Output, file: &Path, words: &str) {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let is_it = |line: &&str| line.contains("error: ") && words.split(" | ").all(|word| line.contains(word));
    assert_eq!(said.lines().filter(is_it).count(), 1, "{words:?} in\n{said}");
    assert!(!said.contains("panicked") && !file.exists(), "{said}");
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Registers the patient by its marker from four points that are exact.
fn register(world: &World, ct_hash: &str) -> String {
    let mut csv = "from_x,from_y,from_z,to_x,to_y,to_z\n".to_owned();
    for [x, y, z] in [
        [90.0, 0.0, 0.0],
        [-90.0, 10.0, 30.0],
        [0.0, 80.0, -40.0],
        [10.0, -80.0, 60.0],
    ] {
        let [a, b, c] = [x - REFERENCE_MM[0], y - REFERENCE_MM[1], z - REFERENCE_MM[2]];
        csv += &format!("{a},{b},{c},{x},{y},{z}\n");
    }
    let (pairs, out) = (world.file("pairs.csv", &csv), world.path("registration.json"));
    let (pairs, out) = (pairs.to_str().unwrap(), out.to_str().unwrap());
    let line = [
        "register",
        "--pairs",
        pairs,
        "--to",
        "ct",
        "--from",
        "reference",
        "--noise-mm",
        "0.1",
    ];
    let output = world.output("calib", &[&line[..], &["--ct-hash", ct_hash, "--out", out]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    out.to_owned()
}

#[test]
fn a_tool_is_calibrated_while_the_run_goes_on_and_touches_points() {
    let world = World::new();
    world.file("pivot.csv", &pivoting(0.5));
    let gates = "[tracker.calibration.gates]\nmax_rms_mm = 1.0\nmin_cone_deg = 20.0\n";
    let pilot = started(&world, &scene(gates), "tool not calibrated: tool.json is not there");
    let touched = world.path("touched.csv");
    let to = touched.to_str().unwrap();
    is_refused(
        &calibrate(&world, &["touch", "a", "--to", to]),
        &touched,
        "touch of a: the tip is not known: tool.json is not there | --tip",
    );

    let file = world.path("tool.json");
    let line = [
        "pivot",
        "--seconds",
        "6",
        "--axis",
        "scene",
        "--out",
        file.to_str().unwrap(),
    ];
    let output = calibrate(&world, &line);
    assert!(output.status.success(), "{}", stderr(&output));
    println!("{}{}", stderr(&output), stdout(&output));
    let said = stderr(&output);
    assert!(said.contains(" s of 6, ") && said.contains("turned by "), "{said}");
    pilot.wait_live();
    let status = pilot.wait_for("a pose", |status| status["pose"]["state"] == "valid");
    // The scene states no error of its own registration; the calibration's and the emitters' are a few tenths.
    assert!(status["pose"]["tip_95_mm"].as_f64().unwrap() < 2.0, "{status}");
    check_tip(&serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap());

    for name in ["a", "b"] {
        let output = calibrate(&world, &["touch", name, "--to", to]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    check_touches(&std::fs::read_to_string(&touched).unwrap());
    let bus = Bus::join(&RunContext::load(&world.run_dir("default")).unwrap()).unwrap();
    check_a_known_point(&world, &register(&world, &volume_hash(&bus)));
    assert!(pilot.stop().success());
}

fn check_tip(file: &Value) {
    let (pivot, frame) = (&file["pivot"], &file["tool_frame"]);
    let tip: [f64; 3] = numbers(&pivot["tip_mm"]).try_into().unwrap();
    let c = numbers(&pivot["covariance_upper_mm2"]);
    let rms = (c[0] + c[6] + c[11]).sqrt();
    let off = distance(tip, MARKER_FROM_TOOL_MM);
    println!("tip off by {off:.4} mm, by its covariance {rms:.4} mm rms");
    // Beyond four times its root mean square an error has a chance of 1e-6, in whichever directions it may be.
    assert!(off < 4.0 * rms && rms < 0.2, "{off} mm, {rms} mm");
    assert_eq!(
        (file["tool"].as_str(), file["marker"].as_str()),
        (Some("mediastinoscope"), Some("ball"))
    );
    assert_eq!(
        (&file["kind"], &frame["translation_mm"]),
        (&"tool".into(), &pivot["tip_mm"])
    );
    let names: Vec<&str> = file["gates"]
        .as_array()
        .unwrap()
        .iter()
        .map(|g| g["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["max-rms-mm", "min-cone-deg"]);
}

/// Each touch is at the tip's place in the patient's marker, within what its covariance says.
fn check_touches(text: &str) {
    let expected = [0, 1, 2].map(|i| TIP_CT_MM[i] - REFERENCE_MM[i]);
    // Comments are the frame, and the gates that each touch has kept.
    assert!(
        text.contains("# max_rms_mm 1 (tracker.calibration.gates of run default): found "),
        "{text}"
    );
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), ["a", "b"]);
    for row in rows {
        let n: Vec<f64> = row[1..].iter().map(|x| x.parse().unwrap()).collect();
        let (off, rms) = (distance([n[0], n[1], n[2]], expected), (n[3] + n[6] + n[8]).sqrt());
        println!("touch {} off by {off:.4} mm, by its covariance {rms:.4} mm rms", row[0]);
        assert!(off < 4.0 * rms && rms < 0.3, "{off} mm, {rms} mm");
    }
}

fn check_a_known_point(world: &World, registration: &str) {
    let known = |dx: f64| format!("{},{},{}", TIP_CT_MM[0] + dx, TIP_CT_MM[1], TIP_CT_MM[2]);
    let good = calibrate(world, &["check", registration, "--known", &known(0.0)]);
    let text = stdout(&good);
    assert!(
        good.status.success() && text.contains("verdict          pass"),
        "{text}{}",
        stderr(&good)
    );
    let bad = calibrate(world, &["check", registration, "--known", &known(10.0)]);
    is_refused(&bad, Path::new("/no/file"), "do not use this registration");
}

#[test]
fn what_is_no_calibration_is_refused_by_name_and_nothing_is_written() {
    let world = World::new();
    let file = world.path("tool.json");
    let out = file.to_str().unwrap();
    let refused = |line: &[&str], words: &str| {
        let all = [line, &["--seconds", "3", "--out", out]].concat();
        is_refused(&calibrate(&world, &all), &file, words);
    };
    refused(&["pivot", "--run", "nobody"], "run \"nobody\" is not going");
    world.file("pivot.csv", &pivoting(0.08));
    let gates = "[tracker.calibration.gates]\nmin_cone_deg = 20.0\n";
    let pilot = started(&world, &scene(gates), "tool not calibrated");
    // The scene's gate; turns of 0.08 sin have twice a root mean square of 6.5 degrees.
    refused(
        &["pivot", "--axis", "scene"],
        "not accepted: min_cone_deg 20 (tracker.calibration.gates of run default): found ",
    );
    refused(
        &["pivot", "--marker", "star"],
        "--marker \"star\" | is of marker \"ball\"",
    );
    refused(
        &["pivot", "--tool", "pointer"],
        "--tool \"pointer\" | is of tool \"mediastinoscope\"",
    );
    // The shaft was not spun.
    refused(&["spin", "--towards", "0,0,-1"], "spin calibration from the | 30");
    // A run without a pose ends with a problem.
    assert_eq!(pilot.stop().code(), Some(3));
}

#[test]
fn a_run_that_shows_no_marker_gives_no_calibration() {
    let world = World::new();
    let file = world.path("tool.json");
    world.file("pivot.csv", &pivoting(0.5));
    let line = ["pivot", "--seconds", "1", "--out", file.to_str().unwrap()];
    let blind = scene("[tracker.room.localizer]\nnearest_mm = 9000.0\n");
    let pilot = started(&world, &blind, "tool not calibrated");
    is_refused(
        &calibrate(&world, &line),
        &file,
        "frames in 1 s shows the marker | tool: no emitter is seen",
    );
    // A run without a pose ends with a problem.
    assert_eq!(pilot.stop().code(), Some(3));
    let silent = SMALL.replace("[tracker]\n", "[tracker]\nsource = \"emitters\"\n");
    let pilot = started(&world, &silent, "localizer silent");
    is_refused(&calibrate(&world, &line), &file, "no frame of emitters came in 1 s");
    // A run without a pose ends with a problem.
    assert_eq!(pilot.stop().code(), Some(3));
}

#[test]
fn a_tip_that_moves_is_no_touch() {
    let world = World::new();
    // The scripted approach, by the scene's own calibration.
    let text = scene("");
    let text = text.split("[tracker.room.gesture]").next().unwrap();
    let text = text.replace("[tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n", "");
    let pilot = world.start(&world.file("s.toml", &text), &world.path("out"), "default");
    pilot.wait_live();
    let touched = world.path("touched.csv");
    let line = ["touch", "a", "--to", touched.to_str().unwrap()];
    // It rests for 0.2 s of 3.2 only.
    is_refused(
        &calibrate(&world, &line),
        &touched,
        "touch of a: the tip moved by | hold it still",
    );
    assert!(pilot.stop().success());
}
