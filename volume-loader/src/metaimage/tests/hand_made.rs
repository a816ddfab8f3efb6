//! Every variety of header, and what is read from it.

use super::*;
use crate::raster::test_files::{drink_both, gzip, zlib};
use crate::source::VoxelSource;

fn voxels(bytes: &[u8]) -> Vec<i16> {
    read_bytes(bytes).unwrap().0
}

fn refused(changes: &[&str], options: OpenOptions) -> String {
    let folder = tempfile::tempdir().unwrap();
    let opened = open(&file(&folder, "a.mha", &hand(changes, &counted())), options);
    opened.map(|_| ()).unwrap_err().to_string()
}

fn rows(changes: &[&str], options: OpenOptions) -> ([[f64; 4]; 3], String) {
    let folder = tempfile::tempdir().unwrap();
    let source = open(&file(&folder, "a.mha", &hand(changes, &counted())), options).unwrap();
    (source.grid().ct_from_voxel().rows(), source.describe())
}

#[test]
fn plain_voxels_are_read() {
    let want: Vec<i16> = (0..12).collect();
    assert_eq!(voxels(&hand(&[], &counted())), want);
    let remarks = [
        "Comment = anything",
        "0010|0010 = Doe^John",
        "Modality = MET_MOD_CT",
        "HeaderSize = 0",
    ];
    assert_eq!(voxels(&hand(&remarks, &counted())), want);
    let big: Vec<u8> = (0..12_i16).flat_map(i16::to_be_bytes).collect();
    assert_eq!(voxels(&hand(&["BinaryDataByteOrderMSB = True"], &big)), want);
    let other = ["BinaryDataByteOrderMSB =", "ElementByteOrderMSB = True"].map(|line| line.trim_end_matches(' '));
    assert_eq!(voxels(&hand(&[other[0].trim(), other[1]], &big)), want);
    assert_eq!(
        voxels(&hand(&["BinaryData = False"], b"0 1 2 3 4 5 6 7 8 9 10 11\n")),
        want
    );
}

#[test]
fn each_type_is_read() {
    fn check<const N: usize>(word: &str, little: impl Fn(i16) -> [u8; N]) {
        let bytes: Vec<u8> = (0..12).flat_map(little).collect();
        let kind = format!("ElementType = {word}");
        assert_eq!(voxels(&hand(&[&kind], &bytes)), (0..12).collect::<Vec<i16>>(), "{word}");
    }
    check("MET_CHAR", |v| (v as i8).to_le_bytes());
    check("MET_UCHAR", |v| (v as u8).to_le_bytes());
    check("MET_SHORT", i16::to_le_bytes);
    check("MET_USHORT", |v| (v as u16).to_le_bytes());
    check("MET_INT", |v| i32::from(v).to_le_bytes());
    check("MET_UINT", |v| (v as u32).to_le_bytes());
    check("MET_LONG_LONG", |v| i64::from(v).to_le_bytes());
    check("MET_ULONG_LONG", |v| (v as u64).to_le_bytes());
    check("MET_FLOAT", |v| f32::from(v).to_le_bytes());
    check("MET_DOUBLE", |v| f64::from(v).to_le_bytes());
}

#[test]
fn compressed_voxels_are_read() {
    let want: Vec<i16> = (0..12).collect();
    for packed in [zlib(&counted()), gzip(&counted())] {
        let size = format!("CompressedDataSize = {}", packed.len());
        for sizes in [&["CompressedData = True"][..], &["CompressedData = True", &size]] {
            assert_eq!(voxels(&hand(sizes, &packed)), want);
        }
    }
}

