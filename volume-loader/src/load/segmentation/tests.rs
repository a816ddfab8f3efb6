//! Segmentations made by hand, element by element: where voxels come to lie, and what is refused by which name. Those that other programs
//! wrote are read in `tests/cli`.

mod origin;

use std::path::{Path, PathBuf};

use super::*;
use crate::dicom::tests::writer::{Coding, File, Value};
use crate::load::names::label_names;
use crate::load::{labels_in, open_labels};

type Change<'a> = &'a dyn Fn(&mut Made);
type Elements = Vec<((u16, u16), Value)>;

/// Columns and rows: not a whole number of bytes, so that frames begin within one.
const SIZE: [u16; 2] = [5, 3];
const PIXELS: usize = 15;
const BINARY: &str = "1.2.840.10008.5.1.4.1.1.66.4";
const LABELMAP: &str = "1.2.840.10008.5.1.4.1.1.66.7";

/// A frame: its segment, its place along z in mm, and the pixels that are set.
#[derive(Debug, Clone)]
struct Frame(u16, f64, Vec<usize>);

/// A segmentation that is changed before it is written.
#[derive(Debug, Clone)]
struct Made {
    class: &'static str,
    kind: &'static str,
    bits: u16,
    coding: Coding,
    open: bool,
    segments: Vec<(u16, &'static str)>,
    frames: Vec<Frame>,
    step: Option<&'static str>,
    frame_of_reference: &'static str,
    patient: &'static str,
    /// TemporalPositionIndex of the last frame; of the others it is 1.
    time: u32,
    /// BitsStored, where it is not BitsAllocated.
    stored: Option<u16>,
    /// In place of those of the frames.
    pixels: Option<Vec<u8>>,
}

impl Made {
    /// Two structures in three planes of four; the third plane has no frame.
    fn new() -> Self {
        Self {
            class: BINARY,
            kind: "BINARY",
            bits: 1,
            coding: Coding::Explicit,
            open: false,
            segments: vec![(1, "liver"), (7, "portal vein")],
            frames: vec![
                Frame(7, 7.5, vec![0, 14]),
                Frame(1, 0.0, vec![3, 4, 9]),
                Frame(1, 2.5, vec![3]),
                Frame(7, 2.5, vec![8]),
            ],
            step: Some("2.5"),
            frame_of_reference: "1.2.3.4.6",
            patient: "",
            time: 1,
            stored: None,
            pixels: None,
        }
    }

    /// The voxels (column, row, plane) with their labels, in order.
    fn want() -> Vec<([u32; 3], i16)> {
        let mut all = vec![
            ([3, 0, 0], 1),
            ([4, 0, 0], 1),
            ([4, 1, 0], 1),
            ([3, 0, 1], 1),
            ([3, 1, 1], 7),
            ([0, 0, 3], 7),
            ([4, 2, 3], 7),
        ];
        all.sort_by_key(|(at, _)| [at[2], at[1], at[0]]);
        all
    }

