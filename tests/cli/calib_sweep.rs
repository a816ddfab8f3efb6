//! `calib sweep`: the tip glides over a bone in the simulated operating room, and the patient is registered by its surface.

#![allow(clippy::print_stdout, reason = "the figures of the registration")]

pub(crate) mod probe;

use std::fs;

use crate::support::{Pilot, SMALL, World, stderr, stdout};
use calib::file::{Registered, RegistrationFile};
use chance::Chance;
use geometry::{Ct, Point, Reference};

/// Where the marker on the patient sits unless a scene says otherwise.
const REFERENCE_MM: [f64; 3] = [150.0, -120.0, -150.0];
const TARGET_MM: [f64; 3] = [10.0, -20.0, 15.0];
/// Corners of the bone along a meridian and around.
const ROWS: u32 = 60;
const COLUMNS: u32 = 120;
/// Poses of the gesture, s apart.
const STEP_S: f64 = 0.04;
const POSES: u32 = 500;
/// Deviation of the tip from the bone that it touches.
const CONTACT_MM: f64 = 0.35;

/// The bone's surface in a direction: a ball with bumps that no turn brings back.
fn surface([x, y, z]: [f64; 3]) -> [f64; 3] {
    let radius = 40.0 + 9.0 * x * y + 8.0 * x * z * z - 6.0 * y * y * z + 7.0 * x - 5.0 * y + 4.0 * x * y * z;
    [x, y, z].map(|c| c * radius)
}

/// The direction at a polar angle and an azimuth.
fn towards(polar: f64, azimuth: f64) -> [f64; 3] {
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
}

