//! `pilot plan --labels`: what is said of structures beside a way, and label maps that are refused, each by name.

#![allow(clippy::disallowed_methods, reason = "an independent program is the point of a test")]

use crate::support::nifti::Nifti;
use crate::support::{World, python, stderr, stdout};
use serde_json::Value;
use std::process::{Command, Output};

/// A voxel's side, mm: that of [`Nifti::header`], whose voxel (i, j, k) lies at (-20 i, -20 j, 20 k), LPS.
const SIDE_MM: f64 = 20.0;
const DIMS: [usize; 3] = [12, 10, 8];

/// A map of this type (NIfTI's code, bits a voxel) with these bytes.
fn map(of: [i16; 2], bytes: Vec<u8>) -> Nifti {
    Nifti::header().i16(70, of[0]).i16(72, of[1]).with(bytes)
}

fn labelled(places: &[([usize; 3], i16)]) -> Nifti {
    let mut labels = vec![0_i16; DIMS.iter().product()];
    for ([i, j, k], label) in places {
        labels[(k * DIMS[1] + j) * DIMS[0] + i] = *label;
    }
    map([4, 16], labels.iter().flat_map(|label| label.to_le_bytes()).collect())
}

struct Planned(World);

impl Planned {
    /// A CT of soft tissue, and a way of 160 mm through the middles of the voxels (10, 5, 4) to (2, 5, 4).
    fn new() -> Self {
        let world = World::new();
        let ct = vec![40_i16; DIMS.iter().product()];
        let ct = map([4, 16], ct.iter().flat_map(|hu| hu.to_le_bytes()).collect());
        std::fs::write(world.path("ct.nii"), ct.0).unwrap();
        let planned = Self(world);
        let made = planned.ask(&["--target", "n=-40,-100,80", "--entry", "n=-200,-100,80"]);
        assert_eq!(made.status.code(), Some(0), "{}\n{}", stdout(&made), stderr(&made));
        assert!(
            stdout(&made).contains("NOT CHECKED, there is no label map"),
            "{}",
            stdout(&made)
        );
        planned
    }

    fn ask(&self, arguments: &[&str]) -> Output {
        let [plan, ct] = ["plan.json", "ct.nii"].map(|name| self.0.path(name).to_string_lossy().into_owned());
        let mut all = vec!["plan", &plan, "--volume", &ct];
        all.extend(arguments);
        self.0.output("pilot", &all)
    }

    fn beside(&self, labels: Nifti, more: &[&str]) -> Output {
        let path = self.0.path("labels.nii");
        std::fs::write(&path, labels.0).unwrap();
        let mut arguments = vec!["--labels", path.to_str().unwrap()];
        arguments.extend(more);
        self.ask(&arguments)
    }

    fn text(&self) -> String {
        std::fs::read_to_string(self.0.path("plan.json")).unwrap()
    }
}

/// The tube has a radius of 6 mm, half a voxel's diagonal is 17.3 mm: by hand.
#[test]
fn structures_beside_a_way_are_told_as_they_lie() {
    let planned = Planned::new();
    let on_the_way = ([6, 5, 4], 5);
    let beside = ([6, 6, 4], 7);
    let diagonal = ([6, 6, 5], 8);
    let at = "80.0 mm deep";
    let clear_mm = SIDE_MM * 2.0_f64.sqrt() - 6.0;
    let said = |labels: &[_], error: &str| {
        let asked = planned.beside(labelled(labels), &["--error-mm", error]);
        (stdout(&asked), asked.status.code())
    };
    let (text, code) = said(&[on_the_way, beside, diagonal], "2");
    let least = clear_mm - SIDE_MM * 3.0_f64.sqrt() / 2.0 - 2.0;
    for words in [
        format!("! n: CUTS label 5, {at}"),
        format!("! n: MAY CUT label 7: 14.0 mm to the middle of a voxel, {at}"),
        format!("  n: label 8 is {clear_mm:.1} mm away, {at}; at least {least:.1} mm"),
    ] {
        assert!(text.contains(&words), "{words}\n{text}");
    }
    assert_eq!(code, Some(3));
    // Clear, and nothing speaks against it; clear by the map, and not by the error.
    assert_eq!(said(&[diagonal], "2").1, Some(0));
    let (text, code) = said(&[diagonal], "6");
    assert!(
        text.contains("! n: label 8") && text.contains("WITHIN THE ERROR"),
        "{text}"
    );
    assert_eq!(code, Some(3));
    // However many a way cuts, none is left out.
    let many: Vec<_> = (2..=10).map(|i| ([i, 5, 4], 10 + i as i16)).collect();
    let (text, _) = said(&many, "2");
    assert_eq!(text.matches("CUTS label").count(), many.len(), "{text}");
}

