//! Functional groups and numbers of frames that are made to do harm.

use proptest::prelude::*;

use super::made::{PER_FRAME, SHARED};
use super::*;
use crate::dicom::tests::hostile::parse;

fn counted(count: &str) -> String {
    let mut enhanced = Enhanced::of(3);
    enhanced.count = Some(count.to_owned());
    enhanced.folder().refused()
}

#[test]
fn numbers_of_frames_that_cannot_be_are_refused() {
    for count in ["0", "-3", "16385", "2147483648", "1e300"] {
        let error = counted(count);
        assert!(
            error.contains("NumberOfFrames") && error.contains("from 1 to 16384"),
            "{count}: {error}"
        );
    }
    assert!(counted("2.5").contains("NumberOfFrames is 2.5"));
    assert!(counted("").contains("NumberOfFrames is missing"));
}

#[test]
fn frames_and_groups_must_be_as_many() {
    let error = counted("2");
    assert!(
        error.contains("has more than 2 items, expected 2: one for each frame"),
        "{error}"
    );
    let error = counted("16384");
    assert!(error.contains("has 3 items, expected 16384"), "{error}");
    let mut file = Enhanced::of(3).file();
    file.remove(PER_FRAME);
    let error = Folder::of(&[file]).refused();
    assert!(
        error.contains("PerFrameFunctionalGroupsSequence has 0 items, expected 3"),
        "{error}"
    );
    let mut file = Enhanced::of(3).file();
    file.set(SHARED, Value::Items(vec![vec![], vec![]], false));
    let error = Folder::of(&[file]).refused();
    assert!(
        error.contains("SharedFunctionalGroupsSequence has more than one item"),
        "{error}"
    );
}

#[test]
fn frames_and_pixels_must_be_as_many() {
    for count in [2, 4] {
        let mut enhanced = Enhanced::of(count);
        enhanced.pixels = Some(Value::Raw("OW", vec![0; 72], 72));
        let error = enhanced.folder().refused();
        let words = format!("72 bytes long, expected {} for {count} frames", 24 * count);
        assert!(error.contains(&words), "{error}");
    }
}

#[test]
fn a_group_with_several_items_is_refused() {
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[1].elements[0].1 = Value::Items(vec![vec![], vec![]], false);
    let error = enhanced.folder().refused();
    assert!(
        error.contains("frame 2: (0020,9113) PlanePositionSequence has more than one item, expected one"),
        "{error}"
    );
}

#[test]
fn a_group_or_a_value_twice_is_refused() {
    let mut enhanced = Enhanced::of(3);
    let again = enhanced.frames[2].elements[0].clone();
    enhanced.frames[2].elements.push(again);
    assert!(enhanced.folder().refused().contains("frame 3: element (0020,9113)"));
    let mut enhanced = Enhanced::of(3);
    let mut twice = made::text((0x0020, 0x0032), "DS", "1\\2\\3");
    twice.extend(twice.clone());
    enhanced.frames[0].group(POSITION_GROUP, twice);
    assert!(enhanced.folder().refused().contains("frame 1: element (0020,0032)"));
}

#[test]
fn values_that_are_none_are_named_with_their_frame() {
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[1].group(POSITION_GROUP, made::text((0x0020, 0x0032), "DS", "SECRET"));
    let error = enhanced.folder().refused();
    assert!(
        error.contains("frame 2: element (0020,0032)") && !error.contains("SECRET"),
        "{error}"
    );
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[1].group(made::CONTENT_GROUP, vec![((0x0020, 0x9057), Value::Us(1))]);
    assert!(
        enhanced
            .folder()
            .refused()
            .contains("InStackPositionNumber is 2 bytes long")
    );
    let mut enhanced = Enhanced::of(3);
    enhanced.frames[1].group(TRANSFORMATION, made::transformation("0", "0"));
    let error = enhanced.folder().refused();
    assert!(
        error.contains("frame 2: element (0028,1053) RescaleSlope is 0"),
        "{error}"
    );
}

/// The bytes of a file whose per-frame groups are these.
fn with_groups(bytes: Vec<u8>, length: u32) -> Vec<u8> {
    Enhanced::of(3)
        .file()
        .set(PER_FRAME, Value::Raw("SQ", bytes, length))
        .bytes()
}

const OPEN_ITEM: [u8; 8] = [0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];

#[test]
fn two_thousand_million_items_are_refused_at_the_first_too_many() {
    let error = parse(&with_groups(OPEN_ITEM.to_vec(), 1 << 31)).unwrap_err();
    assert!(matches!(error, FileError::Truncated { .. }), "{error}");
    let many: Vec<u8> = [0xFE, 0xFF, 0x00, 0xE0, 0, 0, 0, 0].repeat(1 << 20);
    let error = parse(&with_groups(many, u32::MAX)).unwrap_err();
    assert!(matches!(error, FileError::Items { .. }), "{error}");
}

