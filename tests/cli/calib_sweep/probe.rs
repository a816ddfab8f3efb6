//! `calib sweep --probe`: an ultrasound probe glides over the skin in the simulated operating room, and the patient is registered by the bone
//! in its images.

#![allow(clippy::print_stdout, reason = "the figures of the registration")]

#[path = "../../../study/src/sounding.rs"]
pub(crate) mod sounding;

use std::fs;

use crate::support::{SMALL, World, stderr, stdout};
use calib::file::{Registered, RegistrationFile, content_id};
use calib_cli::{ArrayRecord, ImagesRecord, LagRecord, PROBE_FORMAT, PROBE_VERSION, ProbeFile};
use chance::Chance;
use geometry::{Ct, Image, Marker, Point, Rigid, Tool, Tracker, Vector};
use phantom::Phantom;
use scene::{Scene, TrackerSource};
use tracker_proc::probe::SimulatedProbe;
use ultrasound::Beams;

/// Error of the probe's calibration, along and about each axis.
const CALIBRATION: [f64; 2] = [0.2, 0.002];
/// From one place of the hand to the next, and for the ways through the air, s.
const STEP_S: f64 = 0.14;
const AIR_S: f64 = 0.15;

fn scene() -> String {
    SMALL
        .replace("[tracker]\n", "[tracker]\nsource = \"operating-room\"\n")
        .replace("spacing_mm = 6.0", "spacing_mm = 1.5")
        + "[tracker.registration]\nfile = \"registration.json\"\n[tracker.registration.gates]\nmax_tre_mm = 3.0\n\
           [tracker.room.marker]\ncone_deg = 180.0\n[tracker.room.handle]\nradius_mm = 0.0\n\
           [tracker.room.reference]\ncone_deg = 180.0\n[tracker.room.patient.breathing]\n\
           [tracker.room.gesture]\nfile = \"glide.csv\"\nat_end = \"loop\"\n\
           [tracker.room.probe]\nradius_mm = 60\nangle_deg = 57\ndepth_mm = 80\npixel_mm = 0.25\nrate_hz = 10\nlag_ms = 40\nspeed_percent = 1.5\n"
}

/// From place to place, and lifted on the way to one that is far.
pub(crate) fn gliding(places: &[Rigid<Ct, Tool>]) -> String {
    let mut csv = "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned();
    let mut t_s = 0.0;
    let mut line = |t_s: f64, pose: Rigid<Ct, Tool>| {
        let ([w, x, y, z], [a, b, c]) = (pose.quaternion(), pose.translation_mm());
        csv += &format!("{t_s},{w},{x},{y},{z},{a},{b},{c}\n");
    };
    let tip = Point::<Tool>::new(0.0, 0.0, 0.0);
    let above = |pose: Rigid<Ct, Tool>| {
        let [x, y, z] = (pose * Point::<Tool>::new(0.0, 0.0, -40.0)).mm();
        Rigid::from_parts(pose.rotation(), Vector::new(x, y, z))
    };
    for (i, place) in places.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| places[i]);
        if let Some(before) = before.filter(|before| (*before * tip).distance(*place * tip) > 20.0) {
            for lifted in [above(before), above(*place)] {
                t_s += AIR_S;
                line(t_s, lifted);
            }
            t_s += AIR_S;
        }
        line(t_s, *place);
        t_s += STEP_S;
    }
    csv
}

