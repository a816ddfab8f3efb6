//! Each bad file by its name, and no bytes at all that make a panic.

use geometry::GridError;
use proptest::prelude::*;

use super::*;
use crate::raster::NamesError;
use crate::raster::test_files::{every_flip, every_truncation, gzip};
use crate::source::{Place, Scratch, VoxelSource};

fn refused(changes: &[&str]) -> NrrdError {
    refused_bytes(&hand(changes, &counted()))
}

fn refused_bytes(bytes: &[u8]) -> NrrdError {
    match read_bytes(bytes) {
        Err(ReadError::Nrrd { source, .. }) => source,
        other => panic!("expected a refused header, found {other:?}"),
    }
}

#[test]
fn headers_are_refused_by_name() {
    use NrrdError as E;
    assert!(matches!(refused_bytes(b"NRDR0004\n\n"), E::Magic { .. }));
    for version in [
        "NRRD0006\n\n",
        "NRRD0000\n\n",
        "NRRD00004\n\n",
        "NRRD\n\n",
        "NRRD000+4\n\n",
    ] {
        assert!(
            matches!(refused_bytes(version.as_bytes()), E::Version { .. }),
            "{version}"
        );
    }
    assert!(matches!(refused(&["colour: red"]), E::Unknown { line: 10, .. }));
    assert!(matches!(
        refused_bytes(b"NRRD0004\nDoe^John\n\n"),
        E::Line { line: 2, bytes: 8 }
    ));
    let twice = b"NRRD0004\ntype: short\nTYPE: int\n\n";
    assert!(matches!(
        refused_bytes(twice),
        E::Duplicate {
            line: 3,
            first: 2,
            field: "type"
        }
    ));
    for field in ["type:", "dimension:", "sizes:", "endian:", "encoding:"] {
        assert!(matches!(refused(&[field]), E::Missing { .. }), "{field}");
    }
    assert!(matches!(
        refused(&["kinds: RGB-color domain domain"]),
        E::Kind { line: 10, axis: 0, .. }
    ));
    assert!(matches!(refused(&["old min: 0"]), E::Quantised { .. }));
    assert!(matches!(refused(&["spacings: 1 1 2"]), E::Disagreement { axis: 2, .. }));
    assert!(matches!(refused(&["space directions:"]), E::NoOrientation { .. }));
    assert!(matches!(refused(&["space:"]), E::NoOrientation { .. }));
    assert!(matches!(refused(&["space: scanner-xyz"]), E::NoOrientation { .. }));
    assert!(matches!(
        refused(&["space directions:", "space:", "spacings: 1 1 1"]),
        E::NoOrientation { .. }
    ));
    assert!(matches!(refused(&["space origin:"]), E::NoOrigin));
    assert!(matches!(
        refused(&["sizes: 2 3 0"]),
        E::Grid(GridError::Dim { axis: 2, .. })
    ));
    assert!(matches!(
        refused(&["space directions: (nan,0,0) (0,1,0) (0,0,1)"]),
        E::Grid(GridError::NotFinite)
    ));
    assert!(matches!(
        refused(&["space directions: (1,0,0) (1,0,0) (0,0,1)"]),
        E::Grid(GridError::Flat { .. })
    ));
    assert!(matches!(
        refused_bytes(hand(&[], &[]).trim_ascii_end()),
        E::NoVoxels { .. }
    ));
    let long = [&b"NRRD0004\n"[..], "# filler\n".repeat(200_000).as_bytes()].concat();
    assert!(matches!(refused_bytes(&long), E::Endless { .. }));
}

