//! What should go one way along the stack.

use super::*;

fn told(files: &[File]) -> Vec<String> {
    Folder::of(files).open().unwrap().series_facts().warnings.clone()
}

/// Two phases of contrast that nothing numbered, and positions that somebody had exchanged.
#[test]
fn times_and_locations_that_do_not_follow_the_stack_are_told() {
    let with = |tag: (u16, u16), vr: &'static str, values: [&str; 6]| {
        let mut files = stack(6);
        for (file, value) in files.iter_mut().zip(values) {
            file.text(tag, vr, value);
        }
        told(&files)
    };
    let times = |values: [&str; 6]| with((0x0008, 0x0032), "TM", values);
    for (values, words) in [
        (
            ["120000", "120030", "120001", "120031", "120002", "120032"],
            "up to 30 s apart and go both ways along the stack",
        ),
        (
            ["120000", "120001", "120002", "120500.75", "120501", "120502"],
            "up to 299 s apart: ",
        ),
        (
            ["120000", "120012", "120012", "120000", "120000", "120000"],
            "up to 12 s apart and go both ways",
        ),
    ] {
        let warnings = times(values);
        assert!(warnings.len() == 1 && warnings[0].contains(words), "{warnings:?}");
    }
    for values in [
        ["120000"; 6],
        ["120000", "120001", "120002", "120003", "120003.5", "120004"],
        ["120100", "120050", "120040", "120030", "120020", "120010"],
        // A turn's slices, and a breath behind it.
        ["120003", "120002", "120001", "120033", "120032", "120031"],
        ["120000", "120030", "120001", "", "120002", "120032"],
        ["nonsense", "120030", "120001", "120000", "120002", "120032"],
    ] {
        assert_eq!(times(values), Vec::<String>::new(), "{values:?}");
    }
    // By date and time in one element, whatever the others say.
    let both = [
        "20240101120000",
        "20240201120000",
        "20240101120001",
        "20240201120001",
        "20240101120002",
        "20240201120002",
    ];
    for time in ["", "120000"] {
        let mut files = stack(6);
        for (file, value) in files.iter_mut().zip(both) {
            file.text((0x0008, 0x002A), "DT", value)
                .text((0x0008, 0x0032), "TM", time);
        }
        let days = told(&files);
        assert!(
            days.len() == 1 && days[0].contains("up to 2678400 s apart and go both ways"),
            "{days:?}"
        );
    }
    let places = |values: [&str; 6]| with((0x0020, 0x1041), "DS", values);
    let exchanged = places(["0", "2.5", "7.5", "5", "10", "12.5"]);
    assert!(
        exchanged.len() == 1 && exchanged[0].starts_with("SliceLocation does not follow"),
        "{exchanged:?}"
    );
    for values in [
        ["1", "3.5", "6", "8.5", "11", "13.5"],
        ["9", "8", "7", "6", "5", "4"],
        ["0"; 6],
        ["0", "2.5", "", "5", "7", "x"],
    ] {
        assert_eq!(places(values), Vec::<String>::new(), "{values:?}");
    }
}