#[test]
fn groups_nested_without_end_are_refused() {
    let mut bytes = OPEN_ITEM.to_vec();
    for _ in 0..10_000 {
        bytes.extend([0x08, 0x00, 0x40, 0x11, b'S', b'Q', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]);
        bytes.extend(OPEN_ITEM);
    }
    let error = parse(&with_groups(bytes, u32::MAX)).unwrap_err().to_string();
    assert!(error.contains("nested deeper than 32"), "{error}");
}

#[test]
fn an_item_that_reaches_beyond_its_sequence_is_refused() {
    // An item of 64 bytes in a sequence of 16.
    let mut bytes = vec![0xFE, 0xFF, 0x00, 0xE0, 64, 0, 0, 0];
    bytes.extend([0x09, 0x00, 0x10, 0x00, b'L', b'O', 56, 0]);
    bytes.extend([b' '; 56]);
    let error = parse(&with_groups(bytes, 16)).unwrap_err();
    assert!(matches!(error, FileError::Overrun { .. }), "{error}");
    // An element of 8 bytes in an item of 12.
    let mut bytes = vec![0xFE, 0xFF, 0x00, 0xE0, 12, 0, 0, 0];
    bytes.extend([0x09, 0x00, 0x10, 0x00, b'L', b'O', 8, 0]);
    bytes.extend([b' '; 8]);
    let length = bytes.len() as u32;
    let error = parse(&with_groups(bytes, length)).unwrap_err();
    assert!(error.to_string().contains("frame 1: (FFFE,E000)"), "{error}");
}

#[test]
fn what_stands_between_items_and_stray_delimiters_are_refused() {
    let stray = [
        vec![0x08, 0x00, 0x60, 0x00, b'C', b'S', 2, 0, b'C', b'T'],
        vec![0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0],
    ];
    for bytes in stray {
        let length = bytes.len() as u32;
        for length in [length, u32::MAX] {
            let error = parse(&with_groups(bytes.clone(), length)).unwrap_err();
            assert!(matches!(error, FileError::Delimiter { .. }), "{error}");
        }
    }
}

#[test]
fn groups_of_unknown_representation_are_implicit_inside() {
    let want = volume(&Enhanced::of(3));
    for open in [false, true] {
        let mut file = Enhanced {
            open,
            ..Enhanced::of(3)
        }
        .file();
        for (_, value) in file.elements.iter_mut().filter(|row| row.0.0 == 0x5200) {
            if let Value::Items(items, _) = value {
                let bytes = writer::sequence(Coding::Implicit, items, open);
                let length = if open { u32::MAX } else { bytes.len() as u32 };
                *value = Value::Raw("UN", bytes, length);
            }
        }
        let folder = Folder::of(&[file]);
        let mut source = folder.open().unwrap();
        assert_eq!(drink(&mut source).unwrap().0, want.0, "delimiters: {open}");
    }
}

#[test]
fn groups_twice_are_refused() {
    let mut file = Enhanced::of(3).file();
    let groups = file.elements.iter().find(|row| row.0 == PER_FRAME).cloned().unwrap();
    file.elements.push(groups);
    file.elements.sort_by_key(|row| row.0);
    assert!(matches!(parse(&file.bytes()), Err(FileError::Twice { .. })));
}

#[test]
fn every_truncation_of_a_file_with_frames_is_refused() {
    for (coding, open) in [
        (Coding::Explicit, false),
        (Coding::Explicit, true),
        (Coding::Implicit, false),
    ] {
        let enhanced = Enhanced {
            coding,
            open,
            ..Enhanced::of(3)
        };
        let bytes = enhanced.file().bytes();
        parse(&bytes).unwrap();
        for length in 260..bytes.len() {
            assert!(
                parse(&bytes[..length]).is_err(),
                "{coding:?}: {length} of {}",
                bytes.len()
            );
        }
    }
}

#[test]
fn a_multi_frame_file_of_another_class_is_refused_by_name() {
    let mut enhanced = Enhanced::of(3);
    enhanced.class = "1.2.840.10008.5.1.4.1.1.7.3";
    let error = enhanced.folder().refused();
    assert!(
        error.contains("3 frames in one file are read of Enhanced CT"),
        "{error}"
    );
}

proptest! {
    #[test]
    fn a_flipped_byte_never_panics(at: usize, flip in 1..=255_u8, open: bool, implicit: bool) {
        let coding = if implicit { Coding::Implicit } else { Coding::Explicit };
        let mut bytes = Enhanced { coding, open, ..Enhanced::of(3) }.file().bytes();
        let at = at % bytes.len();
        bytes[at] ^= flip;
        let folder = Folder::new();
        folder.put("flipped.dcm", &bytes);
        if let Ok(mut source) = folder.open() {
            let _ = drink(&mut source);
        }
    }
}