/// The calibration of the scene's probe, wrong by a draw of what it says of itself.
fn calibration() -> ProbeFile {
    let scene = Scene::parse(&scene(), std::path::Path::new("s.toml")).unwrap();
    let TrackerSource::OperatingRoom(room) = scene.tracker.source else {
        panic!("another source");
    };
    let spec = room.probe.unwrap();
    let probe = SimulatedProbe::new(spec, scene.seed).unwrap();
    let Beams::Convex {
        centre_mm: [x, y],
        radius_mm,
        half_angle,
    } = probe.shape().beams()
    else {
        panic!("another array");
    };
    let [u, v] = probe.shape().pixel_mm();
    let array = ArrayRecord::Curved {
        centre_px: [x / u, y / v],
        radius_px: radius_mm / v,
        angle_deg: 2.0 * half_angle.to_degrees(),
    };
    let truth: Rigid<Marker, Image> = room.marker_from_tool * probe.image_on_tool().unwrap();
    let draw = |i: u64| Chance::new(9, 0).normal(i);
    let [mm, rad] = CALIBRATION;
    let off: Rigid<Marker, Marker> = Rigid::from_rotation_vector(
        Vector::new(rad * draw(0), rad * draw(1), rad * draw(2)),
        Vector::new(mm * draw(3), mm * draw(4), mm * draw(5)),
    )
    .unwrap();
    let told = off * truth;
    let variances = [rad, rad, rad, mm, mm, mm, 1e-3, 1e-3].map(|deviation| deviation * deviation);
    let mut file = ProbeFile {
        format: PROBE_FORMAT.to_owned(),
        version: PROBE_VERSION,
        id: String::new(),
        program: "a test".to_owned(),
        date: "2026-01-01T00:00:00Z".to_owned(),
        verdict: "accepted".to_owned(),
        method: "wires".to_owned(),
        quaternion_wxyz: told.quaternion(),
        translation_mm: told.translation_mm(),
        pixel_mm: [spec.pixel_mm; 2],
        covariance: (0..8)
            .map(|i| (0..8).map(|j| if i == j { variances[i] } else { 0.0 }).collect())
            .collect(),
        seen_px: [[0.0, 300.0], [0.0, 300.0]],
        error_mm: 0.5,
        images: Some(ImagesRecord {
            size_px: Some([probe.shape().columns(), probe.shape().rows()]),
            array: Some(array),
            depth_mm: Some(spec.depth_mm),
            tool: Some(scene.tool.name.clone()),
            ..ImagesRecord::default()
        }),
        water: None,
        lag: Some(LagRecord {
            // Images are stamped late: the pose that goes with one is that of before.
            lag_s: -spec.lag_s + 0.002,
            sigma_s: 0.002,
        }),
        phantom: None,
        tracker: None,
        tracker_about_mm: None,
        frames: [100, 0],
        points: 900,
        share_kept: 1.0,
        mean_mm: 0.3,
        rms_mm: 0.3,
        noise_ratio: 1.0,
        frame_correlation: 1.0,
        cross_validated: None,
        sources: Vec::new(),
    };
    file.id = content_id(serde_json::to_value(&file).unwrap());
    file
}

/// The points of a sweep as they are had the scanner mirrored its picture: each across the middle of its image, found from the marker's pose
/// beside it and the probe's calibration.
fn mirrored(csv: &str) -> String {
    let file = calibration();
    let told: Rigid<Marker, Image> = geometry::checked::rigid(file.quaternion_wxyz, file.translation_mm, 1e-9).unwrap();
    let Some(ArrayRecord::Curved { centre_px, .. }) = file.images.unwrap().array else {
        panic!("another array");
    };
    let middle_mm = centre_px[0] * file.pixel_mm[0];
    let mut text = String::new();
    for line in csv.lines() {
        let words: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = words.iter().skip(1).filter_map(|word| word.parse().ok()).collect();
        if numbers.len() != 20 {
            text += &format!("{line}\n");
            continue;
        }
        let part = |from: usize| std::array::from_fn(|k| numbers[from + k]);
        let turn = std::array::from_fn(|k| numbers[13 + k]);
        let marker: Rigid<Tracker, Marker> = geometry::checked::rigid(turn, part(17), 1e-6).unwrap();
        let from_image = marker * told;
        let [x, y, z] = part(0);
        let [x, y, z] = (from_image.inverse() * Point::<Tracker>::new(x, y, z)).mm();
        let place = (from_image * Point::new(2.0 * middle_mm - x, y, z)).mm();
        let beam = geometry::checked::direction::<Tracker>(part(9)).unwrap();
        let [along_x, along_y, along_z] = (from_image.inverse() * beam).components();
        let beam = geometry::checked::direction::<Image>([-along_x, along_y, along_z]).unwrap();
        let beam = (from_image * beam).components();
        let all = [&place[..], &numbers[3..9], &beam, &numbers[12..]].concat();
        let all: Vec<String> = all.iter().map(f64::to_string).collect();
        text += &format!("{},{}\n", words[0], all.join(","));
    }
    text
}

