//! The whole way by ultrasound with the scenes that are shipped: the probe in a tank, its images exported, calibrated by wires, and held
//! against other wires (docs/ultrasound.md).

#![allow(clippy::print_stdout, reason = "the figures of the calibration")]

mod gestures;

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{World, python, stderr, stdout};
use crate::volume_tools::script;
use calib_cli::ProbeFile;
use geometry::{Image, Marker, Point, Rigid, Vector};
use phantom::Phantom;
use recorder::read::seek::Session;
use scene::operating_room::Room;
use scene::{Scene, TrackerSource};
use tracker_proc::probe::SimulatedProbe;

/// What the phantom's place is off by in the shipped scenes, as it is told.
const PHANTOM: [&str; 4] = ["--phantom-error-mm", "0.2", "--phantom-error-deg", "0.2"];
/// The same told as exact.
const EXACT: [&str; 4] = ["--phantom-error-mm", "0", "--phantom-error-deg", "0"];
/// What else is told of the images: dots in water without speckle, poses as far apart as a busy processor may leave them.
const TOLD: [&str; 6] = [
    "--water-celsius",
    "20",
    "--noise-mm",
    "0.1,0.1,0.2",
    "--window-ms",
    "250",
];

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("config/ultrasound")
}

/// A world with the shipped scenes in it.
fn world() -> World {
    let world = World::new();
    for entry in fs::read_dir(shipped()).unwrap().map(Result::unwrap) {
        fs::copy(entry.path(), world.path(entry.file_name().to_str().unwrap())).unwrap();
    }
    world
}

fn path(world: &World, name: &str) -> String {
    world.path(name).to_str().unwrap().to_owned()
}

/// What a program says, which must succeed.
fn said(world: &World, program: &str, words: &[&str]) -> String {
    let output = world.output(program, words);
    let text = stdout(&output);
    println!("{text}");
    assert!(
        output.status.success(),
        "{program} {words:?}: {}{text}",
        stderr(&output)
    );
    text
}

/// The images of a scene's run of so many seconds, exported; and what `calib probe` is to be told of them.
fn exported(world: &World, scene: &str, seconds: &str) -> (String, Vec<String>) {
    let out = path(world, &format!("{scene}.out"));
    let toml = path(world, &format!("{scene}.toml"));
    let sequence = path(world, &format!("{scene}.igs.mha"));
    said(
        world,
        "pilot",
        &["run", &toml, "--for", seconds, "--out", &out, "--run", scene],
    );
    let session = format!("{out}/session.mcap");
    let text = said(
        world,
        "recorder",
        &["export", "mha", &session, "--images", "--out", &sequence],
    );
    let options = text.lines().find_map(|line| line.strip_prefix("for calib probe: "));
    let options = options.unwrap_or_else(|| panic!("{text}"));
    (sequence, options.split(' ').map(str::to_owned).collect())
}

/// Calibrates by a tank's wires, of which so much is told.
fn calibrated(world: &World, (sequence, options): &(String, Vec<String>), phantom: [&str; 4], out: &str) -> ProbeFile {
    let config = path(world, "wires.xml");
    let own = [
        "probe",
        "--sequence",
        sequence,
        "--config",
        &config,
        "--out",
        out,
        "--lag-ms",
        "100",
    ];
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    said(world, "calib", &[&own[..], &phantom, &TOLD, &options].concat());
    ProbeFile::read(Path::new(out)).unwrap()
}

fn room(world: &World, scene: &str) -> (Box<Room>, u64) {
    let scene = Scene::load(&world.path(&format!("{scene}.toml"))).unwrap();
    match scene.tracker.source {
        TrackerSource::OperatingRoom(room) => (room, scene.seed),
        other => panic!("{other:?}"),
    }
}

