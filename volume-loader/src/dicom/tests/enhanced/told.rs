//! What looks alike and is not: names that may not be shown, numbers that lie close together, files that name one object.

use super::parts::{halves, listed, told_apart, two};
use super::*;
use crate::dicom::header::Header;

const RECONSTRUCTION: made::Tag = (0x0018, 0x9314);
const SHARED_UNASSIGNED: made::Tag = (0x0020, 0x9170);
const FRAME_UNASSIGNED: made::Tag = (0x0020, 0x9171);
const KERNEL: made::Tag = (0x0018, 0x1210);
const CARDIAC: made::Tag = (0x0018, 0x9118);
const CARDIAC_PHASE: made::Tag = (0x0020, 0x9241);

/// Two parts whose frames lie between one another, so that they would make one even stack.
fn interleaved(change: impl Fn(usize, &mut made::Frame)) -> Enhanced {
    let mut enhanced = Enhanced::of(6);
    for (k, frame) in enhanced.frames.iter_mut().enumerate() {
        change(k % 2, frame);
    }
    enhanced
}

/// That neither part is taken with the other, however its frames lie.
fn never_mixed(change: impl Fn(usize, &mut made::Frame) + Copy, words: [&str; 2]) {
    let text = listed(&interleaved(change));
    assert!(text.contains("2 series here"), "{text}");
    let folder = two(change).folder();
    let series = Series::scan(folder.path()).unwrap().series;
    assert_eq!(series.len(), 2);
    for (one, words) in series.iter().zip(words) {
        let told = one.summary().to_string();
        assert!(told.contains(words), "{told}");
        // Two that are told by the same words are found by a frame.
        let first = one.headers.iter().filter_map(Header::frame_number).min();
        let found = format!(", the first of them is frame {}", first.unwrap());
        assert!(told.ends_with(&found), "{told}");
        let (voxels, _) = drink(&mut DicomSource::open(one, Options::default()).unwrap()).unwrap();
        let first: Vec<i16> = voxels.iter().step_by(PIXELS).map(|hu| hu + 1024).collect();
        let part = first[0];
        assert!(part == 0 || part == 100, "{first:?}");
        assert_eq!(first, [part, part + 200, part + 400]);
    }
}

#[test]
fn two_names_that_may_not_be_shown_are_two() {
    type Change = fn(usize, &mut made::Frame);
    let cases: [(Change, &str); 6] = [
        (
            |part, frame| {
                let kernel = ["FC08 (soft)", "FC51 (bone)"][part];
                frame.group(RECONSTRUCTION, made::text(KERNEL, "SH", kernel));
            },
            "kernel unknown",
        ),
        (
            |part, frame| {
                let algorithm = ["A NAME OF MORE THAN 16 - 1", "A NAME OF MORE THAN 16 - 2"][part];
                frame.group(RECONSTRUCTION, made::text((0x0018, 0x9315), "CS", algorithm));
            },
            "unknown",
        ),
        (
            |part, frame| {
                frame.content(["S#1", "S#2"][part], [1, 1]);
            },
            "stack unknown",
        ),
        (
            |part, frame| {
                let kind = ["DERIVED\\PRIMARY\\VOLUME\\A*B", "DERIVED\\PRIMARY\\VOLUME\\A*C"][part];
                frame.group(made::FRAME_TYPE_GROUP, made::text((0x0008, 0x9007), "CS", kind));
            },
            "DERIVED/PRIMARY/VOLUME/unknown",
        ),
        (
            |part, frame| {
                let mut values = made::transformation("1", "-1024");
                values[2].1 = Value::Text("LO", ["HU (80 kV)", "HU (140 kV)"][part].to_owned());
                frame.group(TRANSFORMATION, values);
            },
            "unknown",
        ),
        (
            |part, frame| {
                let kernel = ["A (1)", "A (2)"][part];
                frame.group(FRAME_UNASSIGNED, made::text(KERNEL, "SH", kernel));
            },
            "kernel unknown",
        ),
    ];
    for (change, words) in cases {
        never_mixed(change, [words; 2]);
    }
}

#[test]
fn one_name_is_one_however_it_is_padded() {
    let enhanced = interleaved(|part, frame| {
        let kernel = [" FC08 (soft)\\X", "FC08 (soft) \\ X"][part];
        frame.group(RECONSTRUCTION, made::text(KERNEL, "SH", kernel));
    });
    assert_eq!(volume(&enhanced), classic(&stack(6)));
}

#[test]
fn classic_slices_without_a_series_are_told_apart_by_kernels_that_may_not_be_shown() {
    let mut files = stack(6);
    for (k, file) in files.iter_mut().enumerate() {
        file.remove((0x0020, 0x000E));
        file.text(KERNEL, "SH", ["FC08 (soft)", "FC51 (bone)"][k % 2]);
    }
    let error = Folder::of(&files).open().map(|_| ()).unwrap_err();
    assert!(matches!(error, DicomError::Several { count: 2, .. }), "{error}");
}

fn phase(percent: f32) -> made::Values {
    vec![(CARDIAC_PHASE, Value::Raw("FL", percent.to_le_bytes().to_vec(), 4))]
}

