use std::f64::consts::PI;
use std::path::Path;

use super::super::{Scene, TrackerSource, raw};
use super::*;
use geometry::Point;

fn parsed(room: &str) -> Result<Scene, super::super::SceneError> {
    let text = format!("[tracker]\nsource = \"operating-room\"\n{room}");
    Scene::parse(&text, Path::new("folder/s.toml"))
}

fn room(text: &str) -> Room {
    match parsed(text).unwrap().tracker.source {
        TrackerSource::OperatingRoom(room) => *room,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_room_without_keys_is_the_thesis_with_the_noise_of_its_localizer() {
    let room = room("");
    let ball = Emitters::Ball {
        count: 24,
        radius_mm: 50.0,
    };
    assert_eq!(room.marker.emitters, ball);
    assert!((room.marker.cone_rad - PI / 3.0).abs() < 1e-15);
    assert_eq!(room.marker_from_tool.translation_mm(), [0.0, -60.0, 280.0]);
    assert_eq!((room.handle.from_mm, room.handle.to_mm), (180.0, 260.0));
    assert_eq!((room.sensor.across_mm, room.sensor.depth_mm), (0.1, 0.15));
    assert_eq!(
        (room.hand, room.reference, room.played, room.patient.breathing),
        (None, None, None, None)
    );
    assert_eq!(room.faults, Faults::default());
}

#[test]
fn the_localizer_stands_before_the_patient_unless_told_otherwise() {
    let ct_from_tracker = parsed("").unwrap().tracker.ct_from_tracker;
    let ahead = ct_from_tracker * Point::new(0.0, 0.0, 2300.0);
    // Rounding of coordinates of 2300 mm.
    assert!(ahead.distance(Point::new(0.0, 0.0, 0.0)) < 1e-12 * 2300.0);
    let elsewhere = parsed("[tracker.ct_from_tracker]\ntranslation_mm = [1, 2, 3]").unwrap();
    assert_eq!(elsewhere.tracker.ct_from_tracker.translation_mm(), [1.0, 2.0, 3.0]);
    let simulated = Scene::parse("", Path::new("s.toml")).unwrap();
    assert_eq!(simulated.tracker.ct_from_tracker.translation_mm(), [0.0; 3]);
}

#[test]
fn lists_and_units_are_read() {
    let room = room(
        "[tracker.room.marker]\nemitters = [{ at_mm = [1, 2, 3], normal = [0, 0, 2] }, { at_mm = [9, 0, 0] }, { at_mm = [0, 9, 0] }]\n\
         [tracker.room.localizer]\nlatency_ms = 20\n[tracker.room.patient]\ndrift_mm_per_min = [60, 0, 0]\n\
         [tracker.room.gesture]\nfile = \"a.csv\"\nat_end = \"loop\"",
    );
    let Emitters::Listed(list) = room.marker.emitters else {
        panic!("a list")
    };
    assert_eq!(list.len(), 3);
    assert_eq!((list[0].normal, list[1].normal), (Some(Direction::Z), None));
    assert_eq!(room.timing.latency_s, 0.02);
    assert_eq!(room.patient.drift_mm_per_s.mm(), [1.0, 0.0, 0.0]);
    let played = room.played.unwrap();
    assert_eq!((played.file, played.at_end), ("folder/a.csv".into(), AtEnd::Loop));
}

/// Table, line, and what the refusal must say beside the key.
const REFUSED: &[(&str, &str, &str)] = &[
    ("", "calibration_error_mm = -1", "0 to 50 mm"),
    ("", "calibration_error_deg = 11", "0 to 10 degrees"),
    ("", "registration_error_mm = nan", "found NaN"),
    ("", "registration_error_deg = inf", "found inf"),
    (".marker", "ball.emitters = 33", "3 to 32"),
    (".marker", "ball.radius_mm = 0", "1 to 1000 mm"),
    (".marker", "cone_deg = 0", "1 to 180 degrees"),
    (".marker", "emitters = []", "3 to 32 emitters"),
    (".marker", "marker_from_tool.quaternion = [1, 1, 0, 0]", "norm 1"),
    (".reference", "ball.emitters = 2", "3 to 32"),
    (".reference", "cone_deg = 181", "1 to 180 degrees"),
    (
        ".reference",
        "ct_from_reference.translation_mm = [0, 0, 1e9]",
        "-100000 to 100000 mm",
    ),
    (".handle", "from_mm = -1", "0 to 2000 mm"),
    (".handle", "to_mm = 10", "180 to 3000 mm (its beginning or more)"),
    (".handle", "radius_mm = 201", "0 to 200 mm"),
    (".hand", "radius_mm = -1", "0 to 200 mm"),
    (".hand", "every_s = 0", "0.1 to 3600 s"),
    (".hand", "for_s = 11", "0 to 10 s (at most every_s)"),
    (".localizer", "across_mm = -0.1", "0 to 50 mm"),
    (".localizer", "depth_mm = 51", "0 to 50 mm"),
    (".localizer", "at_mm = 0", "1 to 100000 mm"),
    (".localizer", "growth_across = 5", "0 to 4"),
    (".localizer", "growth_depth = -1", "0 to 4"),
    (".localizer", "quantisation_mm = 11", "0 to 10 mm"),
    (".localizer", "eyes_mm = []", "1 to 8 eyes"),
    (".localizer", "eyes_mm = [[0, 0, nan]]", "-5000 to 5000 mm"),
    (".localizer", "view_deg = 0", "1 to 180 degrees"),
    (".localizer", "nearest_mm = -1", "0 to 100000 mm"),
    (".localizer", "farthest_mm = -1", "0 to 100000 mm (nearest_mm or more)"),
    (".localizer", "latency_ms = 1001", "0 to 1000 ms"),
    (".localizer", "jitter_ms = -1", "0 to 1000 ms"),
    (".localizer", "dropped = 1.1", "0 to 1"),
    (".localizer", "late = -0.1", "0 to 1"),
    (".localizer", "late_ms = 2001", "0 to 2000 ms"),
    (".localizer", "drift_ppm = 100001", "-100000 to 100000 ppm"),
    (".localizer", "offset_s = 1e7", "-1000000 to 1000000 s"),
    (".patient", "drift_mm_per_min = [0, 0, 1001]", "-1000 to 1000 mm/min"),
    (".patient.breathing", "amplitude_mm = 101", "0 to 100 mm"),
    (".patient.breathing", "direction = [0, 0, 0]", "not all 0"),
    (".patient.breathing", "period_s = 0", "0.5 to 60 s"),
    (".patient.bump", "at_s = -1", "0 to 86400 s"),
    (".patient.bump", "over_s = 61", "0 to 60 s"),
    (".patient.bump", "translation_mm = [1001, 0, 0]", "-1000 to 1000 mm"),
    (".patient.bump", "rotation_deg = [0, 181, 0]", "-180 to 180 degrees"),
    (".faults", "dead = [24]", "0 to 23: the marker has 24 emitters"),
    (".faults", "swapped = [3, 3]", "two emitters"),
    (".faults", "from_s = -1", "0 to 86400 s"),
    (".gates", "min_emitters = 2", "3 to 32"),
    (".gates", "max_fre_mm = 0", "0.001 to 1000 mm"),
    (".reference_gates", "outlier_sigmas = 0", "1 to 1000 deviations"),
    (".reference_gates", "max_tip_mm = 0", "0.001 to 1000 mm"),
    (".gesture", "file = \"\"", "the path of a CSV file"),
    (".probe", "width_mm = 2", "5 to 200 mm"),
    (".probe", "angle_deg = 40", "none without radius_mm"),
    (".probe", "depth_mm = 1", "5 to 300 mm"),
    (".probe", "pixel_mm = 0.02", "0.05 to 1 mm"),
    (".probe", "rate_hz = 0", "0.1 to 60 images a second"),
    (".probe", "lag_ms = -1", "0 to 1000 ms"),
    (".probe", "speed_percent = 11", "-10 to 10 percent"),
];

#[test]
fn each_bad_key_is_refused_by_name_and_line() {
    for (table, line, allowed) in REFUSED {
        let text = format!("[tracker]\nsource = \"operating-room\"\n[tracker.room{table}]\n{line}");
        let error = Scene::parse(&text, Path::new("s.toml")).unwrap_err().to_string();
        let key = line.split(" =").next().unwrap();
        assert!(error.starts_with("scene s.toml, line 4, "), "{line}: {error}");
        assert!(
            error.contains(&format!("key tracker.room{table}.{key}")),
            "{line}: {error}"
        );
        assert!(error.contains(allowed), "{line}: {error}");
    }
}

#[test]
fn unknown_keys_misplaced_tables_and_two_shapes_are_refused() {
    for table in [
        "",
        ".marker",
        ".reference",
        ".handle",
        ".hand",
        ".localizer",
        ".patient",
        ".patient.breathing",
        ".patient.bump",
        ".faults",
        ".gates",
        ".reference_gates",
        ".gesture",
        ".probe",
    ] {
        let error = parsed(&format!("[tracker.room{table}]\nradius_m = 1")).unwrap_err();
        assert!(error.to_string().contains("unknown field `radius_m`"), "{error}");
    }
    let elsewhere = Scene::parse("[tracker.room]", Path::new("s.toml")).unwrap_err();
    assert!(
        elsewhere.to_string().contains("tracker.source = \"operating-room\""),
        "{elsewhere}"
    );
    let both = "[tracker.room.marker]\nball = {}\nemitters = []";
    assert!(parsed(both).unwrap_err().to_string().contains("one of the two"));
    let list = "[tracker.room.marker]\nemitters = [{ at_mm = [0, 0, 0] }, { at_mm = [1, 0, 0], normal = [0, 0, 0] }, { at_mm = [0, 1, 0] }]";
    let error = parsed(list).unwrap_err().to_string();
    assert!(error.contains("key tracker.room.marker.emitters.1.normal"), "{error}");
}

#[test]
fn a_probe_is_one_array_of_a_size_that_can_be_shown_and_not_held_by_who_practises() {
    let probe = |keys: &str| parsed(&format!("[tracker.room.probe]\n{keys}"));
    let words = |keys: &str| probe(keys).unwrap_err().to_string();
    assert!(words("width_mm = 40\nradius_mm = 50").contains("not both"));
    assert!(words("depth_mm = 250\npixel_mm = 0.1").contains("24 to 1024 pixels a side"));
    assert!(words("[tracker.room.practice]").contains("one of the two"));
    // A half turn would be as wide as the arc's ends are apart: 2 (60 + 40) sin 30 degrees.
    let room = room("[tracker.room.probe]\nradius_mm = 60\nangle_deg = 60\ndepth_mm = 40");
    let [width, height] = room.probe.unwrap().extent_mm();
    assert!((width - 100.0).abs() < 1e-9 && (height - (100.0 - 60.0 * 0.75_f64.sqrt())).abs() < 1e-9);
}

#[test]
fn a_written_room_reads_back() {
    let text = "[tracker]\nsource = \"operating-room\"\n[tracker.room.hand]\n[tracker.room.reference]\n\
                [tracker.room.patient.breathing]\n[tracker.room.patient.bump]\n[tracker.room.gesture]\nfile = \"/a.csv\"\n\
                [tracker.room.probe]\nradius_mm = 60.0";
    let source = raw::parse(text, Path::new("s.toml")).unwrap();
    let again = raw::parse(&source.to_toml(), Path::new("s.toml")).unwrap();
    assert_eq!(source.scene, again.scene);
    assert_eq!(Scene::from_raw(&source).unwrap(), Scene::from_raw(&again).unwrap());
}
