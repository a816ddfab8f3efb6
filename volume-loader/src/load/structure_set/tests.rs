//! Structure sets made by hand; those that other programs wrote are read in `tests/cli`.

mod origin;

use super::*;
use crate::dicom::tests::writer::{Coding, File, Value};

type Elements = Vec<((u16, u16), Value)>;

fn text(tag: (u16, u16), vr: &'static str, text: &str) -> ((u16, u16), Value) {
    (tag, Value::Text(vr, text.to_owned()))
}

/// A region: its number, name and frame of reference, and its contours.
struct Roi(
    &'static str,
    &'static str,
    &'static str,
    Vec<(&'static str, &'static str)>,
);

fn rois() -> Vec<Roi> {
    vec![
        Roi("3", "node", "1.2.3.4.6", vec![("POINT", "-12.5\\40\\ 1.25e2")]),
        Roi(
            "1",
            "liver",
            "1.2.3.4.6",
            vec![("CLOSED_PLANAR", "0\\0\\0\\1\\0\\0\\0\\1\\0")],
        ),
        Roi("2", "node entry", "1.2.3.4.6", vec![("POINT", "-80\\-40\\125")]),
        Roi("7", "nothing", "1.2.3.4.6", vec![]),
    ]
}

fn bytes(rois: &[Roi], coding: Coding) -> Vec<u8> {
    file(rois, coding, None)
}

/// With this contour in the place of those of the first region.
fn file(rois: &[Roi], coding: Coding, first: Option<Elements>) -> Vec<u8> {
    let file = made(rois, coding, first);
    match coding {
        Coding::Explicit => file.bytes(),
        coding => file.coded(coding).bytes(),
    }
}

fn made(rois: &[Roi], coding: Coding, first: Option<Elements>) -> File {
    let mut file = File {
        coding,
        syntax: "1.2.840.10008.1.2.1".to_owned(),
        preamble: true,
        elements: Vec::new(),
    };
    file.text((0x0008, 0x0016), "UI", CLASS)
        .text((0x0010, 0x0010), "PN", "SECRET^NAME");
    let described = |Roi(number, name, frame, _): &Roi| -> Elements {
        vec![
            text((0x3006, 0x0022), "IS", number),
            text((0x3006, 0x0024), "UI", frame),
            text((0x3006, 0x0026), "LO", name),
        ]
    };
    let contours = |Roi(number, _, _, contours): &Roi| -> Elements {
        let contour =
            |(kind, data): &(&str, &str)| vec![text((0x3006, 0x0042), "CS", kind), text((0x3006, 0x0050), "DS", data)];
        let contours = match first.clone().filter(|_| *number == rois[0].0) {
            Some(first) => vec![first],
            None => contours.iter().map(contour).collect(),
        };
        vec![
            ((0x3006, 0x0040), Value::Items(contours, true)),
            text((0x3006, 0x0084), "IS", number),
        ]
    };
    file.set(
        (0x3006, 0x0020),
        Value::Items(rois.iter().map(described).collect(), false),
    );
    file.set(
        (0x3006, 0x0039),
        Value::Items(rois.iter().map(contours).collect(), true),
    );
    file
}

struct World(tempfile::TempDir);

impl World {
    fn new() -> Self {
        let world = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(world.0.path().join("ct")).unwrap();
        for k in 0..4 {
            let file = File::slice(k, 2.5 * k as f64);
            std::fs::write(world.0.path().join(format!("ct/{k}.dcm")), file.bytes()).unwrap();
        }
        world
    }

    fn read(&self, bytes: &[u8]) -> Result<Option<StructureSet>, StructureSetError> {
        let path = self.0.path().join("points.dcm");
        std::fs::write(&path, bytes).unwrap();
        structure_set(&path, &VolumeSpec::of_path(self.0.path().join("ct")))
    }

    fn refused(&self, rois: &[Roi]) -> String {
        let said = self.read(&bytes(rois, Coding::Explicit)).unwrap_err().to_string();
        assert!(said.contains("points.dcm") && !said.contains("SECRET"), "{said}");
        said
    }
}

#[test]
fn points_have_their_names_and_places_in_every_coding() {
    let world = World::new();
    for coding in [Coding::Explicit, Coding::Implicit, Coding::Big] {
        let set = world.read(&bytes(&rois(), coding)).unwrap().unwrap();
        let found: Vec<_> = set.points.iter().map(|p| (p.name.as_str(), p.ct_mm)).collect();
        let want = [("node entry", [-80.0, -40.0, 125.0]), ("node", [-12.5, 40.0, 125.0])];
        assert_eq!(
            (&found[..], set.others.len(), set.is_in_its_frame),
            (&want[..], 2, true),
            "{coding:?}"
        );
    }
    assert_eq!(world.read(&File::slice(0, 0.0).bytes()).unwrap(), None);
}

