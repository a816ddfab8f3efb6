//! Every variety of header, and what is read from it.

use geometry::Affine;

use super::*;
use crate::raster::test_files::gzip;
use crate::source::VoxelSource;

fn voxels(bytes: &[u8]) -> Vec<i16> {
    read_bytes(bytes).unwrap().0
}

fn rows(changes: &[&str], options: OpenOptions) -> ([[f64; 4]; 3], String) {
    let folder = tempfile::tempdir().unwrap();
    let source = open(&file(&folder, "a.nrrd", &hand(changes, &counted())), options).unwrap();
    (source.grid().ct_from_voxel().rows(), source.describe())
}

#[test]
fn plain_voxels_are_read() {
    let want: Vec<i16> = (0..12).collect();
    assert_eq!(voxels(&hand(&[], &counted())), want);
    let crlf = String::from_utf8(hand(&[], &[])).unwrap().replace('\n', "\r\n");
    assert_eq!(voxels(&[crlf.into_bytes(), counted()].concat()), want);
    let more = [
        "# a comment: of any sort",
        "key:=any value",
        "content: anything",
        "labels: \"x\" \"y\" \"z\"",
    ];
    let mut text = String::from_utf8(hand(&[], &[])).unwrap();
    text = text.replacen('\n', &format!("\n{}\n", more.join("\n")), 1);
    assert_eq!(voxels(&[text.into_bytes(), counted()].concat()), want);
}

#[test]
fn each_type_is_read_in_both_orders() {
    fn check<const N: usize>(word: &str, little: impl Fn(i16) -> [u8; N]) {
        let want = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 100, 101];
        for endian in ["little", "big"] {
            let bytes: Vec<u8> = want
                .iter()
                .flat_map(|&v| {
                    let mut raw = little(v);
                    if endian == "big" {
                        raw.reverse();
                    }
                    raw
                })
                .collect();
            let header = [format!("type: {word}"), format!("endian: {endian}")];
            let changes: Vec<&str> = header.iter().map(String::as_str).collect();
            assert_eq!(voxels(&hand(&changes, &bytes)), want, "{word} {endian}");
        }
    }
    for word in ["signed char", "int8", "int8_t"] {
        check(word, |v| (v as i8).to_le_bytes());
    }
    for word in ["uchar", "unsigned char", "uint8", "UINT8_T"] {
        check(word, |v| (v as u8).to_le_bytes());
    }
    for word in [
        "short",
        "short int",
        "signed short",
        "signed short int",
        "int16",
        "int16_t",
    ] {
        check(word, i16::to_le_bytes);
    }
    for word in ["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"] {
        check(word, |v| (v as u16).to_le_bytes());
    }
    for word in ["int", "signed int", "int32", "int32_t"] {
        check(word, |v| i32::from(v).to_le_bytes());
    }
    for word in ["uint", "unsigned int", "uint32", "uint32_t"] {
        check(word, |v| (v as u32).to_le_bytes());
    }
    for word in [
        "longlong",
        "long long",
        "long long int",
        "signed long long",
        "signed long long int",
        "int64",
        "int64_t",
    ] {
        check(word, |v| i64::from(v).to_le_bytes());
    }
    for word in [
        "ulonglong",
        "unsigned long long",
        "unsigned long long int",
        "uint64",
        "uint64_t",
    ] {
        check(word, |v| (v as u64).to_le_bytes());
    }
    check("float", |v| f32::from(v).to_le_bytes());
    check("double", |v| f64::from(v).to_le_bytes());
}

#[test]
fn each_encoding_is_read() {
    let want: Vec<i16> = (0..12).collect();
    for word in ["gzip", "gz", "GZIP"] {
        let encoding = format!("encoding: {word}");
        assert_eq!(voxels(&hand(&[&encoding], &gzip(&counted()))), want, "{word}");
    }
    for word in ["ascii", "text", "txt"] {
        let encoding = format!("encoding: {word}");
        let text = b"0 1 2,3\n4\t5 6 7 8 9 10, 11";
        assert_eq!(voxels(&hand(&[&encoding, "endian:"], text)), want, "{word}");
    }
    let hex: String = counted().iter().map(|b| format!("{b:02X} ")).collect();
    assert_eq!(voxels(&hand(&["encoding: hex"], hex.as_bytes())), want);
    // Raw voxels that look like gzip are voxels.
    let mut odd = counted();
    odd[..2].copy_from_slice(&[0x1f, 0x8b]);
    assert_eq!(voxels(&hand(&[], &odd))[0], i16::from_le_bytes([0x1f, 0x8b]));
}

#[test]
fn values_beyond_i16_are_held_and_counted() {
    let bytes: Vec<u8> = [70_000_i32, -70_000, 5]
        .iter()
        .cycle()
        .take(12)
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let (voxels, conversion) = read_bytes(&hand(&["type: int"], &bytes)).unwrap();
    assert_eq!(voxels[..3], [32767, -32768, 5]);
    assert_eq!((conversion.clamped_low, conversion.clamped_high), (4, 4));
    let text = b"nan 0.5 1 2 3 4 5 6 7 8 9 inf";
    let (voxels, conversion) = read_bytes(&hand(&["type: float", "encoding: ascii"], text)).unwrap();
    assert_eq!((voxels[0], voxels[1], voxels[11]), (-1024, 1, -1024));
    assert_eq!((conversion.not_finite, conversion.rounded), (2, 1));
}