/// By how much a calibration places each corner of the image elsewhere than the simulator, and what it tells of that, mm.
fn off(file: &ProbeFile, room: &Room, seed: u64) -> Vec<[f64; 2]> {
    let spec = room.probe.unwrap();
    let probe = SimulatedProbe::new(spec, seed).unwrap();
    let truth: Rigid<Marker, Image> = room.marker_from_tool * probe.image_on_tool().unwrap();
    let found = file.probe_from_image().unwrap().transform();
    let (columns, rows) = (probe.shape().columns() as f64, probe.shape().rows() as f64);
    let corner = |[u, v]: [f64; 2]| {
        let place = |[s, t]: [f64; 2]| Point::<Image>::new(u * s, v * t, 0.0);
        let there = (truth * place([spec.pixel_mm; 2])).mm();
        let here = (found * place(file.pixel_mm)).mm();
        let off = (0..3).map(|i| (here[i] - there[i]).powi(2)).sum::<f64>().sqrt();
        [off, told(file, place(file.pixel_mm))]
    };
    [[0.0, 0.0], [columns, 0.0], [0.0, rows], [columns, rows]]
        .map(corner)
        .to_vec()
}

/// The root mean square error of a place of the image in the marker that a calibration tells: J C J' of turn, shift and sizes.
fn told(file: &ProbeFile, place: Point<Image>) -> f64 {
    let found = file.probe_from_image().unwrap().transform();
    let covariance = file.matrix().unwrap();
    let at = (found * place).mm();
    let column = |i: usize| -> [f64; 3] {
        let [x, y, z] = at;
        match i {
            // The motion exp(w) p + v comes after: its derivatives are w x p and v.
            0 => [0.0, -z, y],
            1 => [z, 0.0, -x],
            2 => [-y, x, 0.0],
            3..=5 => std::array::from_fn(|k| f64::from(u8::from(k == i - 3))),
            _ => {
                let [x, y, _] = place.mm();
                let along = if i == 6 { [x, 0.0] } else { [0.0, y] };
                (found * Vector::<Image>::new(along[0], along[1], 0.0)).mm()
            }
        }
    };
    let columns: Vec<[f64; 3]> = (0..8).map(column).collect();
    let trace: f64 = (0..3)
        .flat_map(|k| (0..64).map(move |n| (k, n / 8, n % 8)))
        .map(|(k, i, j)| columns[i][k] * covariance[(i, j)] * columns[j][k])
        .sum();
    trace.sqrt()
}

/// Each scene loads and says what it is for; all but the patient's, whose registration is made on the way, can be started.
#[test]
fn the_shipped_scenes_can_be_started() {
    let world = world();
    let scenes = ["bottom", "tank", "check", "patient", "touch"];
    for scene in scenes {
        let file = world.path(&format!("{scene}.toml"));
        Scene::load(&file).unwrap_or_else(|error| panic!("{error}"));
        assert!(fs::read_to_string(&file).unwrap().starts_with("# "), "{scene}");
        if Scene::load(&file).unwrap().tracker.links.registration.is_none() {
            said(&world, "pilot", &["check", "--quick", file.to_str().unwrap()]);
        }
    }
    let tomls = fs::read_dir(shipped()).unwrap().map(|entry| entry.unwrap().path());
    let tomls = tomls.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    assert_eq!(tomls.count(), scenes.len());
    // A phantom that is none, and one that is not there, are told before the run. Stated of the first was "good", and the tracker died.
    let refused = |words: &str| {
        let output = world.output("pilot", &["check", "--quick", &path(&world, "tank.toml")]);
        let text = stdout(&output) + &stderr(&output);
        assert!(!output.status.success() && text.contains(words), "{text}");
        assert!(text.contains("1 wrong"), "{text}");
    };
    fs::write(world.path("wires.xml"), "t_s,qw,qx\n").unwrap();
    refused("tracker.room.probe.tank: ");
    fs::remove_file(world.path("wires.xml")).unwrap();
    refused("tracker.room.probe.tank.file");
}

