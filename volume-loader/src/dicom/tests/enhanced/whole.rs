//! Volumes of which something is not there.

use super::parts::{concatenated, halves};
use super::*;

fn without_total(number: u16, file: &mut File) {
    concatenated(number, 9, file);
    file.remove((0x0020, 0x9163));
}

#[test]
fn one_part_that_does_not_say_of_how_many_is_refused_by_name_and_in_its_folder() {
    let folder = halves(without_total);
    std::fs::remove_file(folder.path().join("8.dcm")).unwrap();
    let error = folder.refused();
    assert!(
        error.contains("9.dcm: this is part 1") && error.contains("does not say how many there are"),
        "{error}"
    );
    let error = open_path(&folder.path().join("9.dcm"), None, Options::default()).unwrap_err();
    assert!(matches!(error, DicomError::OnePart { number: 1, .. }), "{error}");
}

#[test]
fn parts_that_do_not_say_of_how_many_are_one_volume_with_a_warning() {
    let folder = halves(without_total);
    let mut source = folder.open().unwrap();
    let warnings = source.series_facts().warnings.clone();
    assert!(warnings[0].contains("2 files are parts of one volume"), "{warnings:?}");
    assert!(warnings[0].contains("the last may be missing"), "{warnings:?}");
    assert_eq!(drink(&mut source).unwrap().0, classic(&stack(6)).0);
    // One that says it speaks for all.
    let folder = halves(|number, file| match number {
        1 => concatenated(1, 3, file),
        _ => without_total(number, file),
    });
    assert!(folder.refused().contains("part 3 of 3"), "{}", folder.refused());
}

#[test]
fn parts_in_two_series_are_not_one_volume() {
    let folder = halves(|number, file| {
        concatenated(number, 2, file);
        file.text((0x0020, 0x000E), "UI", &format!("1.2.3.4.5.{number}"));
    });
    let found = Series::scan(folder.path()).unwrap().series;
    assert_eq!(found.len(), 2);
    for (series, missing) in found.iter().zip([2, 1]) {
        let error = DicomSource::open(series, Options::default()).map(|_| ()).unwrap_err();
        assert!(
            matches!(error, DicomError::Parts { missing: found, total: 2, .. } if found == missing),
            "{error}"
        );
    }
}

#[test]
fn a_part_twice_or_beyond_the_last_is_refused() {
    let folder = halves(|_, file| concatenated(1, 1, file));
    let error = folder.refused();
    assert!(
        error.contains("8.dcm") && error.contains("9.dcm") && error.contains("part 1"),
        "{error}"
    );
    for number in [0, 3] {
        let folder = halves(|part, file| concatenated(if part == 1 { 1 } else { number }, 2, file));
        let error = folder.refused();
        assert!(error.contains(&format!("InConcatenationNumber is {number}")), "{error}");
    }
}

/// Frame 6 of six, changed; the others have a content each.
fn last(change: impl Fn(&mut made::Frame)) -> Vec<String> {
    let mut enhanced = Enhanced::of(6);
    for (k, frame) in enhanced.frames.iter_mut().enumerate() {
        frame.content("1", [k as u32 + 1, 1]);
    }
    change(&mut enhanced.frames[5]);
    enhanced.refused_parts()
}

#[test]
fn a_frame_that_says_nothing_is_dropped_from_no_part_of_its_file() {
    let errors = last(|frame| frame.elements.clear());
    assert_eq!(errors.len(), 2);
    for error in &errors {
        assert!(error.contains("frame 6: element (0020,0032)"), "{error}");
    }
    let errors = last(|frame| frame.elements.retain(|row| row.0 != made::CONTENT_GROUP));
    assert_eq!(errors.len(), 2);
    for error in &errors {
        assert!(
            error.contains("frame 6: element (0020,9056) StackID is absent"),
            "{error}"
        );
    }
    let errors = last(|frame| {
        frame.group(made::CONTENT_GROUP, made::text((0x0020, 0x9056), "SH", "1"));
    });
    for error in &errors {
        assert!(
            error.contains("frame 6: element (0020,9128) TemporalPositionIndex is absent"),
            "{error}"
        );
    }
}

fn warnings_of(enhanced: &Enhanced, slices: usize) -> Vec<String> {
    let folder = enhanced.folder();
    let found = Series::scan(folder.path()).unwrap().series;
    let series = found.iter().find(|series| series.summary().slices == slices).unwrap();
    let source = DicomSource::open(series, Options::default()).unwrap();
    source.series_facts().warnings.clone()
}

#[test]
fn frames_of_one_stack_that_are_several_series_are_told_of() {
    let mut enhanced = Enhanced::of(6);
    for frame in &mut enhanced.frames {
        frame.content("A", [1, 1]);
    }
    enhanced.frames[5].group(made::MEASURES_GROUP, made::text((0x0028, 0x0030), "DS", "0.75\\0.51"));
    let warnings = warnings_of(&enhanced, 5);
    assert!(
        warnings[0].contains("6 frames of stack A, temporal position 1 are 2 series"),
        "{warnings:?}"
    );
}

#[test]
fn a_stack_whose_numbers_do_not_begin_or_end_with_its_slices_is_told_of() {
    let of = |numbers: [u32; 4]| {
        let mut enhanced = Enhanced::of(4);
        for (frame, number) in enhanced.frames.iter_mut().zip(numbers) {
            frame.content("1", [number, 1]);
        }
        warnings_of(&enhanced, 4)
    };
    assert!(of([1, 2, 3, 4]).is_empty() && of([4, 3, 2, 1]).is_empty());
    for numbers in [[2, 3, 4, 5], [0, 1, 2, 3], [1, 2, 4, 6]] {
        let warnings = of(numbers);
        let words = format!(
            "InStackPositionNumber is from {} to {} in 4 slices",
            numbers[0], numbers[3]
        );
        assert!(warnings.len() == 1 && warnings[0].contains(&words), "{warnings:?}");
    }
}

#[test]
fn a_frame_that_does_not_say_how_it_was_made_is_told_of() {
    let mut enhanced = Enhanced::of(6);
    for frame in &mut enhanced.frames[..5] {
        frame.group((0x0018, 0x9314), made::text((0x0018, 0x1210), "SH", "B30"));
    }
    let warnings = warnings_of(&enhanced, 5);
    assert!(
        warnings[0].contains("frame 6 of") && warnings[0].contains("has no (0018,1210) ConvolutionKernel"),
        "{warnings:?}"
    );
}