#[test]
fn phases_are_numbers_of_32_bits_and_told_apart_however_close() {
    let phases = two(|part, frame| {
        frame.group(CARDIAC, phase([40.001, 40.004][part]));
    });
    told_apart(
        &phases,
        ["40.001 % of the cardiac cycle", "40.004 % of the cardiac cycle"],
    );
    let mut breath = Enhanced::of(4);
    let percent = Value::Raw("FL", 50.0_f32.to_le_bytes().to_vec(), 4);
    breath.shared_group((0x0020, 0x9253), vec![((0x0020, 0x9245), percent)]);
    assert_eq!(volume(&breath), classic(&stack(4)));
    let told = Series::scan(breath.folder().path()).unwrap().series[0].summary().part;
    assert_eq!(told.as_deref(), Some("frames, 50 % of the respiratory cycle"));
}

#[test]
fn delays_behind_the_hearts_beat_are_told_apart() {
    let delays = two(|part, frame| {
        let ms = Value::Raw("FD", [100.0_f64, 600.5][part].to_le_bytes().to_vec(), 8);
        frame.group(CARDIAC, vec![((0x0020, 0x9153), ms)]);
    });
    told_apart(
        &delays,
        ["100 ms after the heart's beat", "600.5 ms after the heart's beat"],
    );
    // A heart that beats faster for some frames is in the same phase sooner.
    let beats = interleaved(|part, frame| {
        let ms = Value::Raw("FD", [600.0_f64, 612.0][part].to_le_bytes().to_vec(), 8);
        let mut values = vec![((0x0020, 0x9153), ms)];
        values.extend(phase(75.0));
        frame.group(CARDIAC, values);
    });
    assert_eq!(volume(&beats), classic(&stack(6)));
}

#[test]
fn phases_that_are_no_numbers_are_refused() {
    for percent in [f32::NAN, f32::INFINITY] {
        let mut enhanced = Enhanced::of(3);
        enhanced.frames[1].group(CARDIAC, phase(percent));
        let error = enhanced.folder().refused();
        assert!(
            error.contains("frame 2: element (0020,9241)") && error.contains("one finite number of 32 bits"),
            "{error}"
        );
    }
    let mut enhanced = Enhanced::of(3);
    let wide = Value::Raw("FD", 40.0_f64.to_le_bytes().to_vec(), 8);
    enhanced.frames[0].group(CARDIAC, vec![(CARDIAC_PHASE, wide)]);
    let error = enhanced.folder().refused();
    assert!(
        error.contains("is 8 bytes long, expected one finite number of 32 bits"),
        "{error}"
    );
}

#[test]
fn an_empty_rescale_type_is_none() {
    let enhanced = interleaved(|part, frame| {
        let mut values = made::transformation("1", "-1024");
        values[2].1 = Value::Text("LO", ["HU", " "][part].to_owned());
        frame.group(TRANSFORMATION, values);
    });
    assert_eq!(volume(&enhanced), classic(&stack(6)));
    let warnings = enhanced.folder().open().unwrap().series_facts().warnings.clone();
    assert_eq!(warnings, ["RescaleType is not there: the numbers are taken as HU"]);
    let mut files = stack(3);
    files.iter_mut().for_each(|file| {
        file.text((0x0028, 0x1054), "LO", "");
    });
    assert!(Folder::of(&files).open().unwrap().series_facts().warnings.is_empty());
}

#[test]
fn unassigned_attributes_that_are_shared_stay_where_a_frame_has_others() {
    let mut enhanced = Enhanced::of(4);
    enhanced.class = "1.2.840.10008.5.1.4.1.1.2.2";
    let mut values = made::text((0x0018, 0x1120), "DS", "20");
    values.extend(made::text(KERNEL, "SH", "B30"));
    enhanced.shared_group(SHARED_UNASSIGNED, values);
    for k in [1, 3] {
        enhanced.frames[k].group(FRAME_UNASSIGNED, made::text((0x0020, 0x0013), "IS", "7"));
    }
    let folder = enhanced.folder();
    let mut source = folder.open().unwrap();
    let facts = source.series_facts().clone();
    assert_eq!((facts.kernel.as_deref(), facts.tilt_tag_deg), (Some("B30"), Some(20.0)));
    assert_eq!(drink(&mut source).unwrap().0, classic(&stack(4)).0);
}

#[test]
fn two_files_that_name_one_object_are_two() {
    let folder = halves(|_, file| {
        file.text((0x0008, 0x0018), "UI", "1.2.3.4.7");
    });
    let error = folder.open().map(|_| ()).unwrap_err();
    assert!(matches!(error, DicomError::Several { count: 2, .. }), "{error}");
}

/// Frames of two scans that nothing else tells apart were one volume without a word.
#[test]
fn frames_of_several_acquisitions_are_told_with_how_many_there_are_of_each() {
    let mut enhanced = Enhanced::of(4);
    for (k, frame) in enhanced.frames.iter_mut().enumerate() {
        frame.group(
            made::CONTENT_GROUP,
            vec![((0x0020, 0x9156), Value::Us(1 + k as u16 % 2))],
        );
    }
    let warnings = enhanced.folder().open().unwrap().series_facts().warnings.clone();
    let words =
        "(0020,9156) FrameAcquisitionNumber is not the same in all slices: 1 in 2, 2 in 2, in turns along the stack:";
    assert!(warnings.len() == 1 && warnings[0].starts_with(words), "{warnings:?}");
}