/// Metres were read as mm: beside directions nobody looked at the units of the array's axes, and at keys by the names of fields never.
#[test]
fn a_unit_or_a_space_that_is_said_elsewhere_is_not_passed_over() {
    let read = |more: &[&str]| read_bytes(&hand(more, &counted()));
    for more in [
        &["units: \"m\" \"m\" \"m\""][..],
        &["units: \"mm\" \"mm\" \"cm\""],
        &["units: m m m"],
        &["units: \"inch\" \"inch\" \"inch\""],
        &["units: \"mm\" \"mm\" \"mm\"", "space units: \"m\" \"m\" \"m\""],
    ] {
        let error = read(more).unwrap_err().to_string();
        assert!(
            error.contains("line 10: units is") && error.contains("expected mm"),
            "{more:?}: {error}"
        );
    }
    for more in [
        &["units: \"mm\" \"mm\" \"mm\""][..],
        &["units: \"\" \"\" \"\""],
        &["units: \"cm\" \"cm\" \"cm\"", "space units: \"cm\" \"cm\" \"cm\""],
        &["Author:=units of space"],
    ] {
        read(more).unwrap_or_else(|error| panic!("{more:?}: {error}"));
    }
    for key in [
        "space:=RAS",
        "Space Units:=\"m\"",
        "units:=m",
        "sizes:=9 9 9",
        "endian:=big",
        "byte skip:=8",
    ] {
        assert!(read(&[key]).unwrap_err().to_string().contains("before :="), "{key}");
    }
}

#[test]
fn values_are_refused_with_line_and_text() {
    for bad in [
        "type: block",
        "type: half",
        "dimension: 2",
        "dimension: 5",
        "dimension: three",
        "sizes: 2 3 2.5",
        "space: 3D-left-handed",
        "space: left-posterior-superior-time",
        "space directions: (1,0,0) (0,1,0) none",
        "space directions: (1,0,0) (0,1,0) (0,0,1",
        "space directions: (1,0,0) (0,1,0) (0,0,1,0)",
        "space directions: 1 1 1",
        "space origin: (0,0)",
        "space origin: 0 0 0",
        "space units: mm mm mm",
        "space units: \"inch\" \"inch\" \"inch\"",
        "space dimension: 2",
        "centers: corner cell cell",
        "endian: middle",
        "encoding: bzip2",
        "encoding: bz2",
        "line skip: -1",
        "byte skip: -2",
        "byte skip: 99999999999",
        "data file: LIST two",
    ] {
        let error = refused(&[bad]);
        let NrrdError::Value { line, field, found, .. } = &error else {
            panic!("{bad}: {error:?}");
        };
        let (name, text) = bad.split_once(": ").unwrap();
        assert!(
            (2..=10).contains(line) && *field == name && found == text,
            "{bad}: {error}"
        );
    }
    let long = format!("type: {}", "x".repeat(500));
    assert!(refused(&[&long]).to_string().len() < 250);
    assert!(matches!(
        refused(&["encoding: gzip", "byte skip: -1"]),
        NrrdError::Value { .. }
    ));
    let four = [
        "dimension: 4",
        "sizes: 3 2 3 2",
        "space directions: none (1,0,0) (0,1,0) (0,0,1)",
    ];
    assert!(matches!(refused(&four), NrrdError::Value { field: "sizes", .. }));
}

/// Entries that were missing were passed over, and so were those too many: kinds, spacings and mins of another volume.
#[test]
fn a_list_that_is_shorter_or_longer_than_the_axes_is_refused_with_counts() {
    for (bad, found, expected) in [
        ("sizes: 2 3", 2, 3),
        ("sizes: 2 3 2 1", 4, 3),
        ("spacings: 1 1", 2, 3),
        ("spacings: 1 1 1 1", 4, 3),
        ("thicknesses: nan nan 1 1", 4, 3),
        ("axis mins: 0 0", 2, 3),
        ("axis maxs: 0", 1, 3),
        ("centers: cell cell", 2, 3),
        ("kinds: domain domain", 2, 3),
        ("kinds: domain domain domain domain", 4, 3),
        ("kinds:  ", 0, 3),
        ("labels: \"x\" \"y\"", 2, 3),
        ("labels: \"x \\\" y\" \"z\"", 2, 3),
        ("units: \"mm\" \"mm\"", 2, 3),
        ("units: \"mm\" \"mm\" \"mm\" \"mm\"", 4, 3),
        ("space units: \"mm\" \"mm\"", 2, 3),
        ("space units: \"mm\" \"mm\" \"mm\" \"mm\"", 4, 3),
        ("space directions: (1,0,0) (0,1,0)", 2, 3),
        ("space directions: (1,0,0) (0,1,0) (0,0,1) none", 4, 3),
        ("space origin: (0,0,0) (0,0,0)", 2, 1),
        ("measurement frame: (1,0,0) (0,1,0)", 2, 3),
    ] {
        let (name, _) = bad.split_once(':').unwrap();
        let error = refused(&[bad]);
        let told = matches!(error, NrrdError::Count { field, found: f, expected: e, .. } if (field, f, e) == (name, found, expected));
        assert!(told, "{bad}: {error}");
    }
    let whole = [
        "kinds: domain domain domain",
        "labels: \"x\" \"y \\\" y\" \"z\"",
        "thicknesses: nan nan 1",
        "measurement frame: (1,0,0) (0,1,0) (0,0,1)",
    ];
    assert!(read_bytes(&hand(&whole, &counted())).is_ok());
}

