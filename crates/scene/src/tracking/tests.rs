use std::path::Path;

use super::super::{Scene, TrackerSource};
use super::*;

fn parsed(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("folder/s.toml")).map_err(|error| error.to_string())
}

#[test]
fn emitters_of_another_program_have_the_thesis_marker_unless_told_otherwise() {
    let scene = parsed("[tracker]\nsource = \"emitters\"").unwrap();
    let TrackerSource::Emitters(source) = &scene.tracker.source else {
        panic!("{:?}", scene.tracker.source)
    };
    assert_eq!(source.marker.emitters.count(), 24);
    assert_eq!((source.noise.across_mm, source.noise.depth_mm), (0.1, 0.15));
    assert_eq!(scene.tracker.links, LinkFiles::default());
    assert_eq!(scene.tracker.smoothing, None);
    // The identity is a place like any other: no localizer is simulated.
    assert_eq!(scene.tracker.ct_from_tracker.translation_mm(), [0.0; 3]);
}

#[test]
fn files_are_relative_to_the_scene() {
    let scene = parsed(
        "[tracker]\nsource = \"sequence\"\n[tracker.sequence]\nfile = \"a.mha\"\nreference = \"R\"\nnoise_mm = 0.1\n\
         [tracker.calibration]\nfile = \"tool.json\"\nmarker = \"ball\"\n[tracker.registration]\nfile = \"/r.json\"\n\
         [tracker.smoothing]\ntime_constant_ms = 35",
    )
    .unwrap();
    let TrackerSource::Sequence(source) = &scene.tracker.source else {
        panic!("{:?}", scene.tracker.source)
    };
    assert_eq!(source.file, Path::new("folder/a.mha"));
    assert_eq!(source.markers.reference.as_ref().unwrap().0, "R");
    let links = &scene.tracker.links;
    let calibration = links.calibration.as_ref().unwrap();
    assert_eq!(calibration.file.path, Path::new("folder/tool.json"));
    assert_eq!(calibration.file.marker.as_deref(), Some("ball"));
    assert_eq!(calibration.gates, CalibrationGates::default());
    let registration = links.registration.as_ref().unwrap();
    assert_eq!(registration.file.path, Path::new("/r.json"));
    assert_eq!(
        (registration.unchecked_ct, registration.gates),
        (false, RegistrationGates::default())
    );
    assert_eq!(scene.tracker.smoothing.unwrap().as_millis(), 35);
}

#[test]
fn markers_of_a_localizer_are_named_and_need_no_table() {
    let scene = parsed("[tracker]\nsource = \"markers\"").unwrap();
    let TrackerSource::Markers(source) = &scene.tracker.source else {
        panic!("{:?}", scene.tracker.source)
    };
    assert_eq!((&source.markers.marker, &source.markers.reference), (&None, &None));
    assert_eq!((source.markers.noise, source.max_error_mm), (None, None));
    let scene = parsed(
        "[tracker]\nsource = \"markers\"\n[tracker.markers]\nmarker = \"StylusToTracker\"\nreference = \"R\"\nnoise_mm = 0.2\n\
         noise_deg = 0.1\nmax_error_mm = 0.5\n[tracker.markers.ct_from_reference]\ntranslation_mm = [1, 2, 3]\n\
         [tracker.calibration]\nfile = \"t.json\"",
    );
    let scene = scene.unwrap();
    let TrackerSource::Markers(source) = &scene.tracker.source else {
        panic!("{:?}", scene.tracker.source)
    };
    let (name, ct_from_reference) = source.markers.reference.as_ref().unwrap();
    assert_eq!(
        (name.as_str(), ct_from_reference.translation_mm()),
        ("R", [1.0, 2.0, 3.0])
    );
    assert_eq!(
        (source.markers.marker.as_deref(), source.max_error_mm),
        (Some("StylusToTracker"), Some(0.5))
    );
    assert_eq!(source.markers.noise.unwrap().shift_mm, 0.2);
    assert!(scene.tracker.links.calibration.is_some());
    assert_ne!(
        scene.registration_id(),
        parsed("[tracker]\nsource = \"markers\"").unwrap().registration_id()
    );
}

#[test]
fn gates_of_files_are_those_of_the_scene() {
    let scene = parsed(
        "[tracker]\nsource = \"emitters\"\n[tracker.calibration]\nfile = \"t.json\"\n[tracker.calibration.gates]\n\
         max_rms_mm = 0.5\nmax_tip_error_mm = 0.3\nmax_condition = 30\nmin_cone_deg = 18\n[tracker.registration]\n\
         file = \"r.json\"\nunchecked_ct = true\n[tracker.registration.gates]\nmax_fre_mm = 1\nmax_condition = 9\nmax_tre_mm = 2",
    );
    let links = scene.unwrap().tracker.links;
    let gates = links.calibration.unwrap().gates;
    assert_eq!((gates.max_rms_mm, gates.max_tip_error_mm), (Some(0.5), Some(0.3)));
    assert_eq!(gates.max_condition, Some(30.0));
    // A tenth of a right angle twice over, up to a rounding of the conversion.
    assert!((gates.min_cone_rad.unwrap() - std::f64::consts::PI / 10.0).abs() < 1e-15);
    let registration = links.registration.unwrap();
    let gates = registration.gates;
    assert!(registration.unchecked_ct);
    assert_eq!(
        (gates.max_fre_mm, gates.max_condition, gates.max_tre_mm),
        (Some(1.0), Some(9.0), Some(2.0))
    );
}

