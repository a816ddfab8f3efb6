//! What the numbers of a frame mean, and where that cannot be HU.

use super::*;

const LUT: made::Tag = (0x0028, 0x3000);
const DETAILS: made::Tag = (0x0018, 0x9304);

fn of_kind(kind: &str) -> Enhanced {
    let mut enhanced = Enhanced::of(3);
    let kind = format!("DERIVED\\PRIMARY\\VOLUME\\{kind}");
    enhanced.shared_group(made::FRAME_TYPE_GROUP, made::text((0x0008, 0x9007), "CS", &kind));
    enhanced
}

#[test]
fn images_that_are_surely_no_hu_are_refused_by_their_type() {
    for kind in ["EFF_ATOMIC_NUM", "ELECTRON_DENSITY", "MAT_FRACTIONAL", "STD_DEVIATION"] {
        let error = of_kind(kind).folder().refused();
        let words = format!("frame 1: element (0008,9007) FrameType is {kind}");
        assert!(error.contains(&words), "{error}");
        // By the type of the whole file, where the frames say nothing or that nothing was made of them.
        let whole = format!("DERIVED\\PRIMARY\\AXIAL\\{kind}");
        for mut enhanced in [Enhanced::of(3), of_kind("NONE")] {
            enhanced.base.text((0x0008, 0x0008), "CS", &whole);
            assert!(enhanced.folder().refused().contains(kind));
        }
        let mut files = stack(3);
        files[1].text((0x0008, 0x0008), "CS", &whole);
        let error = Folder::of(&files).refused();
        assert!(
            error.contains(&format!("element (0008,0008) ImageType is {kind}")),
            "{error}"
        );
    }
    for unit in ["OD", "MGML", "Z_EFF", "ED", "EDW", "PCT"] {
        let mut enhanced = Enhanced::of(3);
        let mut values = made::transformation("1", "-1024");
        values[2].1 = Value::Text("LO", unit.to_owned());
        enhanced.shared_group(TRANSFORMATION, values);
        let error = enhanced.folder().refused();
        assert!(
            error.contains(&format!("RescaleType is {unit}, expected an image")),
            "{error}"
        );
    }
}

#[test]
fn images_that_were_made_of_others_are_told() {
    for kind in ["MAXIMUM", "MINIMUM", "VMI", "MAT_REMOVED", "MAT_SPECIFIC"] {
        let folder = of_kind(kind).folder();
        let warnings = folder.open().unwrap().series_facts().warnings.clone();
        assert!(
            warnings.len() == 1 && warnings[0].contains(&format!("is {kind}: its numbers were made of others")),
            "{warnings:?}"
        );
    }
    for kind in ["NONE", "RESAMPLED"] {
        assert!(
            of_kind(kind)
                .folder()
                .open()
                .unwrap()
                .series_facts()
                .warnings
                .is_empty(),
            "{kind}"
        );
    }
}

#[test]
fn a_file_that_is_distorted_as_a_whole_is_refused() {
    let mut enhanced = Enhanced::of(3);
    enhanced.base.text((0x0008, 0x9206), "CS", "DISTORTED");
    assert!(enhanced.folder().refused().contains("frame 1: element (0008,9206)"));
    // Two that say the contrary of one another are no ground to believe the better one.
    enhanced.shared_group(made::FRAME_TYPE_GROUP, made::text((0x0008, 0x9206), "CS", "VOLUME"));
    assert!(enhanced.folder().refused().contains("frame 1: element (0008,9206)"));
    enhanced.base.text((0x0008, 0x9206), "CS", "MIXED");
    assert_eq!(volume(&enhanced), classic(&stack(3)));
}

#[test]
fn bent_planes_and_pictures_of_surfaces_are_no_slices() {
    const TECHNIQUE: made::Tag = (0x0008, 0x9207);
    for technique in ["CURVED_MPR", "VOLUME_RENDER", "SURFACE_RENDER"] {
        let mut enhanced = Enhanced::of(3);
        enhanced.frames[1].group(made::FRAME_TYPE_GROUP, made::text(TECHNIQUE, "CS", technique));
        let words = format!("VolumeBasedCalculationTechnique is {technique}");
        let error = enhanced.folder().refused();
        assert!(
            error.contains(&format!("frame 2: element (0008,9207) {words}")),
            "{error}"
        );
        let mut enhanced = Enhanced::of(3);
        enhanced.base.text(TECHNIQUE, "CS", technique);
        assert!(enhanced.folder().refused().contains(&words));
    }
    let mut enhanced = Enhanced::of(3);
    enhanced.base.text(TECHNIQUE, "CS", "MPR");
    assert_eq!(volume(&enhanced), classic(&stack(3)));
}

