//! Enhanced CT: the frames of one file are the slices of a series, or refused by name.

mod compressed;
mod damaged;
mod made;
mod meaning;
mod parts;
mod told;
mod whole;

use super::writer::{Coding, SIZE};
use super::*;
use crate::dicom::open_path;
use made::{Enhanced, POSITION_GROUP, TRANSFORMATION};

const PIXELS: usize = 12;

/// What the classic series of these slices gives: the oracle.
fn classic(files: &[File]) -> (Vec<i16>, geometry::VolumeGrid) {
    let folder = Folder::of(files);
    let mut source = folder.open().unwrap();
    let grid = *source.grid();
    (drink(&mut source).unwrap().0, grid)
}

fn volume(enhanced: &Enhanced) -> (Vec<i16>, geometry::VolumeGrid) {
    let folder = enhanced.folder();
    let mut source = folder.open().unwrap();
    let grid = *source.grid();
    (drink(&mut source).unwrap().0, grid)
}

#[test]
fn frames_are_the_slices_of_the_classic_series_in_every_coding() {
    let want = classic(&stack(5));
    for coding in [Coding::Explicit, Coding::Implicit, Coding::Big] {
        for open in [false, true] {
            let enhanced = Enhanced {
                coding,
                open,
                ..Enhanced::of(5)
            };
            assert_eq!(volume(&enhanced), want, "{coding:?}, delimiters: {open}");
        }
    }
}

#[test]
fn frames_in_any_order_and_the_legacy_class_give_the_same_volume() {
    let mut enhanced = Enhanced::of(5);
    enhanced.frames = [3, 0, 4, 1, 2].map(|k| enhanced.frames[k].clone()).to_vec();
    enhanced.class = "1.2.840.10008.5.1.4.1.1.2.2";
    assert_eq!(volume(&enhanced), classic(&stack(5)));
}

#[test]
fn one_file_alone_is_opened_by_its_name_and_told_whose_it_is() {
    let folder = Enhanced::of(4).folder();
    let file = folder.path().join("many.dcm");
    let mut source = open_path(&file, None, Options::default()).unwrap().unwrap();
    assert_eq!(drink(&mut source).unwrap().0, classic(&stack(4)).0);
    assert_eq!(source.whose().unwrap().words[0], "SECRET^NAME");
    assert!(crate::dicom::holds_series(&file));
    let error = open_path(&file, Some(2), Options::default()).unwrap_err();
    assert!(
        matches!(error, DicomError::NoSuchSeries { asked: 2, count: 1, .. }),
        "{error}"
    );
}

#[test]
fn each_frame_has_its_own_slope_and_what_all_share_is_shared() {
    let (mut files, mut enhanced) = (stack(4), Enhanced::of(4));
    for (k, (slope, intercept)) in [("1", "-1024"), ("0.5", "3.25"), ("2", "-900"), ("1", "0")]
        .into_iter()
        .enumerate()
    {
        files[k]
            .text((0x0028, 0x1053), "DS", slope)
            .text((0x0028, 0x1052), "DS", intercept);
        // The frame's own goes before the one that all share.
        if k > 0 {
            enhanced.frames[k].group(TRANSFORMATION, made::transformation(slope, intercept));
        }
    }
    assert_eq!(volume(&enhanced), classic(&files));
}

#[test]
fn a_tilted_gantry_stays_a_sheared_map() {
    let (mut files, mut enhanced) = (stack(4), Enhanced::of(4));
    let (s, c) = 18.5_f64.to_radians().sin_cos();
    let axes = format!("1\\0\\0\\0\\{c:.12}\\{s:.12}");
    for (k, file) in files.iter_mut().enumerate() {
        file.text((0x0020, 0x0037), "DS", &axes);
        enhanced.frames[k].group(made::ORIENTATION_GROUP, made::text((0x0020, 0x0037), "DS", &axes));
    }
    let source = enhanced.folder().open().unwrap();
    assert!(
        (source.series_facts().tilt_deg - 18.5).abs() < 1e-6,
        "{:?}",
        source.series_facts()
    );
    assert_eq!(volume(&enhanced), classic(&files));
}

#[test]
fn padding_is_declared_for_all_frames() {
    let mut enhanced = Enhanced::of(3);
    enhanced.base.us((0x0028, 0x0120), 7);
    let folder = enhanced.folder();
    let source = folder.open().unwrap();
    assert_eq!(
        (source.padding_hu(), source.series_facts().padding_known),
        (7 - 1024, true)
    );
}

#[test]
fn cells_of_an_odd_number_of_bytes_have_no_padding_between_frames() {
    let mut enhanced = Enhanced::of(3);
    enhanced
        .base
        .us((0x0028, 0x0100), 8)
        .us((0x0028, 0x0101), 8)
        .us((0x0028, 0x0102), 7);
    enhanced.base.us((0x0028, 0x0010), 3).us((0x0028, 0x0011), 3);
    enhanced.pixels = Some(Value::Raw("OB", (0..28).collect(), 28));
    let (voxels, grid) = volume(&enhanced);
    assert_eq!(grid.dims(), [3, 3, 3]);
    assert_eq!(voxels, (0..27).map(|i| i - 1024).collect::<Vec<i16>>());
}

