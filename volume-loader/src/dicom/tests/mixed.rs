//! Slices of one series that are of several scans, or follow no order: told with how many say what.

use super::*;

const ACQUISITION: (u16, u16) = (0x0020, 0x0012);

/// An element, what it is in some slices and in others, and the words it is told by.
type Case<'a> = ((u16, u16), &'static str, [&'a str; 2], &'a str);

fn told(files: &[File]) -> Vec<String> {
    Folder::of(files).open().unwrap().series_facts().warnings.clone()
}

/// With this value in every slice, and another in the last `count`.
fn with(tag: (u16, u16), vr: &'static str, [value, other]: [&str; 2], count: usize) -> Vec<File> {
    let mut files = stack(6);
    for (k, file) in files.iter_mut().enumerate() {
        file.text(tag, vr, if k + count < 6 { value } else { other });
    }
    files
}

/// Two scans, or two phases of contrast, were one volume without a word.
#[test]
fn slices_of_several_scans_are_told_with_how_many_there_are_of_each() {
    let cases: [Case<'_>; 15] = [
        (
            ACQUISITION,
            "IS",
            ["4", "5"],
            "(0020,0012) AcquisitionNumber # 4 in 4, 5 in 2:",
        ),
        (
            (0x0008, 0x0017),
            "UI",
            ["1.2.SECRET", "1.3"],
            "(0008,0017) AcquisitionUID # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x0020),
            "DA",
            ["20200101", "20200102"],
            "(0008,0020) StudyDate # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x0021),
            "DA",
            ["20200101", ""],
            "(0008,0021) SeriesDate # one value in 4, none in 2:",
        ),
        (
            (0x0008, 0x0022),
            "DA",
            ["20200101", "20200102"],
            "(0008,0022) AcquisitionDate # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x0023),
            "DA",
            ["20200101", "20200102"],
            "(0008,0023) ContentDate # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x0050),
            "SH",
            ["SECRET", "SECRET 2"],
            "(0008,0050) AccessionNumber # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x103E),
            "LO",
            ["SECRET", "SECRET B"],
            "(0008,103E) SeriesDescription # one value in 4, another in 2:",
        ),
        (
            (0x0008, 0x1090),
            "LO",
            ["SECRET", "B"],
            "(0008,1090) ManufacturerModelName # one value in 4, another in 2:",
        ),
        (
            (0x0018, 0x1000),
            "LO",
            ["SECRET", "B"],
            "(0018,1000) DeviceSerialNumber # one value in 4, another in 2:",
        ),
        (
            (0x0018, 0x0010),
            "LO",
            ["SECRET", ""],
            "(0018,0010) ContrastBolusAgent # one value in 4, none in 2:",
        ),
        (
            (0x0018, 0x0060),
            "DS",
            ["120", "80"],
            "(0018,0060) KVP # 120 in 4, 80 in 2:",
        ),
        (
            (0x0008, 0x0008),
            "CS",
            ["ORIGINAL\\PRIMARY\\AXIAL", "DERIVED\\PRIMARY\\MPR"],
            "(0008,0008) ImageType # ORIGINAL/PRIMARY/AXIAL in 4, DERIVED/PRIMARY/MPR in 2:",
        ),
        (
            (0x0018, 0x0050),
            "DS",
            ["0.6", "5"],
            "(0018,0050) SliceThickness # 0.6 in 4, 5 in 2:",
        ),
        (
            (0x0028, 0x1054),
            "LO",
            ["HU", "US"],
            "(0028,1054) RescaleType # HU in 4, US in 2:",
        ),
    ];
    for (tag, vr, values, words) in cases {
        let warnings = told(&with(tag, vr, values, 2));
        let words = words.replace('#', "is not the same in all slices:");
        assert!(
            warnings.iter().any(|said| said.starts_with(&words)),
            "{words}: {warnings:?}"
        );
        let said = warnings.join("; ");
        assert!(!said.contains("SECRET") && !said.contains("2020"), "{said}");
        // Alike, nothing is told but what the values themselves are.
        let alike = told(&with(tag, vr, [values[0], values[0]], 2));
        assert_eq!(alike, Vec::<String>::new(), "{words}");
    }
}

