use std::path::Path;

use scene::raw;

use super::*;

fn checked(text: &str) -> Checked {
    let source = raw::parse(text, Path::new("s.toml")).unwrap();
    check(&source, &Scene::from_raw(&source).unwrap())
}

#[test]
fn what_lies_outside_the_ct_is_said_with_its_distance() {
    let text = "[volume]\nspacing_mm = 6.0\n[tracker.approach]\nentry_ct_mm = [0.0, -2000.0, 0.0]\n\
                [[targets]]\nname = \"in\"\nct_mm = [0.0, 0.0, 0.0]\n[[targets]]\nname = \"out\"\nct_mm = [5000.0, 0.0, 0.0]\n";
    let faults = checked(text).faults;
    assert_eq!(faults.len(), 2, "{faults:?}");
    let grid = phantom::Phantom::new(0).grid([6.0; 3]).unwrap();
    // The outer side of the last voxel along +x: the generated patient's axes are the patient's.
    let side = grid.centre().mm()[0] + f64::from(grid.dims()[0]) * 3.0;
    assert!(faults[0].contains("target \"out\""), "{faults:?}");
    assert!(
        faults[0].contains(&format!("lies {:.1} mm outside the CT", 5000.0 - side)),
        "{faults:?}"
    );
    assert!(faults[1].contains("entry_ct_mm"), "{faults:?}");
}

#[test]
fn every_fault_is_listed_and_small_images_are_noted() {
    let text = "[volume]\nsource = \"/no/such/ct.nii\"\n[tracker]\nsource = \"sequence\"\n[tracker.sequence]\nfile = \"/no/a.mha\"\n\
                [tracker.calibration]\nfile = \"/dev\"\n[tracker.registration]\nfile = \"/no/r.json\"\n\
                [[views]]\nname = \"small\"\nplane = \"axial\"\nextent = \"global\"\nsize = [300, 191]\n";
    let checked = checked(text);
    let all = checked.faults.join("\n");
    for words in [
        "tracker.sequence.file /no/a.mha: No such file",
        "tracker.calibration.file /dev: it is not a file",
        "tracker.registration.file /no/r.json: No such file",
        "volume.source /no/such/ct.nii: No such file",
    ] {
        assert!(all.contains(words), "{words} in {all}");
    }
    let notes = checked
        .lines
        .iter()
        .filter(|line| line.starts_with("note: view small: 191 pixels"));
    assert_eq!(notes.count(), 1, "{:?}", checked.lines);
}

/// A scene whose images no sweep takes was found good, and the sweep said so at its end.
#[test]
fn images_that_no_sweep_takes_are_warned_of() {
    let warnings = |clock: &str, beams: &str| -> Vec<String> {
        let text = format!(
            "[volume]\nspacing_mm = 6.0\n[tracker]\nsource = \"markers\"\n[tracker.markers]\nnoise_mm = 0.1\n[localizer]\nkind = \"openigtlink\"\n\
             address = \"a:1\"\nclock = \"{clock}\"\n[localizer.images]\nname = \"Image\"\norientation = \"MF\"\n{beams}"
        );
        let all = checked(&text).lines.into_iter();
        all.filter(|line| line.starts_with("warning: `pilot calibrate sweep`"))
            .collect()
    };
    let beams = "depth_mm = 9\nlinear_mm = [0, 6.3, 0]\n";
    assert_eq!(warnings("mapped", beams), Vec::<String>::new());
    assert!(matches!(&warnings("arrival", beams)[..], [one] if one.contains("clock = \"mapped\"")));
    assert!(matches!(&warnings("mapped", "")[..], [one] if one.contains("localizer.images.depth_mm")));
}

#[test]
fn an_examination_that_is_a_device_is_not_opened() {
    let faults = checked("[volume]\nsource = \"/dev/zero\"").faults;
    assert_eq!(faults, ["volume.source /dev/zero: it is neither a file nor a folder"]);
}

/// Held against the sides of the generated patient's box, whose axes are the patient's.
#[test]
fn a_point_is_outside_by_its_distance_from_the_box() {
    let source = raw::parse("[volume]\nspacing_mm = 6.0", Path::new("s.toml")).unwrap();
    let scene = Scene::from_raw(&source).unwrap();
    let examination = Examination::of(&source, &scene).unwrap();
    let grid = phantom::Phantom::new(0).grid([6.0; 3]).unwrap();
    let (centre, dims) = (grid.centre().mm(), grid.dims());
    let mut state = 1_u64;
    // Knuth's multiplier: the upper bits are even enough to spread points over 1800 mm.
    let mut number = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 * 1800.0 - 900.0
    };
    for _ in 0..2000 {
        let p = [number(), number(), number()];
        let beyond = |i: usize| ((p[i] - centre[i]).abs() - f64::from(dims[i]) * 3.0).max(0.0);
        let off = (0..3).map(|i| beyond(i).powi(2)).sum::<f64>().sqrt();
        let found = examination
            .outside_mm(geometry::Point::new(p[0], p[1], p[2]))
            .unwrap_or(0.0);
        // A dozen roundings of numbers below 1000.
        assert!((found - off).abs() < 1e-10, "{p:?}: {found} {off}");
    }
}