#[test]
fn what_makes_no_volume_is_refused_as_classic_slices_are() {
    let at = |places: &[f64]| {
        let mut enhanced = Enhanced::of(places.len());
        for (frame, z) in enhanced.frames.iter_mut().zip(places) {
            frame.place([-10.0, 20.0, *z]);
        }
        enhanced.folder().refused()
    };
    assert!(at(&[0.0, 2.5]).contains("too few slices: 2"));
    assert!(at(&[0.0, 2.5, 2.5, 5.0]).contains("2 slices at one place"));
    let uneven = at(&[0.0, 2.5, 7.5, 10.0]);
    assert!(uneven.contains("found 5.0000 mm, 1 missing"), "{uneven}");
    let mut enhanced = Enhanced::of(4);
    enhanced.frames[2].place([-9.0, 20.0, 5.0]);
    let error = enhanced.folder().refused();
    assert!(error.contains("beside the line"), "{error}");
    let mut mirrored = Enhanced::of(3);
    // A negative spacing turns the rows round.
    mirrored.shared_group(made::MEASURES_GROUP, made::text((0x0028, 0x0030), "DS", "0.75\\-0.5"));
    let error = mirrored.folder().refused();
    assert!(
        error.contains("frame 1: element (0028,0030)") && error.contains("mirror"),
        "{error}"
    );
}

#[test]
fn uneven_frames_are_put_on_an_even_grid_when_asked() {
    let mut enhanced = Enhanced::of(4);
    for (frame, z) in enhanced.frames.iter_mut().zip([0.0, 2.5, 7.5, 10.0]) {
        frame.place([-10.0, 20.0, z]);
    }
    let folder = enhanced.folder();
    let mut source = folder.open_with(Options { regrid: true }).unwrap();
    assert_eq!(
        (source.grid().dims()[2], source.marks()),
        (5, bus::message::Marks::REGRIDDED)
    );
    let (voxels, _) = drink(&mut source).unwrap();
    assert_eq!(voxels[2 * PIXELS], 150 - 1024);
}

#[test]
fn each_missing_group_is_named_with_its_frame() {
    let cases = [
        (POSITION_GROUP, "(0020,0032) ImagePositionPatient is missing"),
        (
            made::ORIENTATION_GROUP,
            "(0020,0037) ImageOrientationPatient is missing",
        ),
        (made::MEASURES_GROUP, "(0028,0030) PixelSpacing is missing"),
        (TRANSFORMATION, "(0028,1053) RescaleSlope is missing"),
    ];
    for (group, words) in cases {
        // What all share moves into each frame but one.
        let mut enhanced = Enhanced::of(3);
        let shared = enhanced.take_shared(group);
        for k in [0, 2] {
            if let Some(value) = &shared {
                enhanced.frames[k].elements.push((group, value.clone()));
            }
        }
        enhanced.frames[1].elements.retain(|row| row.0 != group);
        // Whichever of the slices are asked for, those with a place too.
        let errors = enhanced.refused_parts();
        let error = errors.join("\n");
        assert!(errors.iter().all(|one| *one == errors[0]), "{error}");
        assert!(error.contains(&format!("frame 2: element {words}")), "{error}");
        // A group that is there and says nothing hides the shared one.
        let mut empty = Enhanced::of(3);
        for frame in &mut empty.frames {
            frame.elements.retain(|row| row.0 != group);
            frame.elements.push((group, Value::Items(vec![vec![]], false)));
        }
        let error = empty.folder().refused();
        assert!(error.contains("frame 1: element") && error.contains(words), "{error}");
    }
}

#[test]
fn a_place_outside_of_the_functional_groups_is_none() {
    let mut enhanced = Enhanced::of(3);
    for frame in &mut enhanced.frames {
        frame.elements.retain(|row| row.0 != POSITION_GROUP);
    }
    enhanced.base.text((0x0020, 0x0032), "DS", "1\\2\\3");
    let error = enhanced.folder().refused();
    assert!(error.contains("frame 1: element (0020,0032)"), "{error}");
}

#[test]
fn a_modality_lut_and_distorted_frames_are_refused() {
    let lut = ((0x0028, 0x3000), Value::Items(vec![vec![]], true));
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[1].elements.push(lut.clone());
    let error = enhanced.folder().refused();
    assert!(
        error.contains("frame 2: element (0028,3000) ModalityLUTSequence"),
        "{error}"
    );
    let mut enhanced = Enhanced::of(3);
    enhanced.base.set(lut.0, lut.1.clone());
    assert!(enhanced.folder().refused().contains("frame 1: element (0028,3000)"));
    let mut files = stack(3);
    files[1].set(lut.0, lut.1);
    assert!(
        Folder::of(&files)
            .refused()
            .contains("element (0028,3000) ModalityLUTSequence")
    );
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[2].group(made::FRAME_TYPE_GROUP, made::text((0x0008, 0x9206), "CS", "DISTORTED"));
    let error = enhanced.folder().refused();
    assert!(error.contains("frame 3: element (0008,9206)"), "{error}");
}