/// A change to what the calibration says of its images, and the words of the refusal.
type Changed = (fn(&mut ProbeFile), &'static str);

fn refused_images() -> [Changed; 5] {
    fn images(file: &mut ProbeFile) -> &mut ImagesRecord {
        file.images.as_mut().unwrap()
    }
    [
        (
            |file| images(file).size_px = Some([200, 200]),
            "was calibrated with 200 x 200",
        ),
        (|file| images(file).depth_mm = Some(60.0), "was calibrated at 60.0 mm"),
        (
            |file| images(file).tool = Some("needle".to_owned()),
            "is the calibration of the tool \"needle\"",
        ),
        (
            |file| images(file).orientation = Some("UF".to_owned()),
            "is turned MF, and the probe was calibrated with images turned UF",
        ),
        (|file| file.images = None, "--unchecked-images"),
    ]
}

/// `calib check` at the end of the way: the target, touched where it truly is in the marker on the patient, passes; 12 mm aside it fails.
fn held_by_the_check(world: &World, registration: &str, target: Point<Ct>) {
    let ([x, y, z], [a, b, c]) = (target.mm(), super::REFERENCE_MM);
    let known = format!("--known={x},{y},{z}");
    for (aside_mm, is_kept) in [(0.0, true), (12.0, false)] {
        let touched = format!("--touched={},{},{}", x - a + aside_mm, y - b, z - c);
        let output = world.output("calib", &["check", registration, &known, &touched]);
        println!("{}{}", stdout(&output), stderr(&output));
        assert_eq!(output.status.success(), is_kept, "{aside_mm}: {}", stderr(&output));
    }
}

/// A patient who breathes, sound that is faster than the scanner believes, images that are stamped late, a probe that is calibrated as well as
/// probes are: he is registered without being touched, from nothing, and the truth lies within what is promised.
#[test]
fn a_patient_is_registered_by_the_bone_that_a_probe_sees() {
    let world = World::new();
    let patient = Phantom::new(1);
    world.file("glide.csv", &gliding(&sounding::places(&patient, 1)));
    let path = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let (bone, probe, to, out, png) = (
        path("bone.ply"),
        path("probe.json"),
        path("seen.csv"),
        path("registration.json"),
        path("p.png"),
    );
    // The pelvis, from the CT that is navigated in.
    let region = "-150,-90,-133,150,100,-12";
    let words = [
        "bone",
        "phantom",
        "--spacing-mm",
        "1.5",
        "--threshold-hu",
        "300",
        "--out",
        &bone,
    ];
    let made = world.output("calib", &[&words[..], &[&format!("--box={region}")]].concat());
    assert!(made.status.success(), "{}", stderr(&made));
    fs::write(&probe, serde_json::to_string(&calibration()).unwrap()).unwrap();

    let pilot = super::waiting(&world, &scene());
    let target = patient.targets()[3].centre;
    let [x, y, z] = target.mm();
    let aimed = format!("--target={x},{y},{z}");
    let sweep = [
        "calibrate",
        "sweep",
        "--bone",
        &bone,
        "--probe",
        &probe,
        "--to",
        &to,
        &aimed,
    ];
    // Where in the gesture and in the breath it begins is chance. Whoever is refused sweeps again.
    let more = ["--seconds", "42", "--out", &out, "--picture", &png, "--overwrite"];
    let is_accepted = (0..3).any(|_| {
        let output = world.output("pilot", &[&sweep[..], &more].concat());
        let said = stderr(&output);
        println!("{said}{}", stdout(&output));
        if !output.status.success() {
            assert!(
                output.status.code() == Some(1) && said.contains("is not accepted"),
                "{said}"
            );
            assert!(!world.path("registration.json").exists());
        }
        output.status.success()
    });
    assert!(is_accepted, "three sweeps were refused");
    assert!(world.path("p.png").exists());
    super::within_its_promise(&world, target, 2.0);
    held_by_the_check(&world, &out, target);
    pilot.wait_live();

    // The same points again, from the file: the same pose to the last digit.
    let again = path("again.json");
    let surface = [
        "surface", "--bone", &bone, "--points", &to, "--probe", &probe, &aimed, "--out", &again,
    ];
    let output = world.output("calib", &[&surface[..], &["--live", "default"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let transform = |name: &str| {
        let text = fs::read_to_string(world.path(name)).unwrap();
        let Registered::Referenced(found) = RegistrationFile::parse(&text).unwrap().registered else {
            panic!("{text}")
        };
        found.transform()
    };
    assert_eq!(transform("again.json"), transform("registration.json"));

    // The same sweep by a scanner that mirrored its picture since the calibration, and by nobody's probe.
    let seen = fs::read_to_string(world.path("seen.csv")).unwrap();
    let turned = path("turned.csv");
    fs::write(&turned, mirrored(&seen)).unwrap();
    let surface = [
        "surface", "--bone", &bone, "--points", &turned, "--probe", &probe, &aimed,
    ];
    let refused = world.output("calib", &surface);
    let said = stderr(&refused);
    // As it is in a mirror, or nowhere: from where in the breath the sweep was, its points may fit no pose at all.
    let is_told = said.contains("mirrored back, its images fit better") || said.contains("starts led to a pose");
    assert!(!refused.status.success() && is_told, "{said}");
    let without = [
        "surface",
        "--bone",
        &bone,
        "--points",
        &to,
        &aimed,
        "--shared-mm",
        "0.2",
    ];
    let said = stderr(&world.output("calib", &without));
    assert!(said.contains("say --probe with it"), "{said}");

    // A picture that was cropped, another tool's probe and a calibration that says neither, another depth since the calibration, and one that says nothing of a lag.
    for (change, words) in refused_images() {
        let mut other = calibration();
        change(&mut other);
        other.id = content_id(serde_json::to_value(&other).unwrap());
        fs::write(&probe, serde_json::to_string(&other).unwrap()).unwrap();
        let refused = world.output("pilot", &[&sweep[..], &["--seconds", "2", "--overwrite"]].concat());
        let said = stderr(&refused);
        assert!(!refused.status.success() && said.contains(words), "{words}: {said}");
    }
    let without = ProbeFile {
        lag: None,
        ..calibration()
    };
    let without = ProbeFile {
        id: content_id(serde_json::to_value(&without).unwrap()),
        ..without
    };
    fs::write(&probe, serde_json::to_string(&without).unwrap()).unwrap();
    let refused = world.output("pilot", &[&sweep[..], &["--seconds", "2", "--overwrite"]].concat());
    assert!(stderr(&refused).contains("say --lag-ms"), "{}", stderr(&refused));
    let other = ProbeFile {
        pixel_mm: [0.2, 0.2],
        ..calibration()
    };
    let other = ProbeFile {
        id: content_id(serde_json::to_value(&other).unwrap()),
        ..other
    };
    fs::write(&probe, serde_json::to_string(&other).unwrap()).unwrap();
    let again = world.output("pilot", &[&sweep[..], &["--seconds", "2", "--overwrite"]].concat());
    let words = stderr(&again);
    assert!(
        !again.status.success() && words.contains("the depth was changed since"),
        "{words}"
    );
    assert!(pilot.stop().success());
}