#[test]
fn the_matrix_holds_one_direction_after_another() {
    let changes = [
        "TransformMatrix = 0 1 0 0 0 -1 1 0 0",
        "Offset = 1 2 3",
        "ElementSpacing = 0.5 2 3",
        "AnatomicalOrientation = ASR",
    ];
    // As ITK writes and reads these numbers: axis 0 goes to +y, axis 1 to -z, axis 2 to +x.
    let want = [[0.0, 0.0, 3.0, 1.0], [0.5, 0.0, 0.0, 2.0], [0.0, -2.0, 0.0, 3.0]];
    let (found, about) = rows(&changes, OpenOptions::default());
    assert_eq!(found, want);
    assert!(!about.contains("AnatomicalOrientation"), "{about}");
    let mut wrong = changes;
    wrong[3] = "AnatomicalOrientation = RAI";
    // It was told at the end of a line and no warning: by one of both the patient is in a mirror.
    let refused = refused(&wrong, OpenOptions::default());
    assert!(
        refused.contains("AnatomicalOrientation") && refused.contains("\"RAI\""),
        "{refused}"
    );
    // Where axes go to, as some programs name it; and in small letters.
    wrong[3] = "AnatomicalOrientation = PIL";
    let (found, about) = rows(&wrong, OpenOptions::default());
    assert_eq!(found, want);
    assert!(about.contains("where they come from is ASR"), "{about}");
    wrong[3] = "AnatomicalOrientation = asr";
    assert_eq!(rows(&wrong, OpenOptions::default()).0, want);
    let renamed = [
        "TransformMatrix=",
        "Rotation = 0 1 0 0 0 -1 1 0 0",
        "Offset=",
        "Position = 1 2 3",
        "ElementSpacing=",
        "ElementSize = 0.5 2 3",
    ];
    assert_eq!(rows(&renamed, OpenOptions::default()).0, want);
    let (found, about) = rows(&["DistanceUnits = cm", "Offset = 1 2 3"], OpenOptions::default());
    assert_eq!([found[0][0], found[1][3]], [10.0, 20.0]);
    assert!(about.contains("converted from cm"), "{about}");
    let (_, about) = rows(&["TransformMatrix = 1 0 0 0 0.8 0.6 0 0 1"], OpenOptions::default());
    assert!(about.contains("not at right angles"), "{about}");
}

#[test]
fn an_assumed_orientation_is_said() {
    let (found, about) = rows(&["TransformMatrix=", "Offset="], ASSUMED);
    assert_eq!(
        found,
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    );
    assert!(
        about.contains("NO ORIENTATION IN THE FILE") && about.contains("no origin"),
        "{about}"
    );
    // What the file says is not overruled.
    let refused = refused(&["TransformMatrix=", "Offset=", "AnatomicalOrientation = LPI"], ASSUMED);
    assert!(refused.contains("AnatomicalOrientation"), "{refused}");
    let (found, about) = rows(&["TransformMatrix = -1 0 0 0 -1 0 0 0 1"], ASSUMED);
    assert!(found[0][0] == -1.0 && !about.contains("NO ORIENTATION"), "{about}");
}

#[test]
fn voxels_may_lie_in_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let want: Vec<i16> = (0..12).collect();
    let bytes = counted();
    file(&folder, "all.raw", &bytes);
    file(&folder, "headed.raw", &[&b"0123456789"[..], &bytes].concat());
    file(&folder, "all.zraw", &zlib(&bytes));
    file(&folder, "s1.raw", &bytes[..12]);
    file(&folder, "s2.raw", &bytes[12..]);
    for (name, changes) in [
        ("one.mhd", &["ElementDataFile = all.raw"][..]),
        ("head.mhd", &["HeaderSize = 10", "ElementDataFile = headed.raw"]),
        ("last.mhd", &["HeaderSize = -1", "ElementDataFile = headed.raw"]),
        ("packed.mhd", &["CompressedData = True", "ElementDataFile = all.zraw"]),
        ("pattern.mhd", &["ElementDataFile = s%d.raw 1 2 1"]),
        ("list.mhd", &["ElementDataFile = LIST\ns1.raw\ns2.raw"]),
        ("list2.mhd", &["ElementDataFile = LIST 2D\ns1.raw\ns2.raw"]),
    ] {
        let path = file(&folder, name, &hand(changes, &[]));
        assert_eq!(read(&path).unwrap().0, want, "{name}");
    }
    assert_eq!(
        voxels(&hand(&["HeaderSize = -1"], &[&b"between"[..], &bytes].concat())),
        want
    );
}

fn facts(changes: &[&str], options: OpenOptions) -> (String, Option<String>) {
    let folder = tempfile::tempdir().unwrap();
    let source = open(&file(&folder, "a.mha", &hand(changes, &counted())), options).unwrap();
    let (facts, line) = (source.facts(), source.describe());
    assert!(facts.warnings.iter().all(|doubt| line.contains(doubt)), "{line}");
    let modality = facts.extra.get("modality").and_then(|word| word.as_str());
    (facts.warnings.join("; "), modality.map(str::to_owned))
}