/// Up to 64 KiB behind the voxels were passed over in silence: more than a slice of a small volume.
#[test]
fn bytes_behind_the_voxels_are_told_and_a_slice_of_them_is_refused() {
    let told = |bytes: Vec<u8>| -> Result<String, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let mut source = open(&file(&folder, "a.nrrd", &bytes), OpenOptions::default())?;
        drink_both(&mut source)?;
        Ok([source.facts().warnings, source.remarks()].concat().join("; "))
    };
    let behind = |more: usize| [counted(), vec![0; more]].concat();
    let mm = "space units: \"mm\" \"mm\" \"mm\"";
    let whole = hand(&[mm], &counted());
    assert_eq!(told(whole.clone()).unwrap(), "");
    let said = told(hand(&[mm], &behind(11))).unwrap();
    let words = format!("the voxels end at byte {} and 11 more follow", whole.len());
    assert!(said.contains(&words), "{said}");
    let said = told(hand(&[mm, "encoding: gzip"], &gzip(&behind(11)))).unwrap();
    assert!(said.contains("end at byte 24 and 11 more follow"), "{said}");
    // A slice: 2 x 3 voxels of 2 bytes.
    for bytes in [
        hand(&[mm], &behind(12)),
        hand(&[mm, "encoding: gzip"], &gzip(&behind(12))),
    ] {
        assert!(matches!(told(bytes), Err(ReadError::TooLong { .. })));
    }
    // Voxels that are the file's last bytes, behind a slice that the header does not know.
    let said = told(hand(&[mm, "byte skip: -1"], &[vec![0; 12], counted()].concat())).unwrap();
    assert!(said.contains("12 before them are passed over"), "{said}");
    assert_eq!(
        told(hand(&[mm, "byte skip: -1"], &[vec![0; 11], counted()].concat())).unwrap(),
        ""
    );
}

#[test]
fn files_elsewhere_are_refused_by_name() {
    let source = |text: &str| match refused(&[text]) {
        NrrdError::Files { line: 10, source } => source,
        other => panic!("{other:?}"),
    };
    assert!(matches!(source("data file: /etc/passwd"), NamesError::Outside { .. }));
    assert!(matches!(source("data file: ../x.raw"), NamesError::Outside { .. }));
    assert!(matches!(
        source("data file: x%d.raw 1 3 1"),
        NamesError::Count { found: 3, .. }
    ));
    assert!(matches!(source("data file: x%d.raw 1 6 1 1"), NamesError::Rows { .. }));
    assert!(matches!(source("data file: LIST"), NamesError::Empty));
    let missing = read_bytes(&hand(&["data file: absent.raw"], &[])).unwrap_err();
    assert!(
        matches!(&missing, ReadError::Missing { path } if path.ends_with("absent.raw")),
        "{missing}"
    );
}

#[test]
fn nothing_that_could_name_a_patient_is_repeated() {
    let texts = [
        &b"NRRD0004\ncontent: Doe^John\n\n"[..],
        b"NRRD0004\nDoe^John 1970\n\n",
        b"NRRD0004\nPatientName:=Doe^John\nlabels: \"Doe^John\"\n\n",
    ];
    for text in texts {
        assert!(
            !refused_bytes(text).to_string().contains("Doe"),
            "{}",
            refused_bytes(text)
        );
    }
}