/// The bone as PLY.
fn bone() -> String {
    let mut points = Vec::new();
    for i in 1..ROWS {
        for j in 0..COLUMNS {
            let polar = std::f64::consts::PI * f64::from(i) / f64::from(ROWS);
            let azimuth = std::f64::consts::TAU * f64::from(j) / f64::from(COLUMNS);
            points.push(surface(towards(polar, azimuth)));
        }
    }
    let north = points.len() as u32;
    points.extend([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].map(surface));
    let mut triangles = Vec::new();
    let at = |i: u32, j: u32| (i - 1) * COLUMNS + j % COLUMNS;
    for j in 0..COLUMNS {
        triangles.push([north, at(1, j), at(1, j + 1)]);
        triangles.push([north + 1, at(ROWS - 1, j + 1), at(ROWS - 1, j)]);
        for i in 1..ROWS - 1 {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mut ply = format!(
        "ply\nformat ascii 1.0\ncomment SPACE=LPS\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    );
    for [x, y, z] in points {
        ply += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in triangles {
        ply += &format!("3 {a} {b} {c}\n");
    }
    ply
}

/// A spiral over the bone, the tool upright; now and then the tip is 25 mm above it, and goes on there.
fn gliding() -> String {
    let mut csv = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    for i in 0..POSES {
        let share = f64::from(i) / f64::from(POSES);
        // There and back, so that the loop has no leap.
        let way = 1.0 - (2.0 * share - 1.0).abs();
        let direction = towards(0.4 + 2.2 * way, std::f64::consts::TAU * 5.0 * way);
        // So short that its points are no tail, wherever the sweep ends.
        let lifted = if i % 50 >= 46 { 25.0 } else { 0.0 };
        let [x, y, z] = surface(direction);
        // How well a tip lies on a bone.
        let off = lifted + CONTACT_MM * Chance::new(3, u64::from(i)).normal(0);
        let [x, y, z] = [0, 1, 2].map(|k| [x, y, z][k] + off * direction[k]);
        csv += &format!("{},1,0,0,0,{x},{y},{z}\n", STEP_S * f64::from(i));
    }
    csv
}

fn scene() -> String {
    SMALL.replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n")
        + "[tracker.registration]\nfile = \"registration.json\"\n[tracker.registration.gates]\nmax_tre_mm = 3.0\n\
           [tracker.room]\ncalibration_error_mm = 0.1\n[tracker.room.marker]\ncone_deg = 180.0\n[tracker.room.handle]\n\
           radius_mm = 0.0\n[tracker.room.reference]\ncone_deg = 180.0\n[tracker.room.patient.breathing]\n\
           [tracker.room.gesture]\nfile = \"glide.csv\"\nat_end = \"loop\"\n"
}

fn waiting<'a>(world: &'a World, scene: &str) -> Pilot<'a> {
    let pilot = world.start(&world.file("s.toml", scene), &world.path("out"), "default");
    let words = "patient not registered: registration.json is not there";
    pilot.wait_for(words, |status| {
        let processes = status["processes"].as_array().unwrap();
        let tracker = processes.iter().find(|p| p["name"] == "tracker").unwrap();
        tracker["note"].as_str().unwrap().contains(words)
    });
    pilot
}

/// A patient who breathes, a marker on him, a pointer that glides over his bone and is lifted: he is registered by the bone's surface, the
/// file is in use, and the truth lies within what it promises.
#[test]
fn a_patient_is_registered_by_gliding_over_a_bone() {
    let world = World::new();
    world.file("glide.csv", &gliding());
    fs::write(world.path("bone.ply"), bone()).unwrap();
    let pilot = waiting(&world, &scene());
    let path = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let (bone, to, out, png) = (
        path("bone.ply"),
        path("swept.csv"),
        path("registration.json"),
        path("p.png"),
    );
    let target = TARGET_MM.map(|mm| mm.to_string()).join(",");
    let sweep = ["calibrate", "sweep", "--bone", &bone, "--to", &to, "--target", &target];
    // Two seconds are some points of one side, of which nothing is accepted; they are kept.
    let short = world.output("pilot", &[&sweep[..], &["--seconds", "1.5", "--out", &out]].concat());
    assert_eq!(short.status.code(), Some(1), "{}", stdout(&short));
    assert!(!world.path("registration.json").exists() && world.path("swept.csv").exists());

    let long = ["--seconds", "20", "--out", &out, "--picture", &png, "--overwrite"];
    let output = world.output("pilot", &[&sweep[..], &long].concat());
    let said = stderr(&output);
    println!("{said}{}", stdout(&output));
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("More helps most near ") && said.contains("nothing speaks against it"),
        "{said}"
    );
    assert!(world.path("p.png").exists());
    let predicted = within_its_promise(&world, Point::new(TARGET_MM[0], TARGET_MM[1], TARGET_MM[2]), 1.0);
    // What was told meanwhile has the error that all points share, as the result has.
    assert!(
        said.contains(&format!("{predicted:.1} mm at the targets")),
        "{predicted}: {said}"
    );
    // The same points again, from the file.
    let again = world.path("again.json");
    let words = [
        "surface",
        "--bone",
        &bone,
        "--points",
        &to,
        "--live",
        "default",
        "--shared-mm",
        "0.1",
    ];
    let words = [&words[..], &["--target", &target, "--out", again.to_str().unwrap()]].concat();
    let output = world.output("calib", &words);
    assert!(output.status.success(), "{}", stderr(&output));
    pilot.wait_live();
    assert!(pilot.stop().success());
}

fn within_its_promise(world: &World, target: Point<Ct>, most_mm: f64) -> f64 {
    let text = fs::read_to_string(world.path("registration.json")).unwrap();
    let file = RegistrationFile::parse(&text).unwrap();
    let Registered::Referenced(found) = file.registered else {
        panic!("{text}")
    };
    let [x, y, z] = target.mm();
    let [a, b, c] = REFERENCE_MM;
    // The marker's axes are the CT's.
    let seen = Point::<Reference>::new(x - a, y - b, z - c);
    let tre = (found.transform() * seen).distance(target);
    let predicted = (found * seen).rms_mm();
    println!("the target is off by {tre:.2} mm, {predicted:.2} mm predicted");
    // Beyond four times its root mean square an error has a chance of 1e-6, in whichever directions it may be.
    assert!(
        tre < 4.0 * predicted && predicted < most_mm,
        "{tre} mm, {predicted} predicted"
    );
    predicted
}
