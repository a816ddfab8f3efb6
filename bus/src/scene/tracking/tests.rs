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
    assert_eq!(source.reference.as_ref().unwrap().0, "R");
    let links = &scene.tracker.links;
    let calibration = links.calibration.as_ref().unwrap();
    assert_eq!(calibration.path, Path::new("folder/tool.json"));
    assert_eq!(calibration.marker.as_deref(), Some("ball"));
    assert_eq!(links.registration.as_ref().unwrap().path, Path::new("/r.json"));
    assert_eq!(scene.tracker.smoothing.unwrap().as_millis(), 35);
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
