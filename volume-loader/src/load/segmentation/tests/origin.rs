//! Whose a segmentation is, and whether anybody approved of it.

use super::*;

type Said<'a> = &'a [((u16, u16), &'static str, &'a str)];

const NAME: (u16, u16) = (0x0010, 0x0010);
const ISSUER: (u16, u16) = (0x0010, 0x0021);
const BIRTH: (u16, u16) = (0x0010, 0x0030);
const SEX: (u16, u16) = (0x0010, 0x0040);
const CHARACTERS: (u16, u16) = (0x0008, 0x0005);
const STATUS: (u16, u16) = (0x300E, 0x0002);

/// The warnings of a segmentation that says this of a series that says that, or the refusal.
fn held(own: Said<'_>, of: Said<'_>) -> Result<Vec<String>, String> {
    held_in(own, of, &|_| {})
}

fn held_in(own: Said<'_>, of: Said<'_>, change: &dyn Fn(&mut File)) -> Result<Vec<String>, String> {
    let series = tempfile::tempdir().unwrap();
    for k in 0..4 {
        let mut file = File::slice(k, 2.5 * k as f64);
        for (tag, vr, value) in of {
            file.text(*tag, vr, value);
        }
        // The first says nothing: what the others say holds.
        if k == 0 && !of.is_empty() {
            file.remove(NAME);
        }
        std::fs::write(series.path().join(format!("{k}.dcm")), file.bytes()).unwrap();
    }
    let mut file = Made::new().file();
    for (tag, vr, value) in own {
        file.text(*tag, vr, value);
    }
    change(&mut file);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("organs.dcm");
    std::fs::write(&path, file.bytes()).unwrap();
    let opened = open_labels(&path, Some(&VolumeSpec::of_path(series.path().to_owned())), 1);
    let told = opened
        .map(|(source, _)| source.facts().warnings)
        .map_err(|error| error.to_string());
    let said = format!("{told:?}");
    assert!(!said.contains("SECRET") && !said.contains("1952"), "{said}");
    told.map(|told| {
        told.into_iter()
            .filter(|said| !said.contains("have no frame"))
            .collect()
    })
}

/// PatientID alone was compared, and two persons of one number, or of none, were one.
#[test]
fn a_segmentation_of_another_name_birth_date_sex_or_issuer_is_refused() {
    for (tag, vr, own, of, words) in [
        (NAME, "PN", "DOE^SECRET", "ROE^SECRET", "(0010,0010) PatientName"),
        (NAME, "PN", "DOE^ANN", "DOE^SECRET", "(0010,0010) PatientName"),
        (
            NAME,
            "PN",
            "DOE^ANN=SECRET",
            "DOE^ANN=SECRET2",
            "(0010,0010) PatientName",
        ),
        (BIRTH, "DA", "19520229", "19520228", "(0010,0030) PatientBirthDate"),
        (SEX, "CS", "F", "M", "(0010,0040) PatientSex"),
        (ISSUER, "LO", "SECRET A", "SECRET B", "(0010,0021) IssuerOfPatientID"),
    ] {
        let said = held(&[(tag, vr, own)], &[(tag, vr, of)]).unwrap_err();
        let words = format!("organs.dcm: {words}: found another than the examination's, expected the same");
        assert!(said.contains(&words), "{said}");
        for (own, of) in [(own, own), (own, ""), ("", of)] {
            assert_eq!(held(&[(tag, vr, own)], &[(tag, vr, of)]), Ok(vec![]), "{own:?} {of:?}");
        }
    }
}

#[test]
fn the_same_person_may_be_written_in_other_ways() {
    for (own, of) in [
        ("DOE^ANN", "Doe^Ann^^"),
        ("DOE^ANN", " DOE ^ANN=="),
        ("DOE^ANN", "DOE^ANN^MARIE^DR"),
        ("DOE^ANN=\u{5c71}", "DOE^ANN"),
        ("STRASSE^ANN", "Stra\u{df}e^Ann"),
    ] {
        let (own, of) = (
            [(CHARACTERS, "CS", "ISO_IR 192"), (NAME, "PN", own)],
            [(CHARACTERS, "CS", "ISO_IR 192"), (NAME, "PN", of)],
        );
        assert_eq!(held(&own, &of), Ok(vec![]), "{own:?} {of:?}");
    }
    let old = held(&[(BIRTH, "DA", "1952.02.29")], &[(BIRTH, "DA", "19520229")]);
    assert_eq!(old, Ok(vec![]));
}