#[test]
fn where_the_label_map_ends_nothing_is_called_free() {
    let planned = Planned::new();
    let voxels = vec![1_i16; 6 * 10 * 8];
    let half = Nifti::header()
        .dims([6, 10, 8])
        .with(voxels.iter().flat_map(|label| label.to_le_bytes()));
    let asked = planned.beside(half, &["--error-mm", "2"]);
    // The map ends at 5.5 voxels, 110 mm to the right; the entry lies 200 mm to the right.
    assert!(
        stdout(&asked).contains("from 0.0 to 90.0 mm its way lies outside the label map: NOT CHECKED"),
        "{}",
        stdout(&asked)
    );
    assert!(
        stdout(&asked).contains("! LABELS LIE ON A PART OF THE CT'S VOXELS"),
        "{}",
        stdout(&asked)
    );
    assert_eq!(asked.status.code(), Some(3));
    // An error as large as what is left beside the way: the tube may leave the map.
    let asked = planned.beside(labelled(&[([6, 6, 5], 8)]), &["--error-mm", "40"]);
    assert!(
        stdout(&asked).contains("within the error: NOT CHECKED beyond"),
        "{}",
        stdout(&asked)
    );
}

#[test]
fn ten_thousand_labels_are_ten_thousand_structures() {
    let planned = Planned::new();
    let labels = (1..=10_000_i16).flat_map(i16::to_le_bytes);
    let asked = planned.beside(Nifti::header().dims([25, 20, 20]).with(labels), &[]);
    assert!(
        stdout(&asked).contains("CUTS label"),
        "{}\n{}",
        stdout(&asked),
        stderr(&asked)
    );
    assert_eq!(asked.status.code(), Some(3));
}

#[test]
fn what_is_no_label_map_is_refused_by_name_and_nothing_is_written() {
    let planned = Planned::new();
    let before = planned.text();
    let count = DIMS.iter().product::<usize>();
    let floats = |value: f32| map([16, 32], (0..count).flat_map(|_| value.to_le_bytes()).collect());
    let words = |value: u16| map([512, 16], (0..count).flat_map(|_| value.to_le_bytes()).collect());
    for (labels, said) in [
        (labelled(&[]), "label"),
        (labelled(&[([1, 2, 3], -4)]), "-4"),
        (floats(2.5), "960 are no whole numbers"),
        (floats(0.4), "960 are no whole numbers"),
        (floats(f32::NAN), "960 are no numbers"),
        (words(40_000), "960 are below -32768 or above 32767"),
    ] {
        // Not even what could have been written without it.
        let asked = planned.beside(labels, &["--diameter", "n=9", "--confirm", "Dr. A"]);
        let found = stderr(&asked);
        assert!(
            asked.status.code() == Some(1) && found.contains("labels.nii") && found.contains(said),
            "{said}: {found}"
        );
        assert_eq!(planned.text(), before);
    }
    let asked = planned.ask(&["--labels", "/no/such/labels.nii", "--confirm", "Dr. A"]);
    assert!(stderr(&asked).contains("/no/such/labels.nii"), "{}", stderr(&asked));
    assert_eq!(planned.text(), before);
}

