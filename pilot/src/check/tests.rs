use std::path::Path;

use bus::volume::{Hasher, LabelMap, Layout, Marks, OwnedVolume, Voxels};
use scene::{VolumeSpec, raw};

use super::*;

fn checked(text: &str) -> Checked {
    let source = raw::parse(text, Path::new("s.toml")).unwrap();
    check(
        &source,
        &Scene::from_raw(&source).unwrap(),
        false,
        (as_far, |_| Ok(()), labelled),
    )
}

/// Organs that nothing is wrong with.
fn as_far(_: &Scene, depth: Depth) -> Result<Option<String>, Box<dyn std::error::Error + Send + Sync>> {
    Ok((depth == Depth::Meshes).then(|| "meshed".to_owned()))
}

/// A label map that nobody approved of, on a grid of its own; none of another name.
fn labelled(file: &Path, _: &VolumeSpec, _: u64) -> Result<LabelMap, Box<dyn std::error::Error + Send + Sync>> {
    if !file.ends_with("organs.dcm") {
        return Err("no such file".into());
    }
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let grid = geometry::VolumeGrid::checked([4, 4, 4], geometry::Affine::from_rows(rows))?;
    let layout = Layout::new([4; 3], [4; 3])?;
    let volume = OwnedVolume {
        grid,
        voxels: Voxels::zeroed(layout.stored() as usize),
        layout,
        padding_hu: 0,
        hash: Hasher::new(&grid, 0).finish(),
        marks: Marks::NONE,
    };
    Ok(LabelMap {
        volume,
        is_in_its_frame: false,
        doubts: vec!["ApprovalStatus is UNAPPROVED".to_owned()],
    })
}