/// A program that writes UTF-8 of a series in Latin 1 wrote another's name, byte for byte.
#[test]
fn a_name_in_another_character_set_is_the_same_name() {
    let of = [(CHARACTERS, "CS", "ISO_IR 192"), (NAME, "PN", "M\u{fc}ller^J\u{f6}rg")];
    let latin = |name: &'static [u8]| {
        move |file: &mut File| {
            file.text(CHARACTERS, "CS", "ISO_IR 100").raw(NAME, "PN", name);
        }
    };
    assert_eq!(held_in(&[], &of, &latin(b"M\xFCller^J\xF6rg ")), Ok(vec![]));
    let said = held_in(&[], &of, &latin(b"M\xF6ller^J\xF6rg ")).unwrap_err();
    assert!(said.contains("(0010,0010) PatientName: found another"), "{said}");
    // Of a set that is not known nobody knows what it says.
    let unknown = |file: &mut File| {
        file.text(CHARACTERS, "CS", "ISO_IR 148")
            .raw(NAME, "PN", b"M\xF6ller^J\xF6rg ");
    };
    assert_eq!(held_in(&[], &of, &unknown), Ok(vec![]));
}

/// It was drawn as if it were right.
#[test]
fn a_segmentation_that_was_rejected_is_refused_and_one_that_nobody_approved_is_told() {
    for status in ["REJECTED", "REJECTED ", "rejected"] {
        let said = held(&[(STATUS, "CS", status)], &[]).unwrap_err();
        assert!(
            said.contains("organs.dcm: (300E,0002) ApprovalStatus: found REJECTED"),
            "{said}"
        );
    }
    // Beside no examination too.
    let mut file = Made::new().file();
    file.text(STATUS, "CS", "REJECTED");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("organs.dcm");
    std::fs::write(&path, file.bytes()).unwrap();
    assert!(read(&path).is_err() && label_names(&path).is_err());
    assert_eq!(held(&[(STATUS, "CS", "APPROVED")], &[]), Ok(vec![]));
    assert_eq!(held(&[(STATUS, "CS", "")], &[]), Ok(vec![]));
    for (status, words) in [
        ("UNAPPROVED", "ApprovalStatus is UNAPPROVED"),
        ("SEEN", "ApprovalStatus is not APPROVED"),
    ] {
        let told = held(&[(STATUS, "CS", status)], &[]).unwrap();
        assert!(told.len() == 1 && told[0].contains(words), "{told:?}");
    }
}

#[test]
fn another_study_and_another_series_of_the_same_frame_of_reference_are_told() {
    let study = (0x0020, 0x000D);
    let told = held(&[(study, "UI", "1.2.3.9")], &[]).unwrap();
    assert!(told.len() == 1 && told[0].contains("another study"), "{told:?}");
    assert_eq!(held(&[(study, "UI", "1.2.3.4")], &[]), Ok(vec![]));
    let of_series = |uids: &'static [&'static str]| {
        move |file: &mut File| {
            let item = |uid: &&str| vec![((0x0020, 0x000E), Value::Text("UI", (*uid).to_owned()))];
            file.set((0x0008, 0x1115), Value::Items(uids.iter().map(item).collect(), true));
        }
    };
    assert_eq!(held_in(&[], &[], &of_series(&["1.2.9", "1.2.3.4.5"])), Ok(vec![]));
    let told = held_in(&[], &[], &of_series(&["1.2.9"])).unwrap();
    assert!(
        told.len() == 1 && told[0].contains("made of another series"),
        "{told:?}"
    );
}

/// Of a series whose slices name a frame of reference each, that of the first alone was taken for the examination's.
#[test]
fn where_each_slice_names_a_frame_of_reference_that_of_any_slice_is_the_examinations() {
    let series = tempfile::tempdir().unwrap();
    for k in 0..4 {
        let mut file = File::slice(k, 2.5 * k as f64);
        file.text((0x0020, 0x0052), "UI", &format!("1.2.3.4.{k}"));
        std::fs::write(series.path().join(format!("{k}.dcm")), file.bytes()).unwrap();
    }
    let examination = VolumeSpec::of_path(series.path().to_owned());
    for (frame_of_reference, is_taken) in [("1.2.3.4.0", true), ("1.2.3.4.3", true), ("1.2.3.4.6", false)] {
        let (_folder, path) = Made {
            frame_of_reference,
            ..Made::new()
        }
        .put();
        let opened = open_labels(&path, Some(&examination), 1).map(|(_, belongs)| belongs.is_in_its_frame);
        assert_eq!(opened.ok(), is_taken.then_some(true), "{frame_of_reference}");
    }
}