#[test]
fn skips_are_lines_then_bytes() {
    let want: Vec<i16> = (0..12).collect();
    let skipped = [&b"one\ntwo\nxyz"[..], &counted()].concat();
    assert_eq!(voxels(&hand(&["line skip: 2", "byte skip: 3"], &skipped)), want);
    assert_eq!(voxels(&hand(&["line skip: 9", "byte skip: -1"], &skipped)), want);
    // Lines stand before the compressed stream, bytes in it.
    let packed = [&b"one\n"[..], &gzip(&[&b"xyz"[..], &counted()].concat())].concat();
    assert_eq!(
        voxels(&hand(&["encoding: gzip", "line skip: 1", "byte skip: 3"], &packed)),
        want
    );
}

#[test]
fn spaces_become_lps() {
    let lps = [[0.0, 3.0, 0.0, 5.0], [-2.0, 0.0, 0.0, 6.0], [0.0, 0.0, 4.0, 7.0]];
    let negate = |rows: [[f64; 4]; 3], signs: [f64; 3]| -> [[f64; 4]; 3] {
        std::array::from_fn(|r| rows[r].map(|v| 0.0 + signs[r] * v))
    };
    for (word, signs) in [
        ("LPS", [1.0, 1.0, 1.0]),
        ("left-posterior-superior", [1.0, 1.0, 1.0]),
        ("RAS", [-1.0, -1.0, 1.0]),
        ("Right-Anterior-Superior", [-1.0, -1.0, 1.0]),
        ("LAS", [1.0, -1.0, 1.0]),
        ("left-anterior-superior", [1.0, -1.0, 1.0]),
    ] {
        let space = format!("space: {word}");
        let changes = [
            &space,
            "space directions: (0,-2,0) (3,0,0) (0,0,4)",
            "space origin: (5,6,7)",
        ];
        let (found, about) = rows(&changes, OpenOptions::default());
        assert_eq!(found, negate(lps, signs), "{word}");
        assert!(about.contains("oriented in"), "{about}");
    }
}

#[test]
fn units_become_millimetres() {
    let changes = |units| {
        [
            units,
            "space directions: (1,0,0) (0,2,0) (0,0,4)",
            "space origin: (5, 6, 7)",
        ]
    };
    for (units, mm) in [
        ("space units: \"mm\" \"mm\" \"mm\"", [1.0, 1.0, 1.0]),
        ("space units: \"cm\" \"cm\" \"cm\"", [10.0, 10.0, 10.0]),
        ("space units: \"um\" \"µm\" \"mm\"", [1e-3, 1e-3, 1.0]),
        ("space units: \"\" \"???\" \"mm\"", [1.0, 1.0, 1.0]),
    ] {
        let mm_rows = [
            [mm[0], 0.0, 0.0, 5.0 * mm[0]],
            [0.0, 2.0 * mm[1], 0.0, 6.0 * mm[1]],
            [0.0, 0.0, 4.0 * mm[2], 7.0 * mm[2]],
        ];
        assert_eq!(rows(&changes(units), OpenOptions::default()).0, mm_rows, "{units}");
    }
}

#[test]
fn a_fourth_axis_of_length_one_is_passed_over() {
    let first = [
        "dimension: 4",
        "sizes: 1 2 3 2",
        "space directions: none (1,0,0) (0,1,0) (0,0,1)",
        "kinds: vector domain domain domain",
    ];
    let last = [
        "dimension: 4",
        "sizes: 2 3 2 1",
        "space directions: (1,0,0) (0,1,0) (0,0,1) none",
        "kinds: domain domain domain list",
    ];
    for changes in [first, last] {
        assert_eq!(voxels(&hand(&changes, &counted())), (0..12).collect::<Vec<i16>>());
    }
}

#[test]
fn an_assumed_orientation_is_said() {
    let plain = [
        "space:",
        "space directions:",
        "space origin:",
        "spacings: 1 2 3",
        "units: \"mm\" \"mm\" \"mm\"",
    ];
    let (found, about) = rows(&plain, ASSUMED);
    let want = Affine::<(), ()>::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]]).rows();
    assert_eq!(found, want);
    assert!(about.contains("NO ORIENTATION IN THE FILE"), "{about}");
    let (_, about) = rows(&["space: scanner-xyz"], ASSUMED);
    assert!(about.contains("NO ORIENTATION IN THE FILE"), "{about}");
    let (_, about) = rows(&["space origin:"], ASSUMED);
    assert!(about.contains("no origin"), "{about}");
    // What the file says is not overruled.
    let (found, about) = rows(&["space: RAS"], ASSUMED);
    assert!(found[0][0] == -1.0 && !about.contains("NO ORIENTATION"), "{about}");
    let unknown = [&plain[..], &["axis mins: NaN NaN NaN"]].concat();
    assert_eq!(rows(&unknown, ASSUMED).0, want);
    // A file that said RAS, or where its origin is, was turned half round, or put at 0.
    let without = ["space directions:", "space origin:", "spacings: 1 2 3"];
    for (more, field) in [
        (&["space: right-anterior-superior"][..], "space"),
        (
            &["space: left-posterior-superior", "space origin: (100,200,300)"],
            "space origin",
        ),
        (&["space:", "axis mins: 100 200 300"], "axis mins"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let changes = [&without[..], more].concat();
        let opened = open(&file(&folder, "a.nrrd", &hand(&changes, &counted())), ASSUMED);
        let said = opened.map(|_| ()).unwrap_err().to_string();
        assert!(said.contains(&format!(": {field} is ")), "{field}: {said}");
    }
}

