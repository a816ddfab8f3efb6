//! Each bad file by its name, and no bytes at all that make a panic.

use geometry::GridError;
use proptest::prelude::*;

use super::*;
use crate::raster::NamesError;
use crate::raster::test_files::{every_flip, every_truncation, zlib};
use crate::source::Place;

fn refused(changes: &[&str]) -> MetaImageError {
    refused_bytes(&hand(changes, &counted()))
}

fn refused_bytes(bytes: &[u8]) -> MetaImageError {
    match read_bytes(bytes) {
        Err(ReadError::MetaImage { source, .. }) => source,
        other => panic!("expected a refused header, found {other:?}"),
    }
}

#[test]
fn headers_are_refused_by_name() {
    use MetaImageError as E;
    assert!(matches!(refused_bytes(b"NRRD0004\n\n"), E::NotMetaImage));
    assert!(matches!(
        refused_bytes(b"NDims = 3\nDoe^John\n"),
        E::Line { line: 2, bytes: 8 }
    ));
    assert!(matches!(
        refused(&["Position = 1 0 0"]),
        E::Duplicate {
            line: 10,
            first: 6,
            field: "Offset"
        }
    ));
    for field in [
        "NDims=",
        "DimSize=",
        "ElementType=",
        "BinaryDataByteOrderMSB=",
        "ElementSpacing=",
    ] {
        assert!(matches!(refused(&[field]), E::Missing { .. }), "{field}");
    }
    assert!(matches!(
        refused_bytes(b"NDims = 3\n"),
        E::Missing {
            field: "ElementDataFile",
            ..
        }
    ));
    for field in ["TransformMatrix=", "Offset="] {
        assert!(matches!(refused(&[field]), E::NoOrientation { .. }), "{field}");
    }
    let twice = "TransformMatrix = 1 0 0 0 2 0 0 0 1";
    assert!(matches!(refused(&[twice]), E::Length { line: 5, axis: 1, .. }));
    assert!(matches!(
        refused(&["TransformMatrix = 1 0 0 0 nan 0 0 0 1"]),
        E::Length { .. }
    ));
    let flat = "TransformMatrix = 1 0 0 1 0 0 0 0 1";
    assert!(matches!(refused(&[flat]), E::Grid(GridError::Flat { .. })));
    assert!(matches!(
        refused(&["DimSize = 2 3 -2"]),
        E::Grid(GridError::Dim { axis: 2, .. })
    ));
    let long = "Comment = filler\n".repeat(100_000);
    assert!(matches!(refused_bytes(long.as_bytes()), E::Endless { .. }));
}

#[test]
fn values_are_refused_with_line_and_text() {
    for bad in [
        "ObjectType = Tube",
        "NDims = 4",
        "NDims = three",
        "BinaryData = Perhaps",
        "BinaryDataByteOrderMSB = Little",
        "CompressedData = zlib",
        "CompressedDataSize = -5",
        "TransformMatrix = 1 0 0 0 1 0 0 0",
        "Offset = 0 0 inf",
        "Offset = 0 0",
        "CenterOfRotation = 0 0 1",
        "DistanceUnits = inch",
        "ElementSpacing = 1 1 -1",
        "ElementSpacing = 1 1",
        "DimSize = 2 3",
        "DimSize = 2 3 2 1",
        "HeaderSize = -2",
        "HeaderSize = 10",
        "HeaderSizesPerDataFile = 0 512",
        "ElementNumberOfChannels = 3",
        "ElementType = MET_LONG",
        "ElementType = MET_FLOAT_ARRAY",
        "ElementToIntensityFunctionSlope = 2",
        "ElementToIntensityFunctionOffset = -1024",
        "ElementDataFile = LIST two",
    ] {
        let error = refused(&[bad]);
        let MetaImageError::Value { line, field, found, .. } = &error else {
            panic!("{bad}: {error:?}");
        };
        let (name, text) = bad.split_once(" = ").unwrap();
        assert!(
            (1..=10).contains(line) && *field == name && found == text,
            "{bad}: {error}"
        );
    }
    let both = ["BinaryData = False", "CompressedData = True"];
    assert!(matches!(
        refused(&both),
        MetaImageError::Value {
            field: "CompressedData",
            ..
        }
    ));
    let packed = ["CompressedData = True", "HeaderSize = -1"];
    assert!(matches!(
        refused(&packed),
        MetaImageError::Value {
            field: "HeaderSize",
            ..
        }
    ));
}