/// 3D Slicer's library reads every grey value that was recorded, each with its stamp and two poses.
fn read_by_others(world: &World, sequence: &str, scene: &str) {
    let Some(python) = python() else { return };
    let pixels = path(world, "pixels.raw");
    let seen = script(&python, "check_sequence.py", &[sequence, &pixels]);
    let session = Session::open(&world.path(&format!("{scene}.out/session.mcap"))).unwrap();
    let images: Vec<_> = session.us_images_from(0).unwrap().map(Result::unwrap).collect();
    let grey: Vec<u8> = images.iter().flat_map(|image| image.grey.clone()).collect();
    assert!(fs::read(&pixels).unwrap() == grey);
    let stamps = seen["stamps"].as_array().unwrap();
    assert_eq!(stamps.len(), images.len());
    for (stamp, image) in stamps.iter().zip(&images) {
        let t_s = image.header.t_capture_ns as f64 / 1e9;
        // Half a nanosecond, and what a double keeps of it.
        assert!((stamp.as_f64().unwrap() - t_s).abs() < 1e-9, "{stamp} {t_s}");
    }
    let all = images.len() as u64;
    assert_eq!(
        (&seen["transforms"]["ProbeToTracker"], &seen["not_ok"]),
        (&all.into(), &0.into()),
        "{seen}"
    );
    assert!(seen["orthogonal"].as_f64().unwrap() < 1e-13, "{seen}");
}

/// The files of the shipped gestures are those of the generator; where this fails after a change, write what it makes.
#[test]
fn the_shipped_gestures_are_those_that_are_made() {
    let patient = Phantom::new(1);
    let node = patient.targets()[3].centre;
    for (name, made) in [
        ("tank.csv", gestures::tank()),
        ("bottom.csv", gestures::bottom()),
        ("touch.csv", gestures::touch(node)),
        ("patient.csv", gestures::patient(&patient)),
    ] {
        let path = shipped().join(name);
        if std::env::var_os("TROCAR_WRITE_GESTURES").is_some() {
            fs::write(&path, &made).unwrap();
        }
        assert!(fs::read_to_string(&path).unwrap() == made, "{name}");
    }
}

/// From the tank to the calibration, with real processes: the image lies where the simulator has it, within what is told of it, at its
/// corners too, and the lag is the planted one, once. A phantom that is told to stand 1 mm aside, and exactly there, gives a calibration
/// that fits as well and is accepted; other wires say that it is wrong.
#[test]
fn a_probe_is_calibrated_in_the_tank_as_well_as_it_is_told() {
    let world = world();
    let tank = exported(&world, "tank", "22s");
    read_by_others(&world, &tank.0, "tank");
    let out = path(&world, "probe.json");
    let file = calibrated(&world, &tank, PHANTOM, &out);
    let (room, seed) = room(&world, "tank");
    for [off_mm, told_mm] in off(&file, &room, seed) {
        println!("corner off by {off_mm:.2} mm, {told_mm:.2} told");
        // Beyond three times its root mean square an error has a chance of less than 1 in 100, in whichever directions it may be.
        assert!(off_mm < 3.0 * told_mm && told_mm < 1.0, "{off_mm} mm, {told_mm} told");
    }
    let (lag, planted_s) = (file.lag.unwrap(), room.probe.unwrap().lag_s);
    println!("lag {:.1} +- {:.1} ms", lag.lag_s * 1e3, lag.sigma_s * 1e3);
    assert!((lag.lag_s + planted_s).abs() < 3.0 * lag.sigma_s && lag.sigma_s < 0.01);
    // What the images are of is what a sweep compares.
    let images = file.images.clone().unwrap();
    assert_eq!(
        (images.tool.as_deref(), images.orientation.as_deref()),
        (Some("probe"), Some("MF"))
    );

    // Other wires, measured for themselves: within what all promises together; and not by a phantom that was 1 mm aside.
    let (other, options) = exported(&world, "check", "8s");
    let moved = fs::read_to_string(world.path("wires.xml")).unwrap();
    let moved = moved.replace("1 0 0 -100", "1 0 0 -99");
    fs::write(world.path("wires.xml"), moved).unwrap();
    let aside = path(&world, "aside.json");
    calibrated(&world, &tank, EXACT, &aside);
    for (calibration, is_kept) in [(&out, true), (&aside, false)] {
        let config = path(&world, "check.xml");
        let words = [
            "probe",
            "--check",
            calibration,
            "--sequence",
            &other,
            "--config",
            &config,
        ];
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let output = world.output("calib", &[&words[..], &PHANTOM, &TOLD, &options].concat());
        println!("{}{}", stdout(&output), stderr(&output));
        assert_eq!(output.status.success(), is_kept, "{}", stderr(&output));
    }
}