#[test]
fn voxels_may_lie_in_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let want: Vec<i16> = (0..12).collect();
    let (bytes, text) = (counted(), |changes: &[&str]| hand(changes, &[]));
    file(&folder, "all.raw", &bytes);
    file(&folder, "s08.raw", &bytes[..12]);
    file(&folder, "s10.raw", &bytes[12..]);
    file(&folder, "a.gz", &gzip(&bytes[..12]));
    file(&folder, "b.gz", &gzip(&bytes[12..]));
    for (name, changes) in [
        ("one.nhdr", &["data file: all.raw"][..]),
        ("dot.nhdr", &["data file: ./all.raw"]),
        ("pattern.nhdr", &["data file: s%02d.raw 8 10 2"]),
        ("slabs.nhdr", &["data file: s%02d.raw 8 10 2 3"]),
        ("list.nhdr", &["data file: LIST\ns08.raw\ns10.raw"]),
        ("packed.nhdr", &["encoding: gzip", "data file: LIST 2\na.gz\nb.gz"]),
    ] {
        let path = file(&folder, name, &text(changes));
        assert_eq!(read(&path).unwrap().0, want, "{name}");
    }
    // A detached header may end without an empty line.
    let bare = text(&["data file: all.raw"]);
    let path = file(&folder, "bare.nhdr", bare.trim_ascii_end());
    assert_eq!(read(&path).unwrap().0, want);
}

fn facts(changes: &[&str], options: OpenOptions) -> (String, Option<String>) {
    let folder = tempfile::tempdir().unwrap();
    let source = open(&file(&folder, "a.nrrd", &hand(changes, &counted())), options).unwrap();
    let (facts, line) = (source.facts(), source.describe());
    assert!(facts.warnings.iter().all(|doubt| line.contains(doubt)), "{line}");
    let modality = facts.extra.get("modality").and_then(|word| word.as_str());
    (facts.warnings.join("; "), modality.map(str::to_owned))
}

/// They stood in the line of the format alone, and were no warnings where DICOM's doubts are.
#[test]
fn what_is_doubtful_is_a_warning() {
    let mm = "space units: \"mm\" \"mm\" \"mm\"";
    let of = |changes: &[&str]| facts(changes, ASSUMED).0;
    assert_eq!(of(&[mm]), "");
    assert_eq!(of(&[]), "unit of length unknown, taken as mm");
    assert!(of(&["space units: \"cm\" \"cm\" \"cm\""]).contains("lengths converted from \"cm\""));
    assert!(of(&[mm, "space:"]).contains("NO ORIENTATION IN THE FILE"));
    assert!(of(&[mm, "space origin:"]).contains("no origin in the file"));
    let plain = [
        "space directions:",
        "space origin:",
        "space:",
        "spacings: 1 2 3",
        "units: \"mm\" \"mm\" \"mm\"",
    ];
    assert!(of(&plain).contains("NO ORIENTATION IN THE FILE"));
}

/// Numbers of a magnet were shown as HU, whatever the header said of them.
#[test]
fn numbers_that_the_header_says_are_no_hu_are_doubted() {
    let mm = "space units: \"mm\" \"mm\" \"mm\"";
    let of = |line: &str| facts(&[mm, line], OpenOptions::default());
    for line in [
        "sample units: \"HU\"",
        "sample units: Hounsfield units",
        "sample units: ???",
        "# Modality: CT",
        "modality:=CT",
        "content: a liver",
    ] {
        assert_eq!(of(line).0, "", "{line}");
    }
    assert_eq!(of("modality:=CT").1.as_deref(), Some("CT"));
    for (line, words) in [
        ("sample units: Bq/ml", "sample units are Bq/ml: its numbers are not HU"),
        ("# units: cm", "a comment has the unit cm"),
        ("# RescaleType: US", "RescaleType is US, not HU"),
        ("content: brain MRI of Doe^John", "content has the word mri"),
        ("intensity unit:=SUV", "a key has the unit suv"),
    ] {
        let (said, _) = of(line);
        assert!(said.contains(words) && !said.contains("Doe"), "{line}: {said}");
    }
    let (said, modality) = of("DICOM_0008_0060_Modality:=MR");
    assert!(
        said.contains("not a CT (MR, by a key): its numbers are not HU"),
        "{said}"
    );
    assert_eq!(modality.as_deref(), Some("MR"));
}
