//! What a derived object must not say: each refusal by its name, and the words of a patient whose name is no ASCII.

use scene::VolumeSpec;

use super::*;
use crate::dicom::tests::writer::File;
use crate::load::structure_set::NamedPoint;

/// A series of three slices, each changed by `change`.
fn series(change: impl Fn(usize, &mut File)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..3 {
        let mut file = File::slice(k, 2.5 * k as f64);
        file.text((0x0008, 0x0018), "UI", &format!("1.2.3.4.5.{k}"));
        change(k, &mut file);
        std::fs::write(folder.path().join(format!("{k}.dcm")), file.bytes()).unwrap();
    }
    folder
}

fn point(name: &str, ct_mm: [f64; 3]) -> NamedPoint {
    NamedPoint {
        name: name.to_owned(),
        ct_mm,
    }
}

fn written(folder: &tempfile::TempDir, points: &[NamedPoint]) -> Result<Vec<u8>, String> {
    let examination = VolumeSpec::of_path(folder.path().to_owned());
    structure_set_bytes(&examination, points).map_err(|error| error.to_string())
}

#[test]
fn a_series_that_does_not_say_to_what_an_object_would_belong_has_none() {
    let one = [point("node", [1.0, 2.0, 3.0])];
    assert!(written(&series(|_, _| {}), &one).is_ok());
    for (tag, element) in [
        ((0x0020, 0x0052), "FrameOfReferenceUID"),
        ((0x0020, 0x000D), "StudyInstanceUID"),
        ((0x0020, 0x000E), "SeriesInstanceUID"),
        ((0x0008, 0x0018), "SOPInstanceUID"),
        ((0x0008, 0x0016), "SOPClassUID"),
    ] {
        let missing = series(|_, file| {
            file.remove(tag);
        });
        let said = written(&missing, &one).unwrap_err();
        assert!(
            said.contains(element) && said.contains("found nothing"),
            "{element}: {said}"
        );
        // What is no identifier is not copied into one.
        let odd = series(|_, file| {
            file.text(tag, "UI", "1.2.<b>");
        });
        let said = written(&odd, &one).unwrap_err();
        assert!(
            said.contains("no identifier") || said.contains(element),
            "{element}: {said}"
        );
        assert!(!said.contains("<b>"), "{said}");
    }
    // A frame of reference for each slice is loaded, and none of them is that of all.
    let each = series(|k, file| {
        file.text((0x0020, 0x0052), "UI", &format!("1.2.3.{k}"));
    });
    let said = written(&each, &one).unwrap_err();
    assert!(said.contains("FrameOfReferenceUID"), "{said}");
}

#[test]
fn names_and_places_that_dicom_does_not_hold_are_refused() {
    let folder = series(|_, _| {});
    let long = "n".repeat(65);
    for (name, place, words) in [
        ("", 0.0, "found 0 characters"),
        (long.as_str(), 0.0, "found 65 characters"),
        ("a\\b", 0.0, "a backslash or a control character"),
        ("a\nb", 0.0, "a backslash or a control character"),
        (" a", 0.0, "a blank at its end"),
        ("a", f64::NAN, "expected a place that 16 characters"),
        ("a", f64::INFINITY, "expected a place that 16 characters"),
        // Eleven digits before the point leave four behind it.
        ("a", 12_345_678_901.123_456, "expected a place that 16 characters"),
    ] {
        let said = written(&folder, &[point(name, [0.0, place, 0.0])]).unwrap_err();
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(written(&folder, &[]).unwrap_err().contains("there is no point"));
    let many = vec![point("a", [0.0; 3]); 10_001];
    assert!(
        written(&folder, &many)
            .unwrap_err()
            .contains("10001 points: one object holds at most 10000")
    );
    assert!(written(&folder, &[point(&"ä".repeat(64), [0.0; 3])]).is_ok());
}

/// The series is of Latin 1, and the object of UTF-8.
#[test]
fn the_patient_has_her_name_in_whatever_characters() {
    let folder = series(|_, file| {
        file.text((0x0008, 0x0005), "CS", "ISO_IR 100");
        file.raw((0x0010, 0x0010), "PN", b"M\xFCller^J\xF6rg");
        file.text((0x0010, 0x0020), "LO", "4711");
        file.text((0x0010, 0x0030), "DA", "19520229");
    });
    let bytes = written(&folder, &[point("node", [1.0, 2.0, 3.0])]).unwrap();
    let holds = |words: &[u8]| bytes.windows(words.len()).any(|window| window == words);
    for words in [
        "Müller^Jörg",
        "ISO_IR 192",
        "4711",
        "19520229",
        "1.2.3.4.6",
        "1.2.3.4.5.2",
    ] {
        assert!(holds(words.as_bytes()), "{words}");
    }
    assert!(!holds(b"M\xFCller"));
}

/// Below 0 a label is no segment; what is larger than one file holds is refused before it is made.
#[test]
fn labels_that_are_no_segments_are_refused() {
    use crate::nrrd::Segment;
    let folder = series(|_, _| {});
    let examination = VolumeSpec::of_path(folder.path().to_owned());
    let volume = crate::load(&examination).unwrap();
    let context = Context::of(&examination).unwrap();
    let out = folder.path().join("out.dcm");
    let segment = |label, name: &str| Segment {
        label,
        name: Some(name.to_owned()),
        extent: ([0; 3], [3, 2, 2]),
    };
    let refused = |segments: &[Segment]| {
        let written = segmentation::write(&out, &volume.view(), volume.hash, &context, segments);
        assert!(!out.exists());
        written.unwrap_err().to_string()
    };
    assert!(refused(&[segment(-3, "a")]).contains("label -3"));
    assert!(refused(&[segment(1, "a\\b")]).contains("a backslash"));
    assert!(refused(&[]).contains("there is no structure"));
    let many: Vec<Segment> = (0..=i16::MAX)
        .map(|label| segment(label, "a"))
        .chain((0..i16::MAX).map(|label| segment(label, "a")))
        .collect();
    assert!(refused(&many).contains("frames, each a plane of a structure: one object holds at most 131072"));
    segmentation::write(&out, &volume.view(), volume.hash, &context, &[segment(1, "a")]).unwrap();
    // It has the patient's name.
    let mode = std::os::unix::fs::PermissionsExt::mode(&out.metadata().unwrap().permissions());
    assert_eq!(mode & 0o777, 0o600);
}