#[test]
fn frames_without_a_transformation_are_refused_whatever_their_modality() {
    let mut enhanced = Enhanced::of(3);
    enhanced.base.text((0x0008, 0x0060), "CS", "OT");
    enhanced.take_shared(TRANSFORMATION);
    let error = enhanced.folder().refused();
    assert!(
        error.contains("frame 1: element (0028,1053) RescaleSlope is missing"),
        "{error}"
    );
}

#[test]
fn several_beams_are_one_image_and_several_places_none() {
    let mut enhanced = Enhanced::of(3);
    let beam = |tilt: &str| made::text((0x0018, 0x1120), "DS", tilt);
    let beams = Value::Items(vec![beam("0"), beam("0.1")], false);
    enhanced.shared.push((DETAILS, beams));
    let folder = enhanced.folder();
    assert_eq!(folder.open().unwrap().series_facts().tilt_tag_deg, Some(0.0));
    assert_eq!(volume(&enhanced), classic(&stack(3)));
    let slopes = Value::Items(
        vec![made::transformation("1", "0"), made::transformation("2", "0")],
        false,
    );
    enhanced.take_shared(TRANSFORMATION);
    enhanced.shared.push((TRANSFORMATION, slopes));
    let error = enhanced.folder().refused();
    assert!(
        error.contains("PixelValueTransformationSequence has more than one item, expected one"),
        "{error}"
    );
}

#[test]
fn a_sequence_of_no_modality_lut_is_none() {
    for open in [false, true] {
        let none = Value::Items(Vec::new(), open);
        for coding in [Coding::Explicit, Coding::Implicit, Coding::Big] {
            let mut files: Vec<File> = stack(3).into_iter().map(|file| file.coded(coding)).collect();
            files.iter_mut().for_each(|file| {
                file.set(LUT, none.clone());
            });
            assert_eq!(classic(&files), classic(&stack(3)), "{coding:?}, delimiters: {open}");
        }
        let mut enhanced = Enhanced::of(3);
        enhanced.frames[1].elements.push((LUT, none.clone()));
        enhanced.base.set(LUT, none);
        assert_eq!(volume(&enhanced), classic(&stack(3)));
    }
}

#[test]
fn a_modality_lut_within_a_group_is_refused() {
    let lut = (LUT, Value::Items(vec![made::text((0x0028, 0x3004), "LO", "HU")], false));
    let groups = [
        (TRANSFORMATION, made::transformation("1", "-1024")),
        ((0x0020, 0x9170), Vec::new()),
        ((0x0020, 0x9171), Vec::new()),
    ];
    for (group, mut values) in groups {
        values.push(lut.clone());
        let mut enhanced = Enhanced::of(3);
        enhanced.frames[2].group(group, values);
        let error = enhanced.folder().refused();
        assert!(
            error.contains("frame 3: element (0028,3000) ModalityLUTSequence is there"),
            "{group:?}: {error}"
        );
    }
}

#[test]
fn frames_of_many_elements_are_a_sound_file() {
    // More than a million in all of them.
    let mut enhanced = Enhanced::of(300);
    let many: made::Values = (0..4000_u16)
        .map(|k| ((0x0019, 0x1000 + k), Value::Text("DS", String::new())))
        .collect();
    for frame in &mut enhanced.frames {
        frame.group((0x0020, 0x9171), many.clone());
    }
    let bytes = enhanced.file().bytes();
    let folder = Folder::new();
    folder.put("many.dcm", &bytes);
    assert_eq!(folder.open().unwrap().grid().dims()[2], 300);
}

#[test]
fn an_old_file_without_a_preamble_is_listed_and_opened_alike() {
    let mut enhanced = Enhanced::of(4);
    enhanced.coding = Coding::Implicit;
    let mut file = enhanced.file();
    file.preamble = false;
    let folder = Folder::new();
    // Without the name nothing says that it is DICOM.
    for (name, tried) in [("many.dcm", true), ("many", false)] {
        folder.put(name, &file.bytes());
        let path = folder.path().join(name);
        assert_eq!(crate::dicom::holds_series(&path), tried, "{name}");
        let opened = open_path(&path, None, Options::default()).unwrap();
        assert_eq!(opened.is_some(), tried, "{name}");
    }
}