#[test]
fn bad_gates_of_files_are_refused_with_line_and_key() {
    for (table, line, words) in [
        ("calibration", "max_rms_mm = 0", "calibration.gates.max_rms_mm: found 0"),
        (
            "calibration",
            "max_tip_error_mm = -1",
            "calibration.gates.max_tip_error_mm: found -1",
        ),
        (
            "calibration",
            "max_condition = 0.5",
            "calibration.gates.max_condition: found 0.5",
        ),
        (
            "calibration",
            "min_cone_deg = 91",
            "calibration.gates.min_cone_deg: found 91",
        ),
        (
            "calibration",
            "min_cone_deg = nan",
            "calibration.gates.min_cone_deg: found NaN",
        ),
        ("calibration", "max_rms = 1", "unknown field `max_rms`"),
        (
            "registration",
            "max_fre_mm = 2000",
            "registration.gates.max_fre_mm: found 2000",
        ),
        (
            "registration",
            "max_condition = inf",
            "registration.gates.max_condition: found inf",
        ),
        (
            "registration",
            "max_tre_mm = 0",
            "registration.gates.max_tre_mm: found 0",
        ),
        ("registration", "min_cone_deg = 20", "unknown field `min_cone_deg`"),
    ] {
        let text = format!(
            "[tracker]\nsource = \"emitters\"\n[tracker.{table}]\nfile = \"f.json\"\n[tracker.{table}.gates]\n{line}\n"
        );
        let error = parsed(&text).unwrap_err();
        assert!(error.contains("line 6") && error.contains(words), "{error}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_line_and_key() {
    for (text, words) in [
        (
            "[tracker.calibration]\nfile = \"t.json\"",
            "key tracker.calibration: found a table",
        ),
        (
            "[tracker]\nsource = \"external\"\n[tracker.smoothing]\ntime_constant_ms = 5",
            "key tracker.smoothing: found a table",
        ),
        ("[tracker.emitters]", "unless tracker.source = \"emitters\""),
        (
            "[tracker.sequence]\nfile = \"x\"",
            "unless tracker.source = \"sequence\"",
        ),
        ("[tracker.markers]", "unless tracker.source = \"markers\""),
        (
            "[tracker]\nsource = \"markers\"\n[tracker.markers]\nmarker = \"a\"\nreference = \"a\"",
            "key tracker.markers.reference: found \"a\"; allowed: another one than tracker.markers.marker",
        ),
        (
            "[tracker]\nsource = \"markers\"\n[tracker.markers]\nmax_error_mm = 0",
            "key tracker.markers.max_error_mm: found 0",
        ),
        (
            "[tracker]\nsource = \"markers\"\n[tracker.markers.ct_from_reference]\ntranslation_mm = [1, 2, 3]",
            "unless tracker.markers.reference names a marker",
        ),
        ("[tracker]\nsource = \"sequence\"", "key tracker.sequence"),
        (
            "[tracker]\nsource = \"sequence\"\n[tracker.sequence]\nfile = \"\"",
            "line 4, column 8, key tracker.sequence.file",
        ),
        (
            "[tracker]\nsource = \"emitters\"\n[tracker.registration]\nfile = \"\"",
            "line 4, column 8, key tracker.registration.file",
        ),
        (
            "[tracker]\nsource = \"emitters\"\n[tracker.emitters.localizer]\ndepth_mm = 6.0",
            "line 4, column 12, key tracker.emitters.localizer.depth_mm: found 6",
        ),
        (
            "[tracker]\nsource = \"emitters\"\n[tracker.emitters.marker]\nball.emitters = 33",
            "key tracker.emitters.marker.ball.emitters: found 33",
        ),
        (
            "[tracker]\nsource = \"emitters\"\n[tracker.emitters.gates]\nmin_emitters = 2",
            "key tracker.emitters.gates.min_emitters: found 2",
        ),
        (
            "[tracker]\nsource = \"emitters\"\n[tracker.emitters.reference.ct_from_reference]\nquaternion = [1, 1, 0, 0]",
            "key tracker.emitters.reference.ct_from_reference.quaternion",
        ),
        (
            "[tracker.smoothing]\ntime_constant_ms = 0",
            "line 2, column 20, key tracker.smoothing.time_constant_ms: found 0",
        ),
        (
            "[tracker]\nsource = \"sequence\"\n[tracker.sequence]\nfile = \"x\"\n[tracker.sequence.ct_from_reference]\ntranslation_mm = [1, 0, 0]",
            "unless tracker.sequence.reference names",
        ),
    ] {
        let error = parsed(text).unwrap_err();
        assert!(error.contains(words), "{text}\n  gave {error}\n  not  {words}");
    }
}