/// They stood in the line of the format alone, and were no warnings where DICOM's doubts are.
#[test]
fn what_is_doubtful_is_a_warning() {
    let of = |changes: &[&str]| facts(changes, ASSUMED).0;
    assert_eq!(of(&[]), "");
    assert_eq!(of(&["DistanceUnits = ?"]), "unit of length unknown, taken as mm");
    assert_eq!(of(&["DistanceUnits = cm"]), "lengths converted from cm");
    assert!(of(&["TransformMatrix="]).contains("NO ORIENTATION IN THE FILE"));
    assert!(of(&["Offset="]).contains("no origin in the file"));
    assert!(
        of(&["ElementOrigin = 9 9 9", "ElementDirection = -1 0 0 0 1 0 0 0 1"]).ends_with("was passed over: line 10")
    );
    assert_eq!(of(&["ElementSize = 1 1 1.0"]), "");
    assert!(of(&["ElementSize = 1 1 2"]).contains("ElementSize is not ElementSpacing"));
    assert!(of(&["TransformMatrix=", "AnatomicalOrientation = LPS"]).contains("where they come from is RAI"));
    assert!(of(&["AnatomicalOrientation = LPS"]).contains("where they come from is RAI"));
}

/// Numbers of a magnet were shown as HU, whatever the header said of them.
#[test]
fn numbers_that_the_header_says_are_no_hu_are_doubted() {
    let of = |line: &str| facts(&[line], OpenOptions::default());
    for line in ["Modality = MET_MOD_CT", "0008|0060 = CT"] {
        assert_eq!(of(line), (String::new(), Some("CT".to_owned())), "{line}");
    }
    for line in ["Modality = MET_MOD_UNKNOWN", "0028|1054 = HU", "Comment = units: mm"] {
        assert_eq!(of(line), (String::new(), None), "{line}");
    }
    for (line, words, modality) in [
        (
            "Modality = MET_MOD_MR",
            "not a CT (MR, by Modality): its numbers are not HU",
            Some("MR"),
        ),
        ("Modality = MET_MOD_OTHER", "not a CT (OT", Some("OT")),
        ("0008|0060 = PT", "not a CT (PT, by a field)", Some("PT")),
        ("0028|1054 = US", "RescaleType is US, not HU", None),
        ("Comment = Doe^John, units: cm", "Comment has the unit cm", None),
        ("Comment = TE=3.1;Time=1", "Comment has the word TE", Some("MR")),
    ] {
        let (said, found) = of(line);
        assert!(said.contains(words) && !said.contains("Doe"), "{line}: {said}");
        assert_eq!(found.as_deref(), modality, "{line}");
    }
}

/// What followed the compressed voxels, a second stream of them too, was passed over in silence.
#[test]
fn bytes_behind_the_voxels_are_told() {
    let told = |changes: &[&str], bytes: &[u8]| {
        let folder = tempfile::tempdir().unwrap();
        let mut source = open(&file(&folder, "a.mha", &hand(changes, bytes)), OpenOptions::default()).unwrap();
        drink_both(&mut source).unwrap();
        [source.facts().warnings, source.remarks()].concat().join("; ")
    };
    let packed = zlib(&counted());
    let two = [packed.clone(), zlib(&counted())].concat();
    let size = format!("CompressedDataSize = {}", packed.len());
    assert_eq!(told(&["CompressedData = True", &size], &packed), "");
    let words = format!("{} bytes follow the compressed voxels", packed.len());
    for changes in [&["CompressedData = True", &size][..], &["CompressedData = True"]] {
        let said = told(changes, &two);
        assert!(said.contains(&words), "{said}");
    }
    let said = told(&["CompressedData = True"], &zlib(&[counted(), vec![0; 11]].concat()));
    assert!(said.contains("end at byte 24 and 11 more follow"), "{said}");
    let said = told(&[], &[counted(), vec![0; 11]].concat());
    assert!(said.contains("11 more follow"), "{said}");
    assert_eq!(told(&[], &counted()), "");
}
