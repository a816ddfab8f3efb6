//! Headers in every coding, and each element that must be there.

use super::writer::Coding;
use super::*;

#[test]
fn every_coding_gives_the_same_volume() {
    let mut volumes = Vec::new();
    for coding in [Coding::Explicit, Coding::Implicit, Coding::Big] {
        let files: Vec<File> = stack(4).into_iter().map(|file| file.coded(coding)).collect();
        let folder = Folder::of(&files);
        let mut source = folder.open().unwrap();
        assert_eq!(source.grid().dims(), [4, 3, 4]);
        volumes.push((drink(&mut source).unwrap().0, *source.grid()));
    }
    assert_eq!(volumes[0], volumes[1]);
    assert_eq!(volumes[0], volumes[2]);
    let want: Vec<i16> = (0..48).map(|i| 100 * (i / 12) + i % 12 - 1024).collect();
    assert_eq!(volumes[0].0, want);
}

#[test]
fn a_file_without_preamble_is_read_as_implicit() {
    let files: Vec<File> = stack(3)
        .into_iter()
        .map(|file| File {
            preamble: false,
            ..file.coded(Coding::Implicit)
        })
        .collect();
    assert_eq!(Folder::of(&files).open().unwrap().grid().dims(), [4, 3, 3]);
}

#[test]
fn sequences_are_passed_over_in_every_coding() {
    for coding in [Coding::Explicit, Coding::Implicit] {
        let mut files: Vec<File> = stack(3).into_iter().map(|file| file.coded(coding)).collect();
        for file in &mut files {
            // An item of undefined length that holds a series UID of its own and a sequence within.
            let mut inner = vec![0xFE, 0xFF, 0x00, 0xE0, 0xFF, 0xFF, 0xFF, 0xFF];
            let nested = File {
                coding,
                syntax: String::new(),
                preamble: false,
                elements: vec![
                    ((0x0008, 0x1199), Value::Raw("SQ", writer::item(&[]), 8)),
                    ((0x0020, 0x000E), Value::Text("UI", "9.9".to_owned())),
                ],
            };
            inner.extend(nested.bytes());
            inner.extend([0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0, 0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
            file.set((0x0008, 0x1140), Value::Raw("SQ", inner, u32::MAX));
        }
        assert_eq!(Folder::of(&files).open().unwrap().grid().dims(), [4, 3, 3]);
    }
}

#[test]
fn what_is_unknown_and_of_undefined_length_is_implicit_inside() {
    let mut files = stack(3);
    for file in &mut files {
        let mut inner = writer::item(&[]);
        inner[4..8].copy_from_slice(&[0xFF; 4]);
        // An element in implicit coding whose length looks like no representation.
        inner.extend([0x08, 0x00, 0x60, 0x00, 0x02, 0x00, 0x00, 0x00, b'C', b'T']);
        inner.extend([0xFE, 0xFF, 0x0D, 0xE0, 0, 0, 0, 0, 0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
        file.set((0x0009, 0x1010), Value::Raw("UN", inner, u32::MAX));
    }
    assert_eq!(Folder::of(&files).open().unwrap().grid().dims(), [4, 3, 3]);
}

#[test]
fn each_missing_element_is_named() {
    let needed = [
        ((0x0008, 0x0060), "Modality"),
        ((0x0020, 0x0032), "ImagePositionPatient"),
        ((0x0020, 0x0037), "ImageOrientationPatient"),
        ((0x0028, 0x0002), "SamplesPerPixel"),
        ((0x0028, 0x0004), "PhotometricInterpretation"),
        ((0x0028, 0x0010), "Rows"),
        ((0x0028, 0x0011), "Columns"),
        ((0x0028, 0x0030), "PixelSpacing"),
        ((0x0028, 0x0100), "BitsAllocated"),
        ((0x0028, 0x0101), "BitsStored"),
        ((0x0028, 0x0102), "HighBit"),
        ((0x0028, 0x0103), "PixelRepresentation"),
        ((0x0028, 0x1052), "RescaleIntercept"),
        ((0x0028, 0x1053), "RescaleSlope"),
        ((0x7FE0, 0x0010), "PixelData"),
    ];
    for (tag, name) in needed {
        let mut files = stack(3);
        files.iter_mut().for_each(|file| {
            file.remove(tag);
        });
        let error = Folder::of(&files).refused_file();
        assert!(matches!(error, FileError::Missing { .. }), "{name}: {error}");
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
}

#[test]
fn bad_values_are_refused_by_name() {
    let cases: [((u16, u16), Value, &str); 21] = [
        ((0x0020, 0x0032), Value::Text("DS", "1\\2".into()), "\"1\\2\""),
        (
            (0x0020, 0x0032),
            Value::Text("DS", "1\\2\\3\\4".into()),
            "ImagePositionPatient",
        ),
        ((0x0020, 0x0032), Value::Text("DS", "1\\2\\nan".into()), "not numbers"),
        ((0x0020, 0x0032), Value::Text("DS", "1\\2\\1e999".into()), "1e999"),
        ((0x0028, 0x0002), Value::Us(3), "SamplesPerPixel is 3"),
        ((0x0028, 0x0004), Value::Text("CS", "MONOCHROME1".into()), "MONOCHROME1"),
        ((0x0028, 0x0008), Value::Text("IS", "20".into()), "20 frames"),
        (
            (0x0028, 0x0010),
            Value::Raw("US", vec![1, 0, 2, 0], 4),
            "Rows is 4 bytes long",
        ),
        ((0x0028, 0x0010), Value::Us(0), "Rows"),
        ((0x0028, 0x0100), Value::Us(12), "BitsAllocated is 12"),
        ((0x0028, 0x0101), Value::Us(17), "BitsStored is 17"),
        ((0x0028, 0x0102), Value::Us(3), "HighBit is 3"),
        ((0x0028, 0x0103), Value::Us(2), "PixelRepresentation is 2"),
        ((0x0028, 0x1053), Value::Text("DS", "0".into()), "RescaleSlope is 0"),
        (
            (0x0028, 0x1053),
            Value::Text("DS", "1e38".into()),
            "RescaleSlope is 1000",
        ),
        (
            (0x0028, 0x1053),
            Value::Text("DS", "1e-310".into()),
            "RescaleSlope is 0.000",
        ),
        ((0x0028, 0x1053), Value::Text("DS", "1e-5".into()), "span at least 1 HU"),
        (
            (0x0028, 0x1053),
            Value::Text("DS", "inf".into()),
            "RescaleSlope is 3 bytes",
        ),
        (
            (0x0028, 0x1052),
            Value::Text("DS", "1e38".into()),
            "RescaleIntercept is 1000",
        ),
        // Eleven of twelve pixels are beyond 32767 HU.
        (
            (0x0028, 0x1053),
            Value::Text("DS", "40000".into()),
            "pixels are beyond -32768 to 32767 HU",
        ),
        (
            (0x0028, 0x1053),
            Value::Text("DS", "SECRET".into()),
            "6 bytes that are not numbers",
        ),
    ];
    for (tag, value, words) in cases {
        let mut files = stack(3);
        for file in &mut files {
            file.set(tag, value.clone());
        }
        let error = Folder::of(&files).refused();
        assert!(error.contains(words) && !error.contains("SECRET"), "{words}: {error}");
    }
}

#[test]
fn transfer_syntaxes_that_are_not_read_are_named() {
    let cases = [
        ("1.2.840.10008.1.2.1.99", "deflated"),
        ("1.2.840.10008.1.2.4.50", "JPEG baseline"),
        ("1.2.840.10008.1.2.4.201", "HTJ2K"),
        ("1.2.3", "unknown"),
        ("SECRET^NAME", "malformed"),
    ];
    for (syntax, words) in cases {
        let mut files = stack(3);
        files.iter_mut().for_each(|file| syntax.clone_into(&mut file.syntax));
        let error = Folder::of(&files).refused();
        assert!(error.contains(words) && !error.contains("SECRET"), "{error}");
    }
}

#[test]
fn nobody_is_named() {
    let mut files = stack(4);
    files[2].text((0x0020, 0x0032), "DS", "-10\\20\\9");
    let folder = Folder::of(&files);
    let mut told = folder.refused();
    let source = folder.open_with(Options { regrid: true }).unwrap();
    told += &format!("{}{:?}", source.describe(), source.series_facts());
    assert!(told.contains("DICOM CT"), "{told}");
    assert!(!told.contains("SECRET") && !told.contains("1.2.3.4"), "{told}");
}
