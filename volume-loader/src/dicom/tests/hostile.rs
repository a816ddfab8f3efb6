//! Bytes meant to do harm: named errors, in no time and no memory.

use std::io::Cursor;

use proptest::prelude::*;

use super::writer::Coding;
use super::*;
use crate::dicom::header::Header;
use crate::dicom::walk::{WalkError, Walker};

/// The header's fate, from bytes in memory.
pub(super) fn parse(bytes: &[u8]) -> Result<(), FileError> {
    let mut walker = Walker::new(Cursor::new(bytes), bytes.len() as u64);
    match Header::parse(Path::new("hand.dcm"), &mut walker) {
        Ok(_) => Ok(()),
        Err(WalkError::File(error)) => Err(error),
        Err(WalkError::Io(error)) => panic!("no disk here: {error}"),
    }
}

fn with(tag: (u16, u16), value: Value) -> Result<(), FileError> {
    parse(&File::slice(0, 0.0).set(tag, value).bytes())
}

#[test]
fn absurd_lengths_are_refused_without_allocating() {
    let four_gib = Value::Raw("UT", vec![1, 2, 3, 4], u32::MAX - 1);
    let error = with((0x0009, 0x0010), four_gib.clone()).unwrap_err();
    assert!(
        matches!(error, FileError::Truncated { expected, .. } if expected > u64::from(u32::MAX) - 1),
        "{error}"
    );
    let error = with((0x0020, 0x0032), four_gib).unwrap_err();
    assert!(matches!(error, FileError::Truncated { .. }), "{error}");
    let long = Value::Raw("UT", vec![b'1'; 70_000], 70_000);
    let error = with((0x0020, 0x0032), long.clone()).unwrap_err();
    assert!(matches!(error, FileError::TooLong { found: 70_000, .. }), "{error}");
    // Elements that are passed over may be long.
    with((0x0009, 0x0010), long).unwrap();
    let undefined = Value::Raw("UN", vec![], u32::MAX);
    assert!(with((0x0020, 0x0032), undefined).is_err());
}

#[test]
fn nesting_without_end_is_refused() {
    let open = [0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];
    let sequence = [0x08, 0x00, 0x40, 0x11, b'S', b'Q', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF];
    let mut bytes = open.to_vec();
    for _ in 0..10_000 {
        bytes.extend(sequence);
        bytes.extend(open);
    }
    let error = with((0x0008, 0x1140), Value::Raw("SQ", bytes, u32::MAX)).unwrap_err();
    assert!(matches!(error, FileError::Nesting { .. }), "{error}");
}

#[test]
fn open_sequences_and_stray_delimiters_are_refused() {
    let open = vec![0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];
    let mut file = File::slice(0, 0.0);
    file.elements.clear();
    file.set((0x0008, 0x1140), Value::Raw("SQ", open, u32::MAX));
    let error = parse(&file.bytes()).unwrap_err();
    assert!(matches!(error, FileError::BrokenOff { .. }), "{error}");
    let item_end = vec![0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0];
    let error = with((0x0008, 0x1140), Value::Raw("SQ", item_end, u32::MAX)).unwrap_err();
    assert!(matches!(error, FileError::Delimiter { .. }), "{error}");
}

#[test]
fn a_file_of_zeros_is_refused_early() {
    let mut bytes = File::slice(0, 0.0).coded(Coding::Implicit).bytes();
    bytes.truncate(160);
    bytes.resize(30_000_000, 0);
    let error = parse(&bytes).unwrap_err();
    assert!(
        matches!(error, FileError::TooManyElements { byte, .. } if byte < 9_000_000),
        "{error}"
    );
}

#[test]
fn an_element_twice_is_refused() {
    let mut file = File::slice(0, 0.0);
    let position = ((0x0020, 0x0032), Value::Text("DS", "0\\0\\5".to_owned()));
    file.elements.insert(0, position);
    assert!(matches!(parse(&file.bytes()), Err(FileError::Twice { .. })));
}

#[test]
fn pixels_of_another_length_are_refused() {
    for (columns, rows) in [(65_535, 65_535), (5, 3), (3, 3), (0, 3)] {
        let mut files = stack(3);
        for file in &mut files {
            file.us((0x0028, 0x0011), columns).us((0x0028, 0x0010), rows);
        }
        let error = Folder::of(&files).refused_file();
        let named = matches!(error, FileError::PixelLength { .. } | FileError::Value { .. });
        assert!(named, "{columns} x {rows}: {error}");
    }
    let claimed = Value::Raw("OW", vec![0; 10], 24);
    assert!(matches!(
        with((0x7FE0, 0x0010), claimed),
        Err(FileError::Truncated { .. })
    ));
    let fragments = Value::Raw("OW", vec![0; 24], u32::MAX);
    assert!(matches!(
        with((0x7FE0, 0x0010), fragments),
        Err(FileError::Encapsulation { .. })
    ));
}

#[test]
fn every_truncation_is_refused() {
    for coding in [Coding::Explicit, Coding::Implicit, Coding::Big] {
        let bytes = File::slice(1, 2.5).coded(coding).bytes();
        parse(&bytes).unwrap();
        for length in 132..bytes.len() {
            // Before the SOP class a file that holds nothing may be any object, of no use to anybody.
            let cut = parse(&bytes[..length]);
            assert!(cut.is_err() || length < 240, "{coding:?}: {length} of {}", bytes.len());
        }
    }
    // A file that says by its name what it is, but is no longer it.
    let folder = Folder::of(&stack(3));
    folder.put("cut.dcm", &File::slice(9, 99.0).bytes()[..100]);
    assert!(matches!(folder.refused_file(), FileError::NotDicom));
}

#[test]
fn a_file_that_shrinks_while_it_is_read_is_refused() {
    let folder = Folder::of(&stack(3));
    let mut source = folder.open().unwrap();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let file = std::fs::OpenOptions::new()
            .write(true)
            .open(entry.unwrap().path())
            .unwrap();
        file.set_len(300).unwrap();
    }
    let error = drink(&mut source).unwrap_err().to_string();
    assert!(error.contains("ends at byte 300"), "{error}");
}

proptest! {
    #[test]
    fn random_bytes_never_panic(tail in prop::collection::vec(any::<u8>(), 0..600), start in 0..4_u8) {
        let mut bytes = vec![0; 128];
        bytes.extend(b"DICM");
        let syntax = ["1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"];
        if let Some(syntax) = syntax.get(usize::from(start)) {
            let head = File { syntax: (*syntax).to_owned(), elements: vec![], ..File::slice(0, 0.0) };
            bytes = head.bytes();
        }
        bytes.extend(tail);
        let _ = parse(&bytes);
    }

    #[test]
    fn a_flipped_byte_never_panics(at in 0..900_usize, flip in 1..=255_u8, coding in 0..3_usize) {
        let coding = [Coding::Explicit, Coding::Implicit, Coding::Big][coding];
        let mut bytes = File::slice(1, 2.5).coded(coding).bytes();
        let at = at % bytes.len();
        bytes[at] ^= flip;
        let folder = Folder::of(&[File::slice(0, 0.0), File::slice(2, 5.0)]);
        folder.put("flipped.dcm", &bytes);
        if let Ok(mut source) = folder.open() {
            let _ = drink(&mut source);
        }
    }
}