    fn values(&self) -> Vec<u8> {
        let stored = |frame: &Frame| {
            let mut values = vec![0_u16; PIXELS];
            frame.2.iter().for_each(|&i| values[i] = frame.0);
            values
        };
        let values: Vec<u16> = self.frames.iter().flat_map(stored).collect();
        match self.bits {
            1 => {
                let mut bytes = vec![0; values.len().div_ceil(8)];
                let set = values.iter().enumerate().filter(|(_, value)| **value != 0);
                set.for_each(|(i, _)| bytes[i / 8] |= 1 << (i % 8));
                bytes
            }
            8 if self.kind == "FRACTIONAL" => values.iter().map(|value| if *value > 0 { 200 } else { 0 }).collect(),
            8 => values.iter().map(|value| *value as u8).collect(),
            _ => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        self.file().bytes()
    }

    fn file(&self) -> File {
        let mut file = File {
            coding: self.coding,
            syntax: "1.2.840.10008.1.2.1".to_owned(),
            preamble: true,
            elements: Vec::new(),
        };
        file.text((0x0008, 0x0016), "UI", self.class)
            .text((0x0010, 0x0010), "PN", "SECRET^NAME")
            .text((0x0020, 0x0052), "UI", self.frame_of_reference)
            .us((0x0028, 0x0002), 1)
            .text((0x0028, 0x0008), "IS", &self.frames.len().to_string())
            .us((0x0028, 0x0010), SIZE[1])
            .us((0x0028, 0x0011), SIZE[0])
            .us((0x0028, 0x0100), self.bits)
            .us((0x0028, 0x0101), self.stored.unwrap_or(self.bits))
            .text((0x0062, 0x0001), "CS", self.kind)
            .us((0x0062, 0x000E), 200);
        if !self.patient.is_empty() {
            file.text((0x0010, 0x0020), "LO", self.patient);
        }
        let segments: Vec<Elements> = self.segments.iter().map(segment).collect();
        file.set((0x0062, 0x0002), Value::Items(segments, self.open));
        file.set((0x5200, 0x9229), Value::Items(vec![self.shared()], self.open));
        let last = self.frames.len().saturating_sub(1);
        let frames = self.frames.iter().enumerate();
        let frames = frames
            .map(|(i, frame)| self.groups(frame, if i == last { self.time } else { 1 }))
            .collect();
        file.set((0x5200, 0x9230), Value::Items(frames, self.open));
        let mut bytes = self.pixels.clone().unwrap_or_else(|| self.values());
        bytes.resize(bytes.len().next_multiple_of(2), 0);
        file.raw((0x7FE0, 0x0010), "OB", &bytes);
        match self.coding {
            Coding::Explicit => file,
            coding => file.coded(coding),
        }
    }

    fn shared(&self) -> Elements {
        let mut measures = vec![((0x0028, 0x0030), Value::Text("DS", "0.5\\0.75".to_owned()))];
        if let Some(step) = self.step {
            measures.insert(0, ((0x0018, 0x0088), Value::Text("DS", step.to_owned())));
        }
        let axes = Value::Text("DS", "1\\0\\0\\0\\1\\0".to_owned());
        vec![
            ((0x0020, 0x9116), self.one(vec![((0x0020, 0x0037), axes)])),
            ((0x0028, 0x9110), self.one(measures)),
        ]
    }

    fn groups(&self, Frame(segment, z, _): &Frame, time: u32) -> Elements {
        let place = Value::Text("DS", format!("-10\\20\\{z}"));
        let time = Value::Raw("UL", time.to_le_bytes().to_vec(), 4);
        let content = ((0x0020, 0x9111), self.one(vec![((0x0020, 0x9128), time)]));
        let mut groups = vec![content, ((0x0020, 0x9113), self.one(vec![((0x0020, 0x0032), place)]))];
        if self.kind != "LABELMAP" {
            let segment = self.one(vec![((0x0062, 0x000B), Value::Us(*segment))]);
            groups.push(((0x0062, 0x000A), segment));
        }
        groups
    }

    fn one(&self, item: Elements) -> Value {
        Value::Items(vec![item], self.open)
    }

    fn put(&self) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("organs.dcm");
        std::fs::write(&path, self.bytes()).unwrap();
        (folder, path)
    }

    fn refused(&self) -> String {
        let (_folder, path) = self.put();
        let said = read(&path).unwrap_err().to_string();
        assert!(said.contains("organs.dcm") && !said.contains("SECRET"), "{said}");
        said
    }