/// A map of the CT's voxels that lies elsewhere, as one does that was exported from the wrong series: nothing else is wrong with it.
#[test]
fn a_map_that_is_moved_against_the_ct_speaks_against_the_plan() {
    let planned = Planned::new();
    let here = labelled(&[([6, 6, 5], 8)]);
    let asked = planned.beside(here, &["--error-mm", "2", "--json"]);
    let said: Value = serde_json::from_str(&stdout(&asked)).unwrap();
    assert_eq!(
        (&said["label_map_on_grid"], asked.status.code()),
        (&true.into(), Some(0))
    );
    assert!(said["label_map"].as_str().unwrap().ends_with("labels.nii"), "{said}");
    // The place of the first voxel along R, A and S: `qoffset` and the fourth numbers of `srow`, bytes 268 and 292 of the header.
    let mut moved = labelled(&[([6, 6, 5], 8)]);
    for at in [268, 292] {
        moved.0[at..at + 4].copy_from_slice(&7.5_f32.to_le_bytes());
    }
    let asked = planned.beside(moved, &["--error-mm", "2", "--json"]);
    let said: Value = serde_json::from_str(&stdout(&asked)).unwrap();
    assert_eq!(
        (&said["label_map_on_grid"], asked.status.code()),
        (&false.into(), Some(3)),
        "{said}"
    );
    let by = said["label_map_moved_mm"].as_array().unwrap();
    assert_eq!(
        by.iter().map(|mm| mm.as_f64().unwrap().abs()).collect::<Vec<_>>(),
        [7.5, 0.0, 0.0]
    );
}

#[test]
fn structures_have_the_names_of_the_file_beside_and_two_names_of_one_are_refused() {
    let planned = Planned::new();
    let snap = "# ITK-SnAP Label Description File\n0 0 0 0 0 0 0 \"Clear Label\"\n5 255 0 0 1 1 1 \"vena cava\"\n";
    std::fs::write(planned.0.path("labels.txt"), snap).unwrap();
    let labels = || labelled(&[([6, 5, 4], 5), ([6, 6, 5], 8)]);
    let text = stdout(&planned.beside(labels(), &["--error-mm", "2"]));
    assert!(text.contains("CUTS vena cava (label 5), 80.0 mm deep"), "{text}");
    assert!(text.contains(" n: label 8 is 22.3 mm away"), "{text}");
    let before = planned.text();
    std::fs::write(planned.0.path("labels.ctbl"), "5 aorta 0 0 0 255\n").unwrap();
    let asked = planned.beside(labels(), &["--diameter", "n=9"]);
    let said = stderr(&asked);
    assert_eq!(asked.status.code(), Some(1), "{said}");
    assert!(
        said.contains("labels.ctbl") && said.contains("\"aorta\", and was \"vena cava\" before"),
        "{said}"
    );
    assert_eq!(planned.text(), before);
}

#[test]
fn names_come_from_segmentations_that_other_software_wrote() {
    let Some(python) = python() else { return };
    let planned = Planned::new();
    for kind in ["pynrrd", "simpleitk"] {
        let path = planned.0.path(&format!("{kind}.seg.nrrd"));
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/write_label_map.py");
        let written = Command::new(&python).args([script, kind]).arg(&path).output().unwrap();
        assert!(written.status.success(), "{}", stderr(&written));
        let asked = planned.ask(&["--labels", path.to_str().unwrap(), "--error-mm", "2", "--json"]);
        let said: Value = serde_json::from_str(&stdout(&asked)).unwrap_or_else(|_| panic!("{}", stderr(&asked)));
        assert_eq!(said["label_map_on_grid"], true, "{kind}: {said}");
        let near = said["structures"][0]["nearest"].as_array().unwrap();
        let names: Vec<_> = near
            .iter()
            .map(|one| (one["label"].as_i64(), one["name"].as_str()))
            .collect();
        let expected = [
            (Some(5), Some("vena cava, inferior")),
            (Some(8), Some("Leber \\ rechts")),
        ];
        assert_eq!(names, expected, "{kind}");
    }
}