#[test]
fn wrong_lengths_are_refused_with_numbers() {
    let whole = hand(&[], &counted());
    every_truncation(&whole, |bytes| read_bytes(bytes).is_ok());
    let head = whole.len() as u64 - 24;
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
    assert_eq!((expected, found), (head + 24, head + 19));
    let packed = hand(&["encoding: gzip"], &gzip(&counted()));
    every_truncation(&packed, |bytes| read_bytes(bytes).is_ok());
    let text = hand(&["encoding: ascii"], b"0 1 2 3 4 5 6 7 8 9 10 1");
    every_truncation(&text, |bytes| read_bytes(bytes).is_ok());
    let long = [whole, vec![0; 70_000]].concat();
    assert!(matches!(read_bytes(&long), Err(ReadError::TooLong { .. })));
    let bomb = hand(&["encoding: gzip"], &gzip(&vec![0; 50_000_000]));
    assert!(matches!(read_bytes(&bomb), Err(ReadError::TooLong { found, .. }) if found < 100_000));
    let huge = hand(&["sizes: 9000 9000 16"], &counted());
    assert!(matches!(read_bytes(&huge), Err(ReadError::Truncated { .. })));
    let lines = hand(&["line skip: 60000000"], &counted());
    assert!(matches!(
        read_bytes(&lines),
        Err(ReadError::Truncated {
            place: Place::Header,
            ..
        })
    ));
}

#[test]
fn a_file_that_is_cut_while_it_is_open_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = hand(&[], &counted());
    let path = file(&folder, "cut.nrrd", &whole);
    let source = open(&path, OpenOptions::default()).unwrap();
    let slices = source.slices().unwrap();
    let mut scratch = Scratch::default();
    std::fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    let mut read = |k, voxels| slices.read(k, &mut vec![0; voxels], &mut scratch);
    assert!(read(0, 6).is_ok());
    assert!(matches!(
        read(1, 6),
        Err(ReadError::Truncated {
            place: Place::Slice(1),
            ..
        })
    ));
    assert!(matches!(read(2, 6), Err(ReadError::Order { found: 2, .. })));
    assert!(matches!(read(0, 7), Err(ReadError::Buffer { found: 7, .. })));
}

#[test]
fn words_that_are_no_numbers_are_refused() {
    for text in [
        "0 1 2 three 4 5 6 7 8 9 10 11",
        "0 1 2 3 4 5 6 7 8 9 10 40000",
        "0 1 2 3 4 5 6 7 8 9 10 11 12",
    ] {
        let error = read_bytes(&hand(&["encoding: ascii"], text.as_bytes())).unwrap_err();
        assert!(matches!(error, ReadError::Word { .. }), "{text}: {error}");
    }
    let long = "1".repeat(100_000);
    let error = read_bytes(&hand(&["encoding: ascii"], long.as_bytes())).unwrap_err();
    assert!(
        matches!(&error, ReadError::Word { found, .. } if found.len() < 100),
        "{error}"
    );
    let hex = read_bytes(&hand(&["encoding: hex"], &[b'g'; 48])).unwrap_err();
    assert!(matches!(hex, ReadError::Word { .. }), "{hex}");
}

#[test]
fn flipped_bytes_never_panic() {
    every_flip(&hand(&["byte skip: 0", "data file:"], &counted()), |bytes| {
        drop(read_bytes(bytes))
    });
    every_flip(&hand(&["encoding: gzip"], &gzip(&counted())), |bytes| {
        drop(read_bytes(bytes))
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), plausible: bool) {
        let head = if plausible { &b"NRRD0004\n"[..] } else { b"" };
        let _ = read_bytes(&[head, &bytes].concat());
    }

    #[test]
    fn random_values_never_panic(which in 1..LINES.len(), value in "[-0-9a-z(),.% \"]{0,20}") {
        let (field, _) = LINES[which].split_once(':').unwrap();
        let _ = read_bytes(&hand(&[&format!("{field}: {value}")], &counted()));
        let _ = read_bytes(&hand(&[&format!("data file: {value}")], &counted()));
    }
}