/// Centimetres and an origin were passed over where the field was written in other letters.
#[test]
fn fields_in_other_letters_are_not_passed_over() {
    for line in [
        "distanceUnits = cm",
        "OFFSET = 1 2 3",
        "position = 1 2 3",
        "Headersize = 4",
        "anatomicalorientation = LPI",
        "elementdatafile = a.raw",
    ] {
        let found = refused(&[line]);
        assert!(
            matches!(found, MetaImageError::Letters { line: 10, .. }),
            "{line}: {found}"
        );
    }
}

#[test]
fn files_elsewhere_are_refused_by_name() {
    let source = |text: &str| match refused(&[text]) {
        MetaImageError::Files { line: 10, source } => source,
        other => panic!("{other:?}"),
    };
    assert!(matches!(
        source("ElementDataFile = /etc/passwd"),
        NamesError::Outside { .. }
    ));
    assert!(matches!(
        source("ElementDataFile = ../x.raw"),
        NamesError::Outside { .. }
    ));
    assert!(matches!(
        source("ElementDataFile = x%d.raw 1 3 1"),
        NamesError::Count { .. }
    ));
    assert!(matches!(source("ElementDataFile = "), NamesError::Empty));
}

#[test]
fn nothing_that_could_name_a_patient_is_repeated() {
    for text in [
        "0010|0010 = Doe^John\nDoe^John\n",
        "Name = Doe\nNDims = 5\nElementDataFile = LOCAL\n",
        "Doe^John\n",
    ] {
        assert!(!refused_bytes(text.as_bytes()).to_string().contains("Doe"), "{text}");
    }
}

#[test]
fn wrong_lengths_are_refused_with_numbers() {
    let whole = hand(&[], &counted());
    every_truncation(&whole, |bytes| read_bytes(bytes).is_ok());
    let error = read_bytes(&whole[..whole.len() - 5]).unwrap_err();
    let ReadError::Truncated {
        place: Place::Slice(1),
        expected,
        found,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(expected - found, 5);
    let packed = zlib(&counted());
    let size = format!("CompressedDataSize = {}", packed.len());
    let whole = hand(&["CompressedData = True", &size], &packed);
    every_truncation(&whole, |bytes| read_bytes(bytes).is_ok());
    // A stream that is said to be shorter than it is breaks off there.
    let short = hand(&["CompressedData = True", "CompressedDataSize = 9"], &packed);
    assert!(matches!(read_bytes(&short), Err(ReadError::BrokenOff { .. })));
    let bomb = hand(&["CompressedData = True"], &zlib(&vec![0; 50_000_000]));
    assert!(matches!(read_bytes(&bomb), Err(ReadError::TooLong { found, .. }) if found < 100_000));
    let long = hand(&[], &vec![0; 90_000]);
    assert!(matches!(read_bytes(&long), Err(ReadError::TooLong { .. })));
    let huge = hand(&["DimSize = 9000 9000 16"], &counted());
    assert!(matches!(read_bytes(&huge), Err(ReadError::Truncated { .. })));
    let last = hand(&["DimSize = 9000 9000 16", "HeaderSize = -1"], &counted());
    assert!(matches!(
        read_bytes(&last),
        Err(ReadError::Truncated {
            place: Place::Header,
            ..
        })
    ));
}

#[test]
fn damage_to_compressed_voxels_is_noticed() {
    let packed = zlib(&counted());
    let mut damaged = packed.clone();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    let error = read_bytes(&hand(&["CompressedData = True"], &damaged)).unwrap_err();
    assert!(matches!(error, ReadError::Corrupt { .. }), "{error}");
}

#[test]
fn flipped_bytes_never_panic() {
    every_flip(&hand(&["HeaderSize = 0"], &counted()), |bytes| drop(read_bytes(bytes)));
    every_flip(&hand(&["CompressedData = True"], &zlib(&counted())), |bytes| {
        drop(read_bytes(bytes))
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), plausible: bool) {
        let head = if plausible { &b"NDims = 3\n"[..] } else { b"" };
        let _ = read_bytes(&[head, &bytes].concat());
    }

    #[test]
    fn random_values_never_panic(which in 0..LINES.len(), value in "[-0-9a-zA-Z(),.% \"]{0,20}") {
        let (field, _) = LINES[which].split_once('=').unwrap();
        let _ = read_bytes(&hand(&[&format!("{field}= {value}")], &counted()));
    }
}
