//! Whose a structure set is, and whether anybody approved of it.

use super::*;

type Said<'a> = &'a [((u16, u16), &'static str, &'a str)];

fn held(world: &World, set: Said<'_>, slices: Said<'_>) -> Result<Vec<String>, String> {
    for k in 0..4 {
        let mut file = File::slice(k, 2.5 * k as f64);
        for (tag, vr, value) in slices {
            file.text(*tag, vr, value);
        }
        std::fs::write(world.0.path().join(format!("ct/{k}.dcm")), file.bytes()).unwrap();
    }
    let mut file = made(&rois(), Coding::Explicit, None);
    for (tag, vr, value) in set {
        file.text(*tag, vr, value);
    }
    let read = world.read(&file.bytes());
    let told = read.map(|set| set.unwrap().warnings).map_err(|error| error.to_string());
    assert!(!format!("{told:?}").contains("SECRET"), "{told:?}");
    told
}

/// PatientID alone was compared.
#[test]
fn a_set_of_another_name_birth_date_sex_or_issuer_is_refused() {
    let world = World::new();
    for (tag, vr, own, of, words) in [
        (
            (0x0010, 0x0010),
            "PN",
            "DOE^SECRET",
            "ROE^SECRET",
            "(0010,0010) PatientName",
        ),
        (
            (0x0010, 0x0030),
            "DA",
            "19520229",
            "19520228",
            "(0010,0030) PatientBirthDate",
        ),
        ((0x0010, 0x0040), "CS", "F", "M", "(0010,0040) PatientSex"),
        (
            (0x0010, 0x0021),
            "LO",
            "SECRET A",
            "SECRET B",
            "(0010,0021) IssuerOfPatientID",
        ),
    ] {
        let said = held(&world, &[(tag, vr, own)], &[(tag, vr, of)]).unwrap_err();
        assert!(said.contains(&format!("points.dcm: {words}: found another")), "{said}");
        for (own, of) in [(own, own), (own, ""), ("", of)] {
            assert_eq!(
                held(&world, &[(tag, vr, own)], &[(tag, vr, of)]),
                Ok(vec![]),
                "{own:?} {of:?}"
            );
        }
    }
}

/// A set that nobody approved was taken like one that somebody had.
#[test]
fn a_set_that_nobody_approved_or_of_another_study_or_series_is_told() {
    let world = World::new();
    let status = |status: &str| held(&world, &[((0x300E, 0x0002), "CS", status)], &[]).unwrap();
    assert!(status("UNAPPROVED")[0].contains("(300E,0002) ApprovalStatus is UNAPPROVED"));
    assert!(status("SEEN")[0].contains("(300E,0002) ApprovalStatus is not APPROVED"));
    assert_eq!((status("APPROVED"), status("")), (vec![], vec![]));
    let other = held(&world, &[((0x0020, 0x000D), "UI", "1.2.3.9")], &[]).unwrap();
    assert!(other.len() == 1 && other[0].contains("another study"), "{other:?}");
    let of_series = |uid: &str| {
        let series = vec![text((0x0020, 0x000E), "UI", uid)];
        let study = vec![((0x3006, 0x0014), Value::Items(vec![series], true))];
        let frame = vec![((0x3006, 0x0012), Value::Items(vec![study], false))];
        let mut file = made(&rois(), Coding::Explicit, None);
        file.set((0x3006, 0x0010), Value::Items(vec![frame], true));
        world.read(&file.bytes()).unwrap().unwrap().warnings
    };
    assert_eq!(of_series("1.2.3.4.5"), Vec::<String>::new());
    let other = of_series("1.2.3.4.9");
    assert!(
        other.len() == 1 && other[0].contains("made of another series"),
        "{other:?}"
    );
}