/// A scene with a label map that nobody approved of, or that is not there, was good without a word.
#[test]
fn what_is_doubtful_about_a_label_map_is_said() {
    let of = |file: &str| checked(&format!("[volume]\nspacing_mm = 6.0\n[plan]\nlabels = \"{file}\"\n"));
    let found = of("/x/organs.dcm");
    let warnings: Vec<_> = found
        .lines
        .iter()
        .filter(|line| line.contains("the label map"))
        .collect();
    assert_eq!(found.faults, [""; 0]);
    assert_eq!(
        warnings,
        [
            "warning: the label map: LABELS LIE ON ANOTHER GRID THAN THE CT: compare them",
            "warning: the label map: ApprovalStatus is UNAPPROVED"
        ]
    );
    assert_eq!(of("/x/none.dcm").faults, ["plan.labels /x/none.dcm: no such file"]);
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

const STEPS: &str = "[volume]\nspacing_mm = 6.0\n[tracker]\nsource = \"operating-room\"\n[tracker.calibration]\nfile = \"t.json\"\n\
                     [tracker.registration]\nfile = \"r.json\"\n[steps]\ncalibrate = \"pivot\"\n";

/// All of these were called good.
#[test]
fn points_to_be_touched_and_entries_outside_the_ct_are_said() {
    let text = format!(
        "{STEPS}points = [{{ name = \"a\", ct_mm = [20, 0, 0] }}, {{ name = \"b\", ct_mm = [60, 0, 0] }}, {{ name = \"c\", ct_mm = [0, 2000, 0] }}]\n\
         check_points = [{{ name = \"d\", ct_mm = [20, 20, 0] }}, {{ name = \"e\", ct_mm = [3000, 0, 0] }}, {{ name = \"f\", ct_mm = [20, 0, 40] }}]\n\
         [[targets]]\nname = \"t\"\nct_mm = [0, 0, 0]\nentry_ct_mm = [0, 0, 5000]\n"
    );
    let faults = checked(&text).faults;
    let words = [
        "the entry of target \"t\"",
        "steps.points, \"c\",",
        "steps.check_points, \"e\",",
    ];
    assert_eq!(faults.len(), words.len(), "{faults:?}");
    for (fault, words) in faults.iter().zip(words) {
        assert!(
            fault.starts_with(words) && fault.ends_with("mm outside the CT"),
            "{fault}"
        );
    }
}

/// A registration by points on a line is refused when they have all been touched.
#[test]
fn points_on_a_line_are_said() {
    let faults = |off: f64| {
        let text = format!(
            "{STEPS}points = [{{ name = \"a\", ct_mm = [20, 0, 0] }}, {{ name = \"b\", ct_mm = [40, {off:?}, 0] }}, {{ name = \"c\", ct_mm = [60, 0, 0] }}]\n"
        );
        checked(&text).faults
    };
    let found = faults(4.9);
    assert!(
        found.len() == 1 && found[0].contains("the farthest is 4.9 mm off it"),
        "{found:?}"
    );
    assert!(faults(0.0).len() == 1 && faults(5.1).is_empty());
}

/// The plan of such a target is refused while the run goes on.
#[test]
fn a_way_that_ends_before_it_begins_is_said() {
    let faults = |entry: [f64; 3], stop: f64| {
        let text = format!(
            "[volume]\nspacing_mm = 6.0\n[[targets]]\nname = \"t\"\nct_mm = [0, 0, 0]\nentry_ct_mm = {entry:?}\nstop_mm = {stop:?}\n"
        );
        checked(&text).faults
    };
    for (entry, stop, words) in [
        ([0.0; 3], 0.0, "it is 0.0 mm, and the tip is to stop 0.0 mm before"),
        (
            [60.0, 0.0, 0.0],
            400.0,
            "it is 60.0 mm, and the tip is to stop 400.0 mm before",
        ),
    ] {
        let found = faults(entry, stop);
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
    }
    assert!(faults([60.0, 0.0, 0.0], 58.9).is_empty());
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

/// It was called good, and the tracker used it without the marker on the patient.
#[test]
fn a_registration_from_the_tracker_in_a_scene_with_a_marker_on_the_patient_is_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.json");
    let faults = |from: &str, reference: &str| {
        std::fs::write(&file, format!("{{\"from\": {from:?}}}")).unwrap();
        let text = format!(
            "[volume]\nspacing_mm = 6.0\n[tracker]\nsource = \"operating-room\"\n[tracker.registration]\nfile = {file:?}\n{reference}"
        );
        checked(&text).faults
    };
    let reference = "[tracker.room.reference]\ncone_deg = 80.0\n";
    assert!(faults("tracker", "").is_empty() && faults("reference", reference).is_empty());
    let found = faults("tracker", reference).join("\n");
    assert!(
        found.contains("found a registration from \"tracker\", expected one from reference"),
        "{found}"
    );
    assert!(faults("reference", "").join("\n").contains("no marker on the patient"));
}

/// The tracker refuses it, and nobody was told before.
#[test]
fn a_registration_that_is_not_of_the_marker_that_the_scene_names_is_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.json");
    let faults = |marker: &str, asked: &str| {
        std::fs::write(&file, format!("{{\"from\": \"tracker\"{marker}}}")).unwrap();
        let text = format!(
            "[volume]\nspacing_mm = 6.0\n[tracker]\nsource = \"operating-room\"\n[tracker.registration]\nfile = {file:?}\n{asked}"
        );
        checked(&text).faults.join("\n")
    };
    let asked = "marker = \"skull\"\n";
    assert_eq!(faults("", "") + &faults(", \"marker\": \"skull\"", asked), "");
    assert!(
        faults("", asked).contains("found a registration of no named marker, expected one of the marker \"skull\"")
    );
    assert!(faults(", \"marker\": \"leg\"", asked).contains("found a registration of the marker \"leg\""));
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

/// Any label map by this name that was not there was the generated patient's, beside a real CT too.
#[test]
fn labels_of_the_generated_patient_beside_another_examination_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let faults = |source: &str, labels: &str| {
        std::fs::write(
            folder.path().join("o.toml"),
            format!("[space]\nlabels = \"{labels}\"\n"),
        )
        .unwrap();
        let text = format!("[volume]\nsource = \"{source}\"\n[tissue]\norgans = \"o.toml\"\n");
        let source = raw::parse(&text, &folder.path().join("s.toml")).unwrap();
        let found = check(
            &source,
            &Scene::from_raw(&source).unwrap(),
            false,
            (as_far, |_| Ok(()), labelled),
        );
        let is_said = |words: &str| found.lines.iter().any(|line| line.contains(words));
        assert!(is_said("organs meshed") != is_said("were not held against the examination"));
        let of_labels = found.faults.into_iter().find(|fault| fault.contains("space.labels"));
        of_labels.unwrap_or_default()
    };
    assert_eq!(faults("phantom", "phantom"), "");
    assert!(faults("ct.nii.gz", "phantom").contains("found the generated patient's, and the examination is"));
    assert!(faults("phantom", "ct/phantom").contains("ct/phantom: No such file"));
}