/// Neither was told.
#[test]
fn a_set_of_another_patient_and_one_that_was_rejected_are_refused() {
    let world = World::new();
    let with = |set: &[((u16, u16), &'static str, &str)], slices: &str| {
        for k in 0..4 {
            let mut file = File::slice(k, 2.5 * k as f64);
            file.text((0x0010, 0x0020), "LO", slices);
            std::fs::write(world.0.path().join(format!("ct/{k}.dcm")), file.bytes()).unwrap();
        }
        let mut file = made(&rois(), Coding::Explicit, None);
        for (tag, vr, value) in set {
            file.text(*tag, vr, value);
        }
        let found = world.read(&file.bytes());
        found
            .map(|set| set.unwrap().points.len())
            .map_err(|error| error.to_string())
    };
    let (id, status) = ((0x0010, 0x0020), (0x300E, 0x0002));
    let other = with(&[(id, "LO", "SECRET2")], "SECRET1").unwrap_err();
    assert!(
        other.contains("points.dcm: (0010,0020) PatientID: found another"),
        "{other}"
    );
    assert!(!other.contains("SECRET"), "{other}");
    for (set, slices) in [("SECRET1 ", "SECRET1"), ("", "SECRET1"), ("SECRET1", "")] {
        assert_eq!(with(&[(id, "LO", set)], slices), Ok(2), "{set:?} {slices:?}");
    }
    let rejected = with(&[(status, "CS", "REJECTED")], "").unwrap_err();
    assert!(rejected.contains("ApprovalStatus: found REJECTED"), "{rejected}");
    for good in ["APPROVED", "UNAPPROVED"] {
        assert_eq!(with(&[(status, "CS", good)], ""), Ok(2), "{good}");
    }
}

#[test]
fn what_would_be_a_guess_is_refused_by_name() {
    let world = World::new();
    let with = |change: &dyn Fn(&mut Vec<Roi>)| {
        let mut rois = rois();
        change(&mut rois);
        world.refused(&rois)
    };
    let twice = with(&|r| r[0].3.push(("POINT", "0\\0\\0")));
    assert!(twice.contains("region of interest 3 (\"node\") is 2 points"), "{twice}");
    let both = with(&|r| r[0].3.push(("OPEN_PLANAR", "0\\0\\0\\1\\1\\1")));
    assert!(both.contains("region of interest 3 (\"node\") is 1 points"), "{both}");
    let other = with(&|r| r[2].2 = "1.2.3.4.7");
    assert!(
        other.contains("(\"node entry\") is in another frame of reference"),
        "{other}"
    );
    let unsaid = with(&|r| r[2].2 = "");
    assert!(unsaid.contains("ReferencedFrameOfReferenceUID is missing"), "{unsaid}");
    for (data, words) in [
        ("1\\2", "ContourData is \"1\\2\", expected as many finite numbers"),
        ("1\\2\\3\\4", "ContourData is \"1\\2\\3\\4\""),
        ("1\\2\\1e5", "no more than 10000 mm"),
        ("1\\2\\nan", "bytes that are not numbers"),
        ("", "ContourData is missing"),
    ] {
        let said = with(&|r| r[0].3[0].1 = data);
        assert!(said.contains(words), "{words}: {said}");
    }
    // The retired offset would move the point.
    for (tag, vr, value, words) in [
        (
            (0x3006, 0x0045),
            "DS",
            "0\\0\\5",
            "ContourOffsetVector is [0.0, 0.0, 5.0], expected none, or zeros",
        ),
        (
            (0x3006, 0x0046),
            "IS",
            "2",
            "NumberOfContourPoints is 2, expected 1 for a POINT",
        ),
    ] {
        let contour = vec![
            text((0x3006, 0x0042), "CS", "POINT"),
            text(tag, vr, value),
            text((0x3006, 0x0050), "DS", "1\\2\\3"),
        ];
        let said = world
            .read(&file(&rois(), Coding::Explicit, Some(contour)))
            .unwrap_err()
            .to_string();
        assert!(said.contains(words), "{words}: {said}");
    }
    let number = with(&|r| r[1].0 = "3");
    assert!(number.contains("ROINumber is 3 twice"), "{number}");
}

/// A target of one scan got its entry from another, where the examination could not be asked.
#[test]
fn of_an_examination_without_a_frame_all_points_are_in_one() {
    let world = World::new();
    let path = world.0.path().join("points.dcm");
    let phantom = scene::RawVolume::default().checked().unwrap();
    let read = |rois: &[Roi]| {
        std::fs::write(&path, bytes(rois, Coding::Explicit)).unwrap();
        structure_set(&path, &phantom)
    };
    let set = read(&rois()).unwrap().unwrap();
    assert_eq!((set.points.len(), set.is_in_its_frame), (2, false));
    let mut two = rois();
    two[2].2 = "1.2.3.4.7";
    let said = read(&two).unwrap_err().to_string();
    assert!(said.contains("(\"node\") is in another frame of reference"), "{said}");
}

#[test]
fn damage_is_refused() {
    let (world, whole) = (World::new(), bytes(&rois(), Coding::Explicit));
    for at in (132..whole.len()).step_by(3) {
        let _ = world.read(&whole[..at]);
        let mut changed = whole.clone();
        changed[at] ^= 0xFF;
        let _ = world.read(&changed);
    }
}