    fn found(&self) -> Vec<([u32; 3], i16)> {
        let (_folder, path) = self.put();
        let volume = read(&path).unwrap();
        let [nx, ny, nz] = volume.grid.dims();
        let places = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let labels = places.map(|at| (at, volume.view().at(at)));
        labels.filter(|(_, label)| *label != 0).collect()
    }
}

fn segment((number, name): &(u16, &'static str)) -> Elements {
    vec![
        // UTF-8, while the data set names none.
        ((0x0008, 0x0005), Value::Text("CS", "ISO_IR 192".to_owned())),
        ((0x0062, 0x0004), Value::Us(*number)),
        ((0x0062, 0x0005), Value::Text("LO", (*name).to_owned())),
    ]
}

fn read(path: &Path) -> Result<bus::volume::OwnedVolume, crate::LoadError> {
    labels_in(open_labels(path, None, 1)?.0)
}

#[test]
fn voxels_lie_where_their_frames_say_in_every_kind_and_coding() {
    let kinds = [
        (BINARY, "BINARY", 1),
        (BINARY, "FRACTIONAL", 8),
        (LABELMAP, "LABELMAP", 8),
        (LABELMAP, "LABELMAP", 16),
    ];
    for (class, kind, bits) in kinds {
        for (coding, open) in [
            (Coding::Explicit, false),
            (Coding::Implicit, true),
            (Coding::Explicit, true),
        ] {
            let mut made = Made {
                class,
                kind,
                bits,
                coding,
                open,
                ..Made::new()
            };
            if kind == "LABELMAP" {
                // One frame a plane, with the labels themselves.
                made.frames.truncate(3);
                let mut values = [0_u16; 3 * PIXELS];
                for (i, label) in [(0, 7), (14, 7), (18, 1), (19, 1), (24, 1), (33, 1), (38, 7)] {
                    values[i] = label;
                }
                made.pixels = Some(
                    values
                        .iter()
                        .flat_map(|v| v.to_le_bytes()[..usize::from(bits / 8)].to_vec())
                        .collect(),
                );
            }
            assert_eq!(made.found(), Made::want(), "{kind} {bits} {coding:?} {open}");
        }
    }
}

#[test]
fn the_grid_is_that_of_the_frames_and_planes_without_one_are_empty() {
    let (_folder, path) = Made::new().put();
    let volume = read(&path).unwrap();
    assert_eq!(volume.grid.dims(), [5, 3, 4]);
    let rows = volume.grid.ct_from_voxel().rows();
    assert_eq!(
        rows,
        [[0.75, 0.0, 0.0, -10.0], [0.0, 0.5, 0.0, 20.0], [0.0, 0.0, 2.5, 0.0]]
    );
    let names = label_names(&path).unwrap();
    assert_eq!(
        (names.len(), names.get(1), names.get(7)),
        (2, Some("liver"), Some("portal vein"))
    );
}

#[test]
fn one_plane_needs_a_step_that_is_stated() {
    let mut made = Made {
        segments: vec![(1, "node")],
        frames: vec![Frame(1, 4.0, vec![2])],
        ..Made::new()
    };
    assert_eq!(made.found(), [([2, 0, 0], 1)]);
    made.step = None;
    assert!(
        made.refused().contains("SpacingBetweenSlices is missing"),
        "{}",
        made.refused()
    );
}

/// A structure with holes that nobody sees: every second plane would have been taken for empty.
#[test]
fn a_stated_step_that_no_two_planes_have_is_refused() {
    let planes = |places: &[f64]| places.iter().map(|z| Frame(1, *z, vec![2])).collect();
    let mut made = Made {
        segments: vec![(1, "liver")],
        frames: planes(&[0.0, 5.0, 10.0, 15.0]),
        ..Made::new()
    };
    assert!(
        made.refused()
            .contains("0.000, 5.000, 10.000, 15.000 mm; SpacingBetweenSlices is 2.5 mm"),
        "{}",
        made.refused()
    );
    made.step = Some("5");
    assert_eq!(made.found().len(), 4);
    made.step = None;
    assert_eq!(made.found().len(), 4);
    // Between two planes alone any number may be missing.
    made.frames = planes(&[0.0, 5.0]);
    assert!(
        made.refused().contains("SpacingBetweenSlices is not stated"),
        "{}",
        made.refused()
    );
    // No whole steps.
    made.step = Some("2.5");
    made.frames = planes(&[0.0, 2.5, 6.0, 8.5]);
    assert!(
        made.refused().contains("no step that leads from each to the next"),
        "{}",
        made.refused()
    );
}

/// The smallest of the printed steps, taken two hundred times, was one plane off.
#[test]
fn places_printed_with_two_decimals_are_on_one_grid() {
    let printed = |k: usize| (0.625 * k as f64 * 100.0).round() / 100.0;
    for step in [Some("0.625"), None] {
        let made = Made {
            segments: vec![(1, "liver")],
            frames: (0..200).map(|k| Frame(1, printed(k), vec![2])).collect(),
            step,
            ..Made::new()
        };
        let found = made.found();
        assert_eq!((found.len(), found[199].0), (200, [2, 0, 199]), "{step:?}");
    }
}

/// The names of an item are in the sets that the item names.
#[test]
fn names_are_in_the_character_set_of_their_item() {
    let made = Made {
        segments: vec![(1, "Milz ä"), (7, "portal vein")],
        ..Made::new()
    };
    let (_folder, path) = made.put();
    assert_eq!(label_names(&path).unwrap().get(1), Some("Milz ä"));
}

/// Another value would be taken for one that is passed over.
#[test]
fn a_value_that_is_too_long_is_no_absent_one() {
    let name: &'static str = Box::leak("x".repeat(5000).into_boxed_str());
    let made = Made {
        segments: vec![(1, name), (7, "portal vein")],
        ..Made::new()
    };
    assert!(made.refused().contains("SegmentLabel at byte"), "{}", made.refused());
}

#[test]
fn what_would_be_a_guess_is_refused_by_name() {
    let with = |change: &dyn Fn(&mut Made)| {
        let mut made = Made::new();
        change(&mut made);
        made.refused()
    };
    let cases: [(Change<'_>, &str); 16] = [
        (
            &|m| m.frames[3].2 = vec![3],
            "segments 1 and 7 overlap, first at column 3, row 0 of frame 4",
        ),
        (
            &|m| m.frames[3].0 = 1,
            "frames 3 and 4 are both of segment 1 at one place",
        ),
        (
            &|m| m.frames[3].0 = 2,
            "frame 4 is of segment 2, which SegmentSequence does not describe",
        ),
        (&|m| m.frames[3].0 = 0, "segment 0: labels from 1 to 32767 are held"),
        (
            &|m| m.frames[3].0 = 40_000,
            "segment 40000: labels from 1 to 32767 are held",
        ),
        (&|m| m.segments.push((7, "vein")), "segment 7 is described twice"),
        (
            &|m| m.segments.push((9, "spleen")),
            "segment 9 (\"spleen\") has no voxel",
        ),
        (&|m| m.segments.clear(), "this segmentation has no segment"),
        (&|m| m.kind = "SURFACE", "SegmentationType is another, expected BINARY"),
        (&|m| m.bits = 16, "BitsAllocated is 16, expected 1 for BINARY"),
        (&|m| m.frame_of_reference = "", "FrameOfReferenceUID is missing"),
        (&|m| m.frames[0].1 = f64::NAN, "ImagePositionPatient"),
        (&|m| m.frames[0].1 = 1e9, "no step that leads"),
        (&|m| m.frames[0].1 = 7.3, "no step"),
        (&|m| m.step = Some("0"), "expected one number above 0, or none"),
        (
            &|m| m.pixels = Some(vec![0; 6]),
            "the pixel data are 6 bytes long, expected 8 for",
        ),
    ];
    for (change, words) in cases {
        let said = with(change);
        assert!(said.contains(words), "{words}: {said}");
    }
    let partly = with(&|m| {
        (m.kind, m.bits) = ("FRACTIONAL", 8);
        let mut values = m.values();
        values[3 * PIXELS + 8] = 199;
        m.pixels = Some(values);
    });
    assert!(
        partly.contains("a voxel of frame 4 is 199 of 200, neither 0 nor all"),
        "{partly}"
    );
    let stored = with(&|m| {
        (m.class, m.kind, m.bits, m.stored) = (LABELMAP, "LABELMAP", 16, Some(12));
        m.frames.truncate(3);
    });
    assert!(
        stored.contains("BitsStored is 12, expected as many as BitsAllocated"),
        "{stored}"
    );
    let times = with(&|m| m.time = 2);
    assert!(times.contains("several points in time"), "{times}");
    let unknown = with(&|m| {
        (m.class, m.kind, m.bits) = (LABELMAP, "LABELMAP", 8);
        m.frames.truncate(3);
        m.pixels = Some([vec![0; 2 * PIXELS], vec![0, 9], vec![0; PIXELS - 2]].concat());
    });
    assert!(unknown.contains("a voxel of frame 3 has the label 9"), "{unknown}");
}

#[test]
fn a_segmentation_of_another_frame_of_reference_is_refused() {
    let series = tempfile::tempdir().unwrap();
    for k in 0..4 {
        let file = File::slice(k, 2.5 * k as f64);
        std::fs::write(series.path().join(format!("{k}.dcm")), file.bytes()).unwrap();
    }
    let examination = VolumeSpec::of_path(series.path().to_owned());
    let (_folder, path) = Made::new().put();
    assert!(open_labels(&path, Some(&examination), 1).unwrap().1.is_in_its_frame);
    assert!(!open_labels(&path, None, 1).unwrap().1.is_in_its_frame);
    let other = Made {
        frame_of_reference: "1.2.3.4.7",
        ..Made::new()
    };
    let (_folder, path) = other.put();
    let said = open_labels(&path, Some(&examination), 1).err().unwrap().to_string();
    assert!(said.contains("another frame of reference"), "{said}");
    assert!(!said.contains("1.2.3.4"), "{said}");
}

/// In the same frame of reference; PatientID is compared as text, and one that is not said is none.
#[test]
fn a_segmentation_of_another_patient_is_refused_and_neither_is_named() {
    let series = tempfile::tempdir().unwrap();
    for k in 0..4 {
        let mut file = File::slice(k, 2.5 * k as f64);
        file.text((0x0010, 0x0020), "LO", "SECRET-1");
        std::fs::write(series.path().join(format!("{k}.dcm")), file.bytes()).unwrap();
    }
    let examination = VolumeSpec::of_path(series.path().to_owned());
    for (patient, is_taken) in [("SECRET-1", true), ("SECRET-1 ", true), ("", true), ("SECRET-2", false)] {
        let (_folder, path) = Made { patient, ..Made::new() }.put();
        let opened = open_labels(&path, Some(&examination), 1);
        assert_eq!(opened.is_ok(), is_taken, "{patient:?}");
        let said = opened.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(
            is_taken || said.contains("PatientID") && said.contains("organs"),
            "{said}"
        );
        assert!(!said.contains("SECRET"), "{said}");
        assert!(open_labels(&path, None, 1).is_ok());
    }
}

/// Cut off anywhere, and with each byte of the header changed: read whole, or refused; never a panic.
#[test]
fn damage_is_refused() {
    let bytes = Made::new().bytes();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("organs.dcm");
    for end in (132..bytes.len()).step_by(3) {
        std::fs::write(&path, &bytes[..end]).unwrap();
        assert!(read(&path).is_err(), "cut off at {end}");
    }
    for at in (132..bytes.len()).step_by(2) {
        let mut changed = bytes.clone();
        changed[at] ^= 0xFF;
        std::fs::write(&path, &changed).unwrap();
        let _ = read(&path);
    }
}
