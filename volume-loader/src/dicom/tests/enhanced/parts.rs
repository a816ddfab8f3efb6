//! Stacks, points in time and reconstructions in one file, and a volume in several files.

use super::*;

pub(super) fn listed(enhanced: &Enhanced) -> String {
    match enhanced.folder().open() {
        Err(error @ DicomError::Several { .. }) => error.to_string(),
        other => panic!("expected several parts, found {other:?}"),
    }
}

/// Six frames, of which every second is another part.
pub(super) fn two(change: impl Fn(usize, &mut made::Frame)) -> Enhanced {
    let mut enhanced = Enhanced::of(6);
    for (k, frame) in enhanced.frames.iter_mut().enumerate() {
        frame.place([-10.0, 20.0, 2.5 * (k / 2) as f64]);
        change(k % 2, frame);
    }
    enhanced
}

/// The list, and that each part is the volume of its own frames.
pub(super) fn told_apart(enhanced: &Enhanced, words: [&str; 2]) {
    let text = listed(enhanced);
    assert!(text.contains("2 series here, choose one with --series N"), "{text}");
    assert!(!text.contains("1.2.3"), "{text}");
    let folder = enhanced.folder();
    for (part, words) in words.into_iter().enumerate() {
        assert!(text.lines().nth(part + 1).unwrap().contains(words), "{words}: {text}");
        let series = Series::scan(folder.path()).unwrap().choose(Some(part + 1)).unwrap();
        let (voxels, _) = drink(&mut DicomSource::open(&series, Options::default()).unwrap()).unwrap();
        let first: Vec<i16> = voxels.iter().step_by(PIXELS).copied().collect();
        let want: Vec<i16> = (0..3).map(|k| 100 * (2 * k + part as i16) - 1024).collect();
        assert_eq!(first, want, "{words}");
    }
}

#[test]
fn stacks_are_told_apart_and_chosen() {
    let stacks = two(|part, frame| {
        frame.content(["A1", "B"][part], [1, 1]);
    });
    told_apart(&stacks, ["frames of stack A1", "frames of stack B"]);
}

#[test]
fn points_in_time_are_told_apart_and_chosen() {
    let times = two(|part, frame| {
        frame.content("1", [1, [2, 10][part]]);
    });
    told_apart(&times, ["temporal position 2", "temporal position 10"]);
    let phases = two(|part, frame| {
        let percent = Value::Raw("FL", [40.0_f32, 75.5][part].to_le_bytes().to_vec(), 4);
        frame.group((0x0018, 0x9118), vec![((0x0020, 0x9241), percent)]);
    });
    told_apart(&phases, ["40 % of the cardiac cycle", "75.5 % of the cardiac cycle"]);
}

#[test]
fn reconstructions_are_told_apart_and_chosen() {
    let kernels = two(|part, frame| {
        frame.group(
            (0x0018, 0x9314),
            made::text((0x0018, 0x1210), "SH", ["B30", "B70"][part]),
        );
    });
    told_apart(&kernels, ["kernel B30", "kernel B70"]);
    let converted = two(|part, frame| {
        frame.group(
            (0x0020, 0x9171),
            made::text((0x0018, 0x1210), "SH", ["B30", "B70"][part]),
        );
    });
    told_apart(&converted, ["kernel B30", "kernel B70"]);
    let kinds = two(|part, frame| {
        let kind = ["DERIVED\\PRIMARY\\VOLUME\\MAXIMUM", "ORIGINAL\\PRIMARY\\VOLUME\\NONE"][part];
        frame.group(made::FRAME_TYPE_GROUP, made::text((0x0008, 0x9007), "CS", kind));
    });
    told_apart(
        &kinds,
        ["DERIVED/PRIMARY/VOLUME/MAXIMUM", "ORIGINAL/PRIMARY/VOLUME/NONE"],
    );
}

#[test]
fn parts_that_say_nothing_are_slices_at_one_place() {
    let error = two(|_, _| ()).folder().refused();
    assert!(error.contains("3 places hold several slices each"), "{error}");
}