#[test]
fn one_number_in_two_ways_of_writing_and_a_type_that_is_not_said_are_no_difference() {
    for (tag, vr, values) in [
        ((0x0018, 0x0060), "DS", ["120", "1.200E2 "]),
        (ACQUISITION, "IS", ["4", "+04"]),
        (ACQUISITION, "IS", ["SECRET", "NAME"]),
        ((0x0028, 0x1054), "LO", ["HU", ""]),
        ((0x0028, 0x1053), "DS", ["1", "1.0"]),
        ((0x0018, 0x0010), "LO", ["IOPAMIDOL", "IOPAMIDOL "]),
    ] {
        assert_eq!(told(&with(tag, vr, values, 3)), Vec::<String>::new(), "{tag:?}");
    }
}

/// The worst mixture: every second slice is of another scan, and the stack is even.
#[test]
fn scans_that_alternate_along_the_stack_are_told_as_such() {
    let numbered = |numbers: [&str; 6]| {
        let mut files = stack(6);
        for (file, number) in files.iter_mut().zip(numbers) {
            file.text(ACQUISITION, "IS", number);
        }
        let warnings = told(&files);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings[0].clone()
    };
    let turns = numbered(["1", "2", "1", "2", "1", "2"]);
    assert!(turns.contains("1 in 3, 2 in 3, in turns along the stack: "), "{turns}");
    let halves = numbered(["2", "2", "2", "1", "1", "1"]);
    assert!(halves.contains("1 in 3, 2 in 3: "), "{halves}");
    // A scanner that counts each turn of its tube.
    let each = numbered(["1", "2", "3", "4", "5", "6"]);
    assert!(
        each.contains("1 in 1, 2 in 1, 3 in 1, 4 in 1 and 2 more values: "),
        "{each}"
    );
}

/// PET scales each slice for itself: each has its own numbers, and for a CT it is told.
#[test]
fn each_slice_has_its_own_slope_and_intercept() {
    for modality in ["CT", "PT"] {
        let mut files = stack(4);
        for (k, file) in files.iter_mut().enumerate() {
            file.text((0x0008, 0x0060), "CS", modality)
                .text((0x0028, 0x1053), "DS", &(k + 1).to_string())
                .text((0x0028, 0x1052), "DS", &format!("-{}", 10 * k));
        }
        let folder = Folder::of(&files);
        let mut source = folder.open().unwrap();
        let warnings = source.series_facts().warnings.clone();
        let (voxels, _) = drink(&mut source).unwrap();
        for (at, hu) in voxels.iter().enumerate() {
            let (k, pixel) = (at / 12, at % 12);
            assert_eq!(
                usize::try_from(i32::from(*hu) + 10 * k as i32),
                Ok((k + 1) * (100 * k + pixel))
            );
        }
        let said = warnings
            .iter()
            .filter(|said| said.contains("each slice's own is taken"))
            .count();
        assert_eq!(said, if modality == "CT" { 2 } else { 0 }, "{warnings:?}");
    }
}

#[test]
fn a_value_without_end_of_what_is_only_told_refuses_no_slice() {
    let mut files = stack(4);
    files[1].set((0x0018, 0x0010), Value::Raw("UN", vec![b'x'; 70_000], 70_000));
    Folder::of(&files).open().unwrap();
}

/// The last slices had another spacing, were a series of their own in the list, and nothing said that the volume ended too early.
#[test]
fn slices_of_the_series_that_are_listed_apart_are_told() {
    let mut files = stack(8);
    for file in &mut files[5..] {
        file.text((0x0028, 0x0030), "DS", "0.76\\0.5");
    }
    let mut scout = File::slice(0, 0.0);
    scout.text((0x0008, 0x0008), "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
    let folder = Folder::of(&files);
    folder.put("scout.dcm", &scout.bytes());
    let found = Series::scan(folder.path()).unwrap();
    let of_slices = |count: usize| {
        found
            .series
            .iter()
            .find(|series| series.headers.len() == count)
            .unwrap()
    };
    for (slices, others) in [(5, 3), (3, 5)] {
        let source = DicomSource::open(of_slices(slices), Options::default()).unwrap();
        let warnings = &source.series_facts().warnings;
        let words = format!("{others} more slices of this series (SeriesInstanceUID) are listed apart");
        assert!(warnings.len() == 1 && warnings[0].starts_with(&words), "{warnings:?}");
    }
    // A scout beside them is none.
    let folder = Folder::of(&stack(4));
    folder.put("scout.dcm", &scout.bytes());
    let found = Series::scan(folder.path()).unwrap();
    let slices = found.series.iter().find(|series| !series.is_localizer()).unwrap();
    let source = DicomSource::open(slices, Options::default()).unwrap();
    assert_eq!(source.series_facts().warnings, Vec::<String>::new());
}