#[test]
fn what_a_stack_is_called_is_shown_only_where_it_is_a_code() {
    let secret = two(|part, frame| {
        frame.content(["M\u{fc}ller, Anna", "B"][part], [1, 1]);
    });
    let text = listed(&secret);
    assert!(text.contains("stack unknown") && !text.contains("Anna"), "{text}");
}

#[test]
fn localizers_among_the_frames_are_kept_apart() {
    let mut enhanced = Enhanced::of(5);
    enhanced.frames[4].group(
        made::FRAME_TYPE_GROUP,
        made::text((0x0008, 0x9007), "CS", "ORIGINAL\\PRIMARY\\LOCALIZER\\NONE"),
    );
    let text = listed(&enhanced);
    assert!(text.contains("1 slices of 4 x 3, axial, localizer"), "{text}");
}

#[test]
fn the_order_in_a_stack_is_compared_and_not_believed() {
    let of = |numbers: [u32; 4]| {
        let mut enhanced = Enhanced::of(4);
        for (frame, number) in enhanced.frames.iter_mut().zip(numbers) {
            frame.content("1", [number, 1]);
        }
        (
            volume(&enhanced),
            enhanced.folder().open().unwrap().series_facts().warnings.clone(),
        )
    };
    let (want, warnings) = of([1, 2, 3, 4]);
    assert_eq!((&want, warnings), (&classic(&stack(4)), vec![]));
    assert_eq!(of([4, 3, 2, 1]), (want.clone(), vec![]));
    let (found, warnings) = of([1, 3, 2, 4]);
    assert_eq!(found, want);
    assert!(
        warnings[0].contains("InStackPositionNumber does not follow"),
        "{warnings:?}"
    );
}

/// Frames 0 to 2 and 3 to 5, in a file each.
pub(super) fn halves(change: impl Fn(u16, &mut File)) -> Folder {
    let (whole, folder) = (Enhanced::of(6), Folder::new());
    for part in [0, 1] {
        let mut half = whole.clone();
        half.frames = whole.frames[3 * part..3 * part + 3].to_vec();
        half.base.text((0x0008, 0x0018), "UI", &format!("1.2.3.4.7.{part}"));
        let mut file = half.file();
        change(part as u16 + 1, &mut file);
        folder.put(&format!("{}.dcm", 9 - part), &file.bytes());
    }
    folder
}

pub(super) fn concatenated(number: u16, total: u16, file: &mut File) {
    file.text((0x0020, 0x9161), "UI", "1.2.3.9")
        .us((0x0020, 0x9162), number)
        .us((0x0020, 0x9163), total);
}

#[test]
fn a_concatenation_is_one_volume_and_another_file_of_the_series_another() {
    let folder = halves(|number, file| concatenated(number, 2, file));
    assert_eq!(drink(&mut folder.open().unwrap()).unwrap().0, classic(&stack(6)).0);
    let error = halves(|_, _| ()).open().map(|_| ()).unwrap_err();
    assert!(matches!(error, DicomError::Several { count: 2, .. }), "{error}");
}

#[test]
fn a_concatenation_that_is_not_whole_is_refused() {
    let folder = halves(|number, file| concatenated(number + 1, 3, file));
    let error = folder.refused();
    assert!(error.contains("part 1 of 3 of a volume in several files"), "{error}");
    let folder = halves(|number, file| concatenated(number, 2, file));
    let error = open_path(&folder.path().join("9.dcm"), None, Options::default()).unwrap_err();
    assert!(matches!(error, DicomError::OnePart { number: 1, .. }), "{error}");
}

#[test]
fn files_of_one_frame_are_slices_of_their_series() {
    let folder = Folder::new();
    let whole = Enhanced::of(4);
    for k in 0..4 {
        let mut one = whole.clone();
        one.frames = vec![whole.frames[k].clone()];
        one.base.text((0x0008, 0x0018), "UI", &format!("1.2.3.4.7.{k}"));
        folder.put(&format!("{k}.dcm"), &one.file().bytes());
    }
    assert_eq!(drink(&mut folder.open().unwrap()).unwrap().0, classic(&stack(4)).0);
    let error = open_path(&folder.path().join("1.dcm"), None, Options::default()).unwrap_err();
    assert!(matches!(error, DicomError::OneFile { .. }), "{error}");
}
